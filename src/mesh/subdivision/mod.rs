//! Subdivision surfaces: geometry alone.
//!
//! Catmull-Clark surfaces. In: a control mesh of quadrilaterals. Out: ever finer meshes of quadrilaterals, values
//! carried to their vertices, and the values of the smooth surface that they tend to.
//!
//! Butterfly surfaces. In: a mesh of triangles. Out: a mesh of four times as many.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`quad_mesh`] | how quadrilaterals are connected |
//! | [`quad_faces`] | the quadrilateral faces of a user's mesh |
//! | [`catmull_clark`] | the rules of Catmull and Clark |
//! | [`refinement`] | several steps, and the cells of a control face |
//! | [`butterfly`] | triangles cut in four by the modified butterfly rules |
//! | [`star`], [`cell_finder`] | the faces round a vertex, flattened, and which of their cells holds a point |

pub(crate) mod butterfly;
pub(crate) mod catmull_clark;
mod cell_finder;
pub(crate) mod quad_faces;
pub(crate) mod quad_mesh;
pub(crate) mod refinement;
pub(crate) mod star;

pub use quad_mesh::{Fans, QuadMesh};
pub use refinement::Refinement;
pub use star::{Star, StarPoint};
