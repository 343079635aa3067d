//! Which texels the triangles of an atlas cover.

use glam::DVec2;

use super::charts::Atlas;
use super::stray_charts;
use super::texel_points::{MOST_TEXELS, TexelPoints};
use crate::error::{Error, Result};
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;

impl TexelPoints {
    /// The texels of an image of the finest level.
    ///
    /// A chart that contains no texel's centre gets the texel nearest its own centre. Refuses a resolution
    /// at which charts touch: one texel in two charts, or two charts' texels side by side.
    pub fn new(mesh: &TriangleMesh, atlas: &Atlas, width: u32, height: u32) -> Result<Self> {
        let (mut points, shared) = Self::covered(mesh, atlas, width, height)?;
        if let Some((texel, triangle)) = shared {
            let charts = [points.triangle[texel], triangle].map(|t| atlas.chart_of[t as usize]);
            return Err(points.touching(texel, charts));
        }
        for stray in stray_charts::find(mesh, atlas, &points) {
            let texel = stray.nearest_texel(&points);
            if let Some(chart) = points.chart(atlas, texel) {
                return Err(points.touching(texel, [chart, stray.chart]));
            }
            points.set(texel, &stray.point_at(atlas, mesh, &points, texel));
        }
        match points.first_neighbors_of_two_charts(atlas) {
            Some((texel, charts)) => Err(points.touching(texel, charts)),
            None => Ok(points),
        }
    }

    /// The texels of an image of a coarser level: charts may touch, and one that contains no texel's centre
    /// gets the free texel nearest its own centre.
    ///
    /// Refuses an image with fewer texels than are needed.
    pub fn coarse(mesh: &TriangleMesh, atlas: &Atlas, width: u32, height: u32) -> Result<Self> {
        let (mut points, _) = Self::covered(mesh, atlas, width, height)?;
        for stray in stray_charts::find(mesh, atlas, &points) {
            let Some(texel) = stray.nearest_free_texel(&points) else {
                return Err(Error::option(
                    "levels",
                    format!(
                        "a level of {width}x{height} texels for {} charts",
                        atlas.charts
                    ),
                    "fewer levels, or a higher --resolution",
                ));
            };
            points.set(texel, &stray.point_at(atlas, mesh, &points, texel));
        }
        Ok(points)
    }

    /// The texels whose centres lie in triangles, and the first texel, with the second triangle, that lies
    /// in two charts. Of several triangles that hold a centre the first has it.
    fn covered(
        mesh: &TriangleMesh,
        atlas: &Atlas,
        width: u32,
        height: u32,
    ) -> Result<(Self, Option<(usize, u32)>)> {
        // Check the size.
        let texels = u64::from(width) * u64::from(height);
        if !(1..=MOST_TEXELS).contains(&texels) {
            return Err(Error::option(
                "resolution",
                format!("{width}x{height}"),
                format!("1 to {MOST_TEXELS} texels"),
            ));
        }
        // Cover the texels, triangle by triangle; the first triangle keeps a texel.
        let mut points = Self {
            width,
            height,
            triangle: vec![NONE; texels as usize],
            weights: vec![[0.0; 3]; texels as usize],
        };
        let mut shared: Option<(usize, u32)> = None;
        for triangle in 0..mesh.triangles.len() {
            let chart = atlas.chart_of[triangle];
            points.cover(
                atlas.corners(triangle),
                |points, texel, weights| match points.triangle[texel] {
                    NONE => {
                        points.triangle[texel] = triangle as u32;
                        points.weights[texel] = weights;
                    }
                    other if atlas.chart_of[other as usize] != chart => {
                        shared.get_or_insert((texel, triangle as u32));
                    }
                    _ => {}
                },
            );
        }
        Ok((points, shared))
    }

    /// Visits every texel whose centre lies in a triangle of the texture, its edges included.
    fn cover(&mut self, corners: [DVec2; 3], mut visit: impl FnMut(&mut Self, usize, [f32; 3])) {
        let [a, b, c] = corners;
        let doubled = (b - a).perp_dot(c - a);
        if doubled == 0.0 {
            return;
        }
        // Rows and columns in which the triangle lies, and one more on each side against rounding.
        let places = corners.map(|corner| self.place(corner));
        let rows = range(places.iter().map(|place| place.y), self.height);
        for row in rows {
            let Some(columns) = columns_in_row(&places, f64::from(row), self.width) else {
                continue;
            };
            for column in columns {
                let centre = self.centre_of(row, column);
                let weights =
                    [(b, c), (c, a), (a, b)].map(|(from, to)| side(from, to, centre) / doubled);
                if weights.iter().all(|&weight| weight >= 0.0) {
                    let texel = row as usize * self.width as usize + column as usize;
                    visit(self, texel, weights.map(|weight| weight as f32));
                }
            }
        }
    }

    /// The first texel beside or above one of another chart, and both charts.
    fn first_neighbors_of_two_charts(&self, atlas: &Atlas) -> Option<(usize, [u32; 2])> {
        let width = self.width as usize;
        (0..self.triangle.len()).find_map(|texel| {
            let own = self.chart(atlas, texel)?;
            let right = (!(texel + 1).is_multiple_of(width)).then_some(texel + 1);
            let below = (texel + width < self.triangle.len()).then_some(texel + width);
            let mut others = [right, below].into_iter().flatten();
            others.find_map(|other| {
                let other = self.chart(atlas, other)?;
                (other != own).then_some((texel, [own, other]))
            })
        })
    }

    fn touching(&self, texel: usize, [a, b]: [u32; 2]) -> Error {
        let (row, column) = (texel / self.width as usize, texel % self.width as usize);
        Error::data(
            "texture coordinates",
            format!(
                "charts {a} and {b} touch at row {row}, column {column} of {}x{} texels",
                self.width, self.height
            ),
        )
        .expected("a texel of no chart between two charts")
        .advice("a higher --resolution, or --unwrap")
    }
}

/// Twice the signed area of a point seen from an edge: exactly the negative for the edge's other direction,
/// so that no point falls between two triangles.
#[inline]
fn side(from: DVec2, to: DVec2, point: DVec2) -> f64 {
    match (from.x, from.y) <= (to.x, to.y) {
        true => (to - from).perp_dot(point - from),
        false => -(from - to).perp_dot(point - to),
    }
}

/// The whole numbers below `end` from the least to the greatest value, and one more on each side.
fn range(values: impl Iterator<Item = f64> + Clone, end: u32) -> std::ops::Range<u32> {
    let least = values.clone().fold(f64::INFINITY, f64::min);
    let most = values.fold(f64::NEG_INFINITY, f64::max);
    let from = (least - 1.0).max(0.0) as u32;
    from..((most + 2.0).max(0.0) as u32).min(end)
}

/// The columns that a triangle may cover in a row.
fn columns_in_row(places: &[DVec2; 3], row: f64, width: u32) -> Option<std::ops::Range<u32>> {
    const SLACK: f64 = 1e-6;
    let crossings = (0..3).flat_map(|k| {
        let (from, to) = (places[k], places[(k + 1) % 3]);
        let share = (row - from.y) / (to.y - from.y);
        let crossing = (0.0..=1.0)
            .contains(&share)
            .then_some(from.x + share * (to.x - from.x));
        // Corners on the row, and edges along it.
        let corner = ((from.y - row).abs() <= SLACK).then_some(from.x);
        [crossing, corner].into_iter().flatten()
    });
    crossings.clone().next()?;
    Some(range(crossings, width))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use glam::{Vec2, Vec3};

    /// A grid whose texture coordinates are its positions, moved and scaled.
    fn flat(side: u32, scale: f32, at: Vec2) -> (TriangleMesh, Atlas) {
        let mesh = shapes::grid(side, side, 1.0 / side as f32);
        let uvs: Vec<_> = (0..mesh.triangles.len())
            .map(|t| mesh.corners(t).map(|corner| at + corner.truncate() * scale))
            .collect();
        let atlas = Atlas::of_uvs(&mesh, &uvs).unwrap();
        (mesh, atlas)
    }

    #[test]
    fn every_texel_of_the_unit_square_lies_at_its_centre() {
        for (side, width, height) in [(3, 8, 8), (4, 16, 8), (7, 10, 13)] {
            let (mesh, atlas) = flat(side, 1.0, Vec2::ZERO);
            let points = TexelPoints::new(&mesh, &atlas, width, height).unwrap();
            assert_eq!(points.inside(), (width * height) as usize);
            for texel in 0..points.triangle.len() {
                let point = points.surface_point(&mesh, texel);
                let centre = points.centre(texel).as_vec2();
                assert!((point.position.truncate() - centre).length() < 1e-6);
                assert!(point.weights.iter().all(|&weight| weight >= 0.0));
                assert!(
                    (points.place(atlas.uv(&point)) - points.place(centre.as_dvec2())).length()
                        < 1e-4
                );
            }
        }
    }

    #[test]
    fn only_centres_inside_the_chart_are_covered() {
        let (mesh, atlas) = flat(2, 0.5, Vec2::splat(0.25));
        let points = TexelPoints::new(&mesh, &atlas, 8, 8).unwrap();
        for texel in 0..64 {
            let inside = (2..6).contains(&(texel / 8)) && (2..6).contains(&(texel % 8));
            assert_eq!(points.chart(&atlas, texel).is_some(), inside, "{texel}");
        }
    }

    /// Two squares of 0.3 beside each other, `gap` apart.
    fn two_charts(gap: f32) -> (TriangleMesh, Atlas) {
        let mut mesh = shapes::grid(1, 1, 1.0);
        let other = shapes::grid(1, 1, 1.0);
        mesh.positions
            .extend(other.positions.iter().map(|&p| p + Vec3::Z));
        mesh.triangles
            .extend(other.triangles.iter().map(|t| t.map(|v| v + 4)));
        let uvs: Vec<_> = (0..4)
            .map(|t| {
                let at = Vec2::new(0.1 + if t < 2 { 0.0 } else { 0.3 + gap }, 0.1);
                mesh.corners(t).map(|corner| at + 0.3 * corner.truncate())
            })
            .collect();
        let atlas = Atlas::of_uvs(&mesh, &uvs).unwrap();
        (mesh, atlas)
    }

    #[test]
    fn charts_that_touch_are_refused() {
        let (mesh, atlas) = two_charts(0.1);
        assert_eq!(atlas.charts, 2);
        assert!(TexelPoints::new(&mesh, &atlas, 20, 20).is_ok());
        let error = TexelPoints::new(&mesh, &atlas, 5, 5)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("touch") && error.contains("--resolution"),
            "{error}"
        );
        let (mesh, atlas) = two_charts(0.0);
        assert!(TexelPoints::new(&mesh, &atlas, 20, 20).is_err());
        assert!(TexelPoints::coarse(&mesh, &atlas, 20, 20).is_ok());
        let error = TexelPoints::new(&mesh, &atlas, 1 << 20, 1 << 20).unwrap_err();
        assert!(error.to_string().contains("--resolution"));
    }

    #[test]
    fn a_chart_without_a_texel_centre_gets_one() {
        let (mesh, atlas) = flat(2, 0.01, Vec2::new(0.3, 0.6));
        let points = TexelPoints::new(&mesh, &atlas, 8, 8).unwrap();
        // (0.305, 0.605) lies in row 3, column 2.
        assert_eq!((points.inside(), points.triangle[26] == NONE), (1, false));
        let point = points.surface_point(&mesh, 26);
        // The nearest corner to the texel's centre (0.3125, 0.5625) is the lower right one.
        assert!((point.position - Vec3::X).length() < 1e-4, "{point:?}");
        let (mesh, atlas) = two_charts(0.1);
        for (width, height) in [(2, 1), (1, 2)] {
            let points = TexelPoints::coarse(&mesh, &atlas, width, height).unwrap();
            assert_eq!(points.inside(), 2);
        }
        let error = TexelPoints::coarse(&mesh, &atlas, 1, 1).unwrap_err();
        assert!(error.to_string().contains("--levels"));
    }
}
