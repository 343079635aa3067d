//! The cells of a level: for every block of 2 × 2 texels and every chart with a texel in it, the four sites
//! that a point of that chart blends there.
//!
//! A texel of the block that is not of the chart stands for the texel across the chart's border, found along
//! the surface; where the surface ends, for the nearest texel of the block that is of the chart.

use std::sync::Arc;

use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::cells::{CellSample, bilinear};
use super::geometry::Geometry;
use super::texels::LevelTexels;
use crate::error::Result;
use crate::mesh::atlas::Across;
use crate::mesh::surface_bvh::SurfacePoint;
use crate::progress::Progress;

/// A place this near a cell's corner, in texels, is the corner: more than rounding moves it.
const SNAP: f64 = 2e-3;
/// A place in a cell whose blended position is as near as this to the sample's, as a share of the cell's
/// diagonal, is good enough.
const CLOSE: f32 = 0.01;
/// Steps of Newton's method to a place in a cell that is no square.
const NEWTON_STEPS: usize = 6;

/// The texels of a block: rows and columns from its first.
const BLOCK: [[i64; 2]; 4] = [[0, 0], [0, 1], [1, 0], [1, 1]];

/// Per corner of a block, from which others it is looked for if it is not of the chart.
const FROM: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 3, 1], [1, 2, 0]];

/// The cells of one level, found by block and chart.
pub struct LevelCells<'a> {
    geometry: &'a Geometry<'a>,
    level: &'a LevelTexels,
    across: Across<'a>,
    /// Where the cells of each block begin; blocks row by row, from one above and left of texel (0, 0).
    starts: Vec<u32>,
    /// The chart of each cell.
    charts: Vec<u32>,
    /// Whether texels of the cell's block are not of its chart.
    on_border: Vec<bool>,
    /// The sites of each cell.
    cells: Arc<Vec<[u32; 4]>>,
}

/// A cell while it is made.
struct Cell {
    chart: u32,
    on_border: bool,
    sites: [u32; 4],
}

impl<'a> LevelCells<'a> {
    /// The cells of a level.
    pub fn new(
        geometry: &'a Geometry<'a>,
        level: &'a LevelTexels,
        progress: Progress<'_>,
    ) -> Result<Self> {
        progress.check()?;
        // Find which texels continue each other across charts.
        let across = Across::new(
            &level.points,
            geometry.atlas,
            geometry.mesh,
            &geometry.topology,
        );
        let mut of_level = Self {
            geometry,
            level,
            across,
            starts: vec![0],
            charts: Vec::new(),
            on_border: Vec::new(),
            cells: Arc::default(),
        };
        // List the cells, row by row.
        let (height, width) = (
            i64::from(level.points.height),
            i64::from(level.points.width),
        );
        let rows: Vec<(Vec<u32>, Vec<Cell>)> = (-1..height)
            .into_par_iter()
            .map(|row| {
                progress.check()?;
                let (mut ends, mut cells) = (Vec::with_capacity(width as usize + 1), Vec::new());
                for column in -1..width {
                    of_level.add_block([row, column], &mut cells);
                    ends.push(cells.len() as u32);
                }
                Ok((ends, cells))
            })
            .collect::<Result<_>>()?;
        // Join the rows.
        let mut sites = Vec::new();
        for (ends, cells) in rows {
            let base = sites.len() as u32;
            of_level.starts.extend(ends.iter().map(|end| base + end));
            for cell in cells {
                of_level.charts.push(cell.chart);
                of_level.on_border.push(cell.on_border);
                sites.push(cell.sites);
            }
        }
        of_level.cells = Arc::new(sites);
        Ok(of_level)
    }

    /// The sites of each cell.
    pub fn cells(&self) -> &Arc<Vec<[u32; 4]>> {
        &self.cells
    }

    /// The cells of one block, one per chart with a texel in it.
    fn add_block(&self, [row, column]: [i64; 2], cells: &mut Vec<Cell>) {
        let points = &self.level.points;
        let texels = BLOCK.map(|[down, right]| points.texel_at(row + down, column + right));
        let charts = texels.map(|texel| points.chart(self.geometry.atlas, texel?));
        for first in 0..4 {
            let Some(chart) = charts[first].filter(|_| !charts[..first].contains(&charts[first]))
            else {
                continue;
            };
            let of_chart = charts.map(|other| other == Some(chart));
            let site = |corner: usize| match texels[corner].filter(|_| of_chart[corner]) {
                Some(texel) => self.level.sites[texel],
                None => self.site_beyond([row, column], corner, of_chart, texels),
            };
            cells.push(Cell {
                chart,
                on_border: of_chart.contains(&false),
                sites: std::array::from_fn(site),
            });
        }
    }

    /// The site that stands for a corner of a block which is not of the block's chart.
    fn site_beyond(
        &self,
        [row, column]: [i64; 2],
        corner: usize,
        of_chart: [bool; 4],
        texels: [Option<usize>; 4],
    ) -> u32 {
        let from = FROM[corner].into_iter().find(|&other| of_chart[other]);
        let Some(from) = from.and_then(|from| texels[from]) else {
            return 0;
        };
        let [down, right] = BLOCK[corner];
        let points = &self.level.points;
        let centre = DVec2::new(
            ((column + right) as f64 + 0.5) / f64::from(points.width),
            1.0 - ((row + down) as f64 + 0.5) / f64::from(points.height),
        );
        let start = points.surface_point(self.geometry.mesh, from);
        let beyond = self.across.beyond(&start, centre);
        let texel = beyond.and_then(|point| self.across.nearest_texel(&point));
        self.level.sites[texel.unwrap_or(from)]
    }

    /// The sample at a surface point.
    pub fn sample(&self, point: &SurfacePoint) -> CellSample {
        let place = self.level.points.place(self.geometry.atlas.uv(point));
        let chart = self.geometry.atlas.chart_of[point.triangle as usize];
        let Some(cell) = self.cell_at(place, chart) else {
            // A part of the chart between texels' centres.
            let nearest = self.across.nearest_texel(point);
            return nearest.map_or(CellSample::OUTSIDE, |texel| {
                self.at_site(self.level.sites[texel] as usize)
            });
        };
        let flat = place - place.floor();
        let place = self.place_in_cell(cell, point.position, flat);
        CellSample::new(cell as u32, place.to_array().map(snapped))
    }

    /// The sample on a site.
    pub fn at_site(&self, site: usize) -> CellSample {
        self.cell_from(site).map_or(CellSample::OUTSIDE, |cell| {
            CellSample::new(cell as u32, [0.0; 2])
        })
    }

    /// A site, those to its right and below it, and the one opposite, across borders too; the site itself
    /// where the surface ends.
    pub fn sites_from(&self, site: usize) -> [u32; 4] {
        let cell = self.cell_from(site);
        cell.map_or([site as u32; 4], |cell| self.cells[cell])
    }

    /// The cell of which a site is the first.
    fn cell_from(&self, site: usize) -> Option<usize> {
        let texel = self.level.texels[site];
        let width = self.level.points.width;
        let place = DVec2::new(f64::from(texel % width), f64::from(texel / width));
        self.cell_at(place, self.level.chart(self.geometry, site))
    }

    /// The cell of a chart at a place in texels; `None` where the block has no texel of the chart.
    fn cell_at(&self, place: DVec2, chart: u32) -> Option<usize> {
        let points = &self.level.points;
        let block = |at: f64, end: u32| (at.floor() as i64).clamp(-1, i64::from(end) - 1) + 1;
        let (row, column) = (block(place.y, points.height), block(place.x, points.width));
        let block = (row * (i64::from(points.width) + 1) + column) as usize;
        let mut cells = self.starts[block] as usize..self.starts[block + 1] as usize;
        cells.find(|&cell| self.charts[cell] == chart)
    }

    /// The place in a cell that blends its sites' positions to a point as nearly as can be, from that in the
    /// texture on. They differ where texels across a border do not lie on a square grid with the others, and
    /// where the texture is bent within the cell.
    fn place_in_cell(&self, cell: usize, point: Vec3, in_texture: DVec2) -> DVec2 {
        let corners = self.cells[cell].map(|site| self.level.positions[site as usize]);
        let apart = |place: Vec2| -> Vec3 {
            let weights = bilinear(place.to_array());
            (0..4).map(|k| (corners[k] - point) * weights[k]).sum()
        };
        let mut place = in_texture.as_vec2();
        let (mut best, mut least) = (in_texture, apart(place).length_squared());
        let size = corners[0].distance_squared(corners[3]);
        if !self.on_border[cell] && least <= CLOSE * CLOSE * size {
            return in_texture;
        }
        for _ in 0..NEWTON_STEPS {
            place = newton_step(&corners, place, apart(place)).clamp(Vec2::ZERO, Vec2::ONE);
            let distance = apart(place).length_squared();
            if distance < least {
                (best, least) = (place.as_dvec2(), distance);
            }
        }
        best
    }
}

/// One step of Gauss and Newton towards the place where the blended corners meet a point; `apart` is what they
/// are from it. Corners that fall together leave the place as it is along their side.
fn newton_step(corners: &[Vec3; 4], place: Vec2, apart: Vec3) -> Vec2 {
    let [a, b, c, d] = corners.map(|corner| corner.as_dvec3());
    let (x, y) = (f64::from(place.x), f64::from(place.y));
    let along: [DVec3; 2] = [
        (b - a) * (1.0 - y) + (d - c) * y,
        (c - a) * (1.0 - x) + (d - b) * x,
    ];
    let apart = apart.as_dvec3();
    let damping = 1e-6 * (along[0].length_squared() + along[1].length_squared());
    let cross = along[0].dot(along[1]);
    let normal = DMat2::from_cols(
        DVec2::new(along[0].length_squared() + damping, cross),
        DVec2::new(cross, along[1].length_squared() + damping),
    );
    if normal.determinant() <= 0.0 {
        return place;
    }
    let step = normal.inverse() * DVec2::new(along[0].dot(apart), along[1].dot(apart));
    (DVec2::new(x, y) - step).as_vec2()
}

fn snapped(part: f64) -> f64 {
    match part {
        part if part < SNAP => 0.0,
        part if part > 1.0 - SNAP => 1.0,
        part => part,
    }
}
