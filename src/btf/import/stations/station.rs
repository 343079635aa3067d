//! Where camera and lamp stood, in millimetres from the patch's centre.

use glam::DVec3;

use crate::btf::direction::Direction;

/// The camera and the lamp of one image: positions where they are known, else directions to what is far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Where it was seen from, at the patch's centre.
    pub view: Direction,
    /// Where the light stood, at the patch's centre.
    pub light: Direction,
    /// The camera in millimetres from the patch's centre, where it is near.
    pub view_at: Option<DVec3>,
    /// The lamp in millimetres from the patch's centre, where it is near.
    pub light_at: Option<DVec3>,
}

impl Station {
    /// The direction to the camera from a point of the patch.
    pub(super) fn view_from(&self, point: DVec3) -> Direction {
        from(self.view_at, self.view, point)
    }

    /// The direction to the lamp from a point of the patch.
    pub(super) fn light_from(&self, point: DVec3) -> Direction {
        from(self.light_at, self.light, point)
    }

    /// What a value at a point is multiplied by to be that of the lamp's distance from the centre.
    pub(super) fn falloff(&self, point: DVec3) -> f64 {
        self.light_at.map_or(1.0, |at| {
            (at - point).length_squared() / at.length_squared()
        })
    }
}

fn from(at: Option<DVec3>, far: Direction, point: DVec3) -> Direction {
    at.and_then(|at| (at - point).try_normalize())
        .map_or(far, Direction)
}

/// The patch: its texels and its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Sides along x and y in millimetres.
    pub sides_mm: [f64; 2],
}

impl Patch {
    /// A point of the patch, in millimetres from its centre: (0, 0) is its top left, (1, 1) its bottom right.
    pub(super) fn point(&self, u: f64, v: f64) -> DVec3 {
        let [width, height] = self.sides_mm;
        DVec3::new((u - 0.5) * width, (0.5 - v) * height, 0.0)
    }
}

/// How far directions at the patch's corners are from those at its centre, in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// The largest of any view.
    pub views: f64,
    /// The largest of any light.
    pub lights: f64,
}

impl Spread {
    /// The larger of both.
    pub fn most(self) -> f64 {
        self.views.max(self.lights)
    }
}

/// The largest spread of all images.
pub fn spread(stations: &[Station], patch: Patch) -> Spread {
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[u, v]| patch.point(u, v));
    let mut spread = Spread::default();
    for station in stations {
        for corner in corners {
            let view = station.view_from(corner).angle_to(station.view);
            let light = station.light_from(corner).angle_to(station.light);
            spread.views = spread.views.max(view);
            spread.lights = spread.lights.max(light);
        }
    }
    spread
}
