//! The surface of a sample, and the height that each of its views sees at every texel.
//!
//! A view v sees through the texel at c of the plane z = 0 the first point of the surface on the line
//! c + z·(v_x, v_y)/v_z. Its height z determines where the point lies, and at which texel another view shows it.

use glam::{DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use crate::btf::HeightMap;
use crate::btf::bake::height_field::HeightField;
use crate::btf::direction::Direction;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;

/// Views are taken to stand no lower than this many texels aside per texel of height (84° from the normal): below, a
/// point moves over the whole sample.
const STEEPEST: f32 = 10.0;

/// A sample's surface and what its views see of it.
#[derive(Debug)]
pub struct Relief {
    surface: HeightField,
    grid: TexelGrid,
    /// In the order of the sample's distinct views.
    views: Vec<SeenHeights>,
}

/// What one view sees.
#[derive(Debug)]
pub(super) struct SeenHeights {
    /// How far a point moves in the image per texel of height, in (s, t).
    pub slope: Vec2,
    /// The height of what it sees at each texel, by pyramid level.
    pub levels: Vec<LevelHeights>,
}

/// The heights seen at the texels of one level: means of the finer ones.
#[derive(Debug)]
pub(super) struct LevelHeights {
    pub grid: TexelGrid,
    heights: Vec<f32>,
}

impl Relief {
    /// What the distinct `views` of a sample see of its heights, down to the coarsest of `levels`.
    pub fn new(heights: &HeightMap, views: &[Direction], levels: usize) -> Self {
        let grid = heights.grid();
        let surface = HeightField::above_plane(grid, heights.heights());
        let seen = |view: &Direction| SeenHeights::of(&surface, grid, *view, levels);
        Self {
            views: views.par_iter().map(seen).collect(),
            surface,
            grid,
        }
    }

    /// The sample's texels.
    pub fn grid(&self) -> TexelGrid {
        self.grid
    }

    /// Bytes that the heights seen take.
    pub fn bytes(&self) -> usize {
        let levels = self.views.iter().flat_map(|view| &view.levels);
        4 * levels.map(|level| level.heights.len()).sum::<usize>()
    }

    #[inline(always)]
    pub(super) fn view(&self, index: u32) -> &SeenHeights {
        &self.views[index as usize]
    }

    /// The height of what a view sees at a coordinate.
    #[inline]
    pub fn height_seen(&self, at: TexCoord, slope: Vec2) -> f32 {
        height_seen(&self.surface, at, slope)
    }
}

/// How far a point moves in the image of a view above the horizon per texel of height.
#[inline]
pub fn slope_of(view: Vec3) -> Vec2 {
    let along = Vec2::new(view.x, view.y);
    (along / view.z.max(1e-6)).clamp_length_max(STEEPEST)
}

#[inline]
fn height_seen(surface: &HeightField, at: TexCoord, slope: Vec2) -> f32 {
    // The surface's coordinates are whole at texel centres, with y = 0 in the lowest row.
    let on_plane = DVec2::new(f64::from(at.s) - 0.5, f64::from(at.t) - 0.5);
    let towards = DVec3::new(f64::from(slope.x), f64::from(slope.y), 1.0);
    let point = surface.seen_through(on_plane, towards);
    point.map_or(0.0, |point| surface.position(point).z) as f32
}

impl SeenHeights {
    fn of(surface: &HeightField, grid: TexelGrid, view: Direction, levels: usize) -> Self {
        let slope = slope_of(view.0.as_vec3());
        let centres = (0..grid.len() as u32).map(|texel| grid.centre(TexelIndex(texel)));
        let finest = LevelHeights {
            grid,
            heights: centres
                .map(|centre| height_seen(surface, centre, slope))
                .collect(),
        };
        let mut all = vec![finest];
        while all.len() < levels {
            let coarser = all[all.len() - 1].coarser();
            all.push(coarser);
        }
        Self { slope, levels: all }
    }
}

impl LevelHeights {
    #[inline(always)]
    pub(super) fn at(&self, texel: TexelIndex) -> f32 {
        self.heights[texel.index()]
    }

    /// The means of what exists of 2 × 2 texels.
    fn coarser(&self) -> Self {
        let grid = self.grid.coarser();
        let mean = |parent: u32| {
            let (row, col) = grid.row_col(TexelIndex(parent));
            let children =
                [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| (2 * row + i, 2 * col + j));
            let there = children
                .iter()
                .filter(|&&(row, col)| row < self.grid.height && col < self.grid.width);
            let (sum, count) = there.fold((0.0, 0.0), |(sum, count), &(row, col)| {
                (sum + self.at(self.grid.texel(row, col)), count + 1.0)
            });
            sum / count
        };
        Self {
            heights: (0..grid.len() as u32).map(mean).collect(),
            grid,
        }
    }
}
