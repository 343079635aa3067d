//! Meshes into files: PLY with all per-vertex properties, OBJ with texture coordinates, GLB.

use std::path::Path;

use glam::Vec3;

use crate::error::{Error, Result};
use crate::format::gltf::{self, GltfMesh};
use crate::format::obj::{self, ObjMesh};
use crate::format::ours::MESH_MARK;
use crate::format::ply::{self, Column};
use crate::mesh::reading::UserMesh;
use crate::mesh::rings::vertex_normals;
use crate::mesh::triangle_mesh::TriangleMesh;

/// Refuses an output whose name asks for a format we do not write.
pub fn check_name(path: &Path) -> Result<()> {
    match extension(path).as_str() {
        "ply" | "obj" | "glb" => Ok(()),
        _ => Err(Error::option(
            "output",
            path.display().to_string(),
            "a name that ends in .ply, .obj or .glb",
        )),
    }
}

fn extension(path: &Path) -> String {
    path.extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase()
}

/// Writes a mesh with its normals.
pub fn write_mesh(path: &Path, mesh: &TriangleMesh) -> Result<()> {
    let user = UserMesh {
        mesh: mesh.clone(),
        ..UserMesh::default()
    };
    write_user(path, &user)
}

/// Writes a user's mesh with what came with it.
pub fn write_user(path: &Path, user: &UserMesh) -> Result<()> {
    check_name(path)?;
    let normals = unit_normals(user);
    match extension(path).as_str() {
        "ply" => write_ply(path, user, &normals),
        "obj" => write_obj(path, user, &normals),
        _ => gltf::write(
            path,
            &GltfMesh {
                positions: &arrays(&user.mesh.positions),
                normals: &arrays(&normals),
                triangles: &user.mesh.triangles,
            },
        ),
    }
}

/// The file's normals where it has them, ours elsewhere.
fn unit_normals(user: &UserMesh) -> Vec<Vec3> {
    let mut normals = vertex_normals(&user.mesh);
    for (ours, theirs) in normals.iter_mut().zip(user.normals.iter().flatten()) {
        *ours = theirs.try_normalize().unwrap_or(*ours);
    }
    normals
}

fn arrays(vectors: &[Vec3]) -> Vec<[f32; 3]> {
    vectors.iter().map(Vec3::to_array).collect()
}

/// The three columns of a list of vectors.
pub(crate) fn columns(vectors: &[Vec3]) -> [Vec<f32>; 3] {
    std::array::from_fn(|axis| vectors.iter().map(|v| v[axis]).collect())
}

fn write_ply(path: &Path, user: &UserMesh, normals: &[Vec3]) -> Result<()> {
    let mut named: Vec<(&str, Vec<f32>)> = Vec::new();
    let mut add = |names: [&'static str; 3], vectors: &[Vec3]| {
        named.extend(names.into_iter().zip(columns(vectors)));
    };
    add(["x", "y", "z"], &user.mesh.positions);
    add(["nx", "ny", "nz"], normals);
    if let Some(orientation) = &user.orientation {
        add(["sx", "sy", "sz"], orientation);
    }
    for (name, values) in [("scale", &user.scale), ("rotation", &user.rotation)] {
        named.extend(values.iter().map(|values| (name, values.clone())));
    }
    let columns: Vec<(&str, Column<'_>)> = named
        .iter()
        .map(|(name, values)| (*name, Column::Float(values)))
        .collect();
    ply::write(path, &[MESH_MARK.into()], &columns, &user.mesh.triangles)
}

fn write_obj(path: &Path, user: &UserMesh, normals: &[Vec3]) -> Result<()> {
    let uvs: Option<Vec<[[f32; 2]; 3]>> = user.corner_uvs.as_ref().map(|all| {
        let finite = |uv: glam::Vec2| {
            if uv.is_finite() {
                uv.to_array()
            } else {
                [0.0; 2]
            }
        };
        all.iter().map(|corners| corners.map(finite)).collect()
    });
    obj::write(
        path,
        &ObjMesh {
            positions: &arrays(&user.mesh.positions),
            normals: &arrays(normals),
            uvs: uvs.as_deref(),
            triangles: &user.mesh.triangles,
        },
    )
}
