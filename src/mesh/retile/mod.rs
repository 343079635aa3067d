//! Retiling: as many vertices as asked, spread evenly over the same surface (the aim of Turk 1992).
//!
//! In: a manifold mesh. Out: another on the same surface, with the same components, boundaries and
//! genus; boundaries and creases keep their lines and corners. Deviation: where Turk repels random
//! points and re-triangulates, edges are split, collapsed and flipped in place and vertices relaxed
//! (Botsch and Kobbelt 2004), which keeps the topology by construction.

pub(crate) mod carrying;
mod edge_operations;
mod even_valence;
mod even_walks;
mod features;
mod lines;
mod needle;
mod order;
mod passes;
pub(crate) mod relax;

use crate::error::{Error, Result};
use crate::mesh::retile::edge_operations::EditMesh;
use crate::mesh::retile::even_walks::make_even;
use crate::mesh::retile::features::SharpFeatures;
use crate::mesh::retile::needle::Needle;
use crate::mesh::retile::relax::ReferenceSurface;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// Rounds of split, collapse, turn and relax.
const ROUNDS: usize = 8;
/// Rounds of turn and relax after the count is met.
const FINAL_ROUNDS: usize = 3;
/// Rounds of relaxing after edges are split for even valences.
const EVEN_ROUNDS: usize = 10;
/// Rounds of retiling and splitting; the second knows how many vertices splits add.
const SPLIT_ROUNDS: usize = 2;
/// Rounds of turning edges to Delaunay, at most.
const DELAUNAY_ROUNDS: usize = 20;
/// Splitting makes no more than so many times the vertices that are wanted or there …
const MOST_GROWTH: usize = 8;
/// … and so many more. Even meshes need a third of it; only needles reach it (see [`needle`]).
const MOST_GROWTH_OF_FEW: usize = 2000;
/// Sweeps of collapsing a round, at most.
const COLLAPSE_ROUNDS: usize = 20;

/// The edge length at which `vertices` equilateral triangles' corners cover an area.
pub fn edge_length(area: f64, vertices: usize) -> f64 {
    (2.0 * area / (3f64.sqrt() * vertices as f64)).sqrt()
}

/// Retiles a manifold mesh to `vertices` vertices; `crease` in radians.
pub fn retile(
    mesh: &TriangleMesh,
    vertices: usize,
    crease: f64,
    progress: Progress<'_>,
) -> Result<TriangleMesh> {
    retile_along(mesh, vertices, (crease, &[]), progress)
}

/// Retiles as [`retile`] does, and keeps the lines of some half-edges as well: the seams of a texture.
pub fn retile_along(
    mesh: &TriangleMesh,
    vertices: usize,
    (crease, lines): (f64, &[bool]),
    progress: Progress<'_>,
) -> Result<TriangleMesh> {
    Retiler::new(mesh, &ReferenceSurface::along(mesh, crease, lines)).to(vertices, progress)
}

/// Retiles as [`retile`] does, to about `vertices` vertices, and splits edges until all inner valences and all walks
/// round handles are even. So triangles have two colours, unless creases or too many handles stand in the way.
pub fn retile_evenly(
    mesh: &TriangleMesh,
    vertices: usize,
    crease: f64,
    progress: Progress<'_>,
) -> Result<TriangleMesh> {
    let target = ReferenceSurface::along(mesh, crease, &[]);
    let mut retiler = Retiler::new(mesh, &target);
    let mut before = vertices;
    for _ in 0..SPLIT_ROUNDS {
        retiler.to(before.max(4), progress)?;
        make_even(&mut retiler.edited);
        before = before * vertices / retiler.edited.vertex_count();
    }
    for _ in 0..EVEN_ROUNDS {
        progress.check()?;
        relax::relax(&mut retiler.edited, &target);
    }
    Ok(order::spatially(&retiler.edited).finish())
}

/// A mesh being retiled on its own surface, to one count after another.
///
/// What a coarse mesh bends by is no crease: lines are those of the first mesh, as long as they
/// are lines at the scale of the present one.
pub struct Retiler<'a> {
    edited: EditMesh,
    target: &'a ReferenceSurface,
    area: f64,
    needle: Option<Needle>,
    first: bool,
}

impl<'a> Retiler<'a> {
    /// Opens a manifold mesh; `target` is that mesh.
    pub fn new(mesh: &TriangleMesh, target: &'a ReferenceSurface) -> Self {
        let features = &target.features;
        Self {
            edited: EditMesh::new(mesh, features.sharp.clone(), features.freedom.clone()),
            area: mesh.area(),
            needle: Needle::of(mesh),
            target,
            first: true,
        }
    }

    /// Goes on to `vertices` vertices, or as near as boundaries, creases and topology allow.
    pub fn to(&mut self, vertices: usize, progress: Progress<'_>) -> Result<TriangleMesh> {
        // Choose the length of edges.
        if self.area <= 0.0 {
            return Err(Error::data("mesh", "no triangle has an area"));
        }
        progress.begin("retiling", (ROUNDS + FINAL_ROUNDS) as u64);
        let mut length = edge_length(self.area, vertices) as f32;
        if !std::mem::take(&mut self.first) {
            self.forget_small_features(length);
        }
        let most = MOST_GROWTH * vertices.max(self.edited.vertex_count()) + MOST_GROWTH_OF_FEW;
        // Split, collapse and flip edges, and approach the count.
        for _ in 0..ROUNDS {
            self.round(length, most, progress)?;
            let ratio = self.edited.vertex_count() as f32 / vertices as f32;
            length *= ratio.sqrt().clamp(0.8, 1.25);
            progress.advance(1)?;
        }
        // Meet the count.
        meet_count(&mut self.edited, vertices, progress)?;
        // Even out valences and shapes.
        for _ in 0..FINAL_ROUNDS {
            passes::even_out_valence(&mut self.edited);
            relax::relax(&mut self.edited, self.target);
            progress.advance(1)?;
        }
        for _ in 0..DELAUNAY_ROUNDS {
            if passes::make_delaunay(&mut self.edited) == 0 {
                break;
            }
            progress.check()?;
        }
        // Put what lies near together in memory.
        progress.end();
        progress.check()?;
        self.edited = order::spatially(&self.edited);
        Ok(self.edited.finish())
    }

    /// Keeps the lines that are such at the scale of edges of length `edge`.
    fn forget_small_features(&mut self, edge: f32) {
        let (mesh, known) = (self.edited.finish(), &self.edited.sharp);
        let features = SharpFeatures::at_scale(
            &mesh,
            |half_edge| known[half_edge],
            self.target.crease,
            edge,
        );
        self.edited = EditMesh::new(&mesh, features.sharp, features.freedom);
    }

    /// Brings edges near to a length, with no more than `most` vertices on the way.
    fn round(&mut self, length: f32, most: usize, progress: Progress<'_>) -> Result<()> {
        let edited = &mut self.edited;
        passes::split_long(edited, length * 4.0 / 3.0, most);
        if edited.vertex_count() >= most
            && let Some(needle) = self.needle.take()
        {
            progress.warn(needle.note());
        }
        for _ in 0..COLLAPSE_ROUNDS {
            progress.check()?;
            let collapsed = passes::collapse_short(edited, length * 0.8, length * 4.0 / 3.0, 0);
            if collapsed <= edited.vertex_count() / 50 {
                break;
            }
        }
        *edited = order::spatially(edited);
        passes::even_out_valence(edited);
        progress.check()?;
        relax::relax(edited, self.target);
        Ok(())
    }
}

/// Splits the longest or collapses the shortest edges, no two of them near each other in one sweep,
/// until the count is met or nothing more can be collapsed.
fn meet_count(edited: &mut EditMesh, vertices: usize, progress: Progress<'_>) -> Result<()> {
    let mut rings = [Vec::new(), Vec::new()];
    for _ in 0..40 {
        progress.check()?;
        let before = edited.vertex_count();
        let edges = edges_by_length(edited);
        let mut touched = vec![false; edited.positions.len()];
        let grow = before < vertices;
        let candidates: Box<dyn Iterator<Item = &u32>> = if grow {
            Box::new(edges.iter().rev())
        } else {
            Box::new(edges.iter())
        };
        for &half_edge in candidates {
            let count = edited.vertex_count();
            if count == vertices {
                return Ok(());
            }
            // A sweep works on the extreme edges only; the next one measures again.
            if count.abs_diff(before) > before / 50 + 1 {
                break;
            }
            if !edited.is_alive(half_edge) || is_touched(edited, half_edge, &touched) {
                continue;
            }
            let ends = edited.ends(half_edge);
            if grow {
                let [a, b] = ends.map(|v| edited.positions[v as usize]);
                edited.split(half_edge, a.midpoint(b));
            } else if !passes::try_collapse(edited, half_edge, f32::INFINITY, &mut rings) {
                continue;
            }
            touch(edited, ends, &mut touched);
        }
        if edited.vertex_count() == before {
            return Ok(());
        }
    }
    Ok(())
}

fn edges_by_length(edited: &EditMesh) -> Vec<u32> {
    let mut edges: Vec<(u32, u32)> = (0..edited.opposite.len() as u32)
        .filter(|&h| edited.stands_for_edge(h))
        .map(|h| (edited.length_squared(h).to_bits(), h))
        .collect();
    edges.sort_unstable();
    edges.into_iter().map(|(_, half_edge)| half_edge).collect()
}

fn is_touched(edited: &EditMesh, half_edge: u32, touched: &[bool]) -> bool {
    let touched = |&v: &u32| touched.get(v as usize).copied().unwrap_or(true);
    edited.ends(half_edge).iter().any(touched)
}

/// Marks what is left of an edge's ends, and their neighbours.
fn touch(edited: &EditMesh, ends: [u32; 2], touched: &mut [bool]) {
    for end in ends {
        touched[end as usize] = true;
        edited.each_leaving(end, |leaving| {
            if let Some(flag) = touched.get_mut(edited.ends(leaving)[1] as usize) {
                *flag = true;
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;
    use glam::Vec3;

    fn evenness(mesh: &TriangleMesh) -> f32 {
        let lengths: Vec<f32> = mesh
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| mesh.positions[a as usize].distance(mesh.positions[b as usize]))
            .collect();
        let mean = lengths.iter().sum::<f32>() / lengths.len() as f32;
        let variance = lengths.iter().map(|l| (l - mean).powi(2)).sum::<f32>();
        (variance / lengths.len() as f32).sqrt() / mean
    }

    #[test]
    fn the_count_is_met_evenly_and_the_topology_kept() {
        for mesh in [
            shapes::torus(40, 12, 1.0, 0.4),
            shapes::icosphere(3),
            shapes::cylinder(24, 10, 1.0, 0.4),
            shapes::grid(6, 4, 1.0),
        ] {
            let shape = Topology::new(&mesh.triangles).shape(&mesh);
            for count in [300, 2000] {
                let even = retile(&mesh, count, 0.7, Progress::silent()).unwrap();
                assert_eq!(Topology::new(&even.triangles).shape(&even), shape);
                let off = (even.positions.len() as f32 / count as f32 - 1.0).abs();
                assert!(off <= 0.02, "{} of {count}", even.positions.len());
                let evenness = evenness(&even);
                assert!(evenness < 0.2, "{evenness} at {count}");
            }
        }
    }

    #[test]
    fn small_holes_leave_no_triangle_without_area() {
        let mut mesh = shapes::grid(30, 30, 1.0);
        mesh.triangles
            .retain(|t| !t.contains(&200) && !t.contains(&700));
        mesh.triangles.remove(900);
        let shape = Topology::new(&mesh.triangles).shape(&mesh);
        for count in [400, 3000] {
            let even = retile(&mesh, count, 0.7, Progress::silent()).unwrap();
            assert_eq!(Topology::new(&even.triangles).shape(&even), shape);
            for triangle in 0..even.triangles.len() {
                assert!(
                    even.area_normal(triangle).z > 1e-4,
                    "triangle {triangle} at {count}"
                );
            }
        }
    }

    #[test]
    fn corners_and_borders_of_a_plate_stay() {
        let mesh = shapes::grid(6, 4, 1.0);
        let even = retile(&mesh, 500, 0.7, Progress::silent()).unwrap();
        for corner in [Vec3::ZERO, Vec3::new(6.0, 4.0, 0.0)] {
            assert!(even.positions.contains(&corner));
        }
        assert!((even.area() - 24.0).abs() < 1e-4);
    }
}
