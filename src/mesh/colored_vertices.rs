//! The vertices of a mesh in their colours, as a PLY file for other programs.
//!
//! Bytes `red green blue` through the sRGB curve are what MeshLab, Blender and trimesh show; the linear numbers beside
//! them are called `r g b`, which Mitsuba reads as `vertex_color`.

use std::path::Path;

use glam::{DVec3, Vec3};

use crate::error::Result;
use crate::format::ours::MESH_MARK;
use crate::format::ply::{self, Column};
use crate::mesh::origin::origin_comment;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::mesh::writing::columns;

/// What is written of each vertex beside its position.
#[derive(Clone, Copy, Debug, Default)]
pub struct ColoredVertices<'a> {
    /// Unit normals.
    pub normals: Option<&'a [Vec3]>,
    /// Colours through the sRGB curve.
    pub srgb: &'a [[u8; 3]],
    /// The same colours as linear Rec. 709.
    pub linear: Option<&'a [[f32; 3]]>,
}

/// Writes a mesh with a colour per vertex; positions count from `origin`.
pub fn write(
    path: &Path,
    (mesh, origin): (&TriangleMesh, DVec3),
    vertices: ColoredVertices<'_>,
) -> Result<()> {
    let ColoredVertices {
        normals,
        srgb,
        linear,
    } = vertices;
    // Lay out a column per property.
    let positions = columns(&mesh.positions);
    let normals = normals.map(columns);
    let bytes = [0, 1, 2].map(|k| -> Vec<u8> { srgb.iter().map(|color| color[k]).collect() });
    let numbers = linear.map(|colors| {
        [0, 1, 2].map(|k| -> Vec<f32> { colors.iter().map(|color| color[k]).collect() })
    });
    // Name those that there are.
    let mut all = named(["x", "y", "z"], &positions, Column::Float);
    if let Some(normals) = &normals {
        all.extend(named(["nx", "ny", "nz"], normals, Column::Float));
    }
    all.extend(named(["red", "green", "blue"], &bytes, Column::UChar));
    if let Some(numbers) = &numbers {
        all.extend(named(["r", "g", "b"], numbers, Column::Float));
    }
    // Say in the header how the colours are encoded.
    let mut comments = vec![MESH_MARK.into(), "red green blue are sRGB".into()];
    if linear.is_some() {
        comments.push("r g b are linear Rec. 709".into());
    }
    comments.extend(origin_comment(origin));
    ply::write(path, &comments, &all, &mesh.triangles)
}

fn named<'a, T>(
    names: [&'static str; 3],
    lists: &'a [Vec<T>; 3],
    column: fn(&'a [T]) -> Column<'a>,
) -> Vec<(&'static str, Column<'a>)> {
    let columns = lists.iter().map(|list| column(list));
    names.into_iter().zip(columns).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_file_has_the_properties_that_were_given() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("colored.ply");
        let mesh = shapes::grid(1, 1, 1.0);
        let (srgb, linear) = ([[0, 128, 255]; 4], [[0.0, 0.25, 7.0]; 4]);
        let mut vertices = ColoredVertices {
            srgb: &srgb,
            ..ColoredVertices::default()
        };
        let names = |vertices| {
            write(&path, (&mesh, DVec3::ZERO), vertices).unwrap();
            let ply = ply::read(&path).unwrap();
            let names: Vec<String> = ply.columns.iter().map(|(name, _)| name.clone()).collect();
            (names.join(" "), ply.comments.len())
        };
        assert_eq!(names(vertices), ("x y z red green blue".into(), 2));
        vertices.normals = Some(&[Vec3::Z; 4]);
        vertices.linear = Some(&linear);
        let all = "x y z nx ny nz red green blue r g b";
        assert_eq!(names(vertices), (all.into(), 3));
    }
}
