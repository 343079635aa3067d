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

/// The numbers of a vertex property to be written.
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
}

impl Column<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Float(values) => values.len(),
            Self::Double(values) => values.len(),
            Self::UShort(values) => values.len(),
            Self::UChar(values) => values.len(),
            Self::Int(values) => values.len(),
        }
    }

    fn scalar_type(&self) -> ScalarType {
        match self {
            Self::Float(_) => ScalarType::Float,
            Self::Double(_) => ScalarType::Double,
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
            Self::Double(values) => fill(&values[rows], f64::to_le_bytes, records, size, offset),
            Self::UShort(values) => fill(&values[rows], u16::to_le_bytes, records, size, offset),
            Self::UChar(values) => fill(&values[rows], u8::to_le_bytes, records, size, offset),
            Self::Int(values) => fill(&values[rows], i32::to_le_bytes, records, size, offset),
        }
    }

    /// Bytes per number.
    fn size(&self) -> usize {
        match self {
            Self::Double(_) => 8,
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
    let header = header_of(comments, columns, triangles.len(), false);
    atomic::write_file(path, |sink| {
        Writer::<DefaultElement>::new().write_header(sink, &header)?;
        write_vertices(sink, columns)?;
        write_faces(sink, triangles)
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
    let header = header_of(comments, columns, triangles.len(), true);
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

fn header_of(
    comments: &[String],
    columns: &[(&str, Column<'_>)],
    triangles: usize,
    is_textured: bool,
) -> Header {
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
    if is_textured {
        let list = PropertyType::List(ScalarType::UChar, ScalarType::Float);
        face.properties
            .add(PropertyDef::new("texcoord".into(), list));
    }
    let mut header = Header::new();
    header.encoding = Encoding::BinaryLittleEndian;
    header.comments = comments.to_vec();
    header.elements.add(vertex);
    header.elements.add(face);
    header
}
