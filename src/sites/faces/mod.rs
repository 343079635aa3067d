//! Faces as sites: triangles that stand for pixels, in levels nested in fours (Castellanos and Williams §3.4–3.9).
//!
//! Levels run from the coarsest, number 0, to the finest, as in the paper. The children of face f are 4·f … 4·f + 3 on
//! the next level, the centre last.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`level`] | the faces of one level: colours, centres, areas, distances |
//! | [`pyramid`] | all levels of a surface |
//! | [`triangular_grid`] | all levels of a flat grid of triangles on a square sample |
//! | [`neighborhood`] | the 36 faces round a face, in three-fold symmetry |
//! | [`plan`] | how many faces a surface and its sample have, level by level |

pub(crate) mod level;
pub(crate) mod neighborhood;
pub(crate) mod plan;
pub(crate) mod pyramid;
pub(crate) mod triangular_grid;

pub use level::{AdjacentDistances, FaceLevel};
pub use neighborhood::{FaceTemplate, Neighborhood, SECTORS};
pub use plan::{FaceOptions, FacePlan};
pub use pyramid::FacePyramid;
pub use triangular_grid::{GridTurn, TriangularGrid};
