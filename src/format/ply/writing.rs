//! Vertices and triangles into a binary PLY.

use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;

use ply_rs_bw::ply::{
    Addable, DefaultElement, ElementDef, Encoding, Header, PropertyDef, PropertyType, ScalarType,
};
use ply_rs_bw::writer::Writer;

use crate::error::Result;
use crate::format::atomic;

/// Vertices, or faces, that are written at once.
pub(super) const WRITTEN: usize = 1024;

/// The numbers of a property to be written, of vertices or faces.
#[derive(Clone, Copy, Debug)]
pub enum Column<'a> {
    /// `float`
    Float(&'a [f32]),
    /// `double`
    Double(&'a [f64]),
    /// `ushort`
    UShort(&'a [u16]),
    /// `uchar`
    UChar(&'a [u8]),
    /// `int`
    Int(&'a [i32]),
    /// `uint`
    UInt(&'a [u32]),
}

impl Column<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Float(values) => values.len(),
            Self::Double(values) => values.len(),
            Self::UShort(values) => values.len(),
            Self::UChar(values) => values.len(),
            Self::Int(values) => values.len(),
            Self::UInt(values) => values.len(),
        }
    }

    fn scalar_type(&self) -> ScalarType {
        match self {
            Self::Float(_) => ScalarType::Float,
            Self::Double(_) => ScalarType::Double,
            Self::UShort(_) => ScalarType::UShort,
            Self::UChar(_) => ScalarType::UChar,
            Self::Int(_) => ScalarType::Int,
            Self::UInt(_) => ScalarType::UInt,
        }
    }

    /// Puts the numbers of some rows into their records: `size` bytes each, this number `offset` behind
    /// their start.
    fn fill(&self, rows: Range<usize>, records: &mut [u8], size: usize, offset: usize) {
        match self {
            Self::Float(values) => fill(&values[rows], f32::to_le_bytes, records, size, offset),
            Self::Double(values) => fill(&values[rows], f64::to_le_bytes, records, size, offset),
            Self::UShort(values) => fill(&values[rows], u16::to_le_bytes, records, size, offset),
            Self::UChar(values) => fill(&values[rows], u8::to_le_bytes, records, size, offset),
            Self::Int(values) => fill(&values[rows], i32::to_le_bytes, records, size, offset),
            Self::UInt(values) => fill(&values[rows], u32::to_le_bytes, records, size, offset),
        }
    }

    /// Bytes per number.
    fn size(&self) -> usize {
        match self {
            Self::Double(_) => 8,
            Self::Float(_) | Self::Int(_) | Self::UInt(_) => 4,
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
    write_with_faces(path, comments, columns, triangles, &[])
}

/// Writes a PLY as [`write()`] does, with scalar properties of the triangles.
pub fn write_with_faces(
    path: &Path,
    comments: &[String],
    columns: &[(&str, Column<'_>)],
    triangles: &[[u32; 3]],
    face_columns: &[(&str, Column<'_>)],
) -> Result<()> {
    let mut header = header_of(comments, columns, triangles.len());
    if let Some(face) = header.elements.get_mut("face") {
        add_scalars(face, face_columns);
    }
    atomic::write_file(path, |sink| {
        Writer::<DefaultElement>::new().write_header(sink, &header)?;
        write_vertices(sink, columns)?;
        write_faces(sink, triangles, face_columns)
    })
}

/// Writes a PLY as [`write()`] does, with the texture coordinates of each triangle's corners (face property
/// `texcoord`, as MeshLab has it). Triangles with a coordinate that is not finite get an empty list.
pub fn write_textured(
    path: &Path,
    comments: &[String],
    columns: &[(&str, Column<'_>)],
    triangles: &[[u32; 3]],
    uvs: &[[[f32; 2]; 3]],
) -> Result<()> {
    debug_assert_eq!(triangles.len(), uvs.len());
    let mut header = header_of(comments, columns, triangles.len());
    if let Some(face) = header.elements.get_mut("face") {
        let list = PropertyType::List(ScalarType::UChar, ScalarType::Float);
        face.properties
            .add(PropertyDef::new("texcoord".into(), list));
    }
    atomic::write_file(path, |sink| {
        Writer::<DefaultElement>::new().write_header(sink, &header)?;
        write_vertices(sink, columns)?;
        for (triangle, uvs) in triangles.iter().zip(uvs) {
            sink.write_all(&[3])?;
            for corner in triangle {
                sink.write_all(&corner.to_le_bytes())?;
            }
            let is_whole = uvs.as_flattened().iter().all(|value| value.is_finite());
            let listed = if is_whole { uvs.as_flattened() } else { &[] };
            sink.write_all(&[listed.len() as u8])?;
            for value in listed {
                sink.write_all(&value.to_le_bytes())?;
            }
        }
        Ok(())
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

/// Writes the faces, some at a time: their corners, then column after column of them.
fn write_faces(
    sink: &mut impl Write,
    triangles: &[[u32; 3]],
    columns: &[(&str, Column<'_>)],
) -> io::Result<()> {
    const CORNERS: usize = 1 + size_of::<[u32; 3]>();
    let scalars: usize = columns.iter().map(|(_, column)| column.size()).sum();
    let size = CORNERS + scalars;
    let mut records = vec![3; WRITTEN.min(triangles.len()) * size];
    for (block, triangles) in triangles.chunks(WRITTEN).enumerate() {
        for (record, triangle) in records.chunks_exact_mut(size).zip(triangles) {
            for (bytes, corner) in record[1..CORNERS].chunks_exact_mut(4).zip(triangle) {
                bytes.copy_from_slice(&corner.to_le_bytes());
            }
        }
        let rows = block * WRITTEN..block * WRITTEN + triangles.len();
        let mut offset = CORNERS;
        for (_, column) in columns {
            column.fill(rows.clone(), &mut records, size, offset);
            offset += column.size();
        }
        sink.write_all(&records[..triangles.len() * size])?;
    }
    Ok(())
}

fn header_of(comments: &[String], columns: &[(&str, Column<'_>)], triangles: usize) -> Header {
    let mut vertex = ElementDef::new("vertex".into());
    vertex.count = columns.first().map_or(0, |(_, column)| column.len());
    add_scalars(&mut vertex, columns);
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

fn add_scalars(element: &mut ElementDef, columns: &[(&str, Column<'_>)]) {
    for (name, column) in columns {
        debug_assert_eq!(column.len(), element.count);
        let data_type = PropertyType::Scalar(column.scalar_type());
        element
            .properties
            .add(PropertyDef::new((*name).into(), data_type));
    }
}
