//! Samples and neighbours of all sites of a level, packed, from the surface points of their windows.

use rayon::prelude::*;

use super::cells::{CellSample, CellStencils};
use super::level_cells::LevelCells;
use super::neighbors::{NeighborCollector, PackedNeighbor};
use super::texels::LevelTexels;
use crate::error::{Error, Result};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::surface_bvh::SurfacePoint;
use crate::neighborhood::Template;
use crate::progress::Progress;

/// A window of samples to be collected.
#[derive(Clone, Copy)]
pub struct Window<'a> {
    /// Where its samples lie, in texels of the texture.
    pub template: &'a Template,
    /// Its width in texels.
    pub width: u32,
    /// Whether neighbours are collected too.
    pub neighbors: bool,
}

/// What became of the samples of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AtlasCounts {
    /// With a value.
    pub valued: u64,
    /// Beyond the surface.
    pub outside: u64,
    /// Without a place in a chart: a straight path was tried. They are also counted above.
    pub marched: u64,
}

/// The samples and neighbours of one window at every site of a level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelSamples {
    /// The samples.
    pub stencils: CellStencils,
    /// The neighbours; none where they were not asked for.
    pub neighbors: Rows<PackedNeighbor>,
    /// What became of the samples.
    pub counts: AtlasCounts,
}

/// The samples and neighbours of some sites.
#[derive(Default)]
pub struct SiteBlock {
    sites: Vec<u32>,
    samples: Vec<CellSample>,
    neighbors: Vec<PackedNeighbor>,
    /// Where the neighbours of each site end.
    ends: Vec<u32>,
    counts: AtlasCounts,
    collector: NeighborCollector,
}

impl SiteBlock {
    /// Takes the samples of one site, in the template's order; the centre is the site itself.
    pub fn take(
        &mut self,
        (level, cells): (&LevelTexels, &LevelCells<'_>),
        window: Window<'_>,
        site: usize,
        points: impl Iterator<Item = Option<SurfacePoint>>,
    ) {
        self.collector.begin();
        // Take sample after sample.
        for (offset, point) in window.template.positions.iter().zip(points) {
            let sample = match point {
                _ if *offset == glam::Vec2::ZERO => cells.at_site(site),
                Some(point) => cells.sample(&point),
                None => CellSample::OUTSIDE,
            };
            self.samples.push(sample);
            match sample {
                CellSample::OUTSIDE => self.counts.outside += 1,
                _ => self.counts.valued += 1,
            }
            if window.neighbors {
                let location = sample.locate(cells.cells());
                self.collector.take(level, site, *offset, location);
            }
        }
        // Keep the neighbours where they are wanted.
        if window.neighbors {
            self.collector
                .finish(site, window.width, &mut self.neighbors);
        }
        self.sites.push(site as u32);
        self.ends.push(self.neighbors.len() as u32);
    }

    /// Counts samples that had no place in a chart.
    pub fn count_marched(&mut self, marched: u64) {
        self.counts.marched += marched;
    }
}

/// Sites per block of [`site_by_site`].
const SITES: usize = 1024;

/// The samples of all sites, each taken by itself.
pub fn site_by_site(
    on: (&LevelTexels, &LevelCells<'_>),
    window: Window<'_>,
    progress: Progress<'_>,
    take: impl Fn(usize, &mut SiteBlock) + Sync,
) -> Result<LevelSamples> {
    let count = on.0.texels.len();
    let of_block = |block: usize| {
        let mut out = SiteBlock::default();
        for site in block * SITES..((block + 1) * SITES).min(count) {
            progress.check()?;
            take(site, &mut out);
        }
        Ok(out)
    };
    let blocks = (0..count.div_ceil(SITES)).into_par_iter().map(of_block);
    join(on, window, blocks.collect::<Result<_>>()?)
}

/// Puts blocks together that hold every site once, in the order of sites.
pub fn join(
    (level, cells): (&LevelTexels, &LevelCells<'_>),
    window: Window<'_>,
    blocks: Vec<SiteBlock>,
) -> Result<LevelSamples> {
    // Find where each site's neighbours begin.
    let (count, per_site) = (level.texels.len(), window.template.positions.len());
    let starts = starts(&blocks, count)?;
    let mut counts = AtlasCounts::default();
    let mut samples = vec![CellSample::OUTSIDE; count * per_site];
    let mut neighbors = vec![PackedNeighbor::default(); starts[count] as usize];
    // Copy block after block to its sites.
    for block in blocks {
        counts.valued += block.counts.valued;
        counts.outside += block.counts.outside;
        counts.marched += block.counts.marched;
        let mut begin = 0;
        for (place, (&site, &end)) in block.sites.iter().zip(&block.ends).enumerate() {
            let (site, end) = (site as usize, end as usize);
            samples[site * per_site..][..per_site]
                .copy_from_slice(&block.samples[place * per_site..][..per_site]);
            neighbors[starts[site] as usize..starts[site + 1] as usize]
                .copy_from_slice(&block.neighbors[begin..end]);
            begin = end;
        }
    }
    Ok(LevelSamples {
        stencils: CellStencils {
            samples_per_site: per_site,
            cells: cells.cells().clone(),
            samples,
        },
        neighbors: Rows {
            starts,
            entries: neighbors,
        },
        counts,
    })
}

/// Where the neighbours of each site begin; 32-bit, and more are refused.
fn starts(blocks: &[SiteBlock], count: usize) -> Result<Vec<u32>> {
    let total: usize = blocks.iter().map(|block| block.neighbors.len()).sum();
    if u32::try_from(total).is_err() {
        return Err(Error::option(
            "resolution",
            format!("{total} neighbours of all texels"),
            "fewer than 4294967296: a lower --resolution, or a smaller neighbourhood",
        ));
    }
    let mut starts = vec![0; count + 1];
    for block in blocks {
        let mut begin = 0;
        for (&site, &end) in block.sites.iter().zip(&block.ends) {
            starts[site as usize + 1] = end - begin;
            begin = end;
        }
    }
    for site in 0..count {
        starts[site + 1] += starts[site];
    }
    Ok(starts)
}
