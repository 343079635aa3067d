//! The properties of a mesh, transferred to its retiling: texture coordinates, orientations, scales and rotations.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::mesh::reading::UserMesh;
use crate::mesh::retile::{edge_length, retile_along};
use crate::mesh::surface_bvh::{SurfaceBvh, SurfacePoint};
use crate::mesh::texture_charts::TextureCharts;
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// Most vertices on the seams of a texture, as a share of all: more would leave the rest uneven.
const MOST_ON_SEAMS: f64 = 0.5;

/// What became of a mesh's texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Carried {
    /// There were none.
    Nothing,
    /// All charts were carried.
    Charts(usize),
    /// Lost: their seams alone would take too many of the vertices.
    Lost {
        /// How many charts there were.
        charts: usize,
        /// How many vertices their seams would take.
        vertices: usize,
    },
}

/// Retiles a mesh to `vertices` vertices with everything that it has, the seams of its texture kept;
/// `crease` in radians.
pub fn retile_with_numbers(
    model: &UserMesh,
    vertices: usize,
    crease: f64,
    progress: Progress<'_>,
) -> Result<(UserMesh, Carried)> {
    let uvs = model.corner_uvs.as_deref();
    let charts = uvs.map(|uvs| TextureCharts::new(&model.mesh.triangles, uvs));
    let mut what = Carried::Nothing;
    let charts = charts.filter(|charts| {
        let edge = edge_length(model.mesh.area(), vertices);
        let on_seams = charts.seam_length(&model.mesh) / edge;
        let fits = on_seams <= MOST_ON_SEAMS * vertices as f64;
        what = match fits {
            true => Carried::Charts(charts.count()),
            false => Carried::Lost {
                charts: charts.count(),
                vertices: on_seams as usize,
            },
        };
        fits
    });
    let seams = charts.as_ref().map_or(&[][..], |charts| &charts.seams);
    let mesh = retile_along(&model.mesh, vertices, (crease, seams), progress)?;
    Ok((carried(model, charts.as_ref(), mesh), what))
}

/// A retiled mesh with everything that its model has; normals are left to follow from the surface.
///
/// A corner's texture coordinate is that of the nearest point of the chart in which its triangle lies. At a
/// seam that the retiling did not keep, a chart ends short of the corner: the texture is stretched there.
fn carried(model: &UserMesh, charts: Option<&TextureCharts<'_>>, mesh: TriangleMesh) -> UserMesh {
    let tree = SurfaceBvh::new(&model.mesh);
    let places: Vec<Option<SurfacePoint>> = match model.has_vertex_numbers() {
        true => mesh
            .positions
            .par_iter()
            .map(|&p| tree.nearest(p))
            .collect(),
        false => Vec::new(),
    };
    let blend = Blend { model, places };
    UserMesh {
        orientation: model
            .orientation
            .as_ref()
            .map(|list| blend.directions(list)),
        scale: model.scale.as_ref().map(|list| blend.factors(list)),
        rotation: model.rotation.as_ref().map(|list| blend.degrees(list)),
        transition: model.transition.as_ref().map(|list| blend.shares(list)),
        mask: model.mask.as_ref().map(|list| blend.labels(list)),
        corner_uvs: charts.map(|charts| corner_uvs(charts, &tree, &model.mesh, &mesh)),
        from_file: (0..mesh.positions.len() as u32).collect(),
        origin: model.origin,
        mesh,
        ..UserMesh::default()
    }
}

/// Numbers of a model's vertices, blended where the new vertices lie.
struct Blend<'a> {
    model: &'a UserMesh,
    places: Vec<Option<SurfacePoint>>,
}

impl Blend<'_> {
    /// Each new vertex's corners of the model and their weights; `None` on a model without a surface.
    fn each<T>(&self, blend: impl Fn(Option<([usize; 3], [f32; 3])>) -> T) -> Vec<T> {
        let corners = |place: &SurfacePoint| {
            let corners = self.model.mesh.triangles[place.triangle as usize];
            (corners.map(|v| v as usize), place.weights)
        };
        self.places
            .iter()
            .map(|place| blend(place.as_ref().map(corners)))
            .collect()
    }

    /// Directions, 0 where there is none; they count by the weight of their corners.
    fn directions(&self, list: &[Vec3]) -> Vec<Vec3> {
        self.each(|place| {
            let Some((corners, weights)) = place else {
                return Vec3::ZERO;
            };
            let parts = corners.into_iter().zip(weights);
            let sum: Vec3 = parts
                .map(|(v, weight)| list[v].normalize_or_zero() * weight)
                .sum();
            sum.normalize_or_zero()
        })
    }

    /// Factors above 0, by their logarithms.
    fn factors(&self, list: &[f32]) -> Vec<f32> {
        self.each(|place| {
            let Some((corners, weights)) = place else {
                return 1.0;
            };
            let parts = corners.into_iter().zip(weights);
            parts
                .map(|(v, weight)| list[v].ln() * weight)
                .sum::<f32>()
                .exp()
        })
    }

    /// Shares from 0 to 1.
    fn shares(&self, list: &[f32]) -> Vec<f32> {
        self.each(|place| {
            let Some((corners, weights)) = place else {
                return 0.0;
            };
            let parts = corners.into_iter().zip(weights);
            let sum: f32 = parts.map(|(v, weight)| list[v] * weight).sum();
            sum.clamp(0.0, 1.0)
        })
    }

    /// Labels: that of the corner that weighs most.
    fn labels(&self, list: &[f32]) -> Vec<f32> {
        self.each(|place| {
            let Some((corners, weights)) = place else {
                return 0.0;
            };
            let heavier = |best: usize, at: usize| match weights[at] > weights[best] {
                true => at,
                false => best,
            };
            list[corners[(0..3).fold(0, heavier)]]
        })
    }

    /// Turns in degrees, as directions in the plane.
    fn degrees(&self, list: &[f32]) -> Vec<f32> {
        self.each(|place| {
            let Some((corners, weights)) = place else {
                return 0.0;
            };
            let parts = corners.into_iter().zip(weights);
            let sum: Vec2 = parts
                .map(|(v, weight)| Vec2::from_angle(list[v].to_radians()) * weight)
                .sum();
            sum.to_angle().to_degrees()
        })
    }
}

fn corner_uvs(
    charts: &TextureCharts<'_>,
    tree: &SurfaceBvh,
    model: &TriangleMesh,
    mesh: &TriangleMesh,
) -> Vec<[Vec2; 3]> {
    let places = chart_places(charts, model);
    let missing = [Vec2::NAN; 3];
    let of_triangle = |triangle: usize| {
        let corners = mesh.corners(triangle);
        let Some(inside) = tree.nearest_alike(corners.iter().sum::<Vec3>() / 3.0, &corners) else {
            return missing;
        };
        let Some(place) = places.get(&charts.charts[inside.triangle as usize]) else {
            return missing;
        };
        corners.map(|corner| place.uv_at(charts, corner))
    };
    (0..mesh.triangles.len())
        .into_par_iter()
        .map(of_triangle)
        .collect()
}

/// Where a chart lies on its mesh.
struct ChartPlace {
    triangles: Vec<u32>,
    tree: SurfaceBvh,
}

impl ChartPlace {
    fn uv_at(&self, charts: &TextureCharts<'_>, position: Vec3) -> Vec2 {
        let Some(point) = self.tree.nearest(position) else {
            return Vec2::NAN;
        };
        let [a, b, c] = charts.uvs[self.triangles[point.triangle as usize] as usize];
        let [u, v, w] = point.weights;
        a * u + b * v + c * w
    }
}

fn chart_places(charts: &TextureCharts<'_>, mesh: &TriangleMesh) -> BTreeMap<u32, ChartPlace> {
    let mut triangles = BTreeMap::<u32, Vec<u32>>::new();
    for (triangle, &chart) in charts.charts.iter().enumerate() {
        if chart != NONE {
            triangles.entry(chart).or_default().push(triangle as u32);
        }
    }
    let place = |(chart, triangles): (u32, Vec<u32>)| {
        let corners: Vec<_> = triangles
            .iter()
            .map(|&t| mesh.corners(t as usize))
            .collect();
        let tree = SurfaceBvh::of_corners(&corners);
        (chart, ChartPlace { triangles, tree })
    };
    triangles.into_iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// A square of 2 × 2 in two charts, left and right of x = 0, whose texture coordinates are positions,
    /// moved by 10 on the right.
    fn model() -> UserMesh {
        let mut mesh = shapes::grid(16, 16, 0.125);
        for p in &mut mesh.positions {
            *p -= Vec3::new(1.0, 1.0, 0.0);
        }
        let uvs = (0..mesh.triangles.len()).map(|t| {
            let corners = mesh.corners(t);
            let right = corners.iter().sum::<Vec3>().x > 0.0;
            corners.map(|p| p.truncate() + if right { Vec2::X * 10.0 } else { Vec2::ZERO })
        });
        UserMesh {
            corner_uvs: Some(uvs.collect()),
            orientation: Some(mesh.positions.iter().map(|_| Vec3::Y).collect()),
            scale: Some(mesh.positions.iter().map(|p| p.x.exp()).collect()),
            rotation: Some(mesh.positions.iter().map(|p| 180.0 + 10.0 * p.y).collect()),
            mesh,
            ..UserMesh::default()
        }
    }

    #[test]
    fn texture_coordinates_keep_to_their_charts() {
        let model = model();
        let (user, what) = retile_with_numbers(&model, 150, 0.7, Progress::silent()).unwrap();
        assert_eq!(what, Carried::Charts(2));
        let mut both = [0, 0];
        for (triangle, uvs) in user.corner_uvs.as_ref().unwrap().iter().enumerate() {
            let right = uvs[0].x > 5.0;
            both[usize::from(right)] += 1;
            let moved = if right { Vec2::X * 10.0 } else { Vec2::ZERO };
            for (uv, corner) in uvs.iter().zip(user.mesh.corners(triangle)) {
                assert!(
                    (*uv - moved - corner.truncate()).length() < 1e-4,
                    "{uv} {corner}"
                );
            }
        }
        assert!(both[0] > 50 && both[1] > 50, "{both:?}");
    }

    #[test]
    fn numbers_of_vertices_are_blended() {
        let model = model();
        let (user, _) = retile_with_numbers(&model, 150, 0.7, Progress::silent()).unwrap();
        for (v, p) in user.mesh.positions.iter().enumerate() {
            assert!((user.orientation.as_ref().unwrap()[v] - Vec3::Y).length() < 1e-5);
            assert!((user.scale.as_ref().unwrap()[v].ln() - p.x).abs() < 1e-3);
            let turn = user.rotation.as_ref().unwrap()[v].rem_euclid(360.0);
            assert!((turn - 180.0 - 10.0 * p.y).abs() < 0.01);
        }
    }

    #[test]
    fn a_chart_per_triangle_is_said_to_be_lost() {
        let mut model = model();
        for (t, uvs) in model.corner_uvs.iter_mut().flatten().enumerate() {
            uvs.iter_mut().for_each(|uv| uv.x += 3.0 * t as f32);
        }
        let (user, what) = retile_with_numbers(&model, 150, 0.7, Progress::silent()).unwrap();
        assert!(
            matches!(what, Carried::Lost { charts: 512, .. }),
            "{what:?}"
        );
        assert_eq!(user.corner_uvs, None);
    }
}
