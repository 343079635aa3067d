//! Bytes ↔ types, and no algorithms.
//!
//! Every writer writes a temporary file beside the target and renames it; every reader checks
//! sizes, ranges and versions before it allocates, and says file, field, found and expected.
//!
//! Files are not trusted. Readers run inside a [`guard`], what they allocate is in proportion to the
//! file's own length, and no file that has a name is mapped ([`positioned`]).

pub(crate) mod atomic;
pub mod exr;
pub mod gltf;
pub mod guard;
pub mod id;
pub mod image;
pub mod json;
pub mod lock;
pub(crate) mod nameless;
pub mod npy;
pub mod npz;
pub mod obj;
pub(crate) mod off;
pub(crate) mod ours;
pub mod ply;
pub mod polygon_mesh;
mod positioned;
pub(crate) mod seal;
pub(crate) mod source;
pub(crate) mod stl;
pub(crate) mod stored_array;
pub(crate) mod text;
mod zip_sink;
