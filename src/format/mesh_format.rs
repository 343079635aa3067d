//! What the file of a mesh format states. `mesh_formats!` in `format/mod.rs` registers it.

use std::path::{Path, PathBuf};

use crate::error::Result;
use crate::format::polygon_mesh::PolygonMesh;

/// Finds the other files that a mesh file names, such as its buffers.
pub(crate) type FindCompanions = fn(&Path) -> Result<Vec<PathBuf>>;

/// A mesh format that is read.
#[derive(Debug)]
pub(crate) struct MeshFormat {
    /// What messages call it.
    pub name: &'static str,
    /// The extensions of its files' names, in lower case and without dots.
    pub extensions: &'static [&'static str],
    /// Parses a file's bytes. Files that it names lie beside the path.
    pub parse: fn(&[u8], &Path) -> Result<PolygonMesh>,
    /// Whether it gives every face or material vertices of its own: these are joined when a mesh is cleaned.
    pub splits_vertices: bool,
    /// Finds the other files that a file names, if files of this format name any.
    pub companions: Option<FindCompanions>,
}
