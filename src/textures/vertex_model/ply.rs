//! A decorated mesh as a PLY that other programs read: bytes for colours, coordinates over the sample's size.

use std::path::Path;

use crate::error::Result;
use crate::format::image::encode_srgb8;
use crate::format::ours::MESH_MARK;
use crate::format::ply::{self, Column};
use crate::mesh::origin::origin_comment;
use crate::textures::vertex_model::VertexModel;

pub(super) fn write(path: &Path, model: &VertexModel<'_>) -> Result<()> {
    let map = model.map;
    let axis = |list: &[glam::Vec3], k: usize| -> Vec<f32> { list.iter().map(|v| v[k]).collect() };
    // Lay out the columns.
    let uvs = model.uvs();
    let floats: Vec<(&str, Vec<f32>)> = [
        (["x", "y", "z"], &map.mesh.positions),
        (["nx", "ny", "nz"], &map.normals),
        (["sx", "sy", "sz"], &map.orientations),
    ]
    .into_iter()
    .flat_map(|(names, list)| [0, 1, 2].map(|k| (names[k], axis(list, k))))
    .chain([0, 1].map(|k| (["s", "t"][k], uvs.iter().map(|uv| uv[k]).collect())))
    .collect();
    let textons: Vec<u16> = map.textons.iter().map(|label| label.0).collect();
    let bytes: Vec<(&str, Vec<u8>)> = match model.colors {
        None => Vec::new(),
        Some(colors) => ["red", "green", "blue"]
            .into_iter()
            .enumerate()
            .map(|(k, name)| (name, colors.iter().map(|c| encode_srgb8(c[k])).collect()))
            .collect(),
    };
    // Join them.
    let mut columns: Vec<(&str, Column<'_>)> = floats
        .iter()
        .map(|(name, values)| (*name, Column::Float(values)))
        .collect();
    columns.push(("texton", Column::UShort(&textons)));
    columns.extend(
        bytes
            .iter()
            .map(|(name, values)| (*name, Column::UChar(values))),
    );
    // Write the file.
    let mut comments = vec![MESH_MARK.to_owned()];
    comments.extend(origin_comment(map.header.origin));
    ply::write(path, &comments, &columns, &map.mesh.triangles)
}
