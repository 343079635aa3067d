//! What any mesh file holds: positions, polygons, and what came with them. The file's own order
//! and indices; nothing repaired.

use crate::error::{Error, Result};

/// The largest coordinate of a vertex: squares of distances stay finite.
pub const FARTHEST: f64 = 1e15;

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

/// A mesh as its file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonMesh {
    /// Vertex positions, in the file's order.
    pub positions: Vec<[f64; 3]>,
    /// Whether the file holds positions in single precision.
    pub single_precision: bool,
    /// Faces of three and more corners; indices are below the number of positions.
    pub faces: Polygons,
    /// A texture coordinate for each of the faces' corners; NaN where the file has none.
    pub corner_uvs: Option<Vec<[f32; 2]>>,
    /// A normal for each vertex, as the file has it; zeros where it has none.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Named numbers, one per vertex.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Whether the format gives every face or material vertices of its own, as the format's file states.
    pub splits_vertices: bool,
    /// Faces that were left out in reading, for the user.
    pub notes: Vec<String>,
    /// What the file holds beside the surface and could not be used, for the user.
    pub unused: Vec<String>,
}

impl PolygonMesh {
    /// Says that `count` faces had too few corners, if any had.
    pub fn note_small_faces(&mut self, count: usize) {
        if count > 0 {
            self.notes
                .push(format!("{count} faces of fewer than 3 corners left out"));
        }
    }

    /// A vertex column by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let found = self.columns.iter().find(|(column, _)| column == name)?;
        Some(&found.1)
    }
}

/// A position that counts from an origin, in the file's coordinates.
pub fn from_origin(origin: [f64; 3], position: [f32; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| origin[axis] + f64::from(position[axis]))
}

/// The coordinates of an origin as `comment origin` of a map has them.
pub fn parse_origin(text: &str) -> Result<[f64; 3]> {
    let numbers: Vec<f64> = text
        .split(' ')
        .filter_map(|word| word.parse().ok())
        .collect();
    match numbers[..] {
        [x, y, z] if numbers.iter().all(|value| value.abs() <= FARTHEST) => Ok([x, y, z]),
        _ => Err(Error::data("comment origin", format!("`{text}`"))
            .expected("three numbers, none beyond 1e15")),
    }
}
