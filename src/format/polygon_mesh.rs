//! What any mesh file holds: positions, polygons, and what came with them. The file's own order
//! and indices; nothing repaired.

use crate::format::ply::Polygons;

/// A mesh as its file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonMesh {
    /// Vertex positions, in the file's order.
    pub positions: Vec<[f32; 3]>,
    /// Faces of three and more corners; indices are below the number of positions.
    pub faces: Polygons,
    /// A texture coordinate for each of the faces' corners; NaN where the file has none.
    pub corner_uvs: Option<Vec<[f32; 2]>>,
    /// A normal for each vertex, as the file has it; zeros where it has none.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Named numbers, one a vertex.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Whether the format gives every face or material vertices of its own.
    pub splits_vertices: bool,
    /// What was left out in reading, for the user.
    pub notes: Vec<String>,
}

impl PolygonMesh {
    /// A vertex column by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let found = self.columns.iter().find(|(column, _)| column == name)?;
        Some(&found.1)
    }
}
