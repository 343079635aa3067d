//! A flat grid of sites with round neighbourhoods, the same sites at every level (Chen 2008 §6.2): level l has
//! circles 2ˡ times as wide. A sample lies between four sites, at the same steps from every site.

use crate::neighborhood::Template;
use crate::sites::grid::window::{SiteGrid, side_colors};
use crate::sites::level::{Neighbor, Parent, SampleLocation, Sites};

/// One level of a flat grid with round neighbourhoods.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundGridSites {
    grid: SiteGrid,
    samples: Vec<Between>,
    /// Rows and columns to the sites that are near, nearest first, and their places in texels of the level.
    near: Vec<([i32; 2], [f32; 2])>,
    /// How far samples and neighbours reach, in sites.
    reach: u32,
    parents: Vec<Parent>,
    areas: Vec<f32>,
}

/// Steps to the four sites round a sample, and their weights.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Between {
    steps: [[i32; 2]; 4],
    weights: [f32; 4],
}

impl Between {
    /// At (x, y) sites along s and t; rows run against t.
    fn at(x: f32, y: f32) -> Self {
        let (col, row) = (x.floor(), (-y).floor());
        let (u, v) = (x - col, -y - row);
        let (col, row) = (col as i32, row as i32);
        Self {
            steps: [
                [row, col],
                [row, col + 1],
                [row + 1, col],
                [row + 1, col + 1],
            ],
            weights: [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v],
        }
    }
}

impl RoundGridSites {
    /// Level `level` of a grid, with the samples of a template; `near` is the radius, in sites, in which others
    /// propose texels.
    pub fn new(grid: SiteGrid, template: &Template, level: u32, near: u32) -> Self {
        let scale = (1_u32 << level) as f32;
        let count = grid.width as usize * grid.height as usize;
        let positions = template.positions.iter();
        let samples: Vec<Between> = positions
            .map(|at| Between::at(scale * at.x, scale * at.y))
            .collect();
        let widest = template.positions.iter().map(|at| at.length());
        let widest = scale * widest.fold(0.0, f32::max);
        Self {
            grid,
            samples,
            near: disc(near, scale),
            reach: (widest.ceil() as u32).max(near),
            parents: Vec::new(),
            areas: vec![1.0; count],
        }
    }

    /// Every site is its own parent on the level above.
    #[must_use]
    pub fn with_parents(mut self) -> Self {
        let parent = |site| Parent {
            site,
            x: 0.0,
            y: 0.0,
        };
        self.parents = (0..self.areas.len() as u32).map(parent).collect();
        self
    }

    fn row_col(&self, site: usize) -> (i64, i64) {
        let width = self.grid.width as usize;
        ((site / width) as i64, (site % width) as i64)
    }
}

/// Steps to the sites within a radius, nearest first, the centre left out; `scale` sites are a texel.
fn disc(radius: u32, scale: f32) -> Vec<([i32; 2], [f32; 2])> {
    let reach = radius as i32;
    let mut steps: Vec<[i32; 2]> = (-reach..=reach)
        .flat_map(|row| (-reach..=reach).map(move |col| [row, col]))
        .filter(|&[row, col]| [row, col] != [0, 0] && row * row + col * col <= reach * reach)
        .collect();
    steps.sort_by_key(|&[row, col]| (row * row + col * col, row, col));
    let place = |[row, col]: [i32; 2]| [col as f32 / scale, -row as f32 / scale];
    steps.into_iter().map(|step| (step, place(step))).collect()
}

impl Sites<4> for RoundGridSites {
    fn count(&self) -> usize {
        self.areas.len()
    }

    #[inline(always)]
    fn neighbors(&self, site: usize) -> impl Iterator<Item = Neighbor> + '_ {
        let (row, col) = self.row_col(site);
        self.near.iter().filter_map(move |&([drow, dcol], [x, y])| {
            let site = self
                .grid
                .site_at(row + i64::from(drow), col + i64::from(dcol))?;
            Some(Neighbor { site, x, y })
        })
    }

    #[inline(always)]
    fn samples(&self, site: usize) -> impl Iterator<Item = SampleLocation<4>> + '_ {
        let (row, col) = self.row_col(site);
        self.samples.iter().map(move |sample| {
            let (mut sites, weights) = ([site as u32; 4], sample.weights);
            for (at, [drow, dcol]) in sample.steps.into_iter().enumerate() {
                if weights[at] == 0.0 {
                    continue;
                }
                match self
                    .grid
                    .site_at(row + i64::from(drow), col + i64::from(dcol))
                {
                    Some(there) => sites[at] = there,
                    None => return SampleLocation::Outside,
                }
            }
            if weights[0] == 1.0 {
                return SampleLocation::AtSite(sites[0]);
            }
            SampleLocation::Between(sites, weights)
        })
    }

    fn parent_samples(&self, _site: usize) -> impl Iterator<Item = SampleLocation<4>> + '_ {
        std::iter::empty()
    }

    fn samples_per_site(&self) -> usize {
        self.samples.len()
    }

    fn parent_samples_per_site(&self) -> usize {
        0
    }

    fn parents(&self) -> &[Parent] {
        &self.parents
    }

    fn areas(&self) -> &[f32] {
        &self.areas
    }

    fn known_colors(&self) -> Option<Vec<u32>> {
        let along = |length| side_colors(length, self.reach, self.grid.toroidal);
        let (rows, cols) = (along(self.grid.height), along(self.grid.width));
        let most = cols.iter().max().map_or(0, |&most| most + 1);
        let color = |row: &u32| {
            cols.iter()
                .map(move |col| row * most + col)
                .collect::<Vec<_>>()
        };
        Some(rows.iter().flat_map(color).collect())
    }

    fn digest(&self, hasher: &mut blake3::Hasher) {
        hasher.update(format!("{:?} {:?}", self.grid, self.samples).as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sites(toroidal: bool, level: u32) -> (RoundGridSites, Template) {
        let grid = SiteGrid {
            width: 20,
            height: 16,
            toroidal,
        };
        let template = Template::round(2);
        (RoundGridSites::new(grid, &template, level, 2), template)
    }

    #[test]
    fn samples_lie_where_the_template_says() {
        for level in [0, 1] {
            let (sites, template) = sites(true, level);
            let centre = 8 * 20 + 10;
            for (sample, at) in sites.samples(centre).zip(&template.positions) {
                let (found, weights) = match sample {
                    SampleLocation::AtSite(site) => ([site; 4], [1.0, 0.0, 0.0, 0.0]),
                    SampleLocation::Between(found, weights) => (found, weights),
                    SampleLocation::Outside => panic!("outside"),
                };
                let place = |site: u32| [(site % 20) as f32 - 10.0, 8.0 - (site / 20) as f32];
                let (mut x, mut y) = (0.0, 0.0);
                for (site, weight) in found.into_iter().zip(weights) {
                    x += weight * place(site)[0];
                    y += weight * place(site)[1];
                }
                let scale = (1 << level) as f32;
                assert!((x - scale * at.x).abs() < 1e-4 && (y - scale * at.y).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn neighbours_are_told_in_texels_and_end_at_an_open_border() {
        let (sites, _) = sites(false, 1);
        let first = sites.neighbors(8 * 20 + 10).next().unwrap();
        assert_eq!((first.site, first.x, first.y), (7 * 20 + 10, 0.0, 0.5));
        assert_eq!(sites.neighbors(8 * 20 + 10).count(), 12);
        assert_eq!(sites.neighbors(0).count(), 5);
        let outside = |sample| sample == SampleLocation::Outside;
        assert!(sites.samples(0).filter(|&sample| outside(sample)).count() > 8);
    }

    #[test]
    fn no_site_reads_another_of_its_colour() {
        let (sites, _) = sites(true, 0);
        let colors = sites.known_colors().unwrap();
        for site in 0..sites.count() {
            let read = sites
                .samples(site)
                .flat_map(|sample| sample.sites().to_vec());
            let read = read.chain(sites.neighbors(site).map(|near| near.site));
            for other in read.filter(|&other| other as usize != site) {
                assert_ne!(colors[other as usize], colors[site]);
            }
        }
    }
}
