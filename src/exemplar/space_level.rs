//! One level of a space: its texel grid and what its texels carry.

use ndarray::{Array2, Array3};

use crate::grid::TexelGrid;

/// The largest dot product or squared feature: distances of the widest neighbourhoods stay below the
/// largest `f32`.
pub(super) const LARGEST: f32 = 1e30;

pub(super) fn is_sound(product: f32) -> bool {
    product.abs() <= LARGEST
}

/// What the texels of one level carry.
#[derive(Clone, Debug, PartialEq)]
pub enum Features {
    /// Texton labels and the dot products of all texton pairs.
    Textons {
        /// Label of each texel, flat index row · width + column.
        labels: Vec<u16>,
        /// Φ, (nt + 1)², not centred; the last row and column are the default texton.
        gram: Array2<f32>,
    },
    /// One feature vector per texel of plain images, [H, W, d], as distances compare them: each number
    /// times the root of its channel's weight. The default is their mean.
    Plain(Array3<f32>),
}

/// One level of the exemplar.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceLevel {
    /// The texel grid of the level.
    pub grid: TexelGrid,
    /// What its texels carry.
    pub features: Features,
}
