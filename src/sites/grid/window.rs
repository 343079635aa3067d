//! The samples round the sites of a flat grid. All coincide with sites, and sites as far from the
//! borders see them at the same steps: a list for every such kind of site instead of one per site.

use crate::sites::level::{Neighbor, SampleLocation};

/// A rectangle of sites; site row · width + col, row 0 at the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SiteGrid {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether opposite borders continue each other.
    pub toroidal: bool,
}

impl SiteGrid {
    /// The site at a signed row and column: wrapped on a torus, else `None` off the grid.
    pub fn site_at(self, row: i64, col: i64) -> Option<u32> {
        let (height, width) = (i64::from(self.height), i64::from(self.width));
        let (row, col) = if (0..height).contains(&row) && (0..width).contains(&col) {
            (row, col)
        } else if self.toroidal {
            (row.rem_euclid(height), col.rem_euclid(width))
        } else {
            return None;
        };
        Some((row * width + col) as u32)
    }
}

/// A window of offsets round every site of a grid, on that grid or on one of half its size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GridWindow {
    /// Sites that have a window, and columns of them.
    sites: usize,
    columns: u32,
    /// How often their rows and columns are halved on the grid that is sampled.
    halvings: u32,
    sampled: SiteGrid,
    /// Samples per site.
    samples: usize,
    rows: SideKinds,
    cols: SideKinds,
    /// Kind after kind of row and of column in it, how many sites after the centre each sample lies.
    steps: Vec<i32>,
}

/// What a sample off the grid has for a step.
const OUTSIDE: i32 = i32::MIN;

/// The kinds of places along a side: each as far as a window reaches from an end, and all between.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SideKinds {
    length: u32,
    reach: u32,
}

impl SideKinds {
    fn count(self) -> u32 {
        self.length.min(2 * self.reach + 1)
    }

    /// Whether a window is longer than the side: every place is a kind of its own.
    #[inline(always)]
    fn is_short(self) -> bool {
        self.length <= 2 * self.reach
    }

    #[inline(always)]
    fn of(self, place: u32) -> u32 {
        let from_end = self.length - 1 - place;
        if self.is_short() || place < self.reach {
            place
        } else if from_end < self.reach {
            2 * self.reach - from_end
        } else {
            self.reach
        }
    }

    /// A place of a kind.
    fn example(self, kind: u32) -> u32 {
        match self.is_short() || kind <= self.reach {
            true => kind,
            false => self.length - 1 - (2 * self.reach - kind),
        }
    }
}

impl GridWindow {
    /// The window of `offsets` ([drow, dcol]) round every site of `grid`, on `sampled`, which has its
    /// rows and columns halved `halvings` times.
    pub fn new(grid: SiteGrid, sampled: SiteGrid, halvings: u32, offsets: &[[i32; 2]]) -> Self {
        let reach = offsets.iter().flatten().map(|o| o.unsigned_abs()).max();
        // A reach beyond the side makes every place a kind of its own, as the side's length does.
        let kinds = |length| SideKinds {
            length,
            reach: reach.unwrap_or(0).min(length),
        };
        let (rows, cols) = (kinds(sampled.height), kinds(sampled.width));
        let mut steps = Vec::new();
        for row in (0..rows.count()).map(|kind| i64::from(rows.example(kind))) {
            for col in (0..cols.count()).map(|kind| i64::from(cols.example(kind))) {
                let centre = row * i64::from(sampled.width) + col;
                steps.extend(offsets.iter().map(|&[drow, dcol]| {
                    let site = sampled.site_at(row + i64::from(drow), col + i64::from(dcol));
                    site.map_or(OUTSIDE, |site| (i64::from(site) - centre) as i32)
                }));
            }
        }
        Self {
            sites: grid.width as usize * grid.height as usize,
            columns: grid.width,
            halvings,
            sampled,
            samples: offsets.len(),
            rows,
            cols,
            steps,
        }
    }

    /// Samples per site.
    pub fn samples_per_site(&self) -> usize {
        self.samples
    }

    /// Where the samples of one site fall.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = SampleLocation<1>> + '_ {
        self.sites_round(site).map(|site| match site {
            Some(site) => SampleLocation::AtSite(site),
            None => SampleLocation::Outside,
        })
    }

    /// The sites that samples fall on, `None` for those off the grid.
    #[inline(always)]
    fn sites_round(&self, site: usize) -> impl Iterator<Item = Option<u32>> + '_ {
        let site = site as u32;
        let row = (site / self.columns) >> self.halvings;
        let col = (site % self.columns) >> self.halvings;
        let kind = self.rows.of(row) * self.cols.count() + self.cols.of(col);
        let steps = &self.steps[kind as usize * self.samples..][..self.samples];
        let centre = row * self.sampled.width + col;
        steps.iter().map(move |&step| match step {
            OUTSIDE => None,
            _ => Some(centre.wrapping_add_signed(step)),
        })
    }
}

/// The sites within a window round every site of a flat grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridNeighbors {
    window: GridWindow,
    /// Where each of the window's samples lies, x along s and y along t.
    places: Vec<[f32; 2]>,
}

impl GridNeighbors {
    /// The sites within a square window of odd `width`, nearest first.
    pub fn new(grid: SiteGrid, width: u32) -> Self {
        let reach = (width / 2) as i32;
        let mut offsets: Vec<[i32; 2]> = (-reach..=reach)
            .flat_map(|drow| (-reach..=reach).map(move |dcol| [drow, dcol]))
            .filter(|&offset| offset != [0, 0])
            .collect();
        offsets.sort_by_key(|&[drow, dcol]| (drow * drow + dcol * dcol, drow, dcol));
        let place = |&[drow, dcol]: &[i32; 2]| [dcol as f32, -drow as f32];
        Self {
            window: GridWindow::new(grid, grid, 0, &offsets),
            places: offsets.iter().map(place).collect(),
        }
    }

    /// The neighbours of one site.
    #[inline(always)]
    pub fn of_site(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_ {
        let sites = self.window.sites_round(site).zip(&self.places);
        sites.filter_map(|(site, &[x, y])| site.map(|site| Neighbor { site, x, y }))
    }

    /// A colour for every site, none of whose neighbours has the same: that of its row and that of its
    /// column together.
    pub fn colors(&self) -> Vec<u32> {
        let GridWindow {
            rows,
            cols,
            sampled,
            ..
        } = &self.window;
        let along = |side: &SideKinds| side_colors(side.length, side.reach, sampled.toroidal);
        let (of_rows, of_cols) = (along(rows), along(cols));
        let most = of_cols.iter().max().map_or(0, |&most| most + 1);
        let colors = of_rows
            .iter()
            .flat_map(|row| of_cols.iter().map(move |col| row * most + col));
        colors.collect()
    }
}

/// A colour for every place along a side, none of whose neighbours within `reach` has the same: blocks of
/// colours 0, 1, 2 …, one longer than the reach or, where they have to fill a circle, a few more.
pub(super) fn side_colors(length: u32, reach: u32, circle: bool) -> Vec<u32> {
    let period = reach + 1;
    if !circle {
        return (0..length).map(|place| place % period).collect();
    }
    let blocks = (length / period).max(1);
    let (shorter, longer) = (length / blocks, length % blocks);
    let of_block = |block| 0..shorter + u32::from(block < longer);
    (0..blocks).flat_map(of_block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const OFFSETS: [[i32; 2]; 5] = [[0, 0], [-2, 1], [1, -2], [2, 2], [0, -1]];

    fn check(width: u32, height: u32, toroidal: bool, halvings: u32) {
        let grid = SiteGrid {
            width,
            height,
            toroidal,
        };
        let sampled = SiteGrid {
            width: width.div_ceil(1 << halvings),
            height: height.div_ceil(1 << halvings),
            toroidal,
        };
        let window = GridWindow::new(grid, sampled, halvings, &OFFSETS);
        for site in 0..width * height {
            let centre = [site / width, site % width].map(|at| i64::from(at >> halvings));
            let expected = OFFSETS.map(|offset| {
                let [row, col] = [0, 1].map(|axis| centre[axis] + i64::from(offset[axis]));
                let site = sampled.site_at(row, col);
                site.map_or(SampleLocation::Outside, SampleLocation::AtSite)
            });
            let found: Vec<_> = window.of_site(site as usize).collect();
            assert_eq!(
                found, expected,
                "{width}x{height} {toroidal} {halvings} {site}"
            );
        }
    }

    #[test]
    fn every_sample_falls_where_its_offset_leads() {
        for toroidal in [false, true] {
            for (width, height) in [(9, 7), (6, 6), (5, 5), (4, 9), (3, 2), (1, 1)] {
                check(width, height, toroidal, 0);
                check(width, height, toroidal, 1);
            }
        }
    }

    #[test]
    fn no_two_neighbours_have_one_color() {
        for toroidal in [false, true] {
            for (width, height) in [(16, 12), (17, 9), (7, 11), (3, 2), (1, 1)] {
                let grid = SiteGrid {
                    width,
                    height,
                    toroidal,
                };
                let neighbors = GridNeighbors::new(grid, 7);
                let colors = neighbors.colors();
                assert_eq!(colors.len(), (width * height) as usize);
                for site in 0..colors.len() {
                    let others = neighbors.of_site(site).map(|n| n.site as usize);
                    let mut others = others.filter(|&other| other != site);
                    assert!(others.all(|other| colors[other] != colors[site]));
                }
            }
        }
        let grid = SiteGrid {
            width: 16,
            height: 8,
            toroidal: true,
        };
        let most = GridNeighbors::new(grid, 7).colors().into_iter().max();
        assert_eq!(most, Some(15));
    }

    #[test]
    fn neighbours_come_nearest_first() {
        let grid = SiteGrid {
            width: 6,
            height: 5,
            toroidal: true,
        };
        let neighbors = GridNeighbors::new(grid, 3);
        // Site (row 0, col 5): right of it is column 0, above it row 4.
        let list: Vec<Neighbor> = neighbors.of_site(5).collect();
        let near = |site, x, y| Neighbor { site, x, y };
        assert_eq!(list[0], near(29, 0.0, 1.0));
        assert!(list.len() == 8 && list.contains(&near(0, 1.0, 0.0)));
        assert!(list[4..].iter().all(|n| n.x.abs() + n.y.abs() == 2.0));
    }
}
