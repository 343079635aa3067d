//! The texels of an atlas map as points that are shaded one by one.

use glam::Vec3;

use crate::grid::TexCoord;
use crate::maps::atlas_map::AtlasMap;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::atlas::TexelPoints;
use crate::mesh::triangle_mesh::TriangleMesh;

/// The texels that lie in charts.
pub struct TexelSites {
    /// The texels, by their numbers.
    pub texels: Vec<u32>,
    /// Each as a vertex of a map without triangles, in the same order.
    pub map: SurfaceTextonMap,
    /// The normal of the triangle that each lies on, as long as twice the triangle's area.
    pub facets: Vec<Vec3>,
}

impl TexelSites {
    /// The texels of a map, whose points are `points`.
    pub fn new(map: &AtlasMap, points: &TexelPoints) -> Self {
        // List the texels inside charts.
        let texels: Vec<u32> = (0..map.len() as u32)
            .filter(|&texel| map.coords[texel as usize].is_some())
            .collect();
        let each = |of: &[Vec3]| texels.iter().map(|&texel| of[texel as usize]).collect();
        let coord =
            |&texel: &u32| map.coords[texel as usize].unwrap_or(TexCoord { s: 0.5, t: 0.5 });
        let scales = map.scale.as_ref();
        // Make a vertex of each.
        Self {
            facets: texels
                .iter()
                .map(|&texel| {
                    let triangle = points.triangle[texel as usize];
                    map.mesh.area_normal(triangle as usize)
                })
                .collect(),
            map: SurfaceTextonMap {
                mesh: TriangleMesh {
                    positions: each(&map.position),
                    triangles: Vec::new(),
                },
                normals: each(&map.normal),
                orientations: each(&map.orientation),
                scale: scales
                    .map(|scale| texels.iter().map(|&texel| scale[texel as usize]).collect()),
                coords: texels.iter().map(coord).collect(),
                textons: texels
                    .iter()
                    .map(|&texel| map.textons[texel as usize])
                    .collect(),
                transition: None,
                mask: None,
                header: map.header.clone(),
            },
            texels,
        }
    }

    /// Pairs of texels that lie side by side in an atlas of this width, each once, by their places in the list.
    pub fn neighbors(&self, width: u32) -> Vec<[u32; 2]> {
        let place = |texel: u32| self.texels.binary_search(&texel).ok().map(|at| at as u32);
        let pairs = self.texels.iter().enumerate().flat_map(|(at, &texel)| {
            let is_last = (texel + 1).is_multiple_of(width);
            let beside = (!is_last).then(|| place(texel + 1)).flatten();
            let below = place(texel + width);
            let found = [beside, below].into_iter().flatten();
            found.map(move |other| [at as u32, other])
        });
        pairs.collect()
    }
}
