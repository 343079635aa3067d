//! The neighbour table (Tong 2002 §5.2): the k nearest texels of every texel, by the distance of
//! their neighbourhoods.

use ndarray::Array2;

use crate::format::id::ContentId;

/// The neighbourhood of a level: where its samples lie and what they weigh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighborhood {
    /// Samples on the level itself, (drow, dcol), centre included.
    pub offsets: Vec<[i32; 2]>,
    /// Their weights.
    pub weights: Vec<f32>,
    /// Samples on the parent level, round the parent texel; empty at the coarsest level.
    pub coarse_offsets: Vec<[i32; 2]>,
    /// Their weights.
    pub coarse_weights: Vec<f32>,
}

/// The neighbour table of one level.
#[derive(Clone, Debug, PartialEq)]
pub struct TableLevel {
    /// Flat texel indices [H·W, k], nearest first, column 0 the texel itself.
    pub neighbors: Array2<u32>,
    /// Squared neighbourhood distances, as [`neighbors`](Self::neighbors).
    pub distances: Array2<f32>,
    /// The neighbourhood they were measured in.
    pub neighborhood: Neighborhood,
    /// Least distance between listed texels, in texels (max norm).
    pub min_separation: u32,
}

/// The tables of all levels, finest first.
#[derive(Clone, Debug, PartialEq)]
pub struct NeighborTable {
    /// Level 0 is the finest.
    pub levels: Vec<TableLevel>,
    /// Neighbours a texel, itself included.
    pub k: usize,
    /// Whether neighbourhoods wrap round the sample's border.
    pub tileable: bool,
    /// This table's own id.
    pub id: ContentId,
    /// The id of the space it was made from.
    pub space: ContentId,
}
