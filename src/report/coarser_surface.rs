//! A decorated surface with fewer vertices, by clusters (Rossignac and Borrel 1993).
//!
//! Vertices in one cell of a grid whose normals point into one octant become one: that nearest to their mean. It keeps
//! its own frame and texture coordinate, from which the texture is continued over its triangles. Normals keep the two
//! sides of something thin apart.

use glam::{DVec3, Vec3};

use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::triangle_mesh::TriangleMesh;

/// How much the side of a cell grows while there are too many.
const GROWTH: f64 = 1.06;
/// The most cells along an axis: their numbers take 20 bits.
const MOST_CELLS: f64 = 1_048_575.0;

/// The surface of a map with at most `most` vertices, all of which stand in a triangle.
pub fn coarser_surface(map: &SurfaceTextonMap, most: usize) -> SurfaceTextonMap {
    let used = map.mesh.referenced();
    let used: Vec<u32> = (0..used.len() as u32)
        .filter(|&v| used[v as usize])
        .collect();
    let diagonal = f64::from(map.mesh.diagonal());
    let mut side = (map.mesh.area() / most.max(1) as f64)
        .sqrt()
        .max(diagonal / MOST_CELLS);
    let mut clusters = clusters(map, &used, side);
    while clusters.len() > most && side <= diagonal {
        side *= GROWTH;
        clusters = self::clusters(map, &used, side);
    }
    of_clusters(map, &clusters)
}

/// Vertices that become one, cluster by cluster.
fn clusters(map: &SurfaceTextonMap, used: &[u32], side: f64) -> Vec<Vec<u32>> {
    let low = map.mesh.bounds().0;
    let cell = |vertex: u32| {
        let at = (map.mesh.positions[vertex as usize] - low).as_dvec3() / side;
        let [x, y, z] = at
            .to_array()
            .map(|along| along.clamp(0.0, MOST_CELLS) as u64);
        let normal = map.normals[vertex as usize].to_array();
        let octant = normal.map(|along| u64::from(along < 0.0));
        let octant = octant[0] << 2 | octant[1] << 1 | octant[2];
        octant << 60 | x << 40 | y << 20 | z
    };
    let mut order: Vec<(u64, u32)> = used.iter().map(|&vertex| (cell(vertex), vertex)).collect();
    order.sort_unstable();
    order
        .chunk_by(|a, b| a.0 == b.0)
        .map(|same| same.iter().map(|&(_, vertex)| vertex).collect())
        .collect()
}

/// The vertex of a cluster that is nearest to the mean of all, the first of equal ones.
fn middle(positions: &[Vec3], cluster: &[u32]) -> u32 {
    let at = |vertex: u32| positions[vertex as usize].as_dvec3();
    let sum: DVec3 = cluster.iter().map(|&vertex| at(vertex)).sum();
    let mean = sum / cluster.len() as f64;
    let distance = |vertex: u32| at(vertex).distance_squared(mean);
    let nearer = |a: u32, b: u32| if distance(b) < distance(a) { b } else { a };
    cluster.iter().copied().reduce(nearer).unwrap_or(0)
}

fn of_clusters(map: &SurfaceTextonMap, clusters: &[Vec<u32>]) -> SurfaceTextonMap {
    // Keep the middle vertex of each cluster.
    let positions = &map.mesh.positions;
    let kept: Vec<usize> = clusters
        .iter()
        .map(|cluster| middle(positions, cluster) as usize)
        .collect();
    let mut becomes = vec![0; positions.len()];
    for (number, cluster) in (0..).zip(clusters) {
        cluster
            .iter()
            .for_each(|&vertex| becomes[vertex as usize] = number);
    }
    // Keep the triangles that still have three corners.
    let triangles = map.mesh.triangles.iter();
    let triangles = triangles.map(|corners| corners.map(|vertex| becomes[vertex as usize]));
    let is_whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    let mesh = TriangleMesh {
        positions: chosen(positions, &kept),
        triangles: triangles.filter(is_whole).collect(),
    };
    SurfaceTextonMap {
        mesh,
        normals: chosen(&map.normals, &kept),
        orientations: chosen(&map.orientations, &kept),
        scale: map.scale.as_ref().map(|scale| chosen(scale, &kept)),
        coords: chosen(&map.coords, &kept),
        textons: chosen(&map.textons, &kept),
        transition: map.transition.as_ref().map(|of| chosen(of, &kept)),
        mask: map.mask.as_ref().map(|mask| chosen(mask, &kept)),
        header: map.header.clone(),
    }
}

fn chosen<T: Copy>(all: &[T], kept: &[usize]) -> Vec<T> {
    kept.iter().map(|&vertex| all[vertex]).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::format::id::ContentId;
    use crate::grid::TexCoord;
    use crate::index::TextonLabel;
    use crate::maps::MapHeader;
    use crate::mesh::shapes;
    use crate::render::sides::has_border;

    /// A decorated ball round the origin.
    pub(in crate::report) fn ball(subdivisions: u32) -> SurfaceTextonMap {
        let mesh = shapes::icosphere(subdivisions);
        let (count, id) = (mesh.positions.len(), ContentId::of_bytes(b"x"));
        let normals: Vec<Vec3> = mesh.positions.iter().map(|p| p.normalize()).collect();
        SurfaceTextonMap {
            orientations: normals.iter().map(|n| n.any_orthonormal_vector()).collect(),
            normals,
            scale: None,
            coords: (0..count)
                .map(|v| TexCoord {
                    s: (v % 8) as f32,
                    t: 1.0,
                })
                .collect(),
            textons: vec![TextonLabel(0); count],
            transition: None,
            mask: None,
            header: MapHeader {
                exemplar: [8, 8],
                texel: 0.1,
                origin: DVec3::ZERO,
                seed: 0,
                method: "k-coherence".into(),
                polish: 0,
                sample: id.clone(),
                space: id,
            },
            mesh,
        }
    }

    #[test]
    fn a_coarser_ball_is_closed_and_as_large() {
        let fine = ball(5);
        let coarse = coarser_surface(&fine, 3000);
        let count = coarse.mesh.positions.len();
        assert!((1500..=3000).contains(&count), "{count}");
        assert_eq!(coarse.mesh.referenced_count(), count);
        assert!(!has_border(&coarse.mesh));
        let [volume, whole] = [&coarse, &fine].map(|map| map.mesh.volume());
        assert!((volume / whole - 1.0).abs() < 0.02, "{volume} {whole}");
        // Every vertex is one of the fine ball's, with all that belongs to it.
        for (place, position) in coarse.mesh.positions.iter().enumerate() {
            let same = fine
                .mesh
                .positions
                .iter()
                .position(|p| p == position)
                .unwrap();
            assert_eq!(coarse.coords[place], fine.coords[same]);
            assert_eq!(coarse.normals[place], fine.normals[same]);
        }
        assert_eq!(coarse, coarser_surface(&fine, 3000));
    }
}
