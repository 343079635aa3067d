//! The atlas map (Ying 2001): per texel of a surface's texture atlas a texture coordinate of the sample, on the mesh
//! and its charts. The result of `synthesis` for an atlas.
//!
//! In memory an [`AtlasMap`]. On disk a folder `NAME.atlas/` (docs/formats.md): [`description`] is
//! `atlas.json`, [`surface`] is `surface.npz`, and [`files`] puts them together with the coordinates.

pub(crate) mod description;
mod files;
mod map;
mod surface;
#[cfg(test)]
pub(crate) mod tests;

pub use description::{ChannelFile, Description};
pub use map::AtlasMap;

pub(crate) use files::{ATLAS_FOLDER, MODEL};
