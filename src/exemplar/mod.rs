//! The exemplar: the sample as synthesis sees it — features of every texel, and the nearest
//! neighbours of every texel's neighbourhood.

pub mod neighbor_table;
pub mod space;
