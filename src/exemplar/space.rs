//! The surface texton space (Tong 2002 §4): per level the texton map and the Gram matrix Φ; or,
//! for a plain image, a feature vector a texel.

use ndarray::{Array2, Array3};

use crate::format::id::ContentId;
use crate::grid::TexelGrid;

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
    /// A feature vector a texel (plain images), [H, W, d]; the default is their mean.
    Vectors(Array3<f32>),
}

/// One level of the exemplar.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceLevel {
    /// The texel grid of the level.
    pub grid: TexelGrid,
    /// What its texels carry.
    pub features: Features,
}

/// All levels of an exemplar, finest first, and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Space {
    /// Level 0 is the finest.
    pub levels: Vec<SpaceLevel>,
    /// This space's own id.
    pub id: ContentId,
    /// The id of the sample it describes.
    pub sample: ContentId,
}
