//! A PLY as a mesh: its vertices and faces, with texture coordinates under the names that other programs write.

use crate::error::Result;
use crate::format::ours::MESH_MARK;
use crate::format::ply::{self, PlyFile};
use crate::format::polygon_mesh::{PolygonMesh, parse_origin};

/// Parses a PLY file's bytes.
pub(super) fn parse(bytes: &[u8]) -> Result<PolygonMesh> {
    let file = ply::parse(bytes)?;
    // Read positions and normals.
    let axes = [file.require("x")?, file.require("y")?, file.require("z")?];
    let origin = ply_origin(&file)?;
    let vertices = 0..file.vertex_count;
    let position = |v: usize| std::array::from_fn(|axis| origin[axis] + axes[axis][v]);
    let positions = vertices.clone().map(position).collect();
    let normals = match ["nx", "ny", "nz"].map(|name| file.column(name)) {
        [Some(x), Some(y), Some(z)] => Some(
            vertices
                .map(|v| [x, y, z].map(|column| column[v] as f32))
                .collect(),
        ),
        _ => None,
    };
    let mut mesh = PolygonMesh {
        positions,
        single_precision: file.single_precision && origin == [0.0; 3],
        normals,
        columns: file.columns,
        ..PolygonMesh::default()
    };
    // Keep the faces, and the texture coordinates of their corners.
    let mut begin = 0;
    for polygon in file.faces.iter() {
        let corners = begin..begin + polygon.len();
        begin = corners.end;
        if polygon.len() < 3 {
            continue;
        }
        mesh.faces.push(polygon);
        if let Some(uvs) = &file.corner_uvs {
            let kept = mesh.corner_uvs.get_or_insert_default();
            kept.extend_from_slice(&uvs[corners]);
        }
    }
    mesh.note_small_faces(file.faces.sizes.len() - mesh.faces.sizes.len());
    // Take texture coordinates of vertices where corners have none.
    if let Some(uvs) = vertex_uvs(&mesh).filter(|_| mesh.corner_uvs.is_none()) {
        mesh.corner_uvs = Some(
            mesh.faces
                .corners
                .iter()
                .map(|&v| uvs[v as usize])
                .collect(),
        );
    }
    Ok(mesh)
}

/// What the positions of a surface texton map count from; zero for any other PLY.
fn ply_origin(file: &PlyFile) -> Result<[f64; 3]> {
    let is_ours = file.comments.iter().any(|line| line == MESH_MARK);
    let origin = file
        .comments
        .iter()
        .find_map(|line| line.strip_prefix("origin "));
    match origin.filter(|_| is_ours) {
        Some(text) => parse_origin(text),
        None => Ok([0.0; 3]),
    }
}

/// Texture coordinates per vertex, under the names other programs write.
fn vertex_uvs(mesh: &PolygonMesh) -> Option<Vec<[f32; 2]>> {
    let names = [("u", "v"), ("texture_u", "texture_v"), ("s", "t")];
    let found = names
        .iter()
        .find_map(|(u, v)| Some((mesh.column(u)?, mesh.column(v)?)));
    // The map's own (s, t) are texels of a sample, no texture coordinates.
    let (u, v) = found.filter(|_| mesh.column("texton").is_none())?;
    Some(
        u.iter()
            .zip(v)
            .map(|(&u, &v)| [u as f32, v as f32])
            .collect(),
    )
}
