//! The results of synthesis, which rendering reads: [`vertex_map`], a texture coordinate and a texton per vertex of a
//! mesh; [`atlas_map`], the same per texel of a mesh's texture atlas; [`face_map`], the part of the sample that each
//! face of a mesh shows. All have a [`header`].

pub mod atlas_map;
pub mod face_map;
pub mod header;
pub mod vertex_map;

pub use atlas_map::AtlasMap;
pub use face_map::FaceMap;
pub use header::MapHeader;
pub use vertex_map::SurfaceTextonMap;
