//! The flat target: a grid of sites one texel apart, so that every sample coincides with a site.
//! The test bed of 2-D synthesis, with the engine that meshes use.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::Neighborhood;
use crate::mesh::hierarchy::{Neighbor, NeighborLists, Parent, SiteHierarchy, SiteLevel};
use crate::mesh::stencil::{PackedSample, Stencils};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::synthesis::check::window_width;
use crate::synthesis::quality::coherence::SiteEdge;

/// Sites of a target grid; more would not fit 32-bit indices of samples.
const MOST_SITES: u64 = 1 << 26;

/// A flat grid of sites; site row · width + col, row 0 at the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridTarget {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether opposite borders continue each other; else samples off the grid hold the default.
    pub toroidal: bool,
}

impl std::str::FromStr for GridTarget {
    type Err = String;

    /// Reads `WxH`; toroidal.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parts = text.split_once(['x', '×']);
        let parsed = parts.and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
        match parsed {
            Some((width, height)) if width > 0 && height > 0 => Ok(Self {
                width,
                height,
                toroidal: true,
            }),
            _ => Err("expected WxH in sites, as 256x256".into()),
        }
    }
}

impl GridTarget {
    /// The hierarchy of sites for the neighbourhoods of as many levels, finest first.
    pub fn hierarchy(self, neighborhoods: &[Neighborhood]) -> Result<SiteHierarchy> {
        self.check(neighborhoods)?;
        let mut levels = Vec::with_capacity(neighborhoods.len());
        let mut grid = self;
        for (index, neighborhood) in neighborhoods.iter().enumerate() {
            let coarser = (index + 1 < neighborhoods.len()).then(|| grid.coarser());
            levels.push(grid.site_level(coarser, neighborhood));
            grid = grid.coarser();
        }
        Ok(SiteHierarchy { levels })
    }

    /// The surface of the grid: a site every mesh unit, x to the right, y up, seen from +z.
    pub fn mesh(self) -> TriangleMesh {
        let positions = (0..self.sites()).map(|site| {
            let (row, col) = (site / self.width, site % self.width);
            Vec3::new(col as f32, (self.height - 1 - row) as f32, 0.0)
        });
        let corners = (0..self.height - 1)
            .flat_map(|row| (0..self.width - 1).map(move |col| row * self.width + col));
        let triangles = corners.flat_map(|top| {
            let below = top + self.width;
            [[top, below, below + 1], [top, below + 1, top + 1]]
        });
        TriangleMesh {
            positions: positions.collect(),
            triangles: triangles.collect(),
        }
    }

    /// The edges right and down of every site; across the border on a torus.
    pub fn edges(self) -> Vec<SiteEdge> {
        let mut edges = Vec::new();
        for site in 0..self.sites() {
            let (row, col) = (i64::from(site / self.width), i64::from(site % self.width));
            for (drow, dcol) in [(0, 1), (1, 0)] {
                if let Some(other) = self.site_at(row + drow, col + dcol) {
                    let offset = [dcol as f32, -drow as f32];
                    edges.push(SiteEdge {
                        from: site,
                        to: other,
                        offset,
                    });
                }
            }
        }
        edges
    }

    fn check(self, neighborhoods: &[Neighborhood]) -> Result<()> {
        let asked = format!("{}x{}", self.width, self.height);
        if u64::from(self.width) * u64::from(self.height) > MOST_SITES {
            return Err(Error::option(
                "grid",
                asked,
                format!("at most {MOST_SITES} sites"),
            ));
        }
        let mut grid = self;
        for (level, neighborhood) in neighborhoods.iter().enumerate() {
            let width = window_width(&neighborhood.offsets);
            if grid.width.min(grid.height) < width {
                return Err(Error::option(
                    "grid",
                    format!(
                        "{asked}: level {level} is {}x{}, smaller than the neighbourhood's {width}",
                        grid.width, grid.height
                    ),
                    "a larger grid, or fewer --levels",
                ));
            }
            let halves = grid.width.is_multiple_of(2) && grid.height.is_multiple_of(2);
            if self.toroidal && level + 1 < neighborhoods.len() && !halves {
                return Err(Error::option(
                    "grid",
                    format!("{asked}: level {level} is {}x{}", grid.width, grid.height),
                    "sides divisible by 2^(levels−1), or --border open",
                ));
            }
            grid = grid.coarser();
        }
        Ok(())
    }

    fn sites(self) -> u32 {
        self.width * self.height
    }

    fn coarser(self) -> Self {
        Self {
            width: self.width.div_ceil(2),
            height: self.height.div_ceil(2),
            ..self
        }
    }

    fn site_at(self, row: i64, col: i64) -> Option<u32> {
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

    fn site_level(self, coarser: Option<Self>, neighborhood: &Neighborhood) -> SiteLevel {
        let parents = coarser.map(|coarser| self.parents(coarser));
        let coarse = coarser.map(|coarser| {
            let centre = |site: u32| {
                let (row, col) = (site / self.width, site % self.width);
                (i64::from(row / 2), i64::from(col / 2))
            };
            coarser.stencils(self.sites(), centre, &neighborhood.coarse_offsets)
        });
        let own = |site: u32| (i64::from(site / self.width), i64::from(site % self.width));
        SiteLevel {
            site_count: self.sites() as usize,
            fine: self.stencils(self.sites(), own, &neighborhood.offsets),
            coarse,
            neighbors: self.neighbors(window_width(&neighborhood.offsets)),
            parents: parents.unwrap_or_default(),
            areas: vec![1.0; self.sites() as usize],
        }
    }

    /// Samples on this grid's sites, round a centre (row, col) for each of `count` sites.
    fn stencils(
        self,
        count: u32,
        centre: impl Fn(u32) -> (i64, i64) + Sync,
        offsets: &[[i32; 2]],
    ) -> Stencils {
        let per_site = offsets.len();
        let sample = |index: usize| {
            let (row, col) = centre((index / per_site) as u32);
            let [drow, dcol] = offsets[index % per_site];
            let there = self.site_at(row + i64::from(drow), col + i64::from(dcol));
            there.map_or(PackedSample::OUTSIDE, |cell| {
                PackedSample::new(cell, [1.0, 0.0, 0.0])
            })
        };
        Stencils {
            samples_per_site: offsets.len(),
            cells: (0..self.sites()).map(|site| [site; 3]).collect(),
            samples: (0..count as usize * per_site)
                .into_par_iter()
                .map(sample)
                .collect(),
        }
    }

    /// All sites within the window, nearest first.
    fn neighbors(self, width: u32) -> NeighborLists {
        let reach = i64::from(width / 2);
        let mut around: Vec<(i64, i64)> = (-reach..=reach)
            .flat_map(|drow| (-reach..=reach).map(move |dcol| (drow, dcol)))
            .filter(|&offset| offset != (0, 0))
            .collect();
        around.sort_by_key(|&(drow, dcol)| (drow * drow + dcol * dcol, drow, dcol));
        let starts = self.neighbor_starts(reach);
        let listed = starts.last().map_or(0, |&end| end as usize);
        let nowhere = Neighbor {
            site: 0,
            x: 0.0,
            y: 0.0,
        };
        let mut entries = vec![nowhere; listed];
        let (mut rest, mut lines) = (&mut entries[..], Vec::new());
        for line in starts[..]
            .windows(self.width as usize + 1)
            .step_by(self.width as usize)
        {
            let (of_line, after) =
                rest.split_at_mut((line[self.width as usize] - line[0]) as usize);
            lines.push(of_line);
            rest = after;
        }
        lines
            .into_par_iter()
            .enumerate()
            .for_each(|(row, entries)| {
                let cols = 0..i64::from(self.width);
                let near = cols.flat_map(|col| self.near(row as i64, col, &around));
                entries
                    .iter_mut()
                    .zip(near)
                    .for_each(|(entry, near)| *entry = near);
            });
        NeighborLists { starts, entries }
    }

    /// Where each site's list of the others within `reach` begins, and where the last ends.
    fn neighbor_starts(self, reach: i64) -> Vec<u32> {
        let within = |at: u32, side: u32| match self.toroidal {
            true => 2 * reach + 1,
            false => {
                let (at, side) = (i64::from(at), i64::from(side));
                (at + reach).min(side - 1) - (at - reach).max(0) + 1
            }
        };
        let mut starts = vec![0];
        let mut end = 0;
        for site in 0..self.sites() {
            let (row, col) = (site / self.width, site % self.width);
            end += within(row, self.height) * within(col, self.width) - 1;
            starts.push(end as u32);
        }
        starts
    }

    /// The sites at some offsets from one.
    fn near(
        self,
        row: i64,
        col: i64,
        around: &[(i64, i64)],
    ) -> impl Iterator<Item = Neighbor> + '_ {
        around.iter().filter_map(move |&(drow, dcol)| {
            let site = self.site_at(row + drow, col + dcol)?;
            let (x, y) = (dcol as f32, -drow as f32);
            Some(Neighbor { site, x, y })
        })
    }

    /// Parent (row ≫ 1, col ≫ 1), a quarter of a coarse texel to one side or the other.
    fn parents(self, coarser: Self) -> Vec<Parent> {
        let parent = |site: u32| {
            let (row, col) = (site / self.width, site % self.width);
            Parent {
                site: (row / 2) * coarser.width + col / 2,
                x: if col % 2 == 0 { 0.25 } else { -0.25 },
                y: if row % 2 == 0 { -0.25 } else { 0.25 },
            }
        };
        (0..self.sites()).map(parent).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::TexelGrid;
    use crate::index::TexelIndex;
    use crate::synthesis::fixtures::square_neighborhood;
    use crate::synthesis::passes::first_guess;

    fn target(width: u32, height: u32, toroidal: bool) -> GridTarget {
        GridTarget {
            width,
            height,
            toroidal,
        }
    }

    #[test]
    fn a_grid_is_asked_for_as_an_image_size() {
        assert_eq!("256x128".parse(), Ok(target(256, 128, true)));
        for wrong in ["256", "0x4", "ax4", "4x-1", ""] {
            assert!(wrong.parse::<GridTarget>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn neighbours_and_samples_lie_where_they_say() {
        let hierarchy = target(6, 5, true)
            .hierarchy(&[square_neighborhood(3, None)])
            .unwrap();
        let level = &hierarchy.levels[0];
        // Site (row 0, col 5): right of it is column 0, above it row 4.
        let list = level.neighbors.of_site(5);
        assert_eq!(list.len(), 8);
        assert!(list.contains(&Neighbor {
            site: 0,
            x: 1.0,
            y: 0.0
        }));
        assert!(list.contains(&Neighbor {
            site: 29,
            x: 0.0,
            y: 1.0
        }));
        let samples = level.fine.of_site(5);
        let sites = samples
            .iter()
            .map(|&sample| level.fine.resolve(sample).unwrap().0[0]);
        assert_eq!(sites.collect::<Vec<_>>(), [28, 29, 24, 4, 5, 0, 10, 11, 6]);
    }

    #[test]
    fn off_an_open_grid_samples_are_outside() {
        let hierarchy = target(6, 5, false)
            .hierarchy(&[square_neighborhood(3, None)])
            .unwrap();
        let level = &hierarchy.levels[0];
        let outside = level
            .fine
            .of_site(0)
            .iter()
            .filter(|&&s| s == PackedSample::OUTSIDE);
        assert_eq!((outside.count(), level.neighbors.of_site(0).len()), (5, 3));
    }

    #[test]
    fn a_coarse_copy_guesses_a_fine_copy() {
        for (tileable, width, height) in [(true, 8, 6), (false, 7, 5)] {
            let fine = TexelGrid {
                width,
                height,
                tileable,
            };
            let coarse = fine.coarser();
            let coords: Vec<_> = (0..coarse.len() as u32)
                .map(|texel| coarse.centre(TexelIndex(texel)))
                .collect();
            let sites = target(width, height, tileable);
            let parents = sites.parents(sites.coarser());
            for (site, parent) in parents.iter().enumerate() {
                let guess = first_guess(fine, &coords, parent);
                assert_eq!(guess, fine.centre(TexelIndex(site as u32)));
            }
        }
    }

    #[test]
    fn the_mesh_faces_up_and_has_unit_cells() {
        let mesh = target(4, 3, false).mesh();
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (12, 12));
        assert!((mesh.area() - 6.0).abs() < 1e-9);
        assert!((0..12).all(|face| mesh.area_normal(face).z > 0.0));
    }

    #[test]
    fn sizes_that_cannot_be_are_refused() {
        let neighborhoods = [
            square_neighborhood(5, Some(3)),
            square_neighborhood(5, None),
        ];
        let message = |grid: GridTarget| grid.hierarchy(&neighborhoods).unwrap_err().to_string();
        assert!(message(target(8, 8, true)).contains("level 1 is 4x4, smaller"));
        assert!(message(target(13, 16, true)).contains("divisible"));
        assert!(message(target(1 << 20, 1 << 20, true)).contains("at most"));
        assert!(target(13, 16, false).hierarchy(&neighborhoods).is_ok());
    }
}
