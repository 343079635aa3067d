//! The texels that a blend of views reads, each in the image of its view.
//!
//! The wanted view w sees at the coordinate c a point of height z. The image of view i shows it at
//! c + z·(w_xy/w_z − i_xy/i_z). Of the four texels round that place count those at which view i sees the surface at
//! that height: where it sees it higher, the point is hidden behind what is seen; where lower, the texel shows what
//! lies beyond the point's edge.

use glam::{Vec2, Vec3};

use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::render::nearest::Weight;
use crate::render::parallax::relief::{Relief, slope_of};

/// Heights that differ by less are of one surface, in texels of the level; from twice that on they are not.
const SAME_SURFACE: f32 = 0.5;
/// Where less than this share of the views' weight sees the point, plain blending fades in.
const LEAST_SEEN: f32 = 0.05;

/// A texel that is read in the images of one view, and its share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Read {
    /// The texel, of the level that is read.
    pub texel: TexelIndex,
    /// The view, as an index among the distinct ones.
    pub view: u32,
    /// Its share of the blend.
    pub share: f32,
}

/// What is looked up.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Where on the sample.
    pub coord: TexCoord,
    /// The pyramid level; 0 is the finest.
    pub level: usize,
    /// The wanted view, above the horizon.
    pub view: Vec3,
    /// How far images may be read from the coordinate, in texels of the finest level.
    pub reach: f32,
}

/// Reads, and working memory to find them; one per task.
#[derive(Debug, Default)]
pub struct ReadList {
    reads: Vec<Read>,
    plain: Vec<Weight>,
    seen: Vec<Seen>,
}

/// How a view sees the point.
#[derive(Clone, Copy, Debug)]
struct Seen {
    view: Weight,
    /// Where its reads end.
    end: usize,
    /// How much of what it shows at the place is the point, 0 to 1.
    share: f32,
}

impl ReadList {
    /// The texels that are read, each in the images of one view.
    #[inline(always)]
    pub fn reads(&self) -> &[Read] {
        &self.reads
    }

    /// The weights of views that are read at the coordinate itself.
    #[inline(always)]
    pub fn plain(&self) -> &[Weight] {
        &self.plain
    }

    /// Finds what is read of views with these weights, some of which may be negative; the weights' sum is kept.
    #[inline(always)]
    pub fn find(&mut self, relief: &Relief, place: &Place, weights: &[Weight]) {
        self.reads.clear();
        self.seen.clear();
        self.plain.clear();
        let slope = slope_of(place.view);
        let height = relief.height_seen(place.coord, slope);
        for &weight in weights {
            self.look_from(relief, place, slope, height, weight);
        }
        self.share_out();
    }

    /// Adds the texels at which a view shows a point of this height, with shares that sum to 1.
    #[inline(always)]
    fn look_from(
        &mut self,
        relief: &Relief,
        place: &Place,
        slope: Vec2,
        height: f32,
        view: Weight,
    ) {
        // Read plainly what lies beyond reach.
        let seen = relief.view(view.index);
        let shift = height * (slope - seen.slope);
        let inside = (place.reach - shift.length()).clamp(0.0, 1.0);
        self.read_plainly(view, 1.0 - inside);
        if inside == 0.0 {
            return;
        }
        // Find where the view shows the point.
        let shifted = TexCoord {
            s: place.coord.s + shift.x,
            t: place.coord.t + shift.y,
        };
        // Weight the texels there by how well their heights agree.
        let (heights, start) = (&seen.levels[place.level], self.reads.len());
        let mut share = 0.0;
        for (texel, near) in around(relief.grid(), heights.grid, place.level, shifted) {
            let agreeing = near * agreement(heights.at(texel) - height, place.level);
            if agreeing > 0.0 {
                share += agreeing;
                self.reads.push(Read {
                    texel,
                    view: view.index,
                    share: agreeing,
                });
            }
        }
        // Normalize.
        let scale = 1.0 / share.max(f32::MIN_POSITIVE);
        let found = self.reads[start..].iter_mut();
        found.for_each(|read| read.share *= scale);
        self.seen.push(Seen {
            view: Weight {
                weight: inside * view.weight,
                ..view
            },
            end: self.reads.len(),
            share: share.min(1.0),
        });
    }

    /// Gives every view its part of the blend. What hidden views leave is made up for by those that see the point, by
    /// the size of their weights; where hardly any sees it, blending becomes plain.
    #[inline(always)]
    fn share_out(&mut self) {
        let (mut whole, mut size, mut found, mut found_size) = (0.0, 0.0, 0.0, 0.0);
        for Seen { view, share, .. } in &self.seen {
            whole += view.weight;
            size += view.weight.abs();
            found += share * view.weight;
            found_size += share * view.weight.abs();
        }
        let kept = (found_size / (LEAST_SEEN * size).max(f32::MIN_POSITIVE)).min(1.0);
        let made_up = (whole - found) / found_size.max(f32::MIN_POSITIVE);
        let mut start = 0;
        for at in 0..self.seen.len() {
            let Seen { view, end, share } = self.seen[at];
            let scale = kept * share * (view.weight + made_up * view.weight.abs());
            let reads = self.reads[start..end].iter_mut();
            reads.for_each(|read| read.share *= scale);
            start = end;
            self.read_plainly(view, 1.0 - kept);
        }
    }

    #[inline(always)]
    fn read_plainly(&mut self, view: Weight, share: f32) {
        if share > 0.0 {
            self.plain.push(Weight {
                weight: share * view.weight,
                ..view
            });
        }
    }
}

/// Whether a texel shows a point whose height it differs from by so much: 1 to 0.
#[inline(always)]
fn agreement(difference: f32, level: usize) -> f32 {
    let same = SAME_SURFACE * (1u32 << level.min(31)) as f32;
    (2.0 - difference.abs() / same).clamp(0.0, 1.0)
}

/// The texels of a level round a coordinate of the finest grid, with their bilinear shares; those off a sample that is
/// not tileable are left out.
#[inline(always)]
fn around(
    finest: TexelGrid,
    grid: TexelGrid,
    level: usize,
    at: TexCoord,
) -> impl Iterator<Item = (TexelIndex, f32)> {
    let (mut column, mut row) = (at.s, finest.height as f32 - at.t);
    if finest.tileable {
        column = column.rem_euclid(finest.width as f32);
        row = row.rem_euclid(finest.height as f32);
    }
    let shrink = 1.0 / (1u32 << level.min(31)) as f32;
    let (column, row) = (column * shrink - 0.5, row * shrink - 0.5);
    let (left, top) = (column.floor(), row.floor());
    let (right, down) = (column - left, row - top);
    let shares = [
        (0, 0, (1.0 - down) * (1.0 - right)),
        (0, 1, (1.0 - down) * right),
        (1, 0, down * (1.0 - right)),
        (1, 1, down * right),
    ];
    shares.into_iter().filter_map(move |(i, j, share)| {
        let texel = grid.texel_at(top as i64 + i, left as i64 + j)?;
        Some((texel, share))
    })
}
