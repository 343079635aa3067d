//! The sites near a site: those that the samples of its window blend, packed in 8 bytes each.

use glam::{Vec2, Vec3};

use super::texels::LevelTexels;
use crate::sites::level::{Neighbor, SampleLocation};

/// Parts of a texel in which offsets are stored: 64 texels fit.
const PARTS: f32 = 512.0;
/// Squares of distances are compared in parts of a texel as coarse as this, so that rounding does not decide.
const SQUARE_PARTS: f32 = 256.0;

/// A neighbour: its site and its offset in 1/512 of a texel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PackedNeighbor {
    site: u32,
    offset: [i16; 2],
}

impl PackedNeighbor {
    fn new(site: u32, offset: Vec2) -> Self {
        let parts = |at: f32| (at * PARTS).round().clamp(-32767.0, 32767.0) as i16;
        Self {
            site,
            offset: offset.to_array().map(parts),
        }
    }

    /// The neighbour, with its offset in texels.
    #[inline(always)]
    pub fn unpacked(self) -> Neighbor {
        let [x, y] = self.offset.map(|parts| f32::from(parts) / PARTS);
        Neighbor {
            site: self.site,
            x,
            y,
        }
    }
}

/// A site that a sample blends.
#[derive(Clone, Copy, Debug)]
struct Blended {
    site: u32,
    weight: f32,
    offset: Vec2,
}

/// Collects neighbours; keeps its memory from one site to the next.
#[derive(Default)]
pub struct NeighborCollector {
    blended: Vec<Blended>,
}

impl NeighborCollector {
    /// Begins with another site.
    pub fn begin(&mut self) {
        self.blended.clear();
    }

    /// Takes the sites that a sample of `site` at `offset` (texels) blends. Each lies as far from the sample
    /// as its position from that of all.
    pub fn take(
        &mut self,
        level: &LevelTexels,
        site: usize,
        offset: Vec2,
        sample: SampleLocation<4>,
    ) {
        let position = |other: u32| level.positions[other as usize];
        match sample {
            SampleLocation::Outside => {}
            SampleLocation::AtSite(other) => self.blended.push(Blended {
                site: other,
                weight: 1.0,
                offset,
            }),
            SampleLocation::Between(others, weights) => {
                let middle: Vec3 = (0..4).map(|k| position(others[k]) * weights[k]).sum();
                for (other, weight) in others.into_iter().zip(weights) {
                    let apart = position(other) - middle;
                    let apart = Vec2::from_array(level.seen_from(site, apart));
                    self.blended.push(Blended {
                        site: other,
                        weight,
                        offset: offset + apart,
                    });
                }
            }
        }
    }

    /// Appends the neighbours of `site` within a window of odd width, each once and where the sample that
    /// gives it the largest weight has it, nearest first; no more than the window has texels beside its own.
    pub fn finish(&mut self, site: usize, window: u32, out: &mut Vec<PackedNeighbor>) {
        let reach = window as f32 / 2.0;
        self.blended.retain(|blended| {
            blended.site as usize != site && blended.offset.abs().max_element() <= reach
        });
        self.blended
            .sort_by(|a, b| a.site.cmp(&b.site).then(b.weight.total_cmp(&a.weight)));
        self.blended.dedup_by_key(|blended| blended.site);
        let square = |of: &Blended| (of.offset.length_squared() * SQUARE_PARTS).round() as u32;
        self.blended.sort_by_key(|of| (square(of), of.site));
        self.blended.truncate((window * window) as usize - 1);
        let packed = self.blended.iter();
        out.extend(packed.map(|of| PackedNeighbor::new(of.site, of.offset)));
    }
}
