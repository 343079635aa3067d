//! Bytes ↔ types, and no algorithms.
//!
//! Every writer writes a temporary file beside the target and renames it; every reader checks
//! sizes, ranges and versions before it allocates, and says file, field, found and expected.
//!
//! Files are not trusted. Readers run inside a [`guard`], what they allocate is proportional to the file's own
//! length, and no file that has a name is mapped ([`positioned`]).
//!
//! | file | what it does |
//! | --- | --- |
//! | [`image`], [`rgb_image`], [`exr`] | images in and previews out; OpenEXR frames out |
//! | [`obj`], [`ply`], [`stl`], [`off`], [`gltf`] | mesh files |
//! | [`mesh_format`], [`mesh_formats`], [`polygon_mesh`] | what a mesh format states, all of them, and what any mesh file holds |
//! | [`npy`], [`npz`], [`zip_sink`] | arrays and archives of them |
//! | [`archive`], [`compress`], [`zip_directory`] | archives that users bring, files of Unix compress |
//! | [`stored_array`], [`nameless`], [`positioned`] | numbers that stay in a file |
//! | [`json`], [`text`], [`source`] | descriptions, tables and whole files |
//! | [`id`], [`seal`], [`ours`], [`own_folder`] | what a file is, whether it is whole, whether this program wrote it |
//! | [`atomic`], [`lock`] | outputs that appear when done, one writer each |
//! | [`guard`] | a panic in a reader as an error |

pub(crate) mod archive;
pub(crate) mod atomic;
pub mod compress;
pub mod exr;
pub mod guard;
pub(crate) mod id;
pub mod image;
pub mod json;
pub(crate) mod lock;
mod mesh_format;
pub(crate) mod mesh_formats;
pub(crate) mod nameless;
pub mod npy;
pub mod npz;
pub(crate) mod ours;
pub(crate) mod own_folder;
pub(crate) mod polygon_mesh;
pub(crate) mod positioned;
pub(crate) mod rgb_image;
pub(crate) mod seal;
pub(crate) mod source;
pub(crate) mod stored_array;
pub(crate) mod text;
mod zip_directory;
mod zip_sink;

/// Registers the mesh formats that are read: one row per file. It declares the file's module and enters its `FORMAT`
/// into the table, from which readers, messages and the names of outputs take what they need. Messages list the formats
/// in this order.
macro_rules! mesh_formats {
    ($($visibility:vis mod $file:ident;)*) => {
        $($visibility mod $file;)*

        /// The mesh formats that are read.
        static MESH_FORMATS: &[mesh_format::MeshFormat] = &[$($file::FORMAT),*];
    };
}

mesh_formats! {
    pub mod obj;
    pub mod ply;
    pub(crate) mod stl;
    pub(crate) mod off;
    pub mod gltf;
}

pub use id::ContentId;
pub use lock::OutputLock;
pub use polygon_mesh::PolygonMesh;
pub use rgb_image::RgbImage;
