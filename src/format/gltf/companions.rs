//! The files a glTF names: buffers and images beside it. They belong to the mesh as its own bytes do.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::{Error, Result};
use crate::format::gltf::buffers::file_name;
use crate::format::{atomic, source};

/// The largest description looked into, in bytes.
const LIMIT: u64 = 64 << 20;

/// The files beside `path` that it names; none for a file that is not there, and for one whose description cannot be
/// parsed, which its reader refuses.
pub(super) fn companions(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let extension = path.extension().unwrap_or_default();
    let description = match extension.eq_ignore_ascii_case("gz") {
        true => description_of(source::read(path)?.as_slice()),
        false => File::open(path).and_then(description_of),
    };
    let description = description.map_err(Error::io(path, "read"))?;
    let Ok(description) = serde_json::from_slice::<Value>(&description) else {
        return Ok(Vec::new());
    };
    let lists = ["buffers", "images"].map(|list| description[list].as_array());
    let entries = lists.into_iter().flatten().flatten();
    Ok(entries
        .filter_map(|entry| entry["uri"].as_str())
        .filter(|uri| !uri.starts_with("data:") && !uri.contains("://"))
        .map(|uri| atomic::parent(path).join(&*file_name(uri)))
        .collect())
}

/// The JSON of a glTF: the whole of a text file, the first chunk of a binary one.
fn description_of(mut file: impl Read) -> io::Result<Vec<u8>> {
    let mut description = Vec::new();
    file.by_ref().take(20).read_to_end(&mut description)?;
    let mut length = LIMIT;
    if let [b'g', b'l', b'T', b'F', .., a, b, c, d, _, _, _, _] = description[..] {
        length = length.min(u32::from_le_bytes([a, b, c, d]).into());
        description.clear();
    }
    file.take(length).read_to_end(&mut description)?;
    Ok(description)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::gltf::{self, GltfMesh};

    #[test]
    fn buffers_and_images_are_named_and_inner_data_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        let text = r#"{"buffers": [{"uri": "a%20b.bin"}, {"uri": "data:;base64,AA=="}, {}],
            "images": [{"uri": "bark.png"}]}"#;
        std::fs::write(&path, text).unwrap();
        let expected = ["a b.bin", "bark.png"].map(|name| folder.path().join(name));
        assert_eq!(companions(&path).unwrap(), expected);
        std::fs::write(&path, "no JSON").unwrap();
        assert!(companions(&path).unwrap().is_empty());
        assert!(
            companions(&folder.path().join("b.gltf"))
                .unwrap()
                .is_empty()
        );
    }

    #[test]
    fn a_binary_file_is_read_as_far_as_its_description() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let points = [[0.0; 3]];
        let mesh = GltfMesh {
            origin: [0.0; 3],
            uvs: None,
            positions: &points,
            normals: &points,
            triangles: &[],
            ..GltfMesh::default()
        };
        gltf::write(&path, &mesh).unwrap();
        let description = description_of(File::open(&path).unwrap()).unwrap();
        let description: Value = serde_json::from_slice(&description).unwrap();
        assert_eq!(description["asset"]["generator"], "mesotex");
    }
}
