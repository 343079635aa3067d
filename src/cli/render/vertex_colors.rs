//! The vertices of a surface in their colours, as a mesh for other programs.
//!
//! Bytes `red green blue` through the sRGB curve are what MeshLab, Blender and trimesh show; the linear numbers beside
//! them are called `r g b`, which Mitsuba reads as `vertex_color`.

use std::path::Path;

use glam::Vec3;

use crate::error::Result;
use crate::format::image::encode_srgb8;
use crate::format::ours::MESH_MARK;
use crate::format::ply::{self, Column};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::origin::origin_comment;

/// Writes positions, normals and colours; the linear numbers too where they are asked for. Colours are linear Rec. 709,
/// one per vertex.
pub(super) fn write(
    file: &Path,
    map: &SurfaceTextonMap,
    colors: &[[f32; 3]],
    is_linear_too: bool,
) -> Result<()> {
    let axis = |list: &[Vec3], k: usize| -> Vec<f32> { list.iter().map(|v| v[k]).collect() };
    let linear = |k: usize| -> Vec<f32> { colors.iter().map(|color| color[k]).collect() };
    let bytes = |k: usize| -> Vec<u8> { colors.iter().map(|c| encode_srgb8(c[k])).collect() };
    // Lay out positions and normals.
    let places: Vec<(&str, Vec<f32>)> = [
        (["x", "y", "z"], &map.mesh.positions),
        (["nx", "ny", "nz"], &map.normals),
    ]
    .into_iter()
    .flat_map(|(names, list)| [0, 1, 2].map(|k| (names[k], axis(list, k))))
    .collect();
    // Lay out the colours as bytes, and as numbers where they are asked for.
    let shown = [0, 1, 2].map(|k| (["red", "green", "blue"][k], bytes(k)));
    let measured = match is_linear_too {
        true => [0, 1, 2].map(|k| (["r", "g", "b"][k], linear(k))).to_vec(),
        false => Vec::new(),
    };
    // Join the columns.
    let mut columns: Vec<(&str, Column<'_>)> = Vec::new();
    columns.extend(
        places
            .iter()
            .map(|(name, list)| (*name, Column::Float(list))),
    );
    columns.extend(
        shown
            .iter()
            .map(|(name, list)| (*name, Column::UChar(list))),
    );
    columns.extend(
        measured
            .iter()
            .map(|(name, list)| (*name, Column::Float(list))),
    );
    // Say in the header how the colours are encoded.
    let mut comments = vec![MESH_MARK.into(), "red green blue are sRGB".into()];
    if is_linear_too {
        comments.push("r g b are linear Rec. 709".into());
    }
    comments.extend(origin_comment(map.header.origin));
    ply::write(file, &comments, &columns, &map.mesh.triangles)
}
