//! The flat target: a grid of sites one texel apart, so that every sample coincides with a site.
//! The test bed of 2-D synthesis, with the engine that meshes use.

use crate::error::{Error, Result};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::{Neighborhood, Template, check_level_count, window_width};
use crate::sites::grid::GridSites;
use crate::sites::grid::round::RoundGridSites;
use crate::sites::grid::window::{GridNeighbors, GridWindow, SiteGrid};
use crate::sites::level::{Parent, SiteEdge, SiteHierarchy};
use glam::Vec3;

/// Sites of a target grid; more would not fit 32-bit indices of samples.
const MOST_SITES: u64 = 1 << 26;

impl std::str::FromStr for SiteGrid {
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

impl SiteGrid {
    /// The hierarchy of sites for the neighbourhoods of as many levels, finest first.
    pub fn hierarchy(self, neighborhoods: &[Neighborhood]) -> Result<SiteHierarchy<GridSites>> {
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

    /// The same sites at every level, with round neighbourhoods that are twice as wide on each.
    pub fn round_hierarchy(
        self,
        rings: u32,
        levels: usize,
    ) -> Result<SiteHierarchy<RoundGridSites>> {
        self.check_count()?;
        check_level_count(levels)?;
        let widest = (u64::from(rings) << levels) + 1;
        if u64::from(self.width.min(self.height)) < widest {
            return Err(Error::option(
                "grid",
                format!("{}x{}", self.width, self.height),
                format!("sides of {widest} or more, or fewer --rings or --levels"),
            ));
        }
        let (grid, template) = (self.site_grid(), Template::round(rings));
        let level = |level: usize| {
            let sites = RoundGridSites::new(grid, &template, level as u32, rings);
            match level + 1 < levels {
                true => sites.with_parents(),
                false => sites,
            }
        };
        Ok(SiteHierarchy {
            levels: (0..levels).map(level).collect(),
        })
    }

    /// The surface of the grid: a site every mesh unit, x to the right, y up, seen from +z.
    pub(crate) fn mesh(self) -> TriangleMesh {
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
    pub(crate) fn edges(self) -> Vec<SiteEdge> {
        let mut edges = Vec::new();
        for site in 0..self.sites() {
            let (row, col) = (i64::from(site / self.width), i64::from(site % self.width));
            for (drow, dcol) in [(0, 1), (1, 0)] {
                if let Some(other) = self.site_grid().site_at(row + drow, col + dcol) {
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

    fn check_count(self) -> Result<()> {
        match u64::from(self.width) * u64::from(self.height) {
            1..=MOST_SITES => Ok(()),
            _ => Err(Error::option(
                "grid",
                format!("{}x{}", self.width, self.height),
                format!("1 to {MOST_SITES} sites"),
            )),
        }
    }

    fn check(self, neighborhoods: &[Neighborhood]) -> Result<()> {
        self.check_count()?;
        check_level_count(neighborhoods.len())?;
        let asked = format!("{}x{}", self.width, self.height);
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

    fn site_level(self, coarser: Option<Self>, neighborhood: &Neighborhood) -> GridSites {
        let own = self.site_grid();
        let window = GridWindow::new(own, own, 0, &neighborhood.offsets);
        let coarse = coarser.map(|coarser| {
            let sampled = coarser.site_grid();
            GridWindow::new(own, sampled, 1, &neighborhood.coarse_offsets)
        });
        let width = window_width(&neighborhood.offsets);
        GridSites {
            fine: window,
            coarse,
            neighbors: GridNeighbors::new(own, width),
            parents: coarser.map_or_else(Vec::new, |coarser| self.parents(coarser)),
            areas: vec![1.0; self.sites() as usize],
        }
    }

    fn site_grid(self) -> SiteGrid {
        SiteGrid {
            width: self.width,
            height: self.height,
            toroidal: self.toroidal,
        }
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
    use crate::sites::level::{SampleLocation, Sites};
    use crate::sites::target::Target;
    use crate::synthesis::state::first_guess;

    fn target(width: u32, height: u32, toroidal: bool) -> SiteGrid {
        SiteGrid {
            width,
            height,
            toroidal,
        }
    }

    #[test]
    fn a_grid_is_asked_for_as_an_image_size() {
        assert_eq!("256x128".parse(), Ok(target(256, 128, true)));
        for wrong in ["256", "0x4", "ax4", "4x-1", ""] {
            assert!(wrong.parse::<SiteGrid>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn neighbours_and_samples_lie_where_they_say() {
        let hierarchy = target(6, 5, true)
            .hierarchy(&[Neighborhood::square(3, 0)])
            .unwrap();
        let level = &hierarchy.levels[0];
        assert_eq!(level.neighbors(5).count(), 8);
        let expected = [28, 29, 24, 4, 5, 0, 10, 11, 6].map(SampleLocation::AtSite);
        assert!(level.samples(5).eq(expected));
    }

    #[test]
    fn off_an_open_grid_samples_are_outside() {
        let hierarchy = target(6, 5, false)
            .hierarchy(&[Neighborhood::square(3, 0)])
            .unwrap();
        let level = &hierarchy.levels[0];
        let outside = level
            .fine
            .of_site(0)
            .filter(|&sample| sample == SampleLocation::Outside);
        assert_eq!((outside.count(), level.neighbors(0).count()), (5, 3));
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
        let neighborhoods = [Neighborhood::square(5, 3), Neighborhood::square(5, 0)];
        let message = |grid: SiteGrid| grid.hierarchy(&neighborhoods).unwrap_err().to_string();
        assert!(message(target(8, 8, true)).contains("level 1 is 4x4, smaller"));
        assert!(message(target(13, 16, true)).contains("divisible"));
        assert!(message(target(1 << 20, 1 << 20, true)).contains("1 to 67108864 sites"));
        assert!(message(target(0, 8, true)).contains("0x8; expected 1 to"));
        assert!(message(target(8, 0, false)).contains("8x0; expected 1 to"));
        assert!(target(13, 16, false).hierarchy(&neighborhoods).is_ok());
    }

    #[test]
    fn numbers_of_levels_that_cannot_be_are_refused() {
        let grid = target(64, 64, true);
        let none = grid.hierarchy(&[]).unwrap_err().to_string();
        assert!(none.contains("--levels: 0; expected 1 to 12"), "{none}");
        for levels in [0, 13, 64, usize::MAX] {
            let refused = grid.round_hierarchy(1, levels).unwrap_err().to_string();
            assert!(refused.contains("expected 1 to 12"), "{refused}");
        }
        let wide = grid.round_hierarchy(u32::MAX, 12).unwrap_err().to_string();
        assert!(wide.contains("or fewer --rings or --levels"), "{wide}");
    }

    #[test]
    fn a_grid_without_sites_is_no_target() {
        for (width, height) in [(0, 0), (0, 4), (4, 0)] {
            let grid = target(width, height, false);
            assert!(Target::grid(grid, &[]).is_err());
            let square = Neighborhood::square(3, 0);
            assert!(Target::round_grid(grid, (1, 1), square).is_err());
        }
    }
}
