//! What is compared of a pixel, as one run of numbers: the mask in a full window, the colours of the pixels
//! before it along scan lines, and both round its parent on the coarser level.
//!
//! Samples come nearest first, so that a sum that grows too large is told early. They weigh less the farther
//! they are from the centre (a Gaussian of a third of the window's width); the label of the pixel itself weighs as
//! much as those of its mask window together. A sample off the texture is as far
//! from anything as can be; one off the output does not count.

use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::lanes::LANES;
use crate::neighborhood::square_window;
use crate::vary::filtering::options::FilterOptions;
use crate::vary::filtering::pyramid::Depths;

/// What a number off the texture is: 1 or more from any other.
const OFF: f32 = 2.0;
/// The deviation of the Gaussian over the window's width.
const DEVIATION: f32 = 1.0 / 3.0;

/// Which numbers a sample reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Mask,
    Color,
    ParentMask,
    ParentColor,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    kind: Kind,
    offset: [i32; 2],
    /// Its first number.
    begin: usize,
}

/// Where the numbers of a pixel's windows lie.
#[derive(Clone, Debug)]
pub struct Layout {
    samples: Vec<Sample>,
    depths: Depths,
    /// The weight of every number; 0 behind the last.
    pub weights: Vec<f32>,
    /// The causal window, nearest first: what lies before a pixel along scan lines.
    pub before: Vec<[i32; 2]>,
    reach: usize,
}

/// A level as windows read it.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// Its pixels.
    pub grid: TexelGrid,
    /// Colour numbers of all pixels.
    pub colors: &'a [f32],
    /// Mask numbers of all pixels.
    pub shares: &'a [f32],
}

impl Layout {
    /// The windows that options say, with or without a coarser level.
    pub fn new(options: &FilterOptions, depths: &Depths, has_parent: bool) -> Self {
        // Take the pixels that are filtered before.
        let before: Vec<[i32; 2]> = nearest_first(options.color_window)
            .into_iter()
            .filter(|&[drow, dcol]| drow < 0 || (drow == 0 && dcol < 0))
            .collect();
        let mut layout = Self {
            samples: Vec::new(),
            depths: *depths,
            weights: Vec::new(),
            before: before.clone(),
            reach: options.color_window as usize / 2,
        };
        // Lay out the masks.
        let mask_weight = options.mask_weight as f32 * depths.mask_weight;
        let mask = nearest_first(options.mask_window);
        layout.lay(Kind::Mask, &mask, options.mask_window, mask_weight);
        layout.stress_own_label();
        // Lay out the coarser level.
        if has_parent {
            let parent = nearest_first(options.parent_window);
            layout.lay(Kind::ParentColor, &parent, options.parent_window, 1.0);
            layout.lay(
                Kind::ParentMask,
                &parent,
                options.parent_window,
                mask_weight,
            );
        }
        // Lay out the colours.
        layout.lay(Kind::Color, &before, options.color_window, 1.0);
        let stride = layout.weights.len().next_multiple_of(LANES);
        layout.weights.resize(stride, 0.0);
        layout
    }

    fn lay(&mut self, kind: Kind, offsets: &[[i32; 2]], width: u32, weight: f32) {
        let deviation = DEVIATION * width as f32;
        for &offset in offsets {
            let [down, right] = offset.map(|step| step as f32);
            let square = down * down + right * right;
            let share = (-square / (2.0 * deviation * deviation)).exp();
            self.samples.push(Sample {
                kind,
                offset,
                begin: self.weights.len(),
            });
            let count = self.depth(kind);
            self.weights
                .extend(std::iter::repeat_n(weight * share, count));
        }
    }

    /// Lets a pixel's own label weigh as much as all others of the mask window, or one that no window of the texture
    /// resembles would not be followed.
    fn stress_own_label(&mut self) {
        let depth = self.depths.mask;
        let (own, others) = self.weights.split_at_mut(depth);
        if let Some(own_weight) = own.first_mut().filter(|_| !others.is_empty()) {
            *own_weight = others.iter().step_by(depth).sum();
            let weight = *own_weight;
            own.fill(weight);
        }
    }

    fn depth(&self, kind: Kind) -> usize {
        match kind {
            Kind::Mask | Kind::ParentMask => self.depths.mask,
            Kind::Color | Kind::ParentColor => self.depths.color,
        }
    }

    /// Numbers of a pixel's windows, filled up to whole lanes.
    pub fn stride(&self) -> usize {
        self.weights.len()
    }

    /// How far the colour window reaches.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// The windows of a texture's pixel.
    pub fn read_source(
        &self,
        plane: Plane<'_>,
        parent: Option<Plane<'_>>,
        pixel: TexelIndex,
        numbers: &mut [f32],
    ) {
        self.read(plane, parent, pixel, |at, found| match found {
            Some(found) => numbers[at..][..found.len()].copy_from_slice(found),
            None => numbers[at] = OFF,
        });
    }

    /// The windows of an output's pixel, and the weights of those numbers that count.
    pub fn read_output(
        &self,
        plane: Plane<'_>,
        parent: Option<Plane<'_>>,
        pixel: TexelIndex,
        (numbers, weights): (&mut Vec<f32>, &mut Vec<f32>),
    ) {
        numbers.clear();
        numbers.resize(self.stride(), 0.0);
        weights.clone_from(&self.weights);
        self.read(plane, parent, pixel, |at, found| match found {
            Some(found) => numbers[at..][..found.len()].copy_from_slice(found),
            None => weights[at] = 0.0,
        });
    }

    /// Hands over the numbers of every sample with the place of the first; off the grid each place by itself.
    fn read(
        &self,
        plane: Plane<'_>,
        parent: Option<Plane<'_>>,
        pixel: TexelIndex,
        mut take: impl FnMut(usize, Option<&[f32]>),
    ) {
        for sample in &self.samples {
            let depth = self.depth(sample.kind);
            let (plane, centre) = match (sample.kind, parent) {
                (Kind::ParentMask | Kind::ParentColor, Some(parent)) => {
                    (parent, plane.grid.parent(pixel))
                }
                _ => (plane, pixel),
            };
            let all = match sample.kind {
                Kind::Mask | Kind::ParentMask => plane.shares,
                Kind::Color | Kind::ParentColor => plane.colors,
            };
            match plane
                .grid
                .offset(centre, sample.offset[0], sample.offset[1])
            {
                Some(there) => take(sample.begin, Some(&all[there.index() * depth..][..depth])),
                None => (0..depth).for_each(|at| take(sample.begin + at, None)),
            }
        }
    }
}

fn nearest_first(width: u32) -> Vec<[i32; 2]> {
    let mut offsets = square_window(width);
    offsets.sort_by_key(|&[drow, dcol]| (drow * drow + dcol * dcol, drow, dcol));
    offsets
}
