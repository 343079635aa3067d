//! The faces of a map in their colours, as one GLB: every face has vertices of its own, in one colour.

use std::path::Path;

use crate::error::Result;
use crate::format::gltf::{self, GltfMesh};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::textures::model::vertex_material;

/// Writes the model. Vertices 3·f … 3·f + 2 of `corners` are those of face f, whose linear colour is `colors[f]`.
pub fn write(path: &Path, corners: &SurfaceTextonMap, colors: &[[f32; 3]]) -> Result<()> {
    let colors: Vec<[f32; 3]> = colors.iter().flat_map(|&color| [color; 3]).collect();
    gltf::write(
        path,
        &GltfMesh {
            origin: corners.header.origin.to_array(),
            positions: bytemuck::cast_slice(&corners.mesh.positions),
            normals: bytemuck::cast_slice(&corners.normals),
            triangles: &corners.mesh.triangles,
            colors: Some(&colors),
            material: Some(vertex_material(false)),
            ..GltfMesh::default()
        },
    )
}
