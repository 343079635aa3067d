//! Names of hidden files beside a target.

use std::path::Path;

/// The folder a path lies in, `.` for a bare name.
pub fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// `.NAME` + suffix: the hidden companion of a path's last part.
pub fn hidden_name(path: &Path, suffix: &str) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    format!(".{name}{suffix}")
}
