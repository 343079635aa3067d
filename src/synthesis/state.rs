//! What the sites of a level hold while it is synthesized.

use rand::Rng;
use rayon::prelude::*;

use crate::exemplar::level::{ExemplarLevel, feature_rows};
use crate::exemplar::space::SpaceLevel;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::random;
use crate::sites::level::Parent;
use crate::synthesis::recipes::reuse_penalty::Uses;

/// A texture coordinate per site, and what a rule remembers beside it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texels {
    /// Texture coordinates, in texels of the level.
    pub coords: Vec<TexCoord>,
    /// The feature row of the texel that holds each.
    pub rows: Vec<u32>,
    /// Which sites are synthesized, while a level grows; `None` when all hold something.
    pub done: Option<Vec<bool>>,
    /// How often each texel is held, where a rule asks for it.
    pub uses: Option<Uses>,
}

impl Texels {
    /// Every site holds the centre of a texel.
    pub fn of_texels(exemplar: &ExemplarLevel<'_>, texels: impl Iterator<Item = u32>) -> Self {
        let mut state = Self::default();
        for texel in texels {
            state.coords.push(exemplar.grid.centre(TexelIndex(texel)));
            state.rows.push(exemplar.rows[texel as usize]);
        }
        state
    }

    /// Every site holds a coordinate, wrapped or clamped to the grid.
    pub fn of_coords(exemplar: &ExemplarLevel<'_>, coords: Vec<TexCoord>) -> Self {
        let row = |&at: &TexCoord| exemplar.rows[exemplar.grid.texel_nearest(at).index()];
        Self {
            rows: coords.iter().map(row).collect(),
            coords,
            ..Self::default()
        }
    }

    /// Coordinates on a level of a space.
    pub fn on(level: &SpaceLevel, coords: Vec<TexCoord>) -> Self {
        let rows = feature_rows(level);
        let row = |&at: &TexCoord| rows[level.grid.texel_nearest(at).index()];
        Self {
            rows: coords.iter().map(row).collect(),
            coords,
            ..Self::default()
        }
    }

    /// A random whole texel at every site.
    pub fn random(exemplar: &ExemplarLevel<'_>, sites: usize, (seed, level): (u64, u32)) -> Self {
        let mut stream = random::stream(seed, "random start", level, 0);
        let whole = &exemplar.whole_texels;
        let texels = (0..sites).map(|_| whole[stream.gen_range(0..whole.len())]);
        Self::of_texels(exemplar, texels)
    }

    /// Every site takes its coordinate from its parent (Tong 2002 §5.1).
    pub fn of_parents(exemplar: &ExemplarLevel<'_>, parents: &[Parent], coarser: &Self) -> Self {
        let guess = |parent: &Parent| first_guess(exemplar.grid, &coarser.coords, parent);
        let coords = parents.par_iter().map(guess).collect();
        Self::of_coords(exemplar, coords)
    }

    /// No site is synthesized yet.
    #[must_use]
    pub fn none_done(self) -> Self {
        Self {
            done: Some(vec![false; self.coords.len()]),
            ..self
        }
    }

    /// The coordinates, each moved to the centre of its texel.
    pub fn at_centres(&self, grid: TexelGrid) -> Vec<TexCoord> {
        let centre = |&at: &TexCoord| grid.centre(grid.texel_nearest(at));
        self.coords.iter().map(centre).collect()
    }

    /// Lets a site hold a coordinate.
    pub fn set(&mut self, exemplar: &ExemplarLevel<'_>, site: usize, at: TexCoord) {
        let texel = exemplar.grid.texel_nearest(at);
        if let Some(uses) = &mut self.uses {
            uses.leave(exemplar.grid.texel_nearest(self.coords[site]));
            uses.take(texel);
        }
        if let Some(done) = &mut self.done {
            done[site] = true;
        }
        self.coords[site] = at;
        self.rows[site] = exemplar.rows[texel.index()];
    }
}

/// The texture coordinate that a site takes from its parent: with u the coarse site at offset (x, y) from the
/// parent point, s = 2(s_u − x) and H − t = 2(H′ − (t_u − y)), wrapped or clamped to the finer grid.
pub fn first_guess(fine: TexelGrid, coarser: &[TexCoord], parent: &Parent) -> TexCoord {
    let at = coarser[parent.site as usize];
    let coarse_height = fine.coarser().height as f32;
    let s = 2.0 * (at.s - parent.x);
    let down = 2.0 * (coarse_height - (at.t - parent.y));
    fine.coordinate(s, down)
}
