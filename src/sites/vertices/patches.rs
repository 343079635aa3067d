//! Stencils and neighbours of every vertex of a level: charts grown and sampled in parallel.

use rayon::prelude::*;

use crate::error::Result;
use crate::mesh::chart::{ChartGrower, Placed};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::connection::Connection;
use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::Template;
use crate::progress::Progress;
use crate::sites::level::{Neighbor, Parent};
use crate::sites::vertices::parents::{nearest_corner, seeds};
use crate::sites::vertices::sampling::{BinnedTemplate, SampleCounts, Sampler};
use crate::sites::vertices::stencil::{PackedSample, PatchStencils};

/// Vertices a block: one grower serves them one after the other.
const BLOCK: usize = 4096;

/// A vertex drawn nearer than this share of its distance in space lies in a fold: no way along the
/// surface is shorter.
const FOLDED: f32 = 0.8;

/// One level's surface, ready to be walked on.
#[derive(Clone, Copy)]
pub struct Patches<'a> {
    /// The level's mesh.
    pub mesh: &'a TriangleMesh,
    /// Its frames and edges.
    pub connection: &'a Connection,
    /// Texel of the level in mesh units, per vertex (its scale included).
    pub texels: &'a [f32],
}

/// What the charts of a level gave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelPatches {
    /// The template's samples.
    pub stencils: PatchStencils,
    /// Vertices within the window.
    pub neighbors: Rows<Neighbor>,
    /// What became of the samples, over all vertices.
    pub counts: SampleCounts,
}

/// The patches of consecutive vertices.
#[derive(Default)]
struct PatchBlock {
    samples: Vec<PackedSample>,
    neighbors: Vec<Neighbor>,
    /// Where each vertex's neighbours end.
    ends: Vec<u32>,
    counts: SampleCounts,
}

impl PatchBlock {
    /// Takes the placed vertices within the window, but those the chart draws nearer than they are:
    /// they lie in a fold.
    fn take_neighbors(
        &mut self,
        patches: &Patches<'_>,
        vertex: usize,
        placed: &[Placed],
        half_window: f32,
    ) {
        let (texel, positions) = (patches.texels[vertex], &patches.mesh.positions);
        let folded = |p: &Placed| {
            let real = positions[vertex].distance(positions[p.vertex as usize]);
            p.position.length() < FOLDED * real
        };
        let others = placed
            .iter()
            .filter(|p| p.vertex as usize != vertex && !folded(p));
        let near = others.map(|p| Neighbor {
            site: p.vertex,
            x: p.position.x / texel,
            y: p.position.y / texel,
        });
        self.neighbors
            .extend(near.filter(|n| n.x.abs().max(n.y.abs()) <= half_window));
        self.ends.push(self.neighbors.len() as u32);
    }
}

impl Patches<'_> {
    /// Stencils of a template round every vertex, and the neighbours within `half_window` texels
    /// (max norm), nearest first, ties by index.
    pub fn round_vertices(
        &self,
        template: &Template,
        half_window: f32,
        progress: Progress<'_>,
    ) -> Result<LevelPatches> {
        // Sort the template's positions into bins.
        let binned = BinnedTemplate::new(template);
        let radius = binned.radius().max(half_window * std::f32::consts::SQRT_2);
        let centre = template
            .positions
            .iter()
            .position(|p| *p == glam::Vec2::ZERO);
        let count = self.mesh.positions.len();
        // Flatten the surroundings of each vertex, and locate the positions in them.
        let blocks: Vec<PatchBlock> = (0..count.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let mut grower = ChartGrower::new(count);
                let mut sampler = Sampler::new(self.mesh, self.connection, &binned);
                let mut out = PatchBlock::default();
                for vertex in block * BLOCK..((block + 1) * BLOCK).min(count) {
                    progress.check()?;
                    let texel = self.texels[vertex];
                    let placed = grower
                        .round_vertex(self.connection, vertex as u32, radius * texel)
                        .to_vec();
                    out.counts += sampler.locate(&grower, &placed, texel, &mut out.samples);
                    if let Some(centre) = centre {
                        let slot = out.samples.len() - binned.len() + centre;
                        out.samples[slot] = sampler.stands_on(vertex as u32);
                    }
                    out.take_neighbors(self, vertex, &placed, half_window);
                }
                Ok(out)
            })
            .collect::<Result<_>>()?;
        Ok(self.join(binned.len(), blocks))
    }

    fn join(&self, samples_per_site: usize, blocks: Vec<PatchBlock>) -> LevelPatches {
        let mut level = LevelPatches::default();
        level.stencils.samples_per_site = samples_per_site;
        level.stencils.cells.clone_from(&self.mesh.triangles);
        let total = samples_per_site * self.mesh.positions.len();
        level.stencils.samples.reserve_exact(total);
        level.neighbors.starts.push(0);
        for block in blocks {
            let base = level.neighbors.entries.len() as u32;
            level.stencils.samples.extend(block.samples);
            level.neighbors.entries.extend(block.neighbors);
            level
                .neighbors
                .starts
                .extend(block.ends.into_iter().map(|end| base + end));
            level.counts += block.counts;
        }
        level
    }

    /// Stencils of a template round the parent points of a finer level on this one, each in the
    /// frame of its child, with the parents' nearest corners. `children` are the finer level's
    /// frames; `texels` this level's texel at each child.
    pub fn round_points(
        &self,
        template: &Template,
        points: &[SurfacePoint],
        children: &Connection,
        texels: &[f32],
        progress: Progress<'_>,
    ) -> Result<(PatchStencils, Vec<Parent>)> {
        // Sort the template's positions into bins.
        let binned = BinnedTemplate::new(template);
        let radius = binned.radius();
        // Flatten the surroundings of each point, and locate the positions in them.
        let rows = Rows::collect(
            points.len(),
            || {
                let grower = ChartGrower::new(self.mesh.positions.len());
                (grower, Sampler::new(self.mesh, self.connection, &binned))
            },
            |(grower, sampler), child, out| {
                if progress.is_interrupted() || !points[child].is_somewhere() {
                    out.extend(std::iter::repeat_n(PackedSample::OUTSIDE, binned.len()));
                    return;
                }
                let seeds = self.seeds(points, children, child);
                let placed = grower
                    .grow(self.connection, &seeds, radius * texels[child])
                    .to_vec();
                sampler.locate(grower, &placed, texels[child], out);
            },
        );
        // Find the parents.
        progress.check()?;
        let parents = (0..points.len())
            .into_par_iter()
            .map(|child| match points[child].is_somewhere() {
                true => nearest_corner(
                    &points[child],
                    &self.seeds(points, children, child),
                    texels[child],
                ),
                false => Parent {
                    site: 0,
                    x: 0.0,
                    y: 0.0,
                },
            })
            .collect();
        let stencils = PatchStencils {
            samples_per_site: binned.len(),
            cells: self.mesh.triangles.clone(),
            samples: rows.entries,
        };
        Ok((stencils, parents))
    }

    fn seeds(&self, points: &[SurfacePoint], children: &Connection, child: usize) -> [Placed; 3] {
        seeds(
            self.mesh,
            self.connection,
            &points[child],
            &children.frames[child],
        )
    }
}
