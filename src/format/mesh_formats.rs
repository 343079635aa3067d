//! The mesh formats that are read, as a whole: which of them a file has, and how messages list them.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::format::MESH_FORMATS;
use crate::format::mesh_format::MeshFormat;
use crate::format::polygon_mesh::PolygonMesh;

/// Whether files with this extension, in lower case and without its dot, are meshes.
pub fn has_extension(extension: &str) -> bool {
    format_of(extension).is_some()
}

/// Parses a mesh file's bytes; the format is recognised by the file's name (`.gz` set aside).
pub fn parse(bytes: &[u8], path: &Path) -> Result<PolygonMesh> {
    let (name, format) = named(path);
    let Some(format) = format else {
        return Err(Error::data("file name", name).expected(format!(
            "a mesh: {}, each also with .gz",
            listed_extensions()
        )));
    };
    let mut mesh = (format.parse)(bytes, path)?;
    mesh.splits_vertices = format.splits_vertices;
    Ok(mesh)
}

/// The other files that a mesh file names; none for a file that is no mesh.
pub fn companions(path: &Path) -> Result<Vec<PathBuf>> {
    let companions = named(path).1.and_then(|format| format.companions);
    companions.map_or_else(|| Ok(Vec::new()), |companions| companions(path))
}

/// The names of all formats: A, B or C.
pub fn listed_names() -> String {
    either(MESH_FORMATS.iter().map(|format| format.name.into()))
}

/// The extensions of all formats: .a, .b or .c.
pub fn listed_extensions() -> String {
    let extensions = MESH_FORMATS.iter().flat_map(|format| format.extensions);
    either(extensions.map(|extension| format!(".{extension}")))
}

fn format_of(extension: &str) -> Option<&'static MeshFormat> {
    let mut formats = MESH_FORMATS.iter();
    formats.find(|format| format.extensions.contains(&extension))
}

/// A file's name in lower case, without `.gz`, and the format that it tells.
fn named(path: &Path) -> (String, Option<&'static MeshFormat>) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    let format = name.rsplit('.').next().and_then(format_of);
    (name.into(), format)
}

/// Names as a message lists them: a, b or c.
pub fn either(names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_the_format() {
        let format = |name: &str| named(Path::new(name)).1.map(|format| format.name);
        assert_eq!(format("a.OBJ"), Some("OBJ"));
        assert_eq!(format("a.map.ply.gz"), Some("PLY"));
        assert_eq!(format("glb"), Some("glTF"));
        assert_eq!(format("a.gz"), None);
        assert_eq!(format("a.xyz"), None);
        assert!(companions(Path::new("a.obj")).unwrap().is_empty());
    }

    #[test]
    fn extensions_are_in_lower_case_and_of_one_format() {
        let mut all: Vec<_> = MESH_FORMATS.iter().flat_map(|f| f.extensions).collect();
        let is_plain = |e: &&&str| {
            e.bytes()
                .all(|b| b.is_ascii_lowercase() || b.is_ascii_digit())
        };
        assert!(all.iter().all(is_plain), "{all:?}");
        all.sort_unstable();
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "{all:?}");
    }

    #[test]
    fn messages_list_all_formats() {
        assert_eq!(
            either(["a", "b", "c"].map(String::from).into_iter()),
            "a, b or c"
        );
        assert_eq!(either(["a"].map(String::from).into_iter()), "a");
        let refusal = parse(b"", Path::new("a.xyz")).unwrap_err().to_string();
        for format in MESH_FORMATS {
            assert!(listed_names().contains(format.name));
            assert!(
                refusal.contains(&format!(".{}", format.extensions[0])),
                "{refusal}"
            );
        }
    }
}
