//! Bytes ↔ types, and no algorithms.
//!
//! Every writer writes a temporary file beside the target and renames it; every reader checks
//! sizes, ranges and versions before it allocates, and says file, field, found and expected.

pub mod atomic;
pub mod exr;
pub mod gltf;
pub mod id;
pub mod image;
pub mod json;
pub mod lock;
pub mod npy;
pub mod npz;
pub mod obj;
pub mod off;
pub mod ours;
pub mod ply;
pub mod polygon_mesh;
pub mod source;
pub mod stl;
pub mod stored_array;
