//! How far a coherent patch of a map continues round a vertex.
//!
//! Inside a patch that was copied from the sample, neighbouring vertices have texture coordinates that differ as their
//! positions do. There the sample's own neighbourhood is what lies round the vertex, so its parallax is that of the
//! surface. Beyond the patch another part of the sample stands beside the vertex.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::grid::TexCoord;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::render::vertex_frame::Axes;

/// Texture coordinates of neighbours agree when they differ from their places by at most this many texels in each
/// direction.
const AGREEING: f64 = 1.0;

/// Per vertex the distance over the surface, in texels, to the nearest vertex at a patch's border.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchReach(Vec<f32>);

impl PatchReach {
    /// The patches of a map, whose neighbours are the ends of its triangles' edges.
    pub fn of_map(map: &SurfaceTextonMap) -> Self {
        let sides = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
        let mut edges: Vec<[u32; 2]> = map.mesh.triangles.iter().flat_map(sides).collect();
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        edges.dedup();
        Self::of_edges(map, &edges)
    }

    /// The patches of a map with these pairs of neighbours, each given once.
    ///
    /// A vertex is at a border when its coordinate disagrees with a third of its neighbours or more, as it does on
    /// either side of a straight cut; a single neighbour that disagrees is no border.
    pub fn of_edges(map: &SurfaceTextonMap, edges: &[[u32; 2]]) -> Self {
        let vertices = map.mesh.positions.len();
        let mut neighbors = vec![Vec::new(); vertices];
        let mut disagreeing = vec![0; vertices];
        for &[a, b] in edges {
            let (length, agrees) = compare(map, a as usize, b as usize);
            for (from, to) in [(a, b), (b, a)] {
                neighbors[from as usize].push((to, length));
                disagreeing[from as usize] += usize::from(!agrees);
            }
        }
        let is_border = |&vertex: &usize| {
            let count = neighbors[vertex].len();
            count > 0 && 3 * disagreeing[vertex] >= count
        };
        let borders: Vec<usize> = (0..vertices).filter(is_border).collect();
        Self(distances(&neighbors, &borders))
    }

    /// The distance of a vertex to the border of its patch, in texels; infinite where there is no border.
    #[inline(always)]
    pub fn of(&self, vertex: usize) -> f32 {
        self.0[vertex]
    }
}

/// The length of an edge in texels, and whether the coordinates at its ends agree.
fn compare(map: &SurfaceTextonMap, a: usize, b: usize) -> (f32, bool) {
    let axes = Axes::of_vertex(map, a);
    let texel = map.texel_at(a);
    let offset = map.mesh.positions[b] - map.mesh.positions[a];
    let (along_s, along_t) = axes.offset(offset);
    let difference = |of: fn(&TexCoord) -> f32, place: f64, side: u32| {
        let apart = f64::from(of(&map.coords[b]) - of(&map.coords[a])) - place / texel;
        let side = f64::from(side);
        (apart - side * (apart / side).round()).abs()
    };
    let [width, height] = map.header.exemplar;
    let agrees = difference(|at| at.s, along_s, width) <= AGREEING
        && difference(|at| at.t, along_t, height) <= AGREEING;
    ((f64::from(offset.length()) / texel) as f32, agrees)
}

/// The length of the shortest way from each vertex to the nearest of some.
fn distances(neighbors: &[Vec<(u32, f32)>], from: &[usize]) -> Vec<f32> {
    let mut distances = vec![f32::INFINITY; neighbors.len()];
    // Bits of numbers that are not negative have the numbers' order.
    let mut waiting = BinaryHeap::new();
    for &vertex in from {
        distances[vertex] = 0.0;
        waiting.push(Reverse((0, vertex)));
    }
    while let Some(Reverse((bits, vertex))) = waiting.pop() {
        if bits > distances[vertex].to_bits() {
            continue;
        }
        for &(next, length) in &neighbors[vertex] {
            let (next, further) = (next as usize, distances[vertex] + length);
            if further < distances[next] {
                distances[next] = further;
                waiting.push(Reverse((further.to_bits(), next)));
            }
        }
    }
    distances
}
