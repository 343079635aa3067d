//! PLY files of vertices and faces: ascii or binary in, binary little-endian out.
//!
//! Properties of vertices and faces come as named columns of numbers, faces as polygons of vertex indices with the
//! texture coordinates of their corners. Strips of triangles (`tristrips`) are faces as well. Other list
//! properties and other elements are skipped.

mod polygons;
mod preamble;
mod rows;
mod writing;

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use ply_rs_bw::parser::{Parser, Reader as PlyReader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyType, ScalarType};

pub use crate::format::ply::writing::{Column, write, write_textured, write_with_faces};

use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::mesh_format::MeshFormat;
use crate::format::ply::preamble::Preamble;
use crate::format::ply::rows::{Record, Rows, fault};
use crate::format::polygon_mesh::Polygons;

/// The format.
pub(crate) const FORMAT: MeshFormat = MeshFormat {
    name: "PLY",
    extensions: &["ply"],
    parse: |bytes, _| polygons::parse(bytes),
    splits_vertices: false,
    companions: None,
};

/// What a PLY file holds of vertices and faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlyFile {
    /// Comment lines, without the word `comment`.
    pub comments: Vec<String>,
    /// Vertices in all.
    pub vertex_count: usize,
    /// Scalar vertex properties in the file's order: name and one number per vertex.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Whether the positions are stored in single precision.
    pub single_precision: bool,
    /// The faces; their indices are below [`vertex_count`](Self::vertex_count).
    pub faces: Polygons,
    /// Scalar face properties in the file's order: name and one number per row of the element.
    pub face_columns: Vec<(String, Vec<f64>)>,
    /// Texture coordinates of the faces' corners (face property `texcoord`); NaN where there are none.
    pub corner_uvs: Option<Vec<[f32; 2]>>,
}

impl PlyFile {
    /// A vertex property by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let found = self.columns.iter().find(|(column, _)| column == name)?;
        Some(&found.1)
    }

    /// A face property by name.
    pub fn face_column(&self, name: &str) -> Option<&[f64]> {
        let mut columns = self.face_columns.iter();
        let found = columns.find(|(column, _)| column == name)?;
        Some(&found.1)
    }

    /// A vertex property by name, or an error that says it is missing.
    pub fn require(&self, name: &str) -> Result<&[f64]> {
        self.column(name).ok_or_else(|| {
            Error::data("element vertex", format!("no property `{name}`"))
                .expected("a property of this name")
        })
    }
}

/// Reads a PLY file.
pub fn read(path: &Path) -> Result<PlyFile> {
    let file = File::open(path).map_err(Error::io(path, "read"))?;
    guarded(path, || parse(BufReader::with_capacity(1 << 18, file)))
}

/// How many vertices a PLY file says it has; reads its header alone.
pub fn vertex_count(path: &Path) -> Result<usize> {
    let file = File::open(path).map_err(Error::io(path, "read"))?;
    guarded(path, || {
        let preamble = Preamble::read(&mut BufReader::new(file))?;
        let parser = Parser::<Record>::new();
        let header = parser
            .read_header(&mut PlyReader::new(preamble.text.as_bytes()))
            .map_err(|error| fault("header", &error))?;
        let vertices = header.elements.get("vertex").map(|element| element.count);
        vertices.ok_or_else(|| Error::data("header", "no element `vertex`"))
    })
}

/// Parses a PLY file from any source.
pub fn parse(mut source: impl BufRead) -> Result<PlyFile> {
    let preamble = Preamble::read(&mut source)?;
    let parser = Parser::<Record>::new();
    let mut header = parser
        .read_header(&mut PlyReader::new(preamble.text.as_bytes()))
        .map_err(|error| fault("header", &error))?;
    if header.encoding == Encoding::Ascii {
        read_floats_as_doubles(&mut header);
    }
    let mut ply = PlyFile {
        comments: header.comments.clone(),
        ..PlyFile::default()
    };
    for element in header.elements.values() {
        check_properties(element)?;
        let mut rows = Rows::new(&parser, header.encoding, element, preamble.line_end);
        match element.name.as_str() {
            "vertex" => read_vertices(&mut rows, &mut source, &mut ply)?,
            "face" => read_faces(&mut rows, &mut source, &mut ply)?,
            "tristrips" => read_strips(&mut rows, &mut source, &mut ply)?,
            _ => (0..element.count).try_for_each(|row| rows.next(row, &mut source).map(drop))?,
        }
    }
    check_indices(&ply)?;
    if let Some(uvs) = &mut ply.corner_uvs {
        uvs.resize(ply.faces.corners.len(), [f32::NAN; 2]);
    }
    Ok(ply)
}

/// Text may have more digits than its header says.
fn read_floats_as_doubles(header: &mut Header) {
    let elements = header.elements.iter_mut().map(|(_, element)| element);
    for (_, property) in elements.flat_map(|element| element.properties.iter_mut()) {
        if let PropertyType::Scalar(kind @ ScalarType::Float) = &mut property.data_type {
            *kind = ScalarType::Double;
        }
    }
}

/// Rows without properties are no bytes, so that nothing would end a count beyond all measure.
fn check_properties(element: &ElementDef) -> Result<()> {
    if element.count == 0 || !element.properties.is_empty() {
        return Ok(());
    }
    Err(Error::data(
        format!("element {}", element.name),
        format!("{} rows without properties", element.count),
    )
    .expected("a property, or no rows"))
}

/// A column for every scalar property of an element, as yet without numbers.
fn empty_columns(element: &ElementDef) -> Vec<(String, Vec<f64>)> {
    let scalars = element
        .properties
        .values()
        .filter(|property| matches!(property.data_type, PropertyType::Scalar(_)));
    scalars
        .map(|property| (property.name.clone(), Vec::new()))
        .collect()
}

fn read_vertices(rows: &mut Rows<'_>, source: &mut impl BufRead, ply: &mut PlyFile) -> Result<()> {
    ply.columns = empty_columns(rows.element);
    if ply.columns.len() > Record::MOST_SCALARS {
        return Err(Error::data(
            "element vertex",
            format!("{} properties", ply.columns.len()),
        )
        .expected(format!("at most {}", Record::MOST_SCALARS)));
    }
    ply.vertex_count = rows.element.count;
    let x = rows.element.properties.get("x");
    ply.single_precision =
        x.is_some_and(|x| x.data_type == PropertyType::Scalar(ScalarType::Float));
    for row in 0..rows.element.count {
        let record = rows.next(row, source)?;
        for ((_, column), &value) in ply.columns.iter_mut().zip(&record.scalars) {
            column.push(value);
        }
    }
    Ok(())
}

fn read_faces(rows: &mut Rows<'_>, source: &mut impl BufRead, ply: &mut PlyFile) -> Result<()> {
    ply.face_columns = empty_columns(rows.element);
    ply.face_columns.truncate(Record::MOST_SCALARS);
    for row in 0..rows.element.count {
        let record = rows.next(row, source)?;
        let Some(polygon) = record.indices() else {
            return Err(
                Error::data(format!("face {row}"), "no usable `vertex_indices`")
                    .expected("a list of vertex indices, none negative"),
            );
        };
        ply.faces.push(&polygon);
        for ((_, column), &value) in ply.face_columns.iter_mut().zip(&record.scalars) {
            column.push(value);
        }
        if let Some(uvs) = record.texture_coordinates(polygon.len()) {
            let all = ply.corner_uvs.get_or_insert_default();
            all.resize(ply.faces.corners.len() - polygon.len(), [f32::NAN; 2]);
            all.extend(uvs);
        }
    }
    Ok(())
}

/// Strips of triangles: every index makes one with the two before it, and −1 starts over.
fn read_strips(rows: &mut Rows<'_>, source: &mut impl BufRead, ply: &mut PlyFile) -> Result<()> {
    for row in 0..rows.element.count {
        let record = rows.next(row, source)?;
        let Some(strips) = record.strips() else {
            return Err(
                Error::data(format!("tristrips {row}"), "no usable `vertex_indices`")
                    .expected("a list of vertex indices, with -1 between strips"),
            );
        };
        for strip in strips {
            for (k, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]];
                ply.faces
                    .push(&if k % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
    }
    Ok(())
}

fn check_indices(ply: &PlyFile) -> Result<()> {
    for (face, polygon) in ply.faces.iter().enumerate() {
        if let Some(index) = polygon
            .iter()
            .find(|&&index| index as usize >= ply.vertex_count)
        {
            return Err(
                Error::data(format!("face {face}"), format!("vertex index {index}"))
                    .expected(format!("below {} vertices", ply.vertex_count)),
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Result<PlyFile> {
        parse(text.as_bytes())
    }

    const QUAD: &str = "ply\nformat ascii 1.0\ncomment made by hand\n\
        element vertex 4\nproperty float x\nproperty float y\nproperty uchar red\n\
        element edge 1\nproperty int a\n\
        element face 1\nproperty list uchar int vertex_index\nend_header\n\
        0 0 255\n1 0 0\n1 1 0\n0 1 7\n9\n4 0 1 2 3\n";

    #[test]
    fn ascii_polygons_and_columns_are_read() {
        let ply = parse_text(QUAD).unwrap();
        assert_eq!(ply.comments, ["made by hand"]);
        assert_eq!(ply.column("red").unwrap(), [255.0, 0.0, 0.0, 7.0]);
        assert_eq!(ply.faces.iter().collect::<Vec<_>>(), [[0, 1, 2, 3]]);
        assert!(ply.require("z").unwrap_err().to_string().contains("`z`"));
    }

    #[test]
    fn line_ends_and_encodings_of_other_systems_are_read() {
        let plain = parse_text(QUAD).unwrap();
        assert_eq!(parse_text(&QUAD.replace('\n', "\r")).unwrap(), plain);
        assert_eq!(parse_text(&QUAD.replace('\n', "\r\n")).unwrap(), plain);
        assert_eq!(parse_text(&format!("\u{feff}{QUAD}")).unwrap(), plain);
        let latin: Vec<u8> = QUAD
            .replace("by hand", "in K\u{f6}ln")
            .chars()
            .map(|c| c as u8)
            .collect();
        assert_eq!(parse(latin.as_slice()).unwrap().comments, ["made in Köln"]);
    }

    #[test]
    fn a_binary_body_may_begin_with_a_line_feed() {
        let header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nend_header\n";
        for ends in ["\n", "\r", "\r\n"] {
            let mut bytes = header.replace('\n', ends).into_bytes();
            bytes.push(b'\n');
            assert_eq!(
                parse(bytes.as_slice()).unwrap().column("x").unwrap(),
                [10.0]
            );
        }
    }

    #[test]
    fn strips_are_triangles() {
        let header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n\
            element tristrips 1\nproperty list int int vertex_indices\nend_header\n0\n1\n2\n3\n4\n";
        let mesh = parse_text(&format!("{header}8 0 1 2 3 -1 4 3 2\n")).unwrap();
        assert_eq!(mesh.faces.corners, [0, 1, 2, 2, 1, 3, 4, 3, 2]);
        let error = parse_text(&format!("{header}3 0 1 7\n")).unwrap_err();
        assert!(error.to_string().contains("vertex index 7"), "{error}");
        assert!(parse_text(&format!("{header}3 0 1 -2\n")).is_err());
    }

    #[test]
    fn corners_may_have_texture_coordinates() {
        let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nelement face 2\n\
            property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n\
            0\n1\n2\n3 0 1 2 0\n3 2 1 0 6 0 0 1 0 0 1\n";
        let uvs = parse_text(text).unwrap().corner_uvs.unwrap();
        assert!(uvs[..3].iter().all(|uv| uv[0].is_nan()));
        assert_eq!(uvs[3..], [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    }

    #[test]
    fn text_keeps_more_digits_than_its_header_says() {
        let text =
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n4485513.7\n";
        let ply = parse_text(text).unwrap();
        assert_eq!(ply.column("x").unwrap(), [4_485_513.7]);
        assert!(!ply.single_precision);
    }

    #[test]
    fn rows_without_properties_are_refused_at_once() {
        for kind in ["vertex", "face", "nothing"] {
            let text = format!(
                "ply\nformat binary_little_endian 1.0\nelement {kind} {}\nend_header\n",
                u64::MAX
            );
            let error = parse_text(&text).unwrap_err().to_string();
            assert!(error.contains(&format!("element {kind}")), "{error}");
        }
        let none = "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n";
        assert_eq!(parse_text(none).unwrap().vertex_count, 0);
    }

    #[test]
    fn written_files_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        let x = [1.5f32, -2.0, 0.25];
        let texton = [1u16, 65535, 3];
        write(
            &path,
            &["mesotex 1".into()],
            &[
                ("x", Column::Float(&x)),
                ("texton", Column::UShort(&texton)),
            ],
            &[[0, 1, 2]],
        )
        .unwrap();
        let ply = read(&path).unwrap();
        assert_eq!(ply.comments, ["mesotex 1"]);
        assert_eq!(ply.column("x").unwrap(), [1.5, -2.0, 0.25]);
        assert_eq!(ply.column("texton").unwrap(), [1.0, 65535.0, 3.0]);
        assert_eq!(ply.faces.corners, [0, 1, 2]);
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\ncomment mesotex 1\n"));
        std::fs::write(&path, &bytes[..bytes.len() - 3]).unwrap();
        let cut = read(&path).unwrap_err().to_string();
        assert!(cut.contains("face 0") && cut.contains("a.ply"), "{cut}");
    }

    #[test]
    fn vertices_and_faces_beyond_one_block_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        let count = 2 * writing::WRITTEN + 3;
        let (x, label): (Vec<f32>, Vec<i32>) = (0..count)
            .map(|row| (row as f32 + 0.5, -(row as i32)))
            .unzip();
        let (kind, red): (Vec<u16>, Vec<u8>) =
            (0..count).map(|row| (7 * row as u16, row as u8)).unzip();
        let columns = [
            ("x", Column::Float(&x)),
            ("kind", Column::UShort(&kind)),
            ("red", Column::UChar(&red)),
            ("label", Column::Int(&label)),
        ];
        let triangles: Vec<[u32; 3]> = (0..count as u32 - 2).map(|a| [a, a + 2, a + 1]).collect();
        write(&path, &[], &columns, &triangles).unwrap();
        let ply = read(&path).unwrap();
        let row = count - 2;
        for (name, expected) in [
            ("x", f64::from(x[row])),
            ("kind", f64::from(kind[row])),
            ("red", f64::from(red[row])),
            ("label", f64::from(label[row])),
        ] {
            let column = ply.column(name).unwrap();
            assert_eq!((column.len(), column[row]), (count, expected), "{name}");
        }
        assert_eq!(ply.faces.corners, triangles.as_flattened());
    }

    #[test]
    fn faces_have_properties() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        let count = writing::WRITTEN + 2;
        let x = [0.0f32; 3];
        let source: Vec<u32> = (0..count as u32).map(|face| u32::MAX - face).collect();
        let phase: Vec<u8> = (0..count).map(|face| (face % 3) as u8).collect();
        let triangles = vec![[2, 0, 1]; count];
        let columns = [
            ("source", Column::UInt(&source)),
            ("phase", Column::UChar(&phase)),
        ];
        write_with_faces(
            &path,
            &[],
            &[("x", Column::Float(&x))],
            &triangles,
            &columns,
        )
        .unwrap();
        let ply = read(&path).unwrap();
        assert_eq!(ply.faces.corners, triangles.as_flattened());
        let wanted: Vec<f64> = source.iter().map(|&number| number.into()).collect();
        assert_eq!(ply.face_column("source").unwrap(), wanted);
        assert_eq!(
            ply.face_column("phase").unwrap()[count - 1],
            ((count - 1) % 3) as f64
        );
        assert!(ply.face_column("x").is_none());
    }

    #[test]
    fn broken_files_are_refused_by_place() {
        let broken =
            |from: &str, to: &str| parse_text(&QUAD.replace(from, to)).unwrap_err().to_string();
        assert!(broken("4 0 1 2 3", "4 0 1 2 4").contains("vertex index 4"));
        assert!(broken("4 0 1 2 3", "4 0 1 2 -1").contains("face 0"));
        assert!(broken("1 1 0\n", "1 one 0\n").contains("vertex 2"));
        assert!(broken("element vertex 4", "element vertex 4000000000").contains("vertex"));
        assert!(broken("ply\n", "obj\n").contains("header"));
    }
}
