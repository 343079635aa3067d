//! OFF, the Object File Format of Geomview, in text: positions and polygons.
//!
//! Normals, colours and texture coordinates that stand between (NOFF, COFF, STOFF, in any order and case) are
//! skipped. Values may wrap over lines. Binary and n-dimensional files are refused.

mod header;
mod values;

use crate::error::{Error, Result};
use crate::format::mesh_format::MeshFormat;
use crate::format::off::header::Header;
use crate::format::off::values::Values;
use crate::format::polygon_mesh::PolygonMesh;
use crate::format::text;

/// The format.
pub(crate) const FORMAT: MeshFormat = MeshFormat {
    name: "OFF",
    extensions: &["off"],
    parse: |bytes, _| parse(bytes),
    splits_vertices: false,
    companions: None,
};

/// How the numbers of vertices are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// A vertex per line, whatever follows its position there.
    Lines,
    /// So many numbers per vertex, wherever lines end.
    Numbers(usize),
}

/// Parses an OFF file's bytes.
pub fn parse(bytes: &[u8]) -> Result<PolygonMesh> {
    let text = text::decode(bytes)?.text;
    let (header, values) = Header::read(Values::new(&text))?;
    let by_line = body(&header, values.clone(), Layout::Lines);
    let Err(fault) = by_line else { return by_line };
    let mut layouts = header.numbers_per_vertex().into_iter();
    layouts
        .find_map(|count| body(&header, values.clone(), Layout::Numbers(count)).ok())
        .ok_or(fault)
}

fn body(header: &Header, mut values: Values<'_>, layout: Layout) -> Result<PolygonMesh> {
    let mut mesh = PolygonMesh::default();
    if !header.has_keyword {
        mesh.unused.push("no OFF keyword: read as plain OFF".into());
    }
    match layout {
        Layout::Lines => values.end_line(),
        // The count of edges.
        Layout::Numbers(_) => drop(values.number::<usize>(true)?),
    }
    let count = header.vertices;
    for vertex in 0..count {
        values.check_left(|| format!("vertex {vertex} of {count}"))?;
        mesh.positions.push(position(header, &mut values, layout)?);
    }
    let mut small_faces = 0;
    for face in 0..header.faces {
        values.check_left(|| format!("face {face} of {}", header.faces))?;
        small_faces += usize::from(!take_face(&mut mesh, &mut values, layout)?);
    }
    if layout != Layout::Lines {
        values.check_end()?;
    }
    mesh.note_small_faces(small_faces);
    Ok(mesh)
}

fn position(header: &Header, values: &mut Values<'_>, layout: Layout) -> Result<[f64; 3]> {
    let wraps = layout != Layout::Lines;
    let mut position = [0.0; 3];
    for value in &mut position {
        *value = values.number(wraps)?;
    }
    if header.is_homogeneous {
        let weight: f64 = values.number(wraps)?;
        position = position.map(|value| value / weight);
    }
    match layout {
        Layout::Lines => values.end_line(),
        Layout::Numbers(count) => {
            for _ in header.position_numbers()..count {
                values.number::<f64>(true)?;
            }
        }
    }
    Ok(position)
}

/// Takes a face, whose line its colour ends; says whether it has corners enough.
fn take_face(mesh: &mut PolygonMesh, values: &mut Values<'_>, layout: Layout) -> Result<bool> {
    let wraps = layout != Layout::Lines;
    let size: usize = values.number(wraps)?;
    let begin = mesh.faces.corners.len();
    for _ in 0..size {
        let index: u32 = values.number(wraps)?;
        if index as usize >= mesh.positions.len() {
            return Err(Error::data(values.place(), format!("vertex index {index}"))
                .expected(format!("below {} vertices", mesh.positions.len())));
        }
        mesh.faces.corners.push(index);
    }
    values.end_line();
    if size < 3 {
        mesh.faces.corners.truncate(begin);
        return Ok(false);
    }
    mesh.faces.sizes.push(size as u32);
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: &str = "\n0 0 0 255\n1 0 0 # x\n\n1 1 0\n0 1 0\n4 0 1 2 3 0.5 0.5\n2 0 1\n";

    #[test]
    fn odd_headers_comments_and_colours_are_read() {
        for head in [
            "OFF\n4 2 0",
            "  OFF4 2 0 # or nah",
            "COFF # colours\n\n4 2 5",
            "noff 4 2",
            "NCOFF 4 2 0",
            "CstNoff\n4 2 0",
            "\u{feff}nOFF 3 4 2 0",
            "4 2 0",
        ] {
            for text in [
                format!("{head}{BODY}"),
                format!("{head}{BODY}").replace('\n', "\r"),
            ] {
                let mesh = parse(text.as_bytes()).unwrap();
                assert_eq!(mesh.positions.len(), 4);
                assert_eq!(mesh.positions[2], [1.0, 1.0, 0.0]);
                assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2, 3]]);
                assert_eq!(mesh.notes.len(), 1);
                assert_eq!(mesh.unused.len(), usize::from(head == "4 2 0"));
            }
        }
    }

    #[test]
    fn values_may_wrap_over_lines() {
        let plain = parse(b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
        let colour = "0 0 255 255";
        for text in [
            "OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2".to_owned(),
            "OFF\n3\n1 0\n0 0\n0 1 0 0\n0 1\n0\n3 0\n1 2 255 0 0\n".to_owned(),
            "NOFF 3 1 0\n0 0 0\n0 0 1\n1 0 0 0 0 1 0 1 0 0 0 1\n3 0 1\n2\n".to_owned(),
            format!("COFF 3 1 0\n0 0 0\n{colour} 1 0 0 {colour} 0 1 0 {colour}\n3 0 1 2 9\n"),
            "COFF 3 1 0\n0 0 0\n9 9 9 1 0 0 9 9 9 0 1 0 9 9 9\n3 0 1 2\n".to_owned(),
        ] {
            let mesh = parse(text.as_bytes()).unwrap();
            assert_eq!(mesh, plain, "{text}");
        }
    }

    #[test]
    fn homogeneous_positions_are_divided() {
        let mesh = parse(b"4OFF 3 1 0\n0 0 0 1\n2 0 0 2\n0 3 0 3\n3 0 1 2\n").unwrap();
        assert_eq!(mesh.positions[1..], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn broken_files_say_where() {
        let error = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert!(error("OFF\n2 1 0\n0 0 0\n1 0 0\n3 0 1 2\n").contains("vertex index 2"));
        assert!(error("OFF\n3000000000 1 0\n0 0 0\n").contains("vertex 1 of 3000000000"));
        assert!(error("nOFF 4\n1 0 0\n").contains("dimension 4"));
        assert!(error("XOFF\n1 0 0\n").contains("`XOFF`"));
        assert!(error("OFF BINARY\n").contains("BINARY"));
        assert!(error("OFF\n1 1 0\n0 zero 0\n").contains("line 3"));
        assert!(error("").contains("OFF"));
    }
}
