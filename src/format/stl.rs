//! STL, text or binary: triangles that share no vertices.

use std::io::Cursor;

use crate::error::{Error, Result};
use crate::format::polygon_mesh::PolygonMesh;

/// Bytes before the first triangle of a binary file, and bytes a triangle.
const BINARY_HEADER: usize = 84;
const BINARY_TRIANGLE: usize = 50;

/// Parses an STL file's bytes. Every triangle has three vertices of its own, in the file's order.
pub fn parse(bytes: &[u8]) -> Result<PolygonMesh> {
    let binary = is_binary(bytes);
    if binary {
        check_length(bytes)?;
    } else if bytes.trim_ascii_start().len() < b"solid".len() {
        return Err(Error::data("header", format!("{} bytes", bytes.len())).expected("an STL file"));
    }
    let mut mesh = PolygonMesh {
        splits_vertices: true,
        ..PolygonMesh::default()
    };
    let text;
    let content = if binary {
        bytes
    } else {
        text = normalised(bytes);
        text.as_bytes()
    };
    let mut cursor = Cursor::new(content);
    let fault = |triangle: usize, error: std::io::Error| {
        Error::data(format!("triangle {triangle}"), error.to_string())
            .advice("the file is cut off or is no sound STL")
    };
    let reader = stl_io::create_stl_reader(&mut cursor).map_err(|error| fault(0, error))?;
    for (number, triangle) in reader.enumerate() {
        let triangle = triangle.map_err(|error| fault(number, error))?;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(triangle.vertices.map(|v| v.0));
        mesh.faces.push(&[first, first + 1, first + 2]);
    }
    Ok(mesh)
}

/// A binary file is as long as its count says, whatever it begins with.
fn is_binary(bytes: &[u8]) -> bool {
    let starts_as_text = bytes.trim_ascii_start().starts_with(b"solid");
    !starts_as_text || stated_length(bytes) == Some(bytes.len())
}

fn stated_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..84)?;
    let count = u32::from_le_bytes(count.try_into().ok()?) as usize;
    Some(BINARY_HEADER + count * BINARY_TRIANGLE)
}

fn check_length(bytes: &[u8]) -> Result<()> {
    match stated_length(bytes) {
        Some(stated) if stated <= bytes.len() => Ok(()),
        Some(stated) => Err(Error::data("length", format!("{} bytes", bytes.len()))
            .expected(format!("{stated}, for the count in the header"))),
        None => Err(Error::data("header", format!("{} bytes", bytes.len()))
            .expected("an STL file: at least 84 bytes, or text that begins with solid")),
    }
}

/// Text with the keywords in lower case and a name after `solid`, as stl_io wants it.
fn normalised(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes).to_ascii_lowercase();
    let body = text.trim_start();
    let (head, rest) = body.split_once('\n').unwrap_or((body, ""));
    let name = head.trim().strip_prefix("solid").unwrap_or_default().trim();
    format!("solid {name}\n{rest}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid\nFACET normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n \
        vertex 0 1 0\n endloop\nendfacet\nendsolid\n";

    fn binary(count: u32) -> Vec<u8> {
        let mut bytes = b"solid but binary".to_vec();
        bytes.resize(80, 0);
        bytes.extend(count.to_le_bytes());
        for value in [0f32, 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.] {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0; 2]);
        bytes
    }

    #[test]
    fn text_and_binary_hold_the_same() {
        let text = parse(TEXT.as_bytes()).unwrap();
        assert_eq!(text.positions, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
        assert_eq!(text, parse(&binary(1)).unwrap());
    }

    #[test]
    fn broken_files_are_refused() {
        let mut long = binary(1);
        long[0] = b'x';
        long[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(parse(&long).unwrap_err().to_string().contains("length"));
        let cut = &TEXT.as_bytes()[..60];
        assert!(parse(cut).unwrap_err().to_string().contains("triangle 0"));
        assert!(parse(b"abc").unwrap_err().to_string().contains("header"));
    }
}
