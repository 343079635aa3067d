//! PLY files of vertices and faces: ascii or binary in, binary little-endian out.
//!
//! Vertex properties come as named columns of numbers, faces as polygons of vertex indices. List
//! properties of vertices and elements other than `vertex` and `face` are skipped.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::ops::Range;
use std::path::Path;

use ply_rs_bw::parser::{ParseError, Parser, Reader as PlyReader};
use ply_rs_bw::ply::{
    Addable, DefaultElement, ElementDef, Encoding, Header, Property, PropertyAccess,
    PropertyAccessResult, PropertyDef, PropertyType, ScalarType,
};
use ply_rs_bw::writer::Writer;

use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::guard::guarded;

/// Vertices, or faces, that are written at once.
const WRITTEN: usize = 1024;

/// Polygons of any number of corners, in one flat list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Polygons {
    /// Corners of each polygon.
    pub sizes: Vec<u32>,
    /// Vertex indices, polygon after polygon.
    pub corners: Vec<u32>,
}

impl Polygons {
    /// Adds a polygon.
    pub fn push(&mut self, polygon: &[u32]) {
        self.sizes.push(polygon.len() as u32);
        self.corners.extend_from_slice(polygon);
    }

    /// The polygons, one after the other.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = self.corners.as_slice();
        self.sizes.iter().map(move |&size| {
            let (polygon, tail) = rest.split_at(size as usize);
            rest = tail;
            polygon
        })
    }
}

/// What a PLY file holds of vertices and faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlyFile {
    /// Comment lines, without the word `comment`.
    pub comments: Vec<String>,
    /// Vertices in all.
    pub vertex_count: usize,
    /// Scalar vertex properties in the file's order: name and one number a vertex.
    pub columns: Vec<(String, Vec<f64>)>,
    /// The faces; their indices are below [`vertex_count`](Self::vertex_count).
    pub faces: Polygons,
}

impl PlyFile {
    /// A vertex property by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let found = self.columns.iter().find(|(column, _)| column == name)?;
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

/// Parses a PLY file from any source.
pub fn parse(source: impl BufRead) -> Result<PlyFile> {
    let parser = Parser::<Record>::new();
    let mut reader = PlyReader::new(source);
    let header = parser
        .read_header(&mut reader)
        .map_err(|error| fault("header", &error))?;
    let mut source = reader.into_inner();
    let mut ply = PlyFile {
        comments: header.comments.clone(),
        ..PlyFile::default()
    };
    for element in header.elements.values() {
        check_properties(element)?;
        let mut rows = Rows {
            parser: &parser,
            encoding: header.encoding,
            element,
            line: String::new(),
        };
        match element.name.as_str() {
            "vertex" => read_vertices(&mut rows, &mut source, &mut ply)?,
            "face" => read_faces(&mut rows, &mut source, &mut ply)?,
            _ => (0..element.count).try_for_each(|row| rows.next(row, &mut source).map(drop))?,
        }
    }
    check_indices(&ply)?;
    Ok(ply)
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

fn fault(place: impl Into<String>, error: &dyn std::fmt::Display) -> Error {
    Error::data(place, error.to_string()).advice("the file is cut off or is no sound PLY")
}

/// Reads the rows of one element, in either encoding.
struct Rows<'a> {
    parser: &'a Parser<Record>,
    encoding: Encoding,
    element: &'a ElementDef,
    line: String,
}

impl Rows<'_> {
    fn next(&mut self, row: usize, source: &mut impl BufRead) -> Result<Record> {
        let record = match self.encoding {
            Encoding::Ascii => self.next_line(source),
            Encoding::BinaryLittleEndian => {
                self.parser.read_little_endian_element(source, self.element)
            }
            Encoding::BinaryBigEndian => self.parser.read_big_endian_element(source, self.element),
        };
        record.map_err(|error| fault(format!("{} {row}", self.element.name), &error))
    }

    fn next_line(&mut self, source: &mut impl BufRead) -> std::result::Result<Record, ParseError> {
        self.line.clear();
        while self.line.trim().is_empty() {
            self.line.clear();
            if source.read_line(&mut self.line)? == 0 {
                return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
            }
        }
        self.parser.read_ascii_element(&self.line, self.element)
    }
}

fn read_vertices(rows: &mut Rows<'_>, source: &mut impl BufRead, ply: &mut PlyFile) -> Result<()> {
    let scalars = rows
        .element
        .properties
        .values()
        .filter(|property| matches!(property.data_type, PropertyType::Scalar(_)));
    ply.columns = scalars
        .map(|property| (property.name.clone(), Vec::new()))
        .collect();
    if ply.columns.len() > Record::MOST_SCALARS {
        return Err(Error::data(
            "element vertex",
            format!("{} properties", ply.columns.len()),
        )
        .expected(format!("at most {}", Record::MOST_SCALARS)));
    }
    ply.vertex_count = rows.element.count;
    for row in 0..rows.element.count {
        let record = rows.next(row, source)?;
        for ((_, column), &value) in ply.columns.iter_mut().zip(&record.scalars) {
            column.push(value);
        }
    }
    Ok(())
}

fn read_faces(rows: &mut Rows<'_>, source: &mut impl BufRead, ply: &mut PlyFile) -> Result<()> {
    for row in 0..rows.element.count {
        let record = rows.next(row, source)?;
        let Some(polygon) = record.indices else {
            return Err(
                Error::data(format!("face {row}"), "no usable `vertex_indices`")
                    .expected("a list of vertex indices, none negative"),
            );
        };
        ply.faces.push(&polygon);
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

/// One row of any element: its scalars in order, and its list of vertex indices.
#[derive(Debug)]
struct Record {
    scalars: [f64; Self::MOST_SCALARS],
    filled: usize,
    indices: Option<Vec<u32>>,
}

impl Record {
    const MOST_SCALARS: usize = 64;

    fn push(&mut self, value: f64) -> PropertyAccessResult {
        if let Some(slot) = self.scalars.get_mut(self.filled) {
            *slot = value;
            self.filled += 1;
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Record {
    fn new() -> Self {
        Self {
            scalars: [0.0; Self::MOST_SCALARS],
            filled: 0,
            indices: None,
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match property {
            Property::Char(v) => self.push(v.into()),
            Property::UChar(v) => self.push(v.into()),
            Property::Short(v) => self.push(v.into()),
            Property::UShort(v) => self.push(v.into()),
            Property::Int(v) => self.push(v.into()),
            Property::UInt(v) => self.push(v.into()),
            Property::Float(v) => self.push(v.into()),
            Property::Double(v) => self.push(v),
            list if matches!(name, "vertex_indices" | "vertex_index") => {
                self.indices = list.to_u32_list();
                PropertyAccessResult::Set
            }
            _ => PropertyAccessResult::Ignored,
        }
    }
}

/// The numbers of a vertex property to be written.
#[derive(Clone, Copy, Debug)]
pub enum Column<'a> {
    /// `float`
    Float(&'a [f32]),
    /// `ushort`
    UShort(&'a [u16]),
    /// `uchar`
    UChar(&'a [u8]),
    /// `int`
    Int(&'a [i32]),
}

impl Column<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Float(values) => values.len(),
            Self::UShort(values) => values.len(),
            Self::UChar(values) => values.len(),
            Self::Int(values) => values.len(),
        }
    }

    fn scalar_type(&self) -> ScalarType {
        match self {
            Self::Float(_) => ScalarType::Float,
            Self::UShort(_) => ScalarType::UShort,
            Self::UChar(_) => ScalarType::UChar,
            Self::Int(_) => ScalarType::Int,
        }
    }

    /// Puts the numbers of some rows into their records: `size` bytes each, this number `offset` behind
    /// their start.
    fn fill(&self, rows: Range<usize>, records: &mut [u8], size: usize, offset: usize) {
        match self {
            Self::Float(values) => fill(&values[rows], f32::to_le_bytes, records, size, offset),
            Self::UShort(values) => fill(&values[rows], u16::to_le_bytes, records, size, offset),
            Self::UChar(values) => fill(&values[rows], u8::to_le_bytes, records, size, offset),
            Self::Int(values) => fill(&values[rows], i32::to_le_bytes, records, size, offset),
        }
    }

    /// Bytes a number.
    fn size(&self) -> usize {
        match self {
            Self::Float(_) | Self::Int(_) => 4,
            Self::UShort(_) => 2,
            Self::UChar(_) => 1,
        }
    }
}

fn fill<T: Copy, const N: usize>(
    values: &[T],
    bytes: impl Fn(T) -> [u8; N],
    records: &mut [u8],
    size: usize,
    offset: usize,
) {
    for (record, &value) in records.chunks_exact_mut(size).zip(values) {
        record[offset..][..N].copy_from_slice(&bytes(value));
    }
}

/// Writes a binary little-endian PLY of vertices and triangles.
pub fn write(
    path: &Path,
    comments: &[String],
    columns: &[(&str, Column<'_>)],
    triangles: &[[u32; 3]],
) -> Result<()> {
    let header = header_of(comments, columns, triangles.len());
    atomic::write_file(path, |sink| {
        Writer::<DefaultElement>::new().write_header(sink, &header)?;
        write_vertices(sink, columns)?;
        write_faces(sink, triangles)
    })
}

/// Writes the vertices, some at a time, column after column of them.
fn write_vertices(sink: &mut impl Write, columns: &[(&str, Column<'_>)]) -> io::Result<()> {
    let count = columns.first().map_or(0, |(_, column)| column.len());
    let size: usize = columns.iter().map(|(_, column)| column.size()).sum();
    let mut records = vec![0; WRITTEN.min(count) * size];
    for start in (0..count).step_by(WRITTEN) {
        let rows = start..(start + WRITTEN).min(count);
        let mut offset = 0;
        for (_, column) in columns {
            column.fill(rows.clone(), &mut records, size, offset);
            offset += column.size();
        }
        sink.write_all(&records[..rows.len() * size])?;
    }
    Ok(())
}

fn write_faces(sink: &mut impl Write, triangles: &[[u32; 3]]) -> io::Result<()> {
    const SIZE: usize = 1 + size_of::<[u32; 3]>();
    let mut records = vec![3; WRITTEN.min(triangles.len()) * SIZE];
    for triangles in triangles.chunks(WRITTEN) {
        for (record, triangle) in records.chunks_exact_mut(SIZE).zip(triangles) {
            for (bytes, corner) in record[1..].chunks_exact_mut(4).zip(triangle) {
                bytes.copy_from_slice(&corner.to_le_bytes());
            }
        }
        sink.write_all(&records[..triangles.len() * SIZE])?;
    }
    Ok(())
}

fn header_of(comments: &[String], columns: &[(&str, Column<'_>)], triangles: usize) -> Header {
    let mut vertex = ElementDef::new("vertex".into());
    vertex.count = columns.first().map_or(0, |(_, column)| column.len());
    for (name, column) in columns {
        debug_assert_eq!(column.len(), vertex.count);
        let data_type = PropertyType::Scalar(column.scalar_type());
        vertex
            .properties
            .add(PropertyDef::new((*name).into(), data_type));
    }
    let mut face = ElementDef::new("face".into());
    face.count = triangles;
    let list = PropertyType::List(ScalarType::UChar, ScalarType::Int);
    face.properties
        .add(PropertyDef::new("vertex_indices".into(), list));
    let mut header = Header::new();
    header.encoding = Encoding::BinaryLittleEndian;
    header.comments = comments.to_vec();
    header.elements.add(vertex);
    header.elements.add(face);
    header
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
        let count = 2 * WRITTEN + 3;
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
