//! The result of the search for a list's images.

use std::path::PathBuf;

/// The files of a list's images, in its order.
#[derive(Debug)]
pub(in crate::btf::import) struct Found {
    pub(in crate::btf::import) paths: Vec<PathBuf>,
    /// What the user should know of how they were found.
    pub(in crate::btf::import) note: Option<String>,
}
