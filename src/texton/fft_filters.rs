//! The filter bank on whole planes, through the Fourier transform.
//!
//! In: planes of one texel grid. Out: a filter's responses at every texel, exact to `f32`.
//!
//! Two planes are filtered at once, as real and imaginary part of one complex image: filters are
//! real. A filter of this bank is even or odd about its centre, so that its spectrum is real or
//! imaginary, one number per wave. A tileable image is its own period; of any other a whole
//! reflection is, or it is continued by reflection for as far as a filter reaches, whichever is
//! less: both are exact.

use std::sync::Arc;

use ndarray::{Array2, Array3, ArrayView2, ArrayViewMut2, Axis as Side};
use rayon::prelude::*;
use rustfft::num_complex::{Complex, Complex32};
use rustfft::{Fft, FftDirection, FftNum, FftPlanner, FftPlannerScalar};

use crate::grid::TexelGrid;
use crate::texton::border;
use crate::texton::filter_bank::{CENTRE, is_odd};
use crate::texton::transpose::transpose;

/// Waves along x that are taken back together: at 64 texels, 4 KB.
const BAND: usize = 8;

/// Odd factors of a period that transforms of it are quick with.
const QUICK_FACTORS: [usize; 5] = [1, 3, 5, 7, 9];

/// One axis of the grid and its period.
struct Axis {
    side: usize,
    period: usize,
    /// Where the first continued texel stands, at most 0.
    start: i64,
    /// The texel at each position from `start` on.
    sources: Vec<usize>,
}

impl Axis {
    fn new(side: usize, wraps: bool) -> Self {
        let padded = quick_period(side + 2 * CENTRE);
        let reach = CENTRE as i64;
        let (period, positions) = if wraps {
            (side, 0..side as i64)
        } else if 2 * side <= padded {
            (2 * side, 0..2 * side as i64)
        } else {
            (padded, -reach..side as i64 + reach)
        };
        Self {
            side,
            period,
            start: positions.start,
            sources: border::sources(positions, side, wraps),
        }
    }

    /// Positions in the period, each with the texel that stands there.
    fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        let place = |at: usize| (at as i64 + self.start).rem_euclid(self.period as i64) as usize;
        let numbered = self.sources.iter().enumerate();
        numbered.map(move |(at, &source)| (place(at), source))
    }
}

/// The least period from `least` on that is an odd factor times a power of two.
fn quick_period(least: usize) -> usize {
    let periods = QUICK_FACTORS.map(|factor| factor * least.div_ceil(factor).next_power_of_two());
    periods.into_iter().min().unwrap_or(least)
}

/// The filters on the planes of one texel grid.
pub struct FftFilters {
    y: Axis,
    x: Axis,
    transforms: Transforms<f32>,
    /// For each filter its spectrum [waves along x, waves along y], over the number of waves.
    spectra: Vec<Spectrum>,
}

/// A filter's spectrum: real numbers, to be multiplied by the imaginary unit if it is odd.
struct Spectrum {
    factors: Vec<f32>,
    odd: bool,
}

/// The spectrum of two planes, [waves along x, waves along y].
pub struct PairSpectrum(Vec<Complex32>);

/// What filtering needs room for; one per thread.
pub struct Workspace {
    band: Vec<Complex32>,
    texels: Vec<Complex32>,
    scratch: Vec<Complex32>,
}

impl FftFilters {
    /// The filters of `bank` [filters, taps, taps], each even or odd about its centre.
    pub fn new(grid: TexelGrid, bank: &Array3<f64>) -> Self {
        let y = Axis::new(grid.height as usize, grid.tileable);
        let x = Axis::new(grid.width as usize, grid.tileable);
        // A few transforms in double precision: vector code for them would take a while to compile.
        let mut planner = FftPlannerScalar::new();
        let plan = |side, direction| planner.plan_fft(side, direction);
        let exact = Transforms::<f64>::new(y.period, x.period, plan);
        let mut planner = FftPlanner::new();
        let plan = |side, direction| planner.plan_fft(side, direction);
        let spectra = bank
            .outer_iter()
            .into_par_iter()
            .map(|taps| Spectrum::new(taps, &exact))
            .collect();
        Self {
            transforms: Transforms::new(y.period, x.period, plan),
            y,
            x,
            spectra,
        }
    }

    /// Bytes the spectra of `filters` filters take on a grid.
    pub fn bytes(grid: TexelGrid, filters: usize) -> u64 {
        let period = |side: u32| Axis::new(side as usize, grid.tileable).period as u64;
        4 * filters as u64 * period(grid.height) * period(grid.width)
    }

    /// How many filters there are.
    pub fn count(&self) -> usize {
        self.spectra.len()
    }

    /// Texels of a plane.
    pub fn texels(&self) -> usize {
        self.y.side * self.x.side
    }

    /// Where responses hold a texel.
    pub fn place(&self, texel: usize) -> usize {
        texel / self.x.side * self.x.period + texel % self.x.side
    }

    /// Room for one thread.
    pub fn workspace(&self) -> Workspace {
        let (rows, columns) = (self.y.period, self.x.period);
        Workspace {
            band: vec![Complex32::default(); BAND.min(columns) * rows],
            texels: vec![Complex32::default(); self.y.side * columns],
            scratch: self.transforms.scratch(),
        }
    }

    /// The spectrum of one or two planes, one after another.
    pub fn spectrum(&self, planes: &[f32], work: &mut Workspace) -> PairSpectrum {
        let (rows, columns) = (self.y.period, self.x.period);
        let (first, second) = planes.split_at(self.texels());
        let mut image = vec![Complex32::default(); rows * columns];
        for (row, from) in self.y.places() {
            let line = &mut image[row * columns..(row + 1) * columns];
            for (column, source) in self.x.places() {
                let texel = from * self.x.side + source;
                let other = second.get(texel).copied().unwrap_or(0.0);
                line[column] = Complex32::new(first[texel], other);
            }
        }
        self.transforms.forward(&mut image, &mut work.scratch);
        PairSpectrum(image)
    }

    /// A filter's responses to the two planes, real and imaginary, at [`place`](Self::place).
    pub fn respond<'w>(
        &self,
        PairSpectrum(planes): &PairSpectrum,
        filter: usize,
        work: &'w mut Workspace,
    ) -> &'w [Complex32] {
        let (spectrum, rows) = (&self.spectra[filter], self.y.period);
        let fill =
            |first: usize, band: &mut [Complex32]| spectrum.weight(planes, first * rows, band);
        self.transforms
            .inverse_rows(fill, &mut work.band, &mut work.texels, &mut work.scratch);
        &work.texels
    }

    /// All responses to planes, one after another, [plane · filters + filter, texels].
    pub fn responses(&self, planes: &[f32]) -> Array2<f32> {
        let (count, texels) = (self.count(), self.texels());
        let pairs = planes.len().div_ceil(2 * texels);
        let mut out = Array2::zeros((pairs * 2 * count, texels));
        out.axis_chunks_iter_mut(Side(0), 2 * count)
            .into_par_iter()
            .zip(planes.par_chunks(2 * texels))
            .for_each(|(pair, planes)| self.respond_pair(planes, pair));
        out.slice_axis_inplace(Side(0), (..planes.len() / texels * count).into());
        out
    }

    fn respond_pair(&self, planes: &[f32], pair: ArrayViewMut2<'_, f32>) {
        let spectrum = self.spectrum(planes, &mut self.workspace());
        let (mut real, mut imaginary) = pair.split_at(Side(0), self.count());
        real.axis_iter_mut(Side(0))
            .into_par_iter()
            .zip(imaginary.axis_iter_mut(Side(0)))
            .enumerate()
            .for_each_init(
                || self.workspace(),
                |work, (filter, (mut real, mut imaginary))| {
                    let response = self.respond(&spectrum, filter, work);
                    for texel in 0..self.texels() {
                        let value = response[self.place(texel)];
                        (real[texel], imaginary[texel]) = (value.re, value.im);
                    }
                },
            );
    }
}

impl Spectrum {
    fn new(taps: ArrayView2<'_, f64>, transforms: &Transforms<f64>) -> Self {
        let (rows, columns) = (transforms.rows, transforms.columns);
        let place = |tap: usize, period: usize| {
            (tap as i64 - CENTRE as i64).rem_euclid(period as i64) as usize
        };
        let mut image = vec![Complex::<f64>::default(); rows * columns];
        for ((u, v), tap) in taps.indexed_iter() {
            image[place(u, rows) * columns + place(v, columns)].re += tap;
        }
        transforms.forward(&mut image, &mut transforms.scratch());
        let odd = is_odd(taps);
        let share = ((rows * columns) as f64).recip();
        let factor = |wave: &Complex<f64>| (share * if odd { wave.im } else { wave.re }) as f32;
        Self {
            factors: image.iter().map(factor).collect(),
            odd,
        }
    }

    /// Some waves of the planes' responses, from number `first` on.
    fn weight(&self, planes: &[Complex32], first: usize, out: &mut [Complex32]) {
        let range = first..first + out.len();
        let waves = planes[range.clone()].iter().zip(&self.factors[range]);
        let pairs = out.iter_mut().zip(waves);
        if self.odd {
            pairs.for_each(|(out, (wave, d))| *out = Complex32::new(-wave.im * d, wave.re * d));
        } else {
            pairs.for_each(|(out, (wave, d))| *out = wave * d);
        }
    }
}

/// Transforms of images [rows, columns]; spectra are [waves along x, waves along y].
struct Transforms<T: FftNum> {
    rows: usize,
    columns: usize,
    /// Along x, then along y.
    forward: [Arc<dyn Fft<T>>; 2],
    inverse: [Arc<dyn Fft<T>>; 2],
}

impl<T: FftNum> Transforms<T> {
    fn new(
        rows: usize,
        columns: usize,
        mut plan: impl FnMut(usize, FftDirection) -> Arc<dyn Fft<T>>,
    ) -> Self {
        Self {
            rows,
            columns,
            forward: [columns, rows].map(|side| plan(side, FftDirection::Forward)),
            inverse: [columns, rows].map(|side| plan(side, FftDirection::Inverse)),
        }
    }

    fn scratch(&self) -> Vec<Complex<T>> {
        let lengths = self.forward.iter().chain(&self.inverse);
        let length = lengths.map(|fft| fft.get_inplace_scratch_len()).max();
        vec![zero(); length.unwrap_or(0)]
    }

    /// An image [rows, columns] becomes its spectrum.
    fn forward(&self, image: &mut Vec<Complex<T>>, scratch: &mut [Complex<T>]) {
        let [along_x, along_y] = &self.forward;
        along_x.process_with_scratch(image, scratch);
        let mut turned = vec![zero(); image.len()];
        transpose(image, self.columns, &mut turned, self.rows, |wave| wave);
        along_y.process_with_scratch(&mut turned, scratch);
        *image = turned;
    }

    /// The first rows of the image of a spectrum, as many as `texels` holds. `fill` gives some
    /// waves along x of the spectrum, from a number on: what the nearest cache holds, so that a
    /// wave is read and written once.
    fn inverse_rows(
        &self,
        fill: impl Fn(usize, &mut [Complex<T>]),
        band: &mut [Complex<T>],
        texels: &mut [Complex<T>],
        scratch: &mut [Complex<T>],
    ) {
        let [along_y, along_x] = [&self.inverse[1], &self.inverse[0]];
        let waves = band.len() / self.rows;
        for first in (0..self.columns).step_by(waves) {
            let count = waves.min(self.columns - first);
            let band = &mut band[..count * self.rows];
            fill(first, band);
            along_y.process_with_scratch(band, scratch);
            transpose(
                band,
                self.rows,
                &mut texels[first..],
                self.columns,
                |wave| wave,
            );
        }
        along_x.process_with_scratch(texels, scratch);
    }
}

fn zero<T: FftNum>() -> Complex<T> {
    Complex::new(T::zero(), T::zero())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texton::filter_bank::leung_malik;
    use crate::texton::oracle;

    #[test]
    fn responses_are_convolutions_at_both_borders_and_any_side() {
        let bank = leung_malik();
        for (height, width) in [(8, 12), (7, 5), (1, 9), (26, 30)] {
            for tileable in [true, false] {
                let grid = TexelGrid {
                    width,
                    height,
                    tileable,
                };
                let texels = grid.len();
                let planes: Vec<f32> = (0..2 * texels)
                    .map(|i| ((i * 7919) % 101) as f32 / 101.0)
                    .collect();
                let filters = FftFilters::new(grid, &bank);
                let mut work = filters.workspace();
                let spectrum = filters.spectrum(&planes, &mut work);
                let alone = filters.spectrum(&planes[..texels], &mut work);
                let exact = [&planes[..texels], &planes[texels..]]
                    .map(|plane| oracle::responses(grid, &bank, plane));
                for filter in 0..filters.count() {
                    let both = filters.respond(&spectrum, filter, &mut work).to_vec();
                    let one = filters.respond(&alone, filter, &mut work);
                    for texel in 0..texels {
                        let at = filters.place(texel);
                        let found = [both[at].re, both[at].im, one[at].re, one[at].im];
                        let exact = exact.each_ref().map(|r| r[[filter, texel]]);
                        let wanted = [exact[0], exact[1], exact[0], 0.0];
                        for (a, b) in found.into_iter().zip(wanted) {
                            assert!((f64::from(a) - b).abs() < 2e-6, "{grid:?}: {a}, not {b}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn periods_are_quick_and_long_enough() {
        assert_eq!(
            [56, 65, 112, 123, 448].map(quick_period),
            [56, 72, 112, 128, 448]
        );
    }
}
