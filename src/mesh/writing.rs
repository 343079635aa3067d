//! Meshes into files: PLY with all per-vertex properties, OBJ with texture coordinates, GLB.

use std::path::Path;

use glam::{DVec3, Vec3};

use crate::error::{Error, Result};
use crate::format::gltf::{self, GltfMesh};
use crate::format::mesh_formats::either;
use crate::format::obj::{self, ObjMesh};
use crate::format::ours::MESH_MARK;
use crate::format::ply::{self, Column};
use crate::mesh::reading::UserMesh;
use crate::mesh::rings::vertex_normals;
use crate::mesh::triangle_mesh::TriangleMesh;

/// Writes a mesh with what came with it and these normals.
type Writer = fn(&Path, &UserMesh, &[Vec3]) -> Result<()>;

/// The formats that meshes are written in: the extension of the file's name, and the writer.
const WRITERS: [(&str, Writer); 3] = [("ply", write_ply), ("obj", write_obj), ("glb", write_glb)];

/// The extensions of these formats.
pub const EXTENSIONS: [&str; WRITERS.len()] = {
    let mut extensions = [""; WRITERS.len()];
    let mut at = 0;
    while at < WRITERS.len() {
        extensions[at] = WRITERS[at].0;
        at += 1;
    }
    extensions
};

/// The extensions as messages list them: .a, .b or .c.
pub fn listed_extensions() -> String {
    either(EXTENSIONS.iter().map(|extension| format!(".{extension}")))
}

/// Refuses an output whose name asks for a format we do not write.
pub fn check_name(path: &Path) -> Result<()> {
    writer_of(path).map(drop)
}

fn writer_of(path: &Path) -> Result<Writer> {
    let extension = path.extension().unwrap_or_default();
    let mut writers = WRITERS.iter();
    let found = writers.find(|(name, _)| extension.eq_ignore_ascii_case(name));
    found.map(|(_, writer)| *writer).ok_or_else(|| {
        let expected = format!("a name that ends in {}", listed_extensions());
        Error::option("output", path.display().to_string(), expected)
    })
}

/// Writes a mesh with its normals.
pub fn write_mesh(path: &Path, mesh: &TriangleMesh) -> Result<()> {
    write_user(path, &UserMesh::from(mesh.clone()))
}

/// Writes a user's mesh with what came with it.
pub fn write_user(path: &Path, user: &UserMesh) -> Result<()> {
    let write = writer_of(path)?;
    write(path, user, &unit_normals(user))
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

fn corner_uvs(user: &UserMesh) -> Option<Vec<[[f32; 2]; 3]>> {
    let all = user.corner_uvs.as_ref()?;
    Some(all.iter().map(|uvs| uvs.map(|uv| uv.to_array())).collect())
}

fn write_ply(path: &Path, user: &UserMesh, normals: &[Vec3]) -> Result<()> {
    // Doubles where an origin was subtracted, so that nothing is lost when it is put back.
    let restored = restored_columns(user);
    let plain = columns(&user.mesh.positions);
    let mut named: Vec<(&str, Column<'_>)> = match &restored {
        Some(axes) => {
            let axes = axes.iter().map(|axis| Column::Double(axis));
            ["x", "y", "z"].into_iter().zip(axes).collect()
        }
        None => {
            let axes = plain.iter().map(|axis| Column::Float(axis));
            ["x", "y", "z"].into_iter().zip(axes).collect()
        }
    };
    let normals = columns(normals);
    let orientation = user.orientation.as_deref().map(columns);
    let vectors = [
        (["nx", "ny", "nz"], Some(&normals)),
        (["sx", "sy", "sz"], orientation.as_ref()),
    ];
    for (names, axes) in vectors {
        let axes = axes.into_iter().flatten().map(|axis| Column::Float(axis));
        named.extend(names.into_iter().zip(axes));
    }
    let scalars = [
        ("scale", &user.scale),
        ("rotation", &user.rotation),
        ("transition", &user.transition),
        ("mask", &user.mask),
    ];
    for (name, values) in scalars {
        named.extend(values.iter().map(|values| (name, Column::Float(values))));
    }
    let (comments, triangles) = ([MESH_MARK.into()], &user.mesh.triangles);
    match corner_uvs(user) {
        Some(uvs) => ply::write_textured(path, &comments, &named, triangles, &uvs),
        None => ply::write(path, &comments, &named, triangles),
    }
}

/// The three columns of positions in the file's coordinates; `None` for a mesh without an origin.
fn restored_columns(user: &UserMesh) -> Option<[Vec<f64>; 3]> {
    let positions = user.mesh.positions.iter();
    (user.origin != DVec3::ZERO).then(|| {
        [0, 1, 2].map(|axis| {
            positions
                .clone()
                .map(|p| user.origin[axis] + f64::from(p[axis]))
                .collect()
        })
    })
}

fn write_obj(path: &Path, user: &UserMesh, normals: &[Vec3]) -> Result<()> {
    obj::write(
        path,
        &ObjMesh {
            origin: user.origin.to_array(),
            positions: &arrays(&user.mesh.positions),
            normals: &arrays(normals),
            uvs: corner_uvs(user).as_deref(),
            triangles: &user.mesh.triangles,
        },
    )
}

fn write_glb(path: &Path, user: &UserMesh, normals: &[Vec3]) -> Result<()> {
    gltf::write(
        path,
        &GltfMesh {
            origin: user.origin.to_array(),
            positions: &arrays(&user.mesh.positions),
            normals: &arrays(normals),
            triangles: &user.mesh.triangles,
            uvs: corner_uvs(user).as_deref(),
            ..GltfMesh::default()
        },
    )
}
