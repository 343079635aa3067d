//! Files that a stage makes beside its product: reports, previews, pictures.

use std::path::{Path, PathBuf};

use toml::Value;

use crate::cli::run::document::{Key, Section};

/// Keys that name files beside a stage's product.
const SIDE_OUTPUTS: [&str; 9] = [
    "preview",
    "surface",
    "report",
    "montage",
    "label-map",
    "pictures",
    "vertex-colors",
    "glb",
    "levels-out",
];

/// Adds a mark to the names of files that a section makes beside its product: `out/look-draft.png`.
pub(super) fn mark_side_outputs(section: &mut Section, mark: &str) {
    let is_side_output = |key: &&mut Key| SIDE_OUTPUTS.contains(&key.name.as_str());
    for key in section.keys.iter_mut().filter(is_side_output) {
        if let Value::String(path) = &mut key.value {
            *path = marked(Path::new(path), mark).to_string_lossy().into_owned();
        }
    }
}

/// A path with a mark before its ending.
fn marked(path: &Path, mark: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(mark);
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}
