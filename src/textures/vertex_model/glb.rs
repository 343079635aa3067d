//! A decorated mesh as a GLB.

use std::path::Path;

use crate::error::Result;
use crate::format::gltf::{self, GltfMesh, VertexAttribute};
use crate::textures::model::vertex_material;
use crate::textures::vertex_model::VertexModel;

pub(super) fn write(path: &Path, model: &VertexModel<'_>) -> Result<()> {
    let map = model.map;
    let uvs = model.uvs();
    let colors = model.clamped_colors();
    // t = n × s, so the sign of the bitangent is + everywhere.
    let tangents: Vec<[f32; 4]> = map
        .orientations
        .iter()
        .map(|s| [s.x, s.y, s.z, 1.0])
        .collect();
    let textons: Vec<f32> = map.textons.iter().map(|label| f32::from(label.0)).collect();
    let attributes = [
        ("TEXCOORD_0", VertexAttribute::Vec2(&uvs)),
        ("TANGENT", VertexAttribute::Vec4(&tangents)),
        ("_TEXTON", VertexAttribute::Scalar(&textons)),
    ];
    gltf::write(
        path,
        &GltfMesh {
            origin: map.header.origin.to_array(),
            positions: bytemuck::cast_slice(&map.mesh.positions),
            normals: bytemuck::cast_slice(&map.normals),
            triangles: &map.mesh.triangles,
            colors: colors.as_deref(),
            attributes: &attributes,
            // Colours of the sample have their light in them.
            material: Some(vertex_material(colors.is_some())),
            ..GltfMesh::default()
        },
    )
}
