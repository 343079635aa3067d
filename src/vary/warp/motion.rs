//! How features move: scaled, turned and shifted about their centres, as far as the transition says there.

use glam::{DMat2, DVec2};
use ndarray::Array2;

use crate::vary::contours::MaskFeatures;

/// The largest factor of a feature's size.
pub const LARGEST_SCALE: f64 = 16.0;

/// The motion of a feature where the transition is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Factor of its size.
    pub scale: f64,
    /// Degrees, counter-clockwise.
    pub turn: f64,
    /// Pixels to the right.
    pub right: f64,
    /// Pixels upwards.
    pub up: f64,
}

impl Motion {
    /// Nothing moves.
    pub const NONE: Self = Self {
        scale: 1.0,
        turn: 0.0,
        right: 0.0,
        up: 0.0,
    };
}

/// A feature that moved: where its points came from and where they are. Coordinates are x rightwards and y
/// downwards, in pixels.
#[derive(Clone, Debug)]
pub struct Moved {
    /// Its centre before.
    pub centre: DVec2,
    /// Its centre after.
    pub target: DVec2,
    /// Its contour before.
    pub contour: Vec<DVec2>,
    forward: DMat2,
}

impl Moved {
    /// The features as a motion leaves them.
    pub fn features(
        features: &MaskFeatures,
        transition: &Array2<f32>,
        motion: Motion,
    ) -> Vec<Self> {
        let moved = features.list.iter().map(|feature| {
            let [row, col] = feature.centre;
            let (height, width) = transition.dim();
            let place = [
                (row.round() as usize).min(height - 1),
                (col.round() as usize).min(width - 1),
            ];
            let share = f64::from(transition[place]);
            let scale = 1.0 + (motion.scale - 1.0) * share;
            // Rows run downwards: counter-clockwise is the other way round.
            let turn = DMat2::from_angle(-(motion.turn * share).to_radians());
            let centre = DVec2::new(col, row);
            let points = feature.contour.iter();
            Self {
                centre,
                target: centre + share * DVec2::new(motion.right, -motion.up),
                contour: points
                    .map(|&[row, col]| DVec2::new(col.into(), row.into()))
                    .collect(),
                forward: turn * scale,
            }
        });
        moved.collect()
    }

    /// Where a point of the feature is after the motion.
    pub fn target_of(&self, point: DVec2) -> DVec2 {
        self.target + self.forward * (point - self.centre)
    }

    /// Where a point came from that moves with the feature.
    pub fn source_of(&self, point: DVec2) -> DVec2 {
        self.centre + self.forward.inverse() * (point - self.target)
    }

    /// At most `most` points of the contour, evenly.
    pub fn contour_points(&self, most: usize) -> impl Iterator<Item = DVec2> + '_ {
        let count = self.contour.len().min(most);
        (0..count).map(move |at| self.contour[at * self.contour.len() / count])
    }
}
