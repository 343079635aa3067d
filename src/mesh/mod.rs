//! Geometry: triangle meshes read, cleaned, retiled, given an orientation field, and charts on them.
//! Nothing here knows of textures or of synthesis.

pub mod builtin;
pub(crate) mod chart;
mod cleaning;
pub mod connection;
pub mod field;
pub(crate) mod frame;
pub(crate) mod origin;
pub(crate) mod pictures;
mod point_tree;
pub(crate) mod quality;
pub mod reading;
pub mod retile;
pub mod rings;
pub(crate) mod rows;
pub mod shapes;
pub(crate) mod surface_tree;
mod texture_charts;
pub mod topology;
pub mod triangle_mesh;
mod triangulation;
pub mod writing;

pub use reading::UserMesh;
pub use triangle_mesh::TriangleMesh;
