//! Triangles cut until no edge is longer than a length, so that a surface can carry relief.
//!
//! Pass by pass every edge that is too long is cut in its middle, and each triangle into as many parts as its
//! edges ask for (red-green refinement). What is cut is the edge, not the triangle, so neighbours fit without
//! cracks. New points lie on the triangles: the surface stays where it was.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use crate::error::Result;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// A mesh with normals per vertex and texture coordinates per corner.
#[derive(Clone, Debug, PartialEq)]
pub struct TexturedMesh {
    /// The surface.
    pub mesh: TriangleMesh,
    /// Unit normals per vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of each triangle's corners.
    pub corner_uvs: Vec<[Vec2; 3]>,
}

/// The area of the triangles that refinement ends with, in squares of the longest edge: what was measured on
/// even meshes lies between a sixth and a quarter.
const MEAN_AREA: f64 = 0.16;

/// The edge length at which at most about `most` triangles come out; `wanted` where that is longer.
pub fn affordable_edge(mesh: &TriangleMesh, wanted: f64, most: usize) -> f64 {
    wanted.max((mesh.area() / (MEAN_AREA * most as f64)).sqrt())
}

/// Cuts a mesh until no edge is longer than `longest`, in mesh units, or one more pass would make more than
/// `most` triangles of it.
pub fn tessellate(
    mut surface: TexturedMesh,
    longest: f64,
    most: usize,
    progress: Progress<'_>,
) -> Result<TexturedMesh> {
    loop {
        progress.check()?;
        let cuts = Cuts::of(&surface.mesh, longest as f32);
        let count = surface.mesh.triangles.len() + cuts.parts;
        if cuts.parts == 0 || count > most {
            return Ok(surface);
        }
        surface = cuts.apply(surface, count);
    }
}

/// The edges that are cut in one pass.
struct Cuts {
    /// Per edge, smaller vertex first, its number among the cut ones.
    middles: HashMap<[u32; 2], u32>,
    /// The edges in the order of their numbers.
    edges: Vec<[u32; 2]>,
    /// Triangles that are added.
    parts: usize,
}

impl Cuts {
    fn of(mesh: &TriangleMesh, longest: f32) -> Self {
        let mut cuts = Self {
            middles: HashMap::new(),
            edges: Vec::new(),
            parts: 0,
        };
        for &[a, b, c] in &mesh.triangles {
            for edge in [[a, b], [b, c], [c, a]].map(sorted) {
                let [from, to] = edge.map(|vertex| mesh.positions[vertex as usize]);
                if from.distance(to) <= longest {
                    continue;
                }
                cuts.parts += 1;
                let next = cuts.edges.len() as u32;
                if *cuts.middles.entry(edge).or_insert(next) == next {
                    cuts.edges.push(edge);
                }
            }
        }
        cuts
    }

    fn apply(&self, surface: TexturedMesh, count: usize) -> TexturedMesh {
        let TexturedMesh {
            mesh,
            mut normals,
            corner_uvs,
        } = surface;
        let TriangleMesh {
            mut positions,
            triangles,
        } = mesh;
        // Add a vertex in the middle of each edge that is cut.
        let first = positions.len() as u32;
        for &[a, b] in &self.edges {
            let (a, b) = (a as usize, b as usize);
            positions.push(0.5 * (positions[a] + positions[b]));
            normals.push(
                (normals[a] + normals[b])
                    .try_normalize()
                    .unwrap_or(normals[a]),
            );
        }
        // Cut the triangles.
        let mut parts = Parts {
            triangles: Vec::with_capacity(count),
            uvs: Vec::with_capacity(count),
        };
        for (triangle, uvs) in triangles.iter().zip(&corner_uvs) {
            let middles = [0, 1, 2].map(|at| {
                let edge = sorted([triangle[at], triangle[(at + 1) % 3]]);
                self.middles.get(&edge).map(|number| first + number)
            });
            parts.cut(*triangle, *uvs, middles, &positions);
        }
        TexturedMesh {
            mesh: TriangleMesh {
                positions,
                triangles: parts.triangles,
            },
            normals,
            corner_uvs: parts.uvs,
        }
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The triangles of the next pass.
struct Parts {
    triangles: Vec<[u32; 3]>,
    uvs: Vec<[Vec2; 3]>,
}

impl Parts {
    /// Adds the parts of one triangle, whose edges begin at its corners and are cut at `middles`.
    fn cut(
        &mut self,
        corners: [u32; 3],
        uvs: [Vec2; 3],
        middles: [Option<u32>; 3],
        positions: &[Vec3],
    ) {
        let between = |at: usize| 0.5 * (uvs[at] + uvs[(at + 1) % 3]);
        let corner = |at: usize| (corners[at % 3], uvs[at % 3]);
        let middle = |at: usize, vertex: u32| (vertex, between(at % 3));
        match middles {
            [Some(a), Some(b), Some(c)] => {
                let (a, b, c) = (middle(0, a), middle(1, b), middle(2, c));
                self.add([corner(0), a, c]);
                self.add([corner(1), b, a]);
                self.add([corner(2), c, b]);
                self.add([a, b, c]);
            }
            _ => {
                // The first cut edge whose predecessor is whole leads: two patterns are left.
                let lead =
                    (0..3).find(|&at| middles[at].is_some() && middles[(at + 2) % 3].is_none());
                let Some((lead, vertex)) = lead.and_then(|at| Some((at, middles[at]?))) else {
                    return self.add([corner(0), corner(1), corner(2)]);
                };
                let first = middle(lead, vertex);
                let [a, b, c] = [0, 1, 2].map(|step| corner(lead + step));
                match middles[(lead + 1) % 3] {
                    None => {
                        self.add([a, first, c]);
                        self.add([first, b, c]);
                    }
                    Some(second) => {
                        let second = middle(lead + 1, second);
                        self.add([first, b, second]);
                        self.add_quad([a, first, second, c], positions);
                    }
                }
            }
        }
    }

    /// Adds a quadrilateral, cut along its shorter diagonal.
    fn add_quad(&mut self, [a, b, c, d]: [(u32, Vec2); 4], positions: &[Vec3]) {
        let length = |p: (u32, Vec2), q: (u32, Vec2)| {
            positions[p.0 as usize].distance_squared(positions[q.0 as usize])
        };
        if length(a, c) <= length(b, d) {
            self.add([a, b, c]);
            self.add([a, c, d]);
        } else {
            self.add([a, b, d]);
            self.add([b, c, d]);
        }
    }

    fn add(&mut self, corners: [(u32, Vec2); 3]) {
        self.triangles.push(corners.map(|(vertex, _)| vertex));
        self.uvs.push(corners.map(|(_, uv)| uv));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::rings::vertex_normals;
    use crate::mesh::shapes::{grid, torus};
    use crate::mesh::topology::Topology;

    fn textured(mesh: TriangleMesh) -> TexturedMesh {
        let uv = |p: Vec3| Vec2::new(p.x, p.y);
        let triangles = 0..mesh.triangles.len();
        TexturedMesh {
            normals: vertex_normals(&mesh),
            corner_uvs: triangles.map(|t| mesh.corners(t).map(uv)).collect(),
            mesh,
        }
    }

    fn longest_edge(mesh: &TriangleMesh) -> f32 {
        let edges = mesh
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let length =
            |[a, b]: [u32; 2]| mesh.positions[a as usize].distance(mesh.positions[b as usize]);
        edges.map(length).fold(0.0, f32::max)
    }

    #[test]
    fn edges_are_cut_without_cracks_and_the_surface_stays() {
        let coarse = textured(torus(12, 7, 1.0, 0.4));
        let fine = tessellate(coarse.clone(), 0.11, 1 << 20, Progress::silent()).unwrap();
        assert!(longest_edge(&fine.mesh) <= 0.11);
        assert!((fine.mesh.area() / coarse.mesh.area() - 1.0).abs() < 1e-5);
        assert!((fine.mesh.volume() / coarse.mesh.volume() - 1.0).abs() < 1e-5);
        let topology = Topology::new(&fine.mesh.triangles);
        assert_eq!(topology.boundary_half_edges().count(), 0);
        // Texture coordinates went along: they are a function of position still.
        for (triangle, uvs) in fine.corner_uvs.iter().enumerate() {
            for (p, uv) in fine.mesh.corners(triangle).into_iter().zip(uvs) {
                assert!((Vec2::new(p.x, p.y) - *uv).length() < 1e-6);
            }
        }
        assert!(fine.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
        let again = tessellate(fine.clone(), 0.11, 1 << 20, Progress::silent()).unwrap();
        assert_eq!(again, fine);
    }

    #[test]
    fn no_more_triangles_are_made_than_allowed() {
        let surface = textured(grid(2, 2, 1.0));
        let cut = |most| {
            let cut = tessellate(surface.clone(), 1e-3, most, Progress::silent()).unwrap();
            cut.mesh.triangles.len()
        };
        assert_eq!(cut(8), 8);
        assert_eq!(cut(31), 8);
        assert_eq!(cut(32), 32);
        let edge = affordable_edge(&surface.mesh, 1e-3, 10_000);
        let cut = tessellate(surface, edge, 10_000, Progress::silent()).unwrap();
        assert!(longest_edge(&cut.mesh) <= edge as f32);
        assert!((2_000..=10_000).contains(&cut.mesh.triangles.len()));
    }
}
