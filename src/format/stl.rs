//! STL, text or binary: triangles that share no vertices. Facet normals are skipped: they follow from the corners.

use crate::error::{Error, Result};
use crate::format::mesh_format::MeshFormat;
use crate::format::polygon_mesh::PolygonMesh;
use crate::format::text;

/// The format.
pub(crate) const FORMAT: MeshFormat = MeshFormat {
    name: "STL",
    extensions: &["stl"],
    parse: |bytes, _| parse(bytes),
    splits_vertices: true,
    companions: None,
};

/// Bytes before the first triangle of a binary file, and bytes per triangle.
const BINARY_HEADER: usize = 84;
const BINARY_TRIANGLE: usize = 50;

/// Parses an STL file's bytes. Every facet has vertices of its own, in the file's order.
pub fn parse(bytes: &[u8]) -> Result<PolygonMesh> {
    match is_text(bytes) {
        true => parse_text(&text::decode(bytes)?.text),
        false => parse_binary(bytes),
    }
}

/// A binary file may begin with `solid` as well, but its header, or the count behind it, holds a zero
/// byte; text holds none.
fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(BINARY_HEADER)];
    if start.starts_with(&[0xFF, 0xFE]) || start.starts_with(&[0xFE, 0xFF]) {
        return true;
    }
    let word = String::from_utf8_lossy(start)
        .trim_start_matches('\u{feff}')
        .trim_start()
        .get(..5)
        .map(str::to_ascii_lowercase);
    let begins_as_text = matches!(word.as_deref(), Some("solid" | "facet"));
    begins_as_text && !start.contains(&0)
}

fn parse_binary(bytes: &[u8]) -> Result<PolygonMesh> {
    let header = bytes.get(80..BINARY_HEADER).and_then(|b| b.try_into().ok());
    let Some(count) = header.map(u32::from_le_bytes) else {
        return Err(Error::data("header", format!("{} bytes", bytes.len()))
            .expected("an STL file: at least 84 bytes, or text that begins with solid"));
    };
    let stated = (count as usize)
        .saturating_mul(BINARY_TRIANGLE)
        .saturating_add(BINARY_HEADER);
    if stated > bytes.len() {
        return Err(Error::data("length", format!("{} bytes", bytes.len()))
            .expected(format!("{stated}, for the {count} triangles of its header"))
            .advice("the file is truncated, or not an STL file"));
    }
    let mut mesh = PolygonMesh {
        single_precision: true,
        ..PolygonMesh::default()
    };
    for record in bytes[BINARY_HEADER..stated].chunks_exact(BINARY_TRIANGLE) {
        let number = |at: usize| {
            let four = std::array::from_fn(|byte| record[at + byte]);
            f64::from(f32::from_le_bytes(four))
        };
        let corner = |k: usize| std::array::from_fn(|axis| number(12 + 12 * k + 4 * axis));
        push_facet(&mut mesh, &[corner(0), corner(1), corner(2)]);
    }
    if stated < bytes.len() {
        let rest = bytes.len() - stated;
        mesh.unused
            .push(format!("{rest} bytes after the last triangle are ignored"));
    }
    Ok(mesh)
}

fn push_facet(mesh: &mut PolygonMesh, corners: &[[f64; 3]]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend_from_slice(corners);
    let corners: Vec<u32> = (first..mesh.positions.len() as u32).collect();
    mesh.faces.push(&corners);
}

/// Where a text file stands between `facet` and `endfacet`.
#[derive(Default)]
struct Facet {
    is_open: bool,
    corners: Vec<[f64; 3]>,
}

/// Reads the facets of all solids.
fn parse_text(text: &str) -> Result<PolygonMesh> {
    let mut mesh = PolygonMesh::default();
    let mut facet = Facet::default();
    let mut words = words(text);
    while let Some((line, word)) = words.next() {
        match word.to_ascii_lowercase().as_str() {
            "facet" => facet = opened(&facet, line)?,
            "vertex" => {
                let mut corner = [0.0; 3];
                for value in &mut corner {
                    *value = number(words.next(), line)?;
                }
                facet.corners.push(corner);
            }
            "endfacet" => {
                check_corners(&facet, line)?;
                push_facet(&mut mesh, &facet.corners);
                facet = Facet::default();
            }
            // The numbers of a normal, `normal` itself, `outer loop` and `endloop`.
            _ => {}
        }
    }
    match facet.is_open {
        false => Ok(mesh),
        true => Err(Error::data("end of file", "a facet without endfacet")
            .expected("endfacet")
            .advice("the file is truncated")),
    }
}

/// The words of a text with their lines. Lines that name a solid are left out: a name may hold any word.
fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_name = |line: &str| {
        let word = line.split_ascii_whitespace().next().unwrap_or_default();
        word.eq_ignore_ascii_case("solid") || word.eq_ignore_ascii_case("endsolid")
    };
    text::lines(text)
        .filter(move |(_, line)| !is_name(line))
        .flat_map(|(number, line)| {
            line.split_ascii_whitespace()
                .map(move |word| (number, word))
        })
}

fn opened(before: &Facet, line: usize) -> Result<Facet> {
    if before.is_open {
        return Err(
            Error::data(format!("line {line}"), "facet inside a facet").expected("endfacet first")
        );
    }
    Ok(Facet {
        is_open: true,
        corners: Vec::with_capacity(3),
    })
}

fn check_corners(facet: &Facet, line: usize) -> Result<()> {
    if facet.is_open && facet.corners.len() >= 3 {
        return Ok(());
    }
    let found = format!("a facet of {} vertices", facet.corners.len());
    Err(Error::data(format!("line {line}"), found).expected("3"))
}

fn number(word: Option<(usize, &str)>, line: usize) -> Result<f64> {
    let Some((line, word)) = word else {
        return Err(
            Error::data(format!("line {line}"), "the file is truncated").expected("a number")
        );
    };
    word.parse()
        .map_err(|_| Error::data(format!("line {line}"), format!("`{word}`")).expected("a number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid\nFACET normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n \
        vertex 0 1 0\n endloop\nendfacet\nendsolid\n";

    fn binary(count: u32) -> Vec<u8> {
        let mut bytes = b"solid but binary".to_vec();
        bytes.resize(80, b' ');
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
        let binary = parse(&binary(1)).unwrap();
        assert_eq!(
            (text.positions, text.faces),
            (binary.positions, binary.faces)
        );
        assert!(binary.single_precision && !text.single_precision);
    }

    #[test]
    fn all_solids_of_a_text_are_read_whatever_they_are_called() {
        let text = format!("{TEXT}{}", TEXT.replace("solid", "solid vertex of a facet"));
        for text in [
            text.clone(),
            text.replace('\n', "\r"),
            format!("\u{feff}{text}"),
        ] {
            let mesh = parse(text.as_bytes()).unwrap();
            assert_eq!(mesh.faces.sizes, [3, 3]);
            assert_eq!(mesh.positions[3..], mesh.positions[..3]);
        }
    }

    #[test]
    fn normals_need_not_be_numbers() {
        let text = TEXT.replace("normal 0 0 1", "normal -nan(ind) 1.#QNAN nan");
        assert_eq!(
            parse(text.as_bytes()).unwrap(),
            parse(TEXT.as_bytes()).unwrap()
        );
    }

    #[test]
    fn what_follows_the_last_triangle_is_noted() {
        let mut long = binary(1);
        long.extend(b"appended by a scanner");
        let mesh = parse(&long).unwrap();
        assert_eq!(mesh.faces.sizes, [3]);
        assert!(mesh.unused[0].contains("21 bytes"));
    }

    #[test]
    fn broken_files_are_refused() {
        let mut long = binary(1);
        long[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        long[40] = 0;
        assert!(parse(&long).unwrap_err().to_string().contains("length"));
        let error = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert!(
            error(&TEXT[..60]).contains("end of file") || error(&TEXT[..60]).contains("number")
        );
        assert!(error(&TEXT.replace("vertex 1 0 0", "")).contains("2 vertices"));
        assert!(error(&TEXT.replace("endfacet", "facet")).contains("line 8"));
        assert!(error(&TEXT.replace("vertex 1 0 0", "vertex 1 zero 0")).contains("`zero`"));
        assert!(error("abc").contains("header"));
    }
}
