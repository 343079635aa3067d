//! Geometry: triangle meshes read, cleaned, retiled, given an orientation field, and charts on them.
//! Nothing here knows of textures or of synthesis.

pub mod builtin;
pub mod chart;
pub mod cleaning;
pub mod connection;
pub mod field;
pub mod frame;
pub mod origin;
pub mod pictures;
pub mod point_tree;
pub mod quality;
pub mod reading;
pub mod retile;
pub mod rings;
pub mod rows;
pub mod shapes;
pub mod surface_tree;
pub mod texture_charts;
pub mod topology;
pub mod triangle_mesh;
pub mod triangulation;
pub mod writing;

pub use reading::UserMesh;
pub use triangle_mesh::TriangleMesh;
