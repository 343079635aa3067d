//! Whether a file was written by this program: only such a file is replaced.
//!
//! Every format has its mark where other readers ignore it. JSON has none; a JSON file is recognised by its
//! structure.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use zip::ZipArchive;

use crate::error::{Error, Result};

/// The line that marks meshes: a comment of PLY and OBJ.
pub const MESH_MARK: &str = "mesotex 1";
/// The keyword and the text of the PNG chunk that marks pictures.
pub const PICTURE_MARK: [&str; 2] = ["Software", "mesotex"];
/// The XML that marks `.btf` files.
pub const BTF_MARK: &str = "<btf writer=\"mesotex\"/>";
/// The element that marks pages.
pub const PAGE_MARK: &str = "<meta name=\"generator\" content=\"mesotex\">";
/// What marks plans of commands.
pub const PLAN_MARK: &str = "# mesotex plan";
/// What stands behind the last coefficient of PTM files, where readers do not look.
pub const PTM_MARK: &[u8] = b"mesotex\n";
/// The member that every archive of ours has.
const ARCHIVE_MARK: &str = "meta.json";
/// How much of a file is read for its mark.
const START: u64 = 1 << 16;

/// The formats this program writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.npz`.
    Archive,
    /// A mesh in the format that its name says: PLY, OBJ or GLB.
    Mesh,
    /// PLY.
    Ply,
    /// OBJ.
    Obj,
    /// GLB.
    Model,
    /// USD text.
    Usda,
    /// PNG.
    Picture,
    /// OpenEXR.
    Frame,
    /// JSON.
    Json,
    /// Bonn's `.btf`.
    Btf,
    /// Polynomial texture map.
    Ptm,
    /// HTML.
    Page,
    /// A scene, TOML.
    Scene,
    /// A plan of commands: a shell script or a Snakefile.
    Plan,
}

impl Format {
    /// What a message calls the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Archive => ".npz archive",
            Self::Mesh | Self::Ply | Self::Obj => "mesh",
            Self::Model => "GLB",
            Self::Usda => "USD file",
            Self::Picture => "picture",
            Self::Frame => "frame",
            Self::Json => "JSON file",
            Self::Btf => ".btf file",
            Self::Ptm => "PTM",
            Self::Page => "page",
            Self::Scene => "scene",
            Self::Plan => "plan",
        }
    }
}

/// Whether the file at `path` is one of ours, or empty.
pub fn is_ours(path: &Path, format: Format) -> io::Result<bool> {
    let mut start = Vec::new();
    File::open(path)?.take(START).read_to_end(&mut start)?;
    if start.is_empty() {
        return Ok(true);
    }
    Ok(match format {
        Format::Archive => start.starts_with(b"PK") && has_member(path, ARCHIVE_MARK)?,
        Format::Mesh | Format::Ply | Format::Obj | Format::Model => is_our_mesh(&start),
        Format::Usda => start.starts_with(b"#usda") && contains(&start, MESH_MARK.as_bytes()),
        Format::Picture => start.starts_with(b"\x89PNG") && contains(&start, &picture_mark()),
        Format::Frame => start.starts_with(&[0x76, 0x2f, 0x31, 1]) && contains(&start, b"mesotex:"),
        Format::Btf => start.starts_with(b"!") && contains(&start, BTF_MARK.as_bytes()),
        Format::Page => contains(&start, PAGE_MARK.as_bytes()),
        Format::Plan => start.starts_with(PLAN_MARK.as_bytes()),
        Format::Ptm => start.starts_with(b"PTM_") && ends_with(path, PTM_MARK)?,
        // A scene is written to be edited: whatever it holds is the user's.
        Format::Scene => false,
        Format::Json => matches!(start.trim_ascii_start().first(), Some(b'{' | b'[')),
    })
}

/// Refuses to write over a file that is not of this program.
pub fn check_replaceable(path: &Path, format: Format) -> Result<()> {
    if !path.exists() || is_ours(path, format).map_err(Error::io(path, "read"))? {
        return Ok(());
    }
    let name = format.name();
    Err(Error::option(
        "output",
        format!(
            "{} exists and is not a {name} of this program",
            path.display()
        ),
        "another output (or delete the file first)",
    ))
}

fn is_our_mesh(start: &[u8]) -> bool {
    let marked = |comment: &str| contains(start, format!("{comment}{MESH_MARK}\n").as_bytes());
    match start {
        [b'p', b'l', b'y', ..] => marked("\ncomment "),
        [b'g', b'l', b'T', b'F', ..] => contains(start, b"\"generator\":\"mesotex\""),
        _ => marked("# ") && start.starts_with(b"# "),
    }
}

fn picture_mark() -> Vec<u8> {
    PICTURE_MARK.join("\0").into_bytes()
}

fn has_member(path: &Path, name: &str) -> io::Result<bool> {
    let archive = ZipArchive::new(File::open(path)?);
    Ok(archive.is_ok_and(|archive| archive.index_for_name(name).is_some()))
}

fn ends_with(path: &Path, mark: &[u8]) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(mark.len() as u64)))?;
    let mut end = Vec::new();
    file.read_to_end(&mut end)?;
    Ok(end == mark)
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::gltf::{self, GltfMesh};
    use crate::format::obj::{self, ObjMesh};
    use crate::format::ply::{self, Column};
    use crate::format::{image, npz};

    #[test]
    fn every_writer_leaves_its_mark() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        ply::write(
            &at("a.ply"),
            &[MESH_MARK.into()],
            &[("x", Column::Float(&[0.0; 3]))],
            &[],
        )
        .unwrap();
        let mesh = ObjMesh {
            origin: [0.0; 3],
            positions: &triangle,
            normals: &[],
            uvs: None,
            triangles: &[[0, 1, 2]],
        };
        obj::write(&at("a.obj"), &mesh).unwrap();
        let mesh = GltfMesh {
            origin: [0.0; 3],
            uvs: None,
            positions: &triangle,
            normals: &triangle,
            triangles: &[[0, 1, 2]],
            ..GltfMesh::default()
        };
        gltf::write(&at("a.glb"), &mesh).unwrap();
        image::write_png(&at("a.png"), 2, 2, &[7; 4]).unwrap();
        npz::write(&at("a.npz"), serde_json::Map::new(), |_| Ok(())).unwrap();
        std::fs::write(at("empty"), "").unwrap();
        for (name, format) in [
            ("a.ply", Format::Mesh),
            ("a.obj", Format::Mesh),
            ("a.glb", Format::Model),
            ("a.png", Format::Picture),
            ("a.npz", Format::Archive),
        ] {
            assert!(is_ours(&at(name), format).unwrap(), "{name}");
            assert!(is_ours(&at("empty"), format).unwrap());
        }
    }

    #[test]
    fn files_of_others_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let foreign: [(&[u8], Format); 6] = [
            (
                b"ply\nformat ascii 1.0\ncomment a scan\nend_header\n",
                Format::Mesh,
            ),
            (b"v 0 0 0\n# mesotex 1\n", Format::Mesh),
            (b"solid cube\n", Format::Mesh),
            (b"\x89PNG\r\n\x1a\n", Format::Picture),
            (b"PK\x05\x06 no archive", Format::Archive),
            (b"a letter", Format::Json),
        ];
        for (bytes, format) in foreign {
            std::fs::write(&path, bytes).unwrap();
            assert!(!is_ours(&path, format).unwrap(), "{format:?}");
        }
    }
}
