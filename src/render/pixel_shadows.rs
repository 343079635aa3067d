//! Shadows found in pixels: the share of a light that reaches the surface, by rays from every sample of a pixel.
//!
//! The edge of a shadow that crosses a pixel hides some of its samples, so that shadows have edges as smooth as
//! outlines. The rays to a light that has a size are divided among the samples of a piece of surface. Together they are
//! about as many as for one point.

use glam::Vec3;

use crate::render::fragment::{MOST, SampleSet, point};
use crate::render::light::Incidence;
use crate::render::occlusion::beam::RayStart;
use crate::render::occlusion::{Cone, Occluders, RayOrigin};
use crate::render::raster::Hit;
use crate::render::seen_points::SeenPoint;
use crate::render::vertex_shading::ShadingScene;

/// The share of a light that reaches a piece of surface: the mean over the samples that see it. `pixel` has the hits of
/// the piece's pixel; where it is empty, the point stands for the piece.
pub fn piece_visibility(
    scene: &ShadingScene,
    light: usize,
    point: &SeenPoint,
    pixel: &[Hit],
) -> f32 {
    let count = point.samples.len();
    if count <= 1 || pixel.is_empty() {
        let alone = std::slice::from_ref(&point.hit);
        return sample_visibilities(scene, light, alone, SampleSet::ONE, point.place)[0];
    }
    let reaches = sample_visibilities(scene, light, pixel, point.samples, point.place);
    reaches.iter().sum::<f32>() / count as f32
}

/// The share of a light that reaches each of some samples of a pixel, which see one piece of surface round `place`; 0
/// at others.
#[inline(never)]
pub fn sample_visibilities(
    scene: &ShadingScene,
    light: usize,
    pixel: &[Hit],
    samples: SampleSet,
    place: Vec3,
) -> [f32; MOST] {
    let mut reaches = [0.0; MOST];
    // Keep the samples that face the light.
    let lit = samples.iter().filter_map(|sample| {
        let (start, incidence) = ray_start(scene, light, &pixel[sample])?;
        Some((sample, start, incidence))
    });
    let Some(occluders) = scene.occluders else {
        lit.for_each(|(sample, ..)| reaches[sample] = 1.0);
        return reaches;
    };
    // Cast one ray per sample where the light is a direction, all at once.
    let cone = Cone::of_light(&scene.lights[light], scene.soft_rays);
    if cone.rays == 1 && scene.lights[light].is_directional() {
        open_samples(occluders, lit, &mut reaches);
        return reaches;
    }
    // Cast a cone per sample, each with its share of the rays.
    let (turn, count) = (turn(place), samples.len());
    for (index, (sample, start, incidence)) in (0..).zip(lit) {
        let RayStart {
            point,
            normal,
            ray_origin,
        } = start;
        let cone = cone.shared(index, count);
        reaches[sample] = occluders.visibility(point, normal, ray_origin, &incidence, cone, turn);
    }
    reaches
}

/// Finds which samples a light of one direction reaches.
fn open_samples(
    occluders: &Occluders,
    lit: impl Iterator<Item = (usize, RayStart, Incidence)>,
    reaches: &mut [f32; MOST],
) {
    let mut starts = [RayStart::default(); MOST];
    let (mut numbers, mut count, mut towards) = ([0; MOST], 0, Vec3::ZERO);
    for (sample, start, incidence) in lit {
        (starts[count], numbers[count], towards) = (start, sample, incidence.towards);
        count += 1;
    }
    let open = occluders.open_points(&starts[..count], towards);
    for (place, &sample) in numbers[..count].iter().enumerate() {
        reaches[sample] = f32::from((open >> place & 1) as u8);
    }
}

/// Where a sample's rays to a light start, on the side of its triangle that is seen; `None` where no vertex of the
/// triangle has the light above its horizon.
fn ray_start(scene: &ShadingScene, light: usize, hit: &Hit) -> Option<(RayStart, Incidence)> {
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
        return None;
    }
    let facet = mesh.area_normal(hit.triangle as usize).normalize_or_zero();
    let normals: Vec3 = corners.iter().map(|corner| corner.normal).sum();
    let start = RayStart {
        point: on_smooth_surface(&corners, hit.barycentric(), p),
        normal: match facet.dot(normals) < 0.0 {
            true => -facet,
            false => facet,
        },
        ray_origin: RayOrigin::Triangle(hit.triangle),
    };
    Some((start, incidence))
}

/// A corner of a triangle, its normal on the side that is seen.
struct Corner {
    position: Vec3,
    normal: Vec3,
}

/// Where the rays of a point begin: on the smooth surface that the normals describe, where that bulges over the
/// triangle (Hanika 2021, "Hacking the Shadow Terminator"). Rays from the triangle itself would meet its neighbours
/// where the light grazes, and draw the triangles in black.
fn on_smooth_surface(corners: &[Corner; 3], shares: [f32; 3], p: Vec3) -> Vec3 {
    let lift = |(corner, share): (&Corner, f32)| {
        // How far the point lies under the plane that touches the smooth surface in the corner.
        let depth = (corner.position - p).dot(corner.normal).max(0.0);
        share * depth * corner.normal
    };
    p + corners.iter().zip(shares).map(lift).sum::<Vec3>()
}

/// What turns the pattern of the rays that leave a place.
fn turn(place: Vec3) -> u32 {
    let [x, y, z] = place.to_array().map(f32::to_bits);
    x ^ y.rotate_left(11) ^ z.rotate_left(22)
}
