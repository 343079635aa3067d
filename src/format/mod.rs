//! Bytes ↔ types, and no algorithms.
//!
//! Every writer writes a temporary file beside the target and renames it; every reader checks
//! sizes, ranges and versions before it allocates, and says file, field, found and expected.
//!
//! Files are not trusted. Readers run inside a [`guard`], what they allocate is in proportion to the
//! file's own length, and no file that has a name is mapped ([`positioned`]).

pub mod atomic;
pub mod exr;
pub mod gltf;
pub mod guard;
pub mod id;
pub mod image;
pub mod json;
pub mod lock;
pub mod nameless;
pub mod npy;
pub mod npz;
pub mod obj;
pub mod off;
pub mod ours;
pub mod ply;
pub mod polygon_mesh;
pub mod positioned;
pub mod seal;
pub mod source;
pub mod stl;
pub mod stored_array;
pub mod text;
pub mod zip_sink;
