//! Sampling in the stars of a control mesh (Ying 2001 §4.2): the control faces round the control vertex nearest
//! to a texel are flattened, and the pattern is laid there through the Jacobian of the texel's triangle.
//!
//! Samples beyond those faces, and all samples round a vertex without a star, are reached along straight paths.

use glam::{Vec2, Vec3};

use super::collecting::{LevelSamples, Window, site_by_site};
use super::drawing::Drawing;
use super::face_surface::FaceSurface;
use super::geometry::Geometry;
use super::level_cells::LevelCells;
use super::paths::Paths;
use super::texels::LevelTexels;
use crate::error::Result;
use crate::mesh::subdivision::{Star, StarPoint};
use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// The corners of a cell, columns and rows from its first.
const CELL: [[u32; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];
/// The corners of both halves of a cell.
const HALVES: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// The samples of a window at every site of a level.
pub fn sample(
    surface: &FaceSurface,
    (geometry, marched): (&Geometry<'_>, &TriangleMesh),
    (level, cells): (&LevelTexels, &LevelCells<'_>),
    window: Window<'_>,
    progress: Progress<'_>,
) -> Result<LevelSamples> {
    site_by_site((level, cells), window, progress, |site, out| {
        let paths = Paths::new((geometry, marched), level, site);
        let chart = StarChart::new(surface, (geometry, level), site);
        let mut marched = 0;
        let offsets = window.template.positions.iter();
        let points = offsets.map(|&offset| {
            let found = chart.as_ref().and_then(|chart| chart.find(offset));
            found.or_else(|| {
                marched += 1;
                paths.end(offset)
            })
        });
        out.take((level, cells), window, site, points);
        out.count_marched(marched);
    })
}

/// The star round the control vertex nearest to a site, laid on the template's plane.
struct StarChart<'a> {
    surface: &'a FaceSurface,
    star: &'a Star,
    /// Per face of the star 4 · control face + the corner that stands on the centre.
    fan: &'a [u32],
    drawing: Drawing,
}

impl<'a> StarChart<'a> {
    /// `None` where the vertex has no star, or the chart folds at the site.
    fn new(
        surface: &'a FaceSurface,
        (geometry, level): (&Geometry<'_>, &LevelTexels),
        site: usize,
    ) -> Option<Self> {
        let point = level.point(geometry, site);
        let (face, cell) = surface.refinement.place_of(point.triangle / 2);
        let half = point.triangle as usize % 2;
        let corner = nearest_corner(surface, cell, half, point.weights);
        let vertex = surface.refinement.control().quads[face as usize][corner as usize];
        let star = surface.star(vertex)?;
        let place = surface.fans.places[(4 * face + corner) as usize] as usize;
        let corners = HALVES[half].map(|of| {
            let [right, up] = CELL[of];
            let vertex = [cell[0] + right, cell[1] + up];
            star.place(place, corner, vertex).as_vec2()
        });
        Some(Self {
            surface,
            star,
            fan: surface.fans.corners.row(vertex as usize),
            drawing: Drawing::new(geometry, level, site, corners)?,
        })
    }

    /// The surface point of a sample; `None` beyond the faces of the star.
    fn find(&self, offset: Vec2) -> Option<SurfacePoint> {
        let at = self.drawing.centre + self.drawing.chart_from_texels * offset;
        let found = self.star.locate(at.as_dvec2(), |face| self.fan[face] % 4)?;
        Some(self.on_surface(&found))
    }

    fn on_surface(&self, found: &StarPoint) -> SurfacePoint {
        let face = self.fan[found.face] / 4;
        let cell = self.surface.refinement.cell(face, found.cell);
        let triangle = 2 * cell + found.half as u32;
        let corners = self.surface.user.mesh.corners(triangle as usize);
        SurfacePoint {
            triangle,
            weights: found.weights,
            position: (0..3).map(|k| corners[k] * found.weights[k]).sum::<Vec3>(),
        }
    }
}

/// The corner of a control face in whose quarter a place lies: in a half of a cell, by the weights of its
/// corners.
fn nearest_corner(surface: &FaceSurface, cell: [u32; 2], half: usize, weights: [f32; 3]) -> u32 {
    let share: Vec2 = (0..3)
        .map(|k| {
            let [right, up] = CELL[HALVES[half][k]];
            Vec2::new(right as f32, up as f32) * weights[k]
        })
        .sum();
    let place = Vec2::new(cell[0] as f32, cell[1] as f32) + share;
    let middle = surface.refinement.cells_per_side() as f32 / 2.0;
    match [place.x < middle, place.y < middle] {
        [true, true] => 0,
        [false, true] => 1,
        [false, false] => 2,
        [true, false] => 3,
    }
}
