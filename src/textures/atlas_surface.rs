//! The surface of an atlas map as textures see it.

use crate::maps::atlas_map::AtlasMap;
use crate::mesh::tessellation::TexturedMesh;

/// The mesh with its texture coordinates.
pub(super) fn surface_of(map: &AtlasMap) -> TexturedMesh {
    TexturedMesh {
        mesh: map.mesh.clone(),
        normals: map.vertex_normals.clone(),
        corner_uvs: map.corner_uvs.clone(),
    }
}

/// The side of a texel of the atlas, in mesh units: the root of the area that one inside a chart stands for.
pub fn texel_of(map: &AtlasMap) -> f64 {
    let inside = map.chart.iter().filter(|chart| **chart >= 0).count();
    (map.mesh.area() / inside.max(1) as f64).sqrt()
}
