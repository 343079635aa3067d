//! A flat grid of sites whose neighbourhoods are scaled and turned, each in its own way (Zhang 2003 §4.1): a
//! sample lies between four sites.
//!
//! The frame of a site is its orientation s and t = s turned a quarter counter-clockwise; one texel of the
//! exemplar is `scale` sites long there. Sites along the field come first.

use glam::Vec2;
use ndarray::{Array2, Array3};

use crate::sites::grid::window::SiteGrid;
use crate::sites::level::{Neighbor, Parent, SampleLocation, Sites};

/// How a site's neighbourhood lies.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SiteFrame {
    /// The orientation, times the scale, in (s, t).
    along: Vec2,
    scale: f32,
}

impl SiteFrame {
    /// Where a position in texels lies, in sites.
    fn place(self, at: Vec2) -> Vec2 {
        at.x * self.along + at.y * self.along.perp()
    }

    /// Where a way in sites leads, in texels.
    fn texels(self, way: Vec2) -> Vec2 {
        let square = self.scale * self.scale;
        Vec2::new(way.dot(self.along), way.dot(self.along.perp())) / square
    }
}

/// One level of a flat grid with neighbourhoods of their own scale and direction.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnedGridSites {
    grid: SiteGrid,
    frames: Vec<SiteFrame>,
    positions: Vec<Vec2>,
    /// Steps (row, column) to the sites that may be near, nearest first.
    near: Vec<[i32; 2]>,
    /// How far neighbours are, in texels.
    reach: f32,
    coarser: Option<SiteGrid>,
    coarse_positions: Vec<Vec2>,
    parents: Vec<Parent>,
    areas: Vec<f32>,
}

/// Positions of windows on a level and on the coarser one.
#[derive(Clone, Debug, Default)]
pub struct TurnedWindows {
    /// Samples, in texels of the level.
    pub positions: Vec<Vec2>,
    /// Samples on the coarser level, in its texels; empty where there is none.
    pub coarse_positions: Vec<Vec2>,
    /// How far others propose texels, in texels.
    pub reach: f32,
}

impl TurnedGridSites {
    /// Sites with the scale of each, [H, W], above 0, and the orientation, unit vectors (s, t) [H, W, 2].
    pub fn new(scales: &Array2<f32>, orientations: &Array3<f32>, windows: TurnedWindows) -> Self {
        let (rows, cols) = scales.dim();
        let grid = SiteGrid {
            width: cols as u32,
            height: rows as u32,
            toroidal: false,
        };
        // Turn and scale each site's frame.
        let frame = |((row, col), &scale): ((usize, usize), &f32)| {
            let vector = Vec2::new(orientations[[row, col, 0]], orientations[[row, col, 1]]);
            SiteFrame {
                along: scale * vector,
                scale,
            }
        };
        let frames: Vec<SiteFrame> = scales.indexed_iter().map(frame).collect();
        // Find how far windows reach.
        let widest = frames.iter().map(|frame| frame.scale).fold(1.0, f32::max);
        let coarser = (!windows.coarse_positions.is_empty()).then(|| SiteGrid {
            width: grid.width.div_ceil(2),
            height: grid.height.div_ceil(2),
            toroidal: false,
        });
        let mut sites = Self {
            grid,
            frames,
            positions: windows.positions,
            near: disc((windows.reach * widest).ceil() as i32),
            reach: windows.reach,
            coarser,
            coarse_positions: windows.coarse_positions,
            parents: Vec::new(),
            areas: vec![1.0; rows * cols],
        };
        // Find the parents.
        if let Some(coarser) = coarser {
            sites.parents = (0..rows * cols)
                .map(|site| sites.parent(site, coarser))
                .collect();
        }
        sites
    }

    /// Parent (row ≫ 1, col ≫ 1), a quarter of a coarse site to one side or the other.
    fn parent(&self, site: usize, coarser: SiteGrid) -> Parent {
        let (row, col) = self.row_col(site);
        let quarter = |at: usize| if at.is_multiple_of(2) { 0.25 } else { -0.25 };
        let way = self.frames[site].texels(Vec2::new(quarter(col), -quarter(row)));
        Parent {
            site: (row / 2) as u32 * coarser.width + (col / 2) as u32,
            x: way.x,
            y: way.y,
        }
    }

    fn row_col(&self, site: usize) -> (usize, usize) {
        let width = self.grid.width as usize;
        (site / width, site % width)
    }
}

/// Steps within a radius, nearest first, the centre left out.
fn disc(radius: i32) -> Vec<[i32; 2]> {
    let mut steps: Vec<[i32; 2]> = (-radius..=radius)
        .flat_map(|row| (-radius..=radius).map(move |col| [row, col]))
        .filter(|&[row, col]| [row, col] != [0, 0] && row * row + col * col <= radius * radius)
        .collect();
    steps.sort_by_key(|&[row, col]| (row * row + col * col, row, col));
    steps
}

/// Where a point lies among the sites of a grid, x along the columns and y along the rows.
fn located(grid: SiteGrid, x: f32, y: f32) -> SampleLocation<4> {
    let (col, row) = (x.floor(), y.floor());
    let (u, v) = (x - col, y - row);
    let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
    let steps = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let mut sites = [0; 4];
    let mut first = None;
    for (at, (down, right)) in steps.into_iter().enumerate() {
        if weights[at] > 0.0 {
            match grid.site_at(row as i64 + down, col as i64 + right) {
                Some(site) => sites[at] = site,
                None => return SampleLocation::Outside,
            }
            first = first.or(Some(sites[at]));
        }
    }
    let first = first.unwrap_or(0);
    if weights[0] == 1.0 {
        return SampleLocation::AtSite(first);
    }
    for (site, weight) in sites.iter_mut().zip(weights) {
        if weight == 0.0 {
            *site = first;
        }
    }
    SampleLocation::Between(sites, weights)
}

impl Sites<4> for TurnedGridSites {
    fn count(&self) -> usize {
        self.areas.len()
    }

    fn neighbors(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_ {
        let (row, col) = self.row_col(site);
        let frame = self.frames[site];
        let most = (self.reach * frame.scale).max(1.0);
        let within =
            move |&&[drow, dcol]: &&[i32; 2]| ((drow * drow + dcol * dcol) as f32) <= most * most;
        self.near
            .iter()
            .take_while(within)
            .filter_map(move |&[drow, dcol]| {
                let other = self
                    .grid
                    .site_at(row as i64 + i64::from(drow), col as i64 + i64::from(dcol))?;
                let at = frame.texels(Vec2::new(dcol as f32, -drow as f32));
                Some(Neighbor {
                    site: other,
                    x: at.x,
                    y: at.y,
                })
            })
    }

    #[inline(always)]
    fn samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<4>> + '_ {
        let (row, col) = self.row_col(site);
        let frame = self.frames[site];
        self.positions.iter().map(move |&at| {
            let way = frame.place(at);
            located(self.grid, col as f32 + way.x, row as f32 - way.y)
        })
    }

    #[inline(always)]
    fn parent_samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<4>> + '_ {
        let (row, col) = self.row_col(site);
        let frame = self.frames[site];
        // A coarse site lies between the four below it.
        let (x, y) = ((col as f32 - 0.5) / 2.0, (row as f32 - 0.5) / 2.0);
        let coarser = self.coarser;
        self.coarse_positions.iter().map(move |&at| {
            let way = frame.place(at);
            match coarser {
                Some(coarser) => located(coarser, x + way.x, y - way.y),
                None => SampleLocation::Outside,
            }
        })
    }

    fn samples_per_site(&self) -> usize {
        self.positions.len()
    }

    fn parent_samples_per_site(&self) -> usize {
        self.coarse_positions.len()
    }

    fn parents(&self) -> &[Parent] {
        &self.parents
    }

    fn areas(&self) -> &[f32] {
        &self.areas
    }

    fn digest(&self, hasher: &mut blake3::Hasher) {
        hasher.update(format!("{:?} {:?} {:?}", self.grid, self.frames, self.positions).as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighborhood::Template;

    fn sites(scale: f32, vector: [f32; 2], coarse: u32) -> TurnedGridSites {
        let scales = Array2::from_elem((16, 20), scale);
        let orientations = Array3::from_shape_fn((16, 20, 2), |(_, _, axis)| vector[axis]);
        let windows = TurnedWindows {
            positions: Template::square(3).positions,
            coarse_positions: Template::square(coarse).positions,
            reach: 2.0,
        };
        TurnedGridSites::new(&scales, &orientations, windows)
    }

    /// Where a sample lies, x to the right and y up, in sites from one.
    fn place(sample: SampleLocation<4>, from: usize, width: usize) -> [f32; 2] {
        let (found, weights) = match sample {
            SampleLocation::AtSite(site) => ([site; 4], [1.0, 0.0, 0.0, 0.0]),
            SampleLocation::Between(found, weights) => (found, weights),
            SampleLocation::Outside => panic!("outside"),
        };
        let mut at = [0.0, 0.0];
        for (site, weight) in found.into_iter().zip(weights) {
            at[0] += weight * ((site as usize % width) as f32 - (from % width) as f32);
            at[1] += weight * ((from / width) as f32 - (site as usize / width) as f32);
        }
        at
    }

    #[test]
    fn samples_are_scaled_and_turned() {
        let centre = 8 * 20 + 10;
        let turned = sites(1.5, [0.6, 0.8], 0);
        for (sample, at) in turned.samples(centre).zip(Template::square(3).positions) {
            let expected = [
                1.5 * (0.6 * at.x - 0.8 * at.y),
                1.5 * (0.8 * at.x + 0.6 * at.y),
            ];
            let found = place(sample, centre, 20);
            assert!((found[0] - expected[0]).abs() < 1e-4 && (found[1] - expected[1]).abs() < 1e-4);
        }
        // Neighbours lie where a texel's way leads.
        for near in turned.neighbors(centre) {
            let way = turned.frames[centre].place(Vec2::new(near.x, near.y));
            let found = place(SampleLocation::AtSite(near.site), centre, 20);
            assert!((way.x - found[0]).abs() < 1e-4 && (way.y - found[1]).abs() < 1e-4);
        }
        let straight = sites(1.0, [1.0, 0.0], 0);
        let at_sites = straight
            .samples(centre)
            .all(|at| matches!(at, SampleLocation::AtSite(_)));
        assert!(at_sites && straight.neighbors(centre).count() == 12);
        assert_eq!(
            straight
                .samples(0)
                .filter(|at| *at == SampleLocation::Outside)
                .count(),
            5
        );
    }

    #[test]
    fn parents_lie_where_they_say() {
        let turned = sites(0.5, [0.0, 1.0], 3);
        for site in [0, 21, 8 * 20 + 11] {
            let parent = turned.parents()[site];
            let way = turned.frames[site].place(Vec2::new(parent.x, parent.y));
            let coarse = |at: usize| (at as f32 - 0.5) / 2.0;
            let x = (parent.site % 10) as f32 - coarse(site % 20);
            let y = coarse(site / 20) - (parent.site / 10) as f32;
            assert!(
                (way.x - x).abs() < 1e-5 && (way.y - y).abs() < 1e-5,
                "{site}"
            );
        }
        let centre = turned.parent_samples(8 * 20 + 11).nth(4).unwrap();
        let found = place(centre, 0, 10);
        assert!((found[0] - 5.25).abs() < 1e-5 && (found[1] + 3.75).abs() < 1e-5);
    }
}
