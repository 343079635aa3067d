//! How one pixel is decided: for each source the pixel whose windows are most similar, coherent ones preferred.
//!
//! Coherent pixels are the pixel's own place, the child of what its parent holds, and those that continue from what
//! the pixels before it hold.

use ndarray::Array2;

use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::synthesis::rule::Rule;
use crate::vary::canvas::Extension;
use crate::vary::filtering::pyramid::{MOST_SOURCES, TextureLevel};
use crate::vary::filtering::search::{Pattern, nearest};
use crate::vary::filtering::windows::{Layout, Plane};

/// A level of a source, with the windows of all its pixels.
pub struct Source {
    /// The level.
    pub level: TextureLevel,
    windows: Vec<f32>,
}

impl Source {
    /// Reads the windows of all pixels.
    pub fn new(level: TextureLevel, parent: Option<&TextureLevel>, layout: &Layout) -> Self {
        let mut windows = vec![0.0; level.grid.len() * layout.stride()];
        let parent = parent.map(plane_of);
        for (pixel, numbers) in (0..).zip(windows.chunks_exact_mut(layout.stride())) {
            layout.read_source(plane_of(&level), parent, TexelIndex(pixel), numbers);
        }
        Self { level, windows }
    }

    fn color(&self, pixel: u32) -> &[f32] {
        &self.level.colors[pixel as usize * self.level.depth..][..self.level.depth]
    }
}

fn plane_of(level: &TextureLevel) -> Plane<'_> {
    Plane {
        grid: level.grid,
        colors: &level.colors,
        shares: &level.shares,
    }
}

/// What the pixels of a level of the output hold.
#[derive(Clone, Debug)]
pub struct Filtered {
    /// Source pixels, one list per source.
    pub texels: Vec<Vec<u32>>,
    colors: Vec<f32>,
    done: Vec<bool>,
}

impl Filtered {
    /// Nothing yet, in so many pixels, of this many sources, with this many colour numbers.
    pub fn nothing(pixels: usize, sources: usize, depth: usize) -> Self {
        Self {
            texels: vec![vec![0; pixels]; sources],
            colors: vec![0.0; pixels * depth],
            done: vec![false; pixels],
        }
    }
}

/// The rule.
pub struct MostAlike<'a> {
    /// What is compared.
    pub layout: &'a Layout,
    /// Where pixels are taken from.
    pub sources: &'a [Source],
    /// The output.
    pub target: &'a TextureLevel,
    /// How each source continues beyond its borders.
    pub extension: Vec<Extension>,
    /// The second source's share at each pixel.
    pub shares: Option<&'a Array2<f32>>,
    /// The coarser level, and what its pixels hold.
    pub coarser: Option<(&'a TextureLevel, &'a Filtered)>,
    /// What a coherent pixel's distance may be over the smallest.
    pub coherence: f32,
}

/// Working memory of one thread.
#[derive(Default)]
pub struct Scratch {
    pattern: Pattern,
    coherent: Vec<u32>,
}

impl Rule for MostAlike<'_> {
    type State = Filtered;
    type Take = [u32; MOST_SOURCES];
    type Scratch = Scratch;

    fn held(&self, state: &Filtered, site: usize) -> Self::Take {
        let mut held = [0; MOST_SOURCES];
        held.iter_mut()
            .zip(&state.texels)
            .for_each(|(held, texels)| *held = texels[site]);
        held
    }

    fn choose(&self, state: &Filtered, site: usize, scratch: &mut Scratch) -> Self::Take {
        let Scratch { pattern, coherent } = scratch;
        let plane = Plane {
            grid: self.target.grid,
            colors: &state.colors,
            shares: &self.target.shares,
        };
        let parent = self.coarser.map(|(level, state)| Plane {
            grid: level.grid,
            colors: &state.colors,
            shares: &level.shares,
        });
        let out = (&mut pattern.numbers, &mut pattern.weights);
        self.layout
            .read_output(plane, parent, TexelIndex(site as u32), out);
        let mut take = [0; MOST_SOURCES];
        for (number, source) in self.sources.iter().enumerate() {
            self.coherent(state, site, number, coherent);
            let best = nearest(&source.windows, pattern, coherent, self.coherence);
            take[number] = best.unwrap_or(0);
        }
        take
    }

    fn set(&self, state: &mut Filtered, site: usize, take: Self::Take) {
        let depth = self.sources[0].level.depth;
        let share = self.share(site);
        let color = &mut state.colors[site * depth..][..depth];
        color.copy_from_slice(self.sources[0].color(take[0]));
        if let Some(second) = self.sources.get(1) {
            let others = second.color(take[1]);
            color
                .iter_mut()
                .zip(others)
                .for_each(|(own, other)| *own += share * (other - *own));
        }
        for (texels, texel) in state.texels.iter_mut().zip(take) {
            texels[site] = texel;
        }
        state.done[site] = true;
    }

    fn batch(&self) -> usize {
        1
    }
}

impl MostAlike<'_> {
    fn share(&self, site: usize) -> f32 {
        let width = self.target.grid.width as usize;
        self.shares
            .map_or(0.0, |shares| shares[[site / width, site % width]])
    }

    /// The coherent pixels of a source, the pixel's own place first.
    fn coherent(&self, state: &Filtered, site: usize, number: usize, found: &mut Vec<u32>) {
        // Propose the pixel's own place.
        let grid = self.sources[number].level.grid;
        let pixel = TexelIndex(site as u32);
        let (row, col) = self.target.grid.row_col(pixel);
        let (own_row, own_col) = self.extension[number].pixel((row as usize, col as usize), grid);
        found.clear();
        found.push(grid.texel(own_row as u32, own_col as u32).0);
        // Propose what the parent holds.
        if let Some((level, coarser)) = self.coarser {
            let parent = coarser.texels[number][self.target.grid.parent(pixel).index()];
            let coarse = grid.coarser();
            debug_assert!(
                level.grid == self.target.grid.coarser() && (parent as usize) < coarse.len()
            );
            found.push(child(
                grid,
                coarse.row_col(TexelIndex(parent)),
                (row % 2, col % 2),
            ));
        }
        // Propose what continues the neighbours.
        for &[drow, dcol] in &self.layout.before {
            let Some(near) = self.target.grid.offset(pixel, drow, dcol) else {
                continue;
            };
            if !state.done[near.index()] {
                continue;
            }
            let texel = TexelIndex(state.texels[number][near.index()]);
            if let Some(next) = grid.offset(texel, -drow, -dcol)
                && !found.contains(&next.0)
            {
                found.push(next.0);
            }
        }
    }
}

/// The child of a coarse pixel that lies in it as (row, column) say, or the last there is.
fn child(grid: TexelGrid, (row, col): (u32, u32), (down, right): (u32, u32)) -> u32 {
    let row = (2 * row + down).min(grid.height - 1);
    grid.texel(row, (2 * col + right).min(grid.width - 1)).0
}
