//! The angles that an image's name states.

use std::cmp::Ordering;

use crate::btf::direction::Direction;

/// View and light as (θ, φ) in degrees: φ in [0, 360), and 0 where θ is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Angles {
    view_deg: [f64; 2],
    light_deg: [f64; 2],
}

impl Angles {
    pub(super) fn new(view_deg: [f64; 2], light_deg: [f64; 2]) -> Self {
        let plain = |[theta, phi]: [f64; 2]| match theta == 0.0 {
            true => [0.0, 0.0],
            false => [theta, phi.rem_euclid(360.0)],
        };
        Self {
            view_deg: plain(view_deg),
            light_deg: plain(light_deg),
        }
    }

    pub(super) fn view(&self) -> Direction {
        direction(self.view_deg)
    }

    pub(super) fn light(&self) -> Direction {
        direction(self.light_deg)
    }

    /// Views first, each direction by θ, then φ: the order of the rings of Bonn's sets.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        let pairs = [
            (self.view_deg[0], other.view_deg[0]),
            (self.view_deg[1], other.view_deg[1]),
            (self.light_deg[0], other.light_deg[0]),
            (self.light_deg[1], other.light_deg[1]),
        ];
        let orders = pairs.map(|(a, b)| a.total_cmp(&b));
        orders.into_iter().fold(Ordering::Equal, Ordering::then)
    }

    /// What no image can have been taken at.
    pub(super) fn fault(&self) -> Option<String> {
        let fault = |kind: &str, theta: f64| {
            let is_above = (0.0..=90.0).contains(&theta);
            (!is_above)
                .then(|| format!("{kind} theta {theta}; expected 0 to 90 degrees from the normal"))
        };
        fault("view", self.view_deg[0]).or_else(|| fault("light", self.light_deg[0]))
    }
}

fn direction([theta, phi]: [f64; 2]) -> Direction {
    Direction::from_angles(theta.to_radians(), phi.to_radians())
}
