//! The charts of a mesh's texture coordinates, checked. Coordinates are OBJ's: u to the right, v up, both
//! from 0 to 1.

use glam::{DMat2, DVec2, DVec3, Vec2};

use super::overlap;
use crate::error::{Error, Result};
use crate::mesh::surface_bvh::SurfacePoint;
use crate::mesh::texture_charts::TextureCharts;
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A texture coordinate this little outside the unit square is taken to be on its border.
const BORDER_SLACK: f32 = 1e-5;
/// A triangle whose height in the texture is no more than this has no area: half a step of 32-bit floating
/// point below 1.
const LEAST_HEIGHT: f64 = 3e-8;

/// Texture coordinates of a mesh, cut into charts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Atlas {
    /// Texture coordinates of each triangle's corners, v up, from 0 to 1.
    pub corner_uvs: Vec<[Vec2; 3]>,
    /// The chart of each triangle, numbered from 0 in the order of their first triangles.
    pub chart_of: Vec<u32>,
    /// How many charts there are.
    pub charts: usize,
}

impl Atlas {
    /// The charts of a mesh's own texture coordinates.
    ///
    /// Refuses missing ones, ones outside the unit square, triangles without area in the texture, and
    /// triangles that overlap there; the error names the first such triangle.
    pub fn of_uvs(mesh: &TriangleMesh, corner_uvs: &[[Vec2; 3]]) -> Result<Self> {
        if corner_uvs.len() != mesh.triangles.len() {
            let found = format!("{} triangles", corner_uvs.len());
            return Err(Error::data("texture coordinates", found).expected(format!(
                "{}, one for each of the mesh",
                mesh.triangles.len()
            )));
        }
        let corner_uvs = corner_uvs
            .iter()
            .enumerate()
            .map(|(triangle, uvs)| check_triangle(mesh, triangle, uvs))
            .collect::<Result<Vec<_>>>()?;
        if let Some([first, second]) = overlap::first_overlap(&corner_uvs) {
            let found = format!(
                "lies over triangle {first} in the texture ({} and {})",
                corners_of(mesh, second),
                corners_of(mesh, first)
            );
            return Err(Error::data(format!("triangle {second}"), found)
                .expected("texture coordinates that do not overlap")
                .advice(ADVICE));
        }
        let charts = TextureCharts::new(&mesh.triangles, &corner_uvs).charts;
        Ok(Self::of_labels(corner_uvs, &charts))
    }

    /// An atlas of checked coordinates; triangles with the same label are a chart.
    pub(super) fn of_labels(corner_uvs: Vec<[Vec2; 3]>, labels: &[u32]) -> Self {
        let most = labels.iter().max().map_or(0, |&most| most as usize + 1);
        let mut numbers = vec![NONE; most];
        let mut charts = 0;
        let number = |&label: &u32| {
            let number = &mut numbers[label as usize];
            if *number == NONE {
                *number = charts;
                charts += 1;
            }
            *number
        };
        let chart_of = labels.iter().map(number).collect();
        Self {
            corner_uvs,
            chart_of,
            charts: charts as usize,
        }
    }

    /// The corners of a triangle in the texture.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [DVec2; 3] {
        self.corner_uvs[triangle].map(|uv| uv.as_dvec2())
    }

    /// Where a surface point lies in the texture.
    #[inline]
    pub fn uv(&self, point: &SurfacePoint) -> DVec2 {
        let [a, b, c] = self.corners(point.triangle as usize);
        let [x, y, z] = point.weights.map(f64::from);
        a * x + b * y + c * z
    }

    /// How far a triangle's surface moves when u and when v grow by 1, in mesh units; zeros for a triangle
    /// without area in the texture.
    pub fn jacobian(&self, mesh: &TriangleMesh, triangle: usize) -> [DVec3; 2] {
        let [a, b, c] = self.corners(triangle);
        let [p, q, r] = mesh.corners(triangle).map(|corner| corner.as_dvec3());
        let matrix = DMat2::from_cols(b - a, c - a);
        if matrix.determinant() == 0.0 {
            return [DVec3::ZERO; 2];
        }
        let inverse = matrix.inverse();
        let along = |column: DVec2| (q - p) * column.x + (r - p) * column.y;
        [along(inverse.x_axis), along(inverse.y_axis)]
    }
}

/// What to do about texture coordinates that cannot be used.
const ADVICE: &str = "--unwrap makes new texture coordinates";

fn corners_of(mesh: &TriangleMesh, triangle: u32) -> String {
    let [a, b, c] = mesh.triangles[triangle as usize];
    format!("vertices {a}, {b}, {c}")
}

/// The texture coordinates of one triangle, refused where they cannot be used.
fn check_triangle(mesh: &TriangleMesh, triangle: usize, uvs: &[Vec2; 3]) -> Result<[Vec2; 3]> {
    let fault = |found: &str, expected: &str| {
        let found = format!("{found} ({})", corners_of(mesh, triangle as u32));
        Err(Error::data(format!("triangle {triangle}"), found)
            .expected(expected)
            .advice(ADVICE))
    };
    if uvs.iter().any(|uv| !uv.is_finite()) {
        return fault("no texture coordinates", "some at each corner");
    }
    let clamped = uvs.map(|uv| uv.clamp(Vec2::ZERO, Vec2::ONE));
    for (uv, clamped) in uvs.iter().zip(clamped) {
        if (uv - clamped).abs().max_element() > BORDER_SLACK {
            let found = format!("texture coordinate ({}, {})", uv.x, uv.y);
            return fault(&found, "0 to 1: no tiles and no repeats");
        }
    }
    if !has_area(&clamped) {
        return fault("no area in the texture", "an area above 0");
    }
    Ok(clamped)
}

/// Whether a triangle has an area in the texture.
fn has_area(uvs: &[Vec2; 3]) -> bool {
    let [a, b, c] = uvs.map(|uv| uv.as_dvec2());
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    (b - a).perp_dot(c - a).abs() > LEAST_HEIGHT * longest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// A grid in the unit square whose texture coordinates are its positions.
    fn flat(side: u32) -> (TriangleMesh, Vec<[Vec2; 3]>) {
        let mesh = shapes::grid(side, side, 1.0 / side as f32);
        let uvs = (0..mesh.triangles.len())
            .map(|t| mesh.corners(t).map(|corner| corner.truncate()))
            .collect();
        (mesh, uvs)
    }

    #[test]
    fn a_flat_grid_is_one_chart_with_its_own_jacobian() {
        let (mesh, uvs) = flat(4);
        let atlas = Atlas::of_uvs(&mesh, &uvs).unwrap();
        assert_eq!((atlas.charts, atlas.chart_of.len()), (1, 32));
        let [along_u, along_v] = atlas.jacobian(&mesh, 5);
        assert!((along_u - DVec3::X).length() < 1e-6 && (along_v - DVec3::Y).length() < 1e-6);
    }

    #[test]
    fn what_cannot_be_an_atlas_is_refused_by_its_triangle() {
        let (mesh, uvs) = flat(2);
        let refused = |change: &dyn Fn(&mut Vec<[Vec2; 3]>)| {
            let mut uvs = uvs.clone();
            change(&mut uvs);
            Atlas::of_uvs(&mesh, &uvs).unwrap_err().to_string()
        };
        let text = refused(&|uvs| uvs[3][1] = Vec2::NAN);
        assert!(text.contains("triangle 3: no texture"), "{text}");
        let text = refused(&|uvs| uvs[5][0].x = 1.5);
        assert!(
            text.contains("triangle 5") && text.contains("1.5"),
            "{text}"
        );
        let text = refused(&|uvs| uvs[4] = [Vec2::ZERO, Vec2::X, Vec2::X * 0.5]);
        assert!(
            text.contains("triangle 4") && text.contains("no area"),
            "{text}"
        );
        let text = refused(&|uvs| uvs[6] = uvs[1]);
        assert!(text.contains("triangle 6: lies over triangle 1"), "{text}");
        assert!(text.contains("--unwrap"), "{text}");
        let text = refused(&|uvs| uvs.truncate(7));
        assert!(text.contains("7 triangles"), "{text}");
    }

    #[test]
    fn seams_part_charts_in_the_order_of_their_triangles() {
        let (mesh, mut uvs) = flat(2);
        for uvs in &mut uvs {
            *uvs = uvs.map(|uv| uv * 0.4);
        }
        for triangle in [2, 3] {
            uvs[triangle] = uvs[triangle].map(|uv| uv + 0.5);
        }
        let atlas = Atlas::of_uvs(&mesh, &uvs).unwrap();
        assert_eq!(
            (atlas.charts, &atlas.chart_of[..5]),
            (2, &[0, 0, 1, 1, 0][..])
        );
    }
}
