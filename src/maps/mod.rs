//! What synthesis hands on, and rendering reads: [`vertex_map`], a texture coordinate and a texton per
//! vertex of a mesh.

pub mod vertex_map;

pub use vertex_map::SurfaceTextonMap;
