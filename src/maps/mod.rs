//! The results of synthesis, which rendering reads: [`vertex_map`], a texture coordinate and a texton per vertex of a
//! mesh; [`atlas_map`], the same per texel of a mesh's texture atlas; [`face_map`], the part of the sample that each
//! face of a mesh shows. All have a [`header`].

pub(crate) mod atlas_map;
pub(crate) mod face_map;
pub(crate) mod header;
pub(crate) mod vertex_map;

pub use atlas_map::description::ChannelFile;
pub use atlas_map::{AtlasMap, Description as AtlasDescription};
pub use face_map::{FaceChannel, FaceMap, Square};
pub use header::MapHeader;
pub use vertex_map::SurfaceTextonMap;
