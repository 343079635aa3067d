//! Marching round every vertex of a mesh, in parallel over blocks of vertices; and the vertices inside the
//! outermost circles.
//!
//! Deviation: the paper takes all vertices of a neighbourhood for candidates. Here the nearest
//! [`MOST_NEIGHBORS`] are kept.

use rayon::prelude::*;

use super::arcs::{Arc, Circles, NearVertex, fraction_between};
use super::frame::Manifold;
use super::march::Marcher;
use super::options::check_circle_count;
use super::patch::Patch;
use crate::error::{Error, Result};
use crate::mesh::compressed_rows::Rows;
use crate::neighborhood::turn_of;
use crate::progress::Progress;

/// Vertices per block: one patch serves them one after the other.
const BLOCK: usize = 2048;
/// A vertex this much farther from the axis than the outermost circle (as a share) lies on it: on regular
/// meshes rounding must not decide.
const ON_CIRCLE: f64 = 1e-5;

/// The most vertices kept as neighbours of one, the nearest: on coarse levels the outermost circle holds
/// thousands, all within a fraction of a texel of nearer ones.
pub const MOST_NEIGHBORS: usize = 128;

/// The circles of consecutive vertices.
#[derive(Default)]
struct Block {
    arcs: Vec<Arc>,
    /// Where each circle's arcs end.
    arc_ends: Vec<usize>,
    perimeters: Vec<f32>,
    near: Vec<NearVertex>,
    /// Where each vertex's neighbours end.
    near_ends: Vec<usize>,
    /// Neighbours of one vertex: squared distance from the axis and index among the patch's corners.
    found: Vec<(f64, u32, u32)>,
}

/// Marches `per_vertex` circles round every vertex; circle m has m times the vertex's radius (mesh units).
pub fn march(
    surface: Manifold<'_>,
    radii: &[f32],
    per_vertex: u32,
    progress: Progress<'_>,
) -> Result<Circles> {
    check(surface, radii, per_vertex)?;
    let blocks: Vec<Block> = radii
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, radii)| {
            let mut patch = Patch::new(surface, per_vertex);
            let mut marcher = Marcher::default();
            let mut out = Block::default();
            for (vertex, &radius) in (block * BLOCK..).zip(radii) {
                progress.check()?;
                let radius = f64::from(radius);
                patch.grow(vertex, radius);
                out.take_circles(&patch, &mut marcher, per_vertex, radius);
                out.take_near(&patch, vertex, per_vertex, radius);
            }
            Ok(out)
        })
        .collect::<Result<_>>()?;
    join(&blocks, radii, per_vertex)
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

impl Block {
    fn take_circles(
        &mut self,
        patch: &Patch<'_>,
        marcher: &mut Marcher,
        per_vertex: u32,
        radius: f64,
    ) {
        for number in 1..=per_vertex {
            let perimeter = marcher.circle(patch, number, radius, &mut self.arcs);
            self.perimeters.push(perimeter as f32);
            self.arc_ends.push(self.arcs.len());
        }
    }

    /// Takes the vertices of the patch inside the outermost circle, nearest first, ties by index.
    fn take_near(&mut self, patch: &Patch<'_>, vertex: usize, per_vertex: u32, radius: f64) {
        let outermost = f64::from(per_vertex) * radius;
        self.found.clear();
        for (place, corner) in patch.corners.iter().enumerate() {
            let inside = corner.distance <= outermost * (1.0 + ON_CIRCLE);
            if corner.in_patch && inside && corner.vertex as usize != vertex {
                self.found
                    .push((corner.distance, corner.vertex, place as u32));
            }
        }
        self.found
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
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
            .map(|&(distance, vertex, place)| {
                let turn = turn_of(patch.corners[place as usize].place.truncate());
                let radii = (distance / radius) as f32;
                let turn = fraction_between(circle, per_vertex, radii, turn as f32);
                NearVertex::new(vertex, (distance / outermost) as f32, turn)
            });
        self.near.extend(near);
        self.near_ends.push(self.near.len());
    }
}

/// Puts the blocks together; starts are 32-bit, and more entries than that are refused.
fn join(blocks: &[Block], radii: &[f32], per_vertex: u32) -> Result<Circles> {
    Ok(Circles {
        per_vertex,
        radii: radii.to_vec(),
        arcs: rows(blocks.iter().map(|block| (&block.arc_ends, &block.arcs)))?,
        near: rows(blocks.iter().map(|block| (&block.near_ends, &block.near)))?,
        perimeters: blocks
            .iter()
            .flat_map(|block| block.perimeters.iter().copied())
            .collect(),
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
