//! What any mesh file holds: positions, polygons, and what came with them. The file's own order
//! and indices; nothing repaired.

use crate::format::ply::Polygons;

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
    /// Whether the format gives every face or material vertices of its own.
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
