//! Pairs of texels side by side on the surface, and the surface between them as a mesh.

use glam::Vec3;
use rayon::prelude::*;

use super::level_cells::LevelCells;
use super::texels::LevelTexels;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::level::SiteEdge;

/// Every texel with the one to its right and the one below it, across charts' borders too; sorted, each pair
/// once.
pub fn edges(level: &LevelTexels, cells: &LevelCells<'_>) -> Vec<SiteEdge> {
    let mut pairs: Vec<[u32; 2]> = (0..level.texels.len() as u32)
        .into_par_iter()
        .flat_map_iter(|site| {
            let [_, right, below, _] = cells.sites_from(site as usize);
            let pairs = [right, below].into_iter();
            pairs
                .filter(move |&other| other != site)
                .map(move |other| [site.min(other), site.max(other)])
        })
        .collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    let edge = |&[from, to]: &[u32; 2]| {
        let apart = level.positions[to as usize] - level.positions[from as usize];
        SiteEdge {
            from,
            to,
            offset: level.seen_from(from as usize, apart),
        }
    };
    pairs.par_iter().map(edge).collect()
}

/// The texels of a level as vertices, with two triangles between every four of one chart that lie together.
pub fn mesh(level: &LevelTexels, cells: &LevelCells<'_>) -> TriangleMesh {
    let positions = level.positions.clone();
    let triangles = cells.whole().flat_map(|[a, b, c, d]| {
        let [p, q, r] = [a, c, d].map(|site| positions[site as usize]);
        let normal: Vec3 = level.frames[a as usize].n;
        // A chart may lie in the texture as in a mirror.
        match (q - p).cross(r - p).dot(normal) < 0.0 {
            true => [[a, d, c], [a, b, d]],
            false => [[a, c, d], [a, d, b]],
        }
    });
    TriangleMesh {
        triangles: triangles.collect(),
        positions,
    }
}
