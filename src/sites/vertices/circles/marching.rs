//! Marching round every vertex of a mesh, in parallel over blocks of vertices; and the vertices inside the
//! outermost circles.
//!
//! Deviation: the paper takes all vertices of a neighbourhood for candidates. Here the nearest
//! [`MOST_NEIGHBORS`] are kept.

use glam::DVec3;
use rayon::prelude::*;

use super::arcs::{Arc, Circles, NearVertex, fraction_between};
use super::frame::Manifold;
use super::march::Marcher;
use super::options::check_circle_count;
use super::patch::Patch;
use crate::error::{Error, Result};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::turn_of;
use crate::progress::Progress;

/// Vertices per block: one patch serves them one after the other.
const BLOCK: usize = 2048;
/// A vertex this much farther from the axis than the outermost circle (as a share) lies on it: on regular
/// meshes rounding must not decide.
const ON_CIRCLE: f64 = 1e-5;

/// The most vertices kept as neighbours of one, the nearest: on coarse levels the outermost circle holds
/// thousands, all within a fraction of a texel of nearer ones.
pub const MOST_NEIGHBORS: usize = 64;

/// The circles of consecutive vertices.
#[derive(Default)]
struct CircleBlock {
    arcs: Vec<Arc>,
    /// Where each circle's arcs end.
    arc_ends: Vec<usize>,
    perimeters: Vec<f32>,
    near: Vec<NearVertex>,
    /// Where each vertex's neighbours end.
    near_ends: Vec<usize>,
    /// Neighbours of one vertex: squared distance from the axis its index, and that among the patch's corners.
    found: Vec<(f64, u32, u32)>,
}

/// Marches `per_vertex` circles round every vertex; circle m has m times the vertex's radius (mesh units).
pub fn march(
    surface: Manifold<'_>,
    radii: &[f32],
    per_vertex: u32,
    progress: Progress<'_>,
) -> Result<Circles> {
    let mut circles = march_levels(surface, radii, per_vertex, &[0], progress)?;
    Ok(circles.remove(0))
}

/// Marches the circles of some levels, given in ascending order: on level l every radius is 2^l times what
/// `radii` says. A vertex's patch of one level grows out of that of the level before.
pub fn march_levels(
    surface: Manifold<'_>,
    radii: &[f32],
    per_vertex: u32,
    levels: &[u32],
    progress: Progress<'_>,
) -> Result<Vec<Circles>> {
    // March block by block; the patch of a vertex grows from level to level.
    check(surface, radii, per_vertex)?;
    let normals = normals(surface.mesh);
    let blocks: Vec<Vec<CircleBlock>> = radii
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, radii)| {
            let mut patch = Patch::new(surface, &normals);
            let mut marcher = Marcher::default();
            let mut out: Vec<CircleBlock> = levels.iter().map(|_| CircleBlock::default()).collect();
            for (vertex, &radius) in (block * BLOCK..).zip(radii) {
                progress.check()?;
                patch.begin(vertex, f64::from(radius));
                for (&level, out) in levels.iter().zip(&mut out) {
                    let numbers = (1..=per_vertex).map(|number| number << level);
                    patch.grow(per_vertex << level);
                    out.take_circles(&patch, &mut marcher, numbers);
                    out.take_near(&patch, vertex, per_vertex, level);
                }
            }
            Ok(out)
        })
        .collect::<Result<_>>()?;
    // Join the blocks of each level.
    let of_level = |(place, &level): (usize, &u32)| {
        let scale = (1_u32 << level) as f32;
        let radii = radii.iter().map(|radius| radius * scale).collect();
        join(
            blocks.iter().map(|of_levels| &of_levels[place]),
            radii,
            per_vertex,
        )
    };
    levels.par_iter().enumerate().map(of_level).collect()
}

/// The unit normals of a mesh's triangles, 0 where they have no area.
fn normals(mesh: &TriangleMesh) -> Vec<DVec3> {
    let normal = |triangle| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner.as_dvec3());
        (b - a).cross(c - a).normalize_or_zero()
    };
    (0..mesh.triangles.len())
        .into_par_iter()
        .map(normal)
        .collect()
}

fn check(surface: Manifold<'_>, radii: &[f32], per_vertex: u32) -> Result<()> {
    check_circle_count(per_vertex)?;
    let count = surface.mesh.positions.len();
    if radii.len() != count {
        return Err(Error::data("radii", radii.len().to_string()).expected(count.to_string()));
    }
    let sound = |radius: &f32| radius.is_finite() && *radius > 0.0;
    match radii.iter().position(|radius| !sound(radius)) {
        Some(vertex) => Err(Error::data(
            format!("radius of vertex {vertex}"),
            radii[vertex].to_string(),
        )
        .expected("a length above 0")),
        None => Ok(()),
    }
}

impl CircleBlock {
    /// Takes the circles of these numbers.
    fn take_circles(
        &mut self,
        patch: &Patch<'_>,
        marcher: &mut Marcher,
        numbers: impl Iterator<Item = u32>,
    ) {
        for number in numbers {
            let perimeter = marcher.circle(patch, number, &mut self.arcs);
            self.perimeters.push(perimeter as f32);
            self.arc_ends.push(self.arcs.len());
        }
    }

    /// Takes the vertices of the patch inside the outermost circle of a level, nearest first, ties by index.
    fn take_near(&mut self, patch: &Patch<'_>, vertex: usize, per_vertex: u32, level: u32) {
        // Find the vertices inside, nearest first.
        let radius = patch.radius * f64::from(1_u32 << level);
        let outermost = f64::from(per_vertex) * radius;
        let farthest = (outermost * (1.0 + ON_CIRCLE)).powi(2);
        self.found.clear();
        for (place, corner) in patch.corners.iter().enumerate() {
            if corner.square <= farthest && corner.vertex as usize != vertex {
                self.found
                    .push((corner.square, corner.vertex, place as u32));
            }
        }
        self.found
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // Place each between the circles, by arc length.
        let first = self.arc_ends.len() - per_vertex as usize;
        let circle = |number: u32| {
            let row = first + number as usize - 1;
            let begin = if row == 0 { 0 } else { self.arc_ends[row - 1] };
            &self.arcs[begin..self.arc_ends[row]]
        };
        let near = self
            .found
            .iter()
            .take(MOST_NEIGHBORS)
            .map(|&(square, vertex, place)| {
                let distance = square.sqrt();
                let turn = turn_of(patch.corners[place as usize].place.truncate());
                let radii = (distance / radius) as f32;
                let turn = fraction_between(circle, per_vertex, radii, turn as f32);
                NearVertex::new(vertex, (distance / outermost) as f32, turn)
            });
        self.near.extend(near);
        self.near_ends.push(self.near.len());
    }
}

/// Puts the blocks of a level together; starts are 32-bit, and more entries than that are refused.
fn join<'a>(
    blocks: impl Iterator<Item = &'a CircleBlock> + Clone,
    radii: Vec<f32>,
    per_vertex: u32,
) -> Result<Circles> {
    let perimeters = blocks.clone().flat_map(|block| &block.perimeters);
    Ok(Circles {
        per_vertex,
        radii,
        perimeters: perimeters.copied().collect(),
        arcs: rows(blocks.clone().map(|block| (&block.arc_ends, &block.arcs)))?,
        near: rows(blocks.map(|block| (&block.near_ends, &block.near)))?,
    })
}

fn rows<'a, T: Copy + 'a>(
    blocks: impl Iterator<Item = (&'a Vec<usize>, &'a Vec<T>)> + Clone,
) -> Result<Rows<T>> {
    let total: usize = blocks.clone().map(|(_, entries)| entries.len()).sum();
    if u32::try_from(total).is_err() {
        return Err(
            Error::data("circles", format!("{total} arcs or neighbours"))
                .expected("fewer than 4294967296")
                .advice("take a smaller texel, fewer circles or fewer levels"),
        );
    }
    let mut rows = Rows {
        starts: vec![0],
        entries: Vec::with_capacity(total),
    };
    for (ends, entries) in blocks {
        let base = rows.entries.len();
        rows.starts
            .extend(ends.iter().map(|end| (base + end) as u32));
        rows.entries.extend_from_slice(entries);
    }
    Ok(rows)
}
