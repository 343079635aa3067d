//! Sampling in planar charts (Ying 2001 §4.2): the surface round every vertex is flattened once, and all
//! texels nearest to the vertex are sampled there. The pattern is laid in the chart through the chart's
//! Jacobian, so that it is square on the surface.
//!
//! Where a chart folds, closes a ring or ends too early a straight path leads to the sample.
//!
//! Charts are discrete exponential maps (Schmidt 2006): an atlas of texture coordinates has no control mesh whose
//! texture maps could be put together as the paper does. [`vertex_stars`](super::vertex_stars) is for those that
//! have one.

use glam::Vec2;
use rayon::prelude::*;

use super::collecting::{LevelSamples, SiteBlock, Window, join};
use super::drawing::Drawing;
use super::geometry::{Geometry, largest};
use super::level_cells::LevelCells;
use super::paths::Paths;
use super::texels::LevelTexels;
use crate::error::Result;
use crate::mesh::chart::{ChartGrower, Placed};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::sites::vertices::sampling::{BinnedTemplate, Sampler};
use crate::sites::vertices::stencil::PackedSample as InTriangle;

/// Vertices per block: one grower serves them.
const BLOCK: usize = 256;

/// The samples of a window at every site of a level.
pub fn sample(
    (geometry, marched): (&Geometry<'_>, &TriangleMesh),
    (level, cells): (&LevelTexels, &LevelCells<'_>),
    window: Window<'_>,
    progress: Progress<'_>,
) -> Result<LevelSamples> {
    // Find the sites near each vertex.
    let sites = sites_of_vertices(geometry, level);
    let template = BinnedTemplate::new(window.template);
    let count = geometry.mesh.positions.len();
    // Sample them in one chart per vertex.
    let blocks: Vec<SiteBlock> = (0..count.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut charts = VertexCharts {
                geometry,
                marched,
                level,
                radius: template.radius(),
                grower: ChartGrower::new(count),
                sampler: Sampler::new(geometry.mesh, &geometry.connection, &template),
                found: Vec::new(),
            };
            let mut out = SiteBlock::default();
            for vertex in block * BLOCK..((block + 1) * BLOCK).min(count) {
                progress.check()?;
                let sites = sites.row(vertex);
                if !sites.is_empty() {
                    charts.take(vertex as u32, sites, cells, window, &mut out);
                }
            }
            Ok(out)
        })
        .collect::<Result<_>>()?;
    join((level, cells), window, blocks)
}

/// Per vertex the sites nearest to it: those whose triangle gives it the largest weight.
fn sites_of_vertices(geometry: &Geometry<'_>, level: &LevelTexels) -> Rows<u32> {
    let vertex = |site: &u32| {
        let point = level.point(geometry, *site as usize);
        let corners = geometry.mesh.triangles[point.triangle as usize];
        corners[largest(point.weights)]
    };
    let mut pairs: Vec<(u32, u32)> = (0..level.texels.len() as u32)
        .into_par_iter()
        .map(|site| (vertex(&site), site))
        .collect();
    pairs.par_sort_unstable();
    let vertices = 0..=geometry.mesh.positions.len() as u32;
    let start = |vertex| pairs.partition_point(|pair| pair.0 < vertex) as u32;
    Rows {
        starts: vertices.map(start).collect(),
        entries: pairs.iter().map(|&(_, site)| site).collect(),
    }
}

/// Charts round vertices; keeps its memory from one to the next.
struct VertexCharts<'a> {
    geometry: &'a Geometry<'a>,
    marched: &'a TriangleMesh,
    level: &'a LevelTexels,
    /// Of the template, in texels.
    radius: f32,
    grower: ChartGrower,
    sampler: Sampler<'a>,
    found: Vec<InTriangle>,
}

impl VertexCharts<'_> {
    /// Samples the sites of one vertex.
    fn take(
        &mut self,
        vertex: u32,
        sites: &[u32],
        cells: &LevelCells<'_>,
        window: Window<'_>,
        out: &mut SiteBlock,
    ) {
        let radius = self.radius_for(vertex, sites);
        let connection = &self.geometry.connection;
        let placed: Vec<Placed> = self
            .grower
            .round_vertex(connection, vertex, radius)
            .to_vec();
        for &site in sites {
            let site = site as usize;
            self.locate(site, &placed);
            let paths = Paths::new((self.geometry, self.marched), self.level, site);
            let mut marched = 0;
            let offsets = window.template.positions.iter().enumerate();
            let points = offsets.map(|(sample, &offset)| {
                self.found(sample).or_else(|| {
                    marched += 1;
                    paths.end(offset)
                })
            });
            out.take((self.level, cells), window, site, points);
            out.count_marched(marched);
        }
    }

    /// Finds the samples of a site in the chart grown last.
    fn locate(&mut self, site: usize, placed: &[Placed]) {
        self.found.clear();
        if let Some(drawing) = self.drawing(site) {
            let texels_from_chart = drawing.chart_from_texels.inverse();
            let draw = |at: Vec2| texels_from_chart * (at - drawing.centre);
            self.sampler
                .locate_drawn(&self.grower, placed, draw, &mut self.found);
        }
    }

    /// The surface point of a sample; `None` where the chart has no place for it.
    fn found(&self, sample: usize) -> Option<SurfacePoint> {
        let found = self.found.get(sample)?;
        if found.cell == InTriangle::NO_CELL {
            return None;
        }
        let corners = self.geometry.mesh.corners(found.cell as usize);
        let weights = found.barycentric();
        Some(SurfacePoint {
            triangle: found.cell,
            weights,
            position: (0..3).map(|k| corners[k] * weights[k]).sum(),
        })
    }

    /// How far a chart has to reach for the windows of some sites. Triangles with a corner as near as that are
    /// in the chart; larger ones are crossed by straight paths.
    fn radius_for(&self, vertex: u32, sites: &[u32]) -> f32 {
        let centre = self.geometry.mesh.positions[vertex as usize];
        let reach = sites.iter().map(|&site| {
            let site = site as usize;
            let distance = self.level.positions[site].distance(centre);
            distance + self.radius * self.level.spacing[site]
        });
        reach.fold(0.0, f32::max)
    }

    /// How the chart grown last is laid on the template's plane for a site. `None` where it folds there.
    fn drawing(&self, site: usize) -> Option<Drawing> {
        let point = self.level.point(self.geometry, site);
        let ids = self.geometry.mesh.triangles[point.triangle as usize];
        let [a, b, c] = ids.map(|id| self.grower.position_of(id));
        Drawing::new(self.geometry, self.level, site, [a?, b?, c?])
    }
}
