//! Shadows found in pixels: the share of a light that reaches the surface, by rays from every sample of a pixel.
//!
//! The edge of a shadow that crosses a pixel hides some of its samples, so that shadows have edges as smooth as outlines.
//! The rays to a light that has a size are dealt out among the samples of a piece of surface: they cast about as many
//! together as one point would.

use glam::Vec3;

use crate::render::fragment::point;
use crate::render::occlusion::{Cone, Departure};
use crate::render::raster::Hit;
use crate::render::seen_points::SeenPoint;
use crate::render::vertex_shading::Scene;

/// The share of a light that reaches a piece of surface: the mean over the samples that see it. `pixel` has the hits of
/// the piece's pixel; where it is empty, the point speaks for the piece.
pub fn piece_visibility(scene: &Scene, light: usize, point: &SeenPoint, pixel: &[Hit]) -> f32 {
    let turn = turn(point.place);
    let cone = Cone::of_light(&scene.lights[light], scene.soft_rays);
    let count = point.samples.len();
    if count <= 1 || pixel.is_empty() {
        return sample_visibility(scene, light, &point.hit, cone, turn);
    }
    let reaches = |(index, sample): (u32, usize)| {
        sample_visibility(
            scene,
            light,
            &pixel[sample],
            cone.shared(index, count),
            turn,
        )
    };
    let sum: f32 = (0..).zip(point.samples.iter()).map(reaches).sum();
    sum / count as f32
}

/// The share of a light that reaches a point of a triangle; 0 where no vertex of the triangle has the light above its
/// horizon.
#[inline(never)]
pub fn sample_visibility(scene: &Scene, light: usize, hit: &Hit, cone: Cone, turn: u32) -> f32 {
    let Some(occluders) = scene.occluders else {
        return 1.0;
    };
    let mesh = &scene.map.mesh;
    let p = point(mesh, hit);
    let incidence = scene.lights[light].at(p);
    let side = match scene.turns(hit.triangle, p) {
        true => -1.0,
        false => 1.0,
    };
    let corners = mesh.triangles[hit.triangle as usize].map(|vertex| Corner {
        position: mesh.positions[vertex as usize],
        normal: side * scene.map.normals[vertex as usize],
    });
    if !corners
        .iter()
        .any(|corner| corner.normal.dot(incidence.towards) > 0.0)
    {
        return 0.0;
    }
    let facet = mesh.area_normal(hit.triangle as usize).normalize_or_zero();
    let normals: Vec3 = corners.iter().map(|corner| corner.normal).sum();
    let outside = if facet.dot(normals) < 0.0 {
        -facet
    } else {
        facet
    };
    let start = on_smooth_surface(&corners, hit.barycentric(), p);
    let departure = Departure::Triangle(hit.triangle);
    occluders.visibility(start, outside, departure, &incidence, cone, turn)
}

/// A corner of a triangle, its normal on the side that is seen.
struct Corner {
    position: Vec3,
    normal: Vec3,
}

/// Where the rays of a point begin: on the smooth surface that the normals describe, where that bulges over the triangle
/// (Hanika 2021, "Hacking the Shadow Terminator"). Rays from the triangle itself would meet its neighbours where the light
/// grazes, and draw the triangles in black.
fn on_smooth_surface(corners: &[Corner; 3], shares: [f32; 3], p: Vec3) -> Vec3 {
    let lift = |(corner, share): (&Corner, f32)| {
        // How far the point lies under the plane that touches the smooth surface in the corner.
        let depth = (corner.position - p).dot(corner.normal).max(0.0);
        share * depth * corner.normal
    };
    p + corners.iter().zip(shares).map(lift).sum::<Vec3>()
}

/// What turns the pattern of the rays that leave a place.
pub fn turn(place: Vec3) -> u32 {
    let [x, y, z] = place.to_array().map(f32::to_bits);
    x ^ y.rotate_left(11) ^ z.rotate_left(22)
}
