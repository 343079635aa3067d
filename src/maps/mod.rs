//! What synthesis hands on, and rendering reads: [`vertex_map`], a texture coordinate and a texton per
//! vertex of a mesh; [`atlas_map`], the same per texel of a mesh's texture atlas.

pub mod atlas_map;
pub mod vertex_map;

pub use atlas_map::AtlasMap;
pub use vertex_map::SurfaceTextonMap;
