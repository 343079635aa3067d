//! The filter bank at the points of a regular sub-grid.
//!
//! In: planes of one texel grid. Out: responses at a few texels, by the definition of convolution:
//! the window round each point times the taps. So the work does not grow with the plane.
//!
//! Filters are even or odd about their centre, f(−v) = ±f(v), and
//! Σ_v f(v) e(x − v) = Σ_{half the v} f(v) (e(x − v) ± e(x + v)): sums of opposite texels serve the
//! even filters, differences the odd ones.

use ndarray::{Array2, Array3, ArrayViewMut2, Axis};
use rayon::prelude::*;

use crate::grid::TexelGrid;
use crate::matrix::{Update, as_rows, as_rows_mut, multiply};
use crate::texton::border;
use crate::texton::filter_bank::{CENTRE, is_odd};

/// Taps along one axis.
const TAPS: usize = 2 * CENTRE + 1;
/// Numbers of half a window: the rows above the centre, and the centre's row at half weight.
const HALF: usize = (CENTRE + 1) * TAPS;

/// Filters of one parity.
struct HalfFilters {
    /// Their places in the bank.
    filters: Vec<usize>,
    /// Taps of half a window, [HALF, filters].
    taps: Array2<f32>,
}

impl HalfFilters {
    fn new(bank: &Array3<f64>, odd: bool) -> Self {
        let filters: Vec<usize> = (0..bank.dim().0)
            .filter(|&filter| is_odd(bank.index_axis(Axis(0), filter)) == odd)
            .collect();
        let taps = Array2::from_shape_fn((HALF, filters.len()), |(at, of)| {
            let (u, v) = (at / TAPS, at % TAPS);
            let share = if u == CENTRE { 0.5 } else { 1.0 };
            (share * bank[[filters[of], u, v]]) as f32
        });
        Self { filters, taps }
    }
}

/// Points of a regular sub-grid and the filters there.
pub struct PointFilters {
    grid: TexelGrid,
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// Rows and columns that stand within a filter's reach of the grid.
    continued: [Vec<usize>; 2],
    filters: usize,
    even: HalfFilters,
    odd: HalfFilters,
}

/// A plane continued on all sides, and the same rotated by 180°.
struct Continued {
    width: usize,
    plane: Vec<f32>,
    turned: Vec<f32>,
}

impl PointFilters {
    /// At most `points` rows and columns, evenly spread, and the filters of `bank`.
    pub fn new(grid: TexelGrid, bank: &Array3<f64>, points: usize) -> Self {
        let (height, width) = (grid.height as usize, grid.width as usize);
        let continued = [height, width].map(|side| {
            let positions = -(CENTRE as i64)..(side + CENTRE) as i64;
            border::sources(positions, side, grid.tileable)
        });
        Self {
            grid,
            rows: spread(height, points),
            columns: spread(width, points),
            continued,
            filters: bank.dim().0,
            even: HalfFilters::new(bank, false),
            odd: HalfFilters::new(bank, true),
        }
    }

    /// The texels of the sub-grid, row by row.
    pub fn points(&self) -> Vec<usize> {
        let width = self.grid.width as usize;
        let of_row = |&row: &usize| self.columns.iter().map(move |&column| row * width + column);
        self.rows.iter().flat_map(of_row).collect()
    }

    /// Numbers of one plane's responses.
    pub fn components(&self) -> usize {
        self.rows.len() * self.columns.len() * self.filters
    }

    /// Responses [planes, point · 48 + filter] of planes, one after another.
    pub fn responses(&self, planes: &[f32]) -> Array2<f32> {
        let texels = self.grid.len();
        let mut out = Array2::zeros((planes.len() / texels, self.components()));
        let windows = || [(); 2].map(|()| vec![0.0; self.components() / self.filters * HALF]);
        out.axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(planes.par_chunks(texels))
            .for_each_init(windows, |[sums, differences], (mut out, plane)| {
                let points = self.components() / self.filters;
                let Some(out) = out.as_slice_mut() else {
                    unreachable!("responses are stored in rows");
                };
                let mut out = as_rows_mut(out, points, self.filters);
                self.gather(&self.continue_plane(plane), sums, differences);
                filter_windows(&self.even, sums, &mut out);
                filter_windows(&self.odd, differences, &mut out);
            });
        out
    }

    fn continue_plane(&self, plane: &[f32]) -> Continued {
        let [rows, columns] = &self.continued;
        let width = self.grid.width as usize;
        let mut continued = Vec::with_capacity(rows.len() * columns.len());
        for row in rows {
            let line = &plane[row * width..(row + 1) * width];
            continued.extend(columns.iter().map(|&column| line[column]));
        }
        let turned = continued.iter().rev().copied().collect();
        Continued {
            width: columns.len(),
            plane: continued,
            turned,
        }
    }

    /// Sums and differences of opposite texels of half the window of every point.
    fn gather(&self, continued: &Continued, sums: &mut [f32], differences: &mut [f32]) {
        let (height, width) = (self.grid.height as usize, self.grid.width as usize);
        let mut lines = sums.chunks_mut(TAPS).zip(differences.chunks_mut(TAPS));
        for row in &self.rows {
            for column in &self.columns {
                for u in 0..=CENTRE {
                    // e(x + v), and e(x − v) from the turned plane: both run forwards in v.
                    let after = (row + u) * continued.width + column;
                    let before = (height - 1 - row + u) * continued.width + width - 1 - column;
                    let after = &continued.plane[after..after + TAPS];
                    let before = &continued.turned[before..before + TAPS];
                    let Some((sums, differences)) = lines.next() else {
                        return;
                    };
                    for (((sum, difference), a), b) in
                        sums.iter_mut().zip(differences).zip(before).zip(after)
                    {
                        *sum = a + b;
                        *difference = a - b;
                    }
                }
            }
        }
    }
}

/// The responses of filters of one parity, into [points, all filters].
fn filter_windows(half: &HalfFilters, windows: &[f32], out: &mut ArrayViewMut2<'_, f32>) {
    let points = out.nrows();
    let mut responses = Array2::zeros((half.filters.len(), points));
    multiply(
        half.taps.t(),
        as_rows(windows, points, HALF).reversed_axes(),
        responses.view_mut(),
        Update::Replace,
    );
    for (&filter, responses) in half.filters.iter().zip(responses.outer_iter()) {
        out.column_mut(filter).assign(&responses);
    }
}

/// The middles of `points` equal parts of a side.
fn spread(side: usize, points: usize) -> Vec<usize> {
    let points = points.min(side);
    (0..points)
        .map(|i| (2 * i + 1) * side / (2 * points))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texton::filter_bank::{FILTERS, leung_malik};
    use crate::texton::oracle;

    #[test]
    fn responses_are_those_of_the_whole_plane() {
        let bank = leung_malik();
        for tileable in [true, false] {
            let grid = TexelGrid {
                width: 11,
                height: 8,
                tileable,
            };
            let plane: Vec<f32> = (0..88).map(|i| ((i * 37) % 41) as f32).collect();
            let filters = PointFilters::new(grid, &bank, 3);
            assert_eq!(
                (filters.rows.as_slice(), filters.columns.as_slice()),
                (&[1, 4, 6][..], &[1, 5, 9][..])
            );
            let fast = filters.responses(&plane);
            let slow = oracle::responses(grid, &bank, &plane);
            for (point, texel) in filters.points().into_iter().enumerate() {
                for filter in 0..FILTERS {
                    let (a, b) = (fast[[0, point * FILTERS + filter]], slow[[filter, texel]]);
                    assert!((f64::from(a) - b).abs() < 1e-4, "{a} against {b}");
                }
            }
        }
    }
}
