//! Choosing neighbours greedily by (distance, flat index), each at least a given separation from all taken.
//!
//! In: distances of a texel to all texels. Out: its neighbours, nearest first, itself in column 0.

use std::ops::Range;

use macro_rules_attribute::apply;

use crate::exemplar::neighbor_list::{Near, Row};
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::lanes::{LANES, least_of_lanes, smaller, vectorized};

/// The texels a level's neighbours are chosen from.
#[derive(Clone, Debug)]
pub struct Choice {
    grid: TexelGrid,
    /// The least separation, less one.
    reach: i64,
    /// Neighbours a texel, itself included.
    pub k: usize,
    /// 0, or infinity for texels that may not be listed; empty where all may.
    barred: Vec<f32>,
    band: Option<Band>,
}

/// Texels of a transition near enough to each other to be listed together (Zhang 2003 eq. 1).
#[derive(Clone, Debug)]
pub struct Band {
    /// The transition of each texel.
    pub transition: Vec<f32>,
    /// They differ by less than this.
    pub tolerance: f32,
}

impl Band {
    /// Whether one texel may be listed for another.
    pub fn has(&self, texel: TexelIndex, other: TexelIndex) -> bool {
        let [own, other] = [texel, other].map(|texel| self.transition[texel.index()]);
        (own - other).abs() < self.tolerance
    }
}

impl Choice {
    /// Chooses `k` neighbours per texel, itself included, among `whole` texels; with a band, of those in each
    /// other's.
    pub fn new(
        grid: TexelGrid,
        whole: &[bool],
        separation: u32,
        k: usize,
        band: Option<Band>,
    ) -> Self {
        let bar = |&whole: &bool| if whole { 0.0 } else { f32::INFINITY };
        let barred = match whole.iter().all(|&whole| whole) {
            true => Vec::new(),
            false => whole.iter().map(bar).collect(),
        };
        Self {
            grid,
            reach: i64::from(separation.max(1)) - 1,
            k,
            barred,
            band,
        }
    }

    /// Chooses the neighbours of a texel, whose distances to all are `distances` (destroyed). Fails
    /// with the number found when there are too few.
    pub fn choose(&self, texel: TexelIndex, distances: &mut [f32]) -> Row {
        choose(self, texel, distances)
    }

    /// Whether one texel may be listed for another, as far as their transitions say.
    pub fn in_band(&self, texel: TexelIndex, other: TexelIndex) -> bool {
        self.band.as_ref().is_none_or(|band| band.has(texel, other))
    }

    /// A row that may be short: where a band is asked for, its last neighbour is repeated.
    pub fn completed(&self, mut row: Vec<Near>) -> Row {
        match row.last() {
            Some(&last) if self.band.is_some() => row.resize(self.k, last),
            _ => {}
        }
        match row.len() == self.k {
            true => Ok(row),
            false => Err(row.len()),
        }
    }

    /// Rows within the separation of one.
    fn rows_around(&self, row: u32) -> impl Iterator<Item = usize> + use<> {
        let (height, tileable) = (i64::from(self.grid.height), self.grid.tileable);
        // On a torus, rows that go round more than once are the same again.
        let reach = self.reach.min(height);
        let rows = i64::from(row) - reach..=i64::from(row) + reach;
        rows.filter_map(move |row| match tileable {
            true => Some(row.rem_euclid(height) as usize),
            false => (0..height).contains(&row).then_some(row as usize),
        })
    }

    /// Columns within the separation of one, in two parts where they go across the border.
    fn cols_around(&self, col: u32) -> [Range<usize>; 2] {
        let (width, col) = (i64::from(self.grid.width), i64::from(col));
        let (from, to) = (col - self.reach, col + self.reach + 1);
        let inside = from.max(0) as usize..to.min(width) as usize;
        let across = match self.grid.tileable {
            true if to - from >= width => return [0..width as usize, 0..0],
            true if from < 0 => (width + from) as usize..width as usize,
            true if to > width => 0..(to - width) as usize,
            _ => 0..0,
        };
        [inside, across]
    }
}

#[apply(vectorized!)]
fn choose(choice: &Choice, texel: TexelIndex, distances: &mut [f32]) -> Row {
    let mut chosen = Vec::with_capacity(choice.k);
    chosen.push((distances[texel.index()], texel.0));
    if let Some(band) = &choice.band {
        let all = distances.iter_mut().zip(0..);
        all.filter(|(_, other)| !band.has(texel, TexelIndex(*other)))
            .for_each(|(distance, _)| *distance = f32::INFINITY);
    }
    let mut field = Field::new(choice, distances);
    field.bar_around(texel);
    while chosen.len() < choice.k {
        let Some((distance, nearest)) = field.nearest() else {
            break;
        };
        chosen.push((distance, nearest.0));
        field.bar_around(nearest);
    }
    choice.completed(chosen)
}

/// The distances from one texel, with those out of the question at infinity.
struct Field<'a> {
    choice: &'a Choice,
    distances: &'a mut [f32],
    /// The least distance of each row.
    minima: Vec<f32>,
}

impl<'a> Field<'a> {
    #[inline(always)]
    fn new(choice: &'a Choice, distances: &'a mut [f32]) -> Self {
        let barred = distances.iter_mut().zip(&choice.barred);
        barred.for_each(|(distance, bar)| *distance += bar);
        let rows = distances.chunks_exact(choice.grid.width as usize);
        Self {
            minima: rows.map(least_of).collect(),
            choice,
            distances,
        }
    }

    /// The nearest texel still in question; of equals the smaller index.
    #[inline(always)]
    fn nearest(&self) -> Option<(f32, TexelIndex)> {
        let distance = least_of(&self.minima);
        if distance == f32::INFINITY {
            return None;
        }
        let row = first_of(&self.minima, distance)?;
        let width = self.choice.grid.width as usize;
        let col = first_of(&self.distances[row * width..][..width], distance)?;
        Some((distance, TexelIndex((row * width + col) as u32)))
    }

    /// Puts everything closer than the separation out of the question.
    #[inline(always)]
    fn bar_around(&mut self, texel: TexelIndex) {
        let (row, col) = self.choice.grid.row_col(texel);
        let (width, cols) = (
            self.choice.grid.width as usize,
            self.choice.cols_around(col),
        );
        for row in self.choice.rows_around(row) {
            let distances = &mut self.distances[row * width..][..width];
            let mut least = f32::INFINITY;
            for cols in &cols {
                for distance in &mut distances[cols.clone()] {
                    least = smaller(least, *distance);
                    *distance = f32::INFINITY;
                }
            }
            if least == self.minima[row] {
                self.minima[row] = least_of(distances);
            }
        }
    }
}

/// The least of some numbers, none of them NaN; infinity of none.
#[inline(always)]
fn least_of(values: &[f32]) -> f32 {
    let (whole, rest) = values.as_chunks::<LANES>();
    let mut lanes = [f32::INFINITY; LANES];
    for values in whole {
        for lane in 0..LANES {
            lanes[lane] = smaller(lanes[lane], values[lane]);
        }
    }
    rest.iter().copied().fold(least_of_lanes(lanes), smaller)
}

/// The place of the first of some numbers that equals one.
#[inline(always)]
fn first_of(values: &[f32], wanted: f32) -> Option<usize> {
    let holds = |values: &[f32]| values.iter().fold(false, |any, &v| any | (v == wanted));
    let lanes = values.chunks(LANES).position(holds)? * LANES;
    let place = values[lanes..].iter().position(|&v| v == wanted)?;
    Some(lanes + place)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(tileable: bool) -> TexelGrid {
        TexelGrid {
            width: 21,
            height: 6,
            tileable,
        }
    }

    #[test]
    fn everything_within_the_separation_is_barred() {
        for (tileable, separation) in [(true, 3), (false, 3), (true, 40), (false, 40)] {
            let grid = grid(tileable);
            let choice = Choice::new(grid, &vec![true; grid.len()], separation, 2, None);
            let reach = i64::from(separation) - 1;
            for texel in (0..grid.len() as u32).map(TexelIndex) {
                let mut distances = vec![1.0; grid.len()];
                Field::new(&choice, &mut distances).bar_around(texel);
                let (row, col) = grid.row_col(texel);
                let mut expected = vec![1.0; grid.len()];
                for drow in -reach..=reach {
                    for dcol in -reach..=reach {
                        let near = grid.texel_at(i64::from(row) + drow, i64::from(col) + dcol);
                        near.into_iter()
                            .for_each(|near| expected[near.index()] = f32::INFINITY);
                    }
                }
                assert_eq!(distances, expected, "{texel:?}");
            }
        }
    }

    #[test]
    fn only_texels_of_the_band_are_listed_and_short_rows_repeat_their_last() {
        let grid = grid(false);
        let band = Band {
            transition: (0..grid.len())
                .map(|texel| (texel % 21) as f32 / 20.0)
                .collect(),
            tolerance: 0.09,
        };
        let whole = vec![true; grid.len()];
        let choice = Choice::new(grid, &whole, 1, 40, Some(band.clone()));
        for texel in [TexelIndex(0), TexelIndex(31)] {
            let row = choice.choose(texel, &mut vec![1.0; grid.len()]).unwrap();
            assert_eq!(row.len(), 40);
            assert!(
                row.iter()
                    .all(|&(_, other)| band.has(texel, TexelIndex(other)))
            );
            let mut listed: Vec<u32> = row.iter().map(|near| near.1).collect();
            listed.dedup();
            // Two columns at the end, three inside.
            assert_eq!(listed.len(), if texel.0 == 0 { 12 } else { 18 });
        }
        let plain = Choice::new(grid, &whole, 40, 2, None);
        assert_eq!(plain.completed(vec![(0.0, 5)]), Err(1));
    }

    #[test]
    fn of_equals_the_first_is_nearest_and_barred_texels_never_are() {
        let grid = grid(false);
        let mut whole = vec![true; grid.len()];
        whole[70] = false;
        let choice = Choice::new(grid, &whole, 1, 4, None);
        let mut distances = vec![2.0; grid.len()];
        for near in [70, 90, 83] {
            distances[near] = 0.5;
        }
        distances[0] = 0.0;
        let row = choice.choose(TexelIndex(0), &mut distances).unwrap();
        assert_eq!(row, [(0.0, 0), (0.5, 83), (0.5, 90), (2.0, 1)]);
        let all = Choice::new(grid, &vec![true; grid.len()], 40, 2, None);
        let mut distances = vec![2.0; grid.len()];
        assert_eq!(all.choose(TexelIndex(5), &mut distances), Err(1));
    }
}
