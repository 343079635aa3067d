//! Texton mask filtering (Zhang 2003 §4.3): a texture T_o that relates to a mask M_o as a texture T_i does to its
//! mask M_i, as image analogies (Hertzmann 2001) find it.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`pyramid`] | colours and masks, level by level |
//! | [`windows`] | what is compared of a pixel: its mask window, its causal colour window, both of its parent |
//! | [`search`] | the most similar of all windows |
//! | [`rule`] | how one pixel is decided |
//! | [`options`] | what can be asked |
//!
//! Level after level, the coarsest first, pixels are visited along scan lines. Each takes the source pixel whose
//! windows are most similar: the mask in the full window, colours as far as they are synthesized. Rows are worked on
//! side by side, each far enough behind the one above to see the same as along scan lines.
//!
//! Of equally good source pixels a coherent one is taken, first of all the pixel's own place: with its own
//! mask a texture comes back as it is.
//! Deviation: Hertzmann 2001 searches approximately, and lifts the numbers of a source to the target's mean
//! and deviation. The search is exact here, and masks need no lift.

pub(crate) mod options;
pub(crate) mod pyramid;
mod rule;
mod search;
mod windows;

use ndarray::Array2;

use crate::error::{Error, Result};
use crate::grid::TexelGrid;
use crate::progress::Progress;
use crate::synthesis::drive::wave_by_wave;
use crate::vary::canvas::Extension;
pub use crate::vary::filtering::options::FilterOptions;
pub use crate::vary::filtering::pyramid::Texture;
use crate::vary::filtering::pyramid::{MOST_SOURCES, MaskCode, TextureLevel, coarser_values};
use crate::vary::filtering::rule::{Filtered, MostAlike, Source};
use crate::vary::filtering::windows::Layout;

/// Pixels of a source at most: all are compared at every pixel of the output.
pub const MOST_SOURCE: usize = 1 << 18;
/// Pixels of an output at most.
pub const MOST_OUTPUT: usize = 1 << 22;
/// Numbers of all windows of a source at most: 1 GiB.
const MOST_NUMBERS: usize = 1 << 28;
/// The shortest side of a level.
const SHORTEST_SIDE: usize = 8;

/// What is filtered.
#[derive(Clone, Copy, Debug)]
pub struct Filtering<'a> {
    /// The textures that pixels are taken from: one, or two that are mixed.
    pub sources: &'a [Texture<'a>],
    /// The mask of the output; `None` to synthesize without masks.
    pub mask: Option<&'a Array2<u8>>,
    /// The second source's share at each pixel of the output, with two sources.
    pub shares: Option<&'a Array2<f32>>,
    /// Rows and columns of the output.
    pub output: (usize, usize),
}

/// The source pixel of every pixel of the output, one list per source. Errors: sizes that do not fit, and
/// [`Error::Interrupted`].
pub fn filter(
    work: Filtering<'_>,
    options: &FilterOptions,
    progress: Progress<'_>,
) -> Result<Vec<Vec<u32>>> {
    options.validate()?;
    check(work)?;
    // Prepare the pyramids.
    let code = MaskCode::of(work.mask.iter().copied().chain(work.masks()));
    let count = level_count(work, options);
    let sources: Vec<Vec<TextureLevel>> = work
        .sources
        .iter()
        .map(|texture| TextureLevel::pyramid(texture, &code, count))
        .collect();
    let targets = TextureLevel::of_output(work.output, work.mask, &code, count);
    let mut shares: Vec<Option<Array2<f32>>> = vec![work.shares.cloned()];
    for level in 1..count {
        let finer = shares[level - 1].as_ref();
        shares.push(finer.map(coarser_values));
    }
    let mut coarser: Option<Filtered> = None;
    for level in (0..count).rev() {
        // Lay out the windows of the level.
        let target = &targets[level];
        let layout = Layout::new(
            options,
            &target.depths(&sources[0][level]),
            level + 1 < count,
        );
        check_windows(&sources, level, &layout)?;
        let of_level = |source: &Vec<TextureLevel>| {
            let parent = source.get(level + 1);
            Source::new(source[level].clone(), parent, &layout)
        };
        let read: Vec<Source> = sources.iter().map(of_level).collect();
        // Filter it, wave by wave.
        let rule = MostAlike {
            layout: &layout,
            sources: &read,
            target,
            extension: read
                .iter()
                .map(|source| Extension::of(source.level.grid))
                .collect(),
            shares: shares[level].as_ref(),
            coarser: coarser.as_ref().map(|state| (&targets[level + 1], state)),
            coherence: options.coherence_at(level),
        };
        let waves = waves(target.grid, layout.reach());
        progress.begin(
            format!("filtering, level {level}"),
            target.grid.len() as u64,
        );
        let mut state = Filtered::nothing(target.grid.len(), read.len(), read[0].level.depth);
        wave_by_wave(&rule, &mut state, &waves, progress)?;
        progress.end();
        coarser = Some(state);
    }
    let state = coarser.ok_or_else(|| Error::option("filter-levels", "0", "1 or more"))?;
    Ok(state.texels)
}

impl<'a> Filtering<'a> {
    fn masks(&self) -> impl Iterator<Item = &'a Array2<u8>> + '_ {
        let masks = self.sources.iter().map(|source| source.mask);
        masks.filter(|_| self.mask.is_some())
    }
}

/// Pixels that read nothing of each other, wave after wave: every row is `reach` + 1 pixels behind the one above.
fn waves(grid: TexelGrid, reach: usize) -> Vec<Vec<u32>> {
    let (width, height) = (grid.width as usize, grid.height as usize);
    let lag = reach + 1;
    let mut waves = vec![Vec::new(); width + lag * (height - 1)];
    for row in 0..height {
        for col in 0..width {
            waves[col + lag * row].push((row * width + col) as u32);
        }
    }
    waves.retain(|wave| !wave.is_empty());
    waves
}

/// As many levels as are asked for and the sizes allow.
fn level_count(work: Filtering<'_>, options: &FilterOptions) -> usize {
    let (rows, cols) = work.output;
    let mut shortest = rows.min(cols);
    let mut halvings = usize::MAX;
    for source in work.sources {
        let grid = source.grid;
        shortest = shortest.min(grid.width.min(grid.height) as usize);
        if grid.tileable {
            let zeros = grid
                .width
                .trailing_zeros()
                .min(grid.height.trailing_zeros());
            halvings = halvings.min(zeros as usize);
        }
    }
    let fit = (shortest / SHORTEST_SIDE).max(1).ilog2() as usize;
    (options.filter_levels as usize).min(1 + fit.min(halvings))
}

/// Refuses windows that would not fit into memory.
fn check_windows(sources: &[Vec<TextureLevel>], level: usize, layout: &Layout) -> Result<()> {
    let pixels = sources.iter().map(|source| source[level].grid.len());
    let numbers = pixels.sum::<usize>() * layout.stride();
    match numbers <= MOST_NUMBERS {
        true => Ok(()),
        false => Err(Error::option(
            "mask-window",
            format!("windows of {numbers} numbers in all"),
            format!("at most {MOST_NUMBERS}: narrower windows, or a smaller texture"),
        )),
    }
}

fn check(work: Filtering<'_>) -> Result<()> {
    let (rows, cols) = work.output;
    let size = |rows: usize, cols: usize| format!("{cols}×{rows}");
    // Check the output.
    if rows == 0 || cols == 0 || rows.saturating_mul(cols) > MOST_OUTPUT {
        return Err(
            Error::data("output", size(rows, cols)).expected(format!("1 to {MOST_OUTPUT} pixels"))
        );
    }
    // Check the sources.
    let mixes = work.shares.is_some();
    let wanted = if mixes { MOST_SOURCES } else { 1 };
    if work.sources.len() != wanted {
        return Err(
            Error::data("sources", work.sources.len().to_string()).expected(wanted.to_string())
        );
    }
    let depth = work.sources[0].numbers.dim().2;
    for source in work.sources {
        let (height, width) = (source.grid.height as usize, source.grid.width as usize);
        if source.grid.len() > MOST_SOURCE {
            return Err(Error::data("texture", size(height, width))
                .expected(format!("at most {MOST_SOURCE} pixels"))
                .advice("cut a part out: every pixel is compared with all others"));
        }
        if source.numbers.dim() != (height, width, depth) || source.mask.dim() != (height, width) {
            let (mask_rows, mask_cols) = source.mask.dim();
            return Err(Error::data("mask", size(mask_rows, mask_cols))
                .expected(format!("{}, the size of its texture", size(height, width))));
        }
    }
    // Check the target.
    let sides = work
        .mask
        .map(Array2::dim)
        .into_iter()
        .chain(work.shares.map(Array2::dim));
    for (other_rows, other_cols) in sides {
        if (other_rows, other_cols) != work.output {
            return Err(
                Error::data("output mask or transition", size(other_rows, other_cols))
                    .expected(size(rows, cols)),
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
