//! Shading at the rate of pixels: a coarse mesh still shows the sample at full resolution.
//!
//! At a point p of a triangle each of its three vertices is evaluated at its own texture
//! coordinate continued to p, (s + (p − x)·s⃗/texel, t + (p − x)·t⃗/texel), with the texel of its own
//! scale, and view and light taken at p in its own frame; the three are blended by p's barycentric
//! weights, so that vertices that come from different patches of the sample meet without a seam.

use glam::{DVec3, Vec4};
use macro_rules_attribute::apply;

use crate::lanes::vectorized;
use crate::render::btf_lookup::Blend;
use crate::render::cover::received;
use crate::render::light::{Incidence, Light, luminance};
use crate::render::nearest::Weight;
use crate::render::pixel_shadows::piece_visibility;
use crate::render::raster::Hit;
use crate::render::seen_points::{SeenPoint, SeenPoints};
use crate::render::texel_table::{AnyTable, Stored, TexelTable};
use crate::render::vertex_frame::Axes;
use crate::render::vertex_shading::ShadingScene;

/// Where a pixel's lights are found to be hidden.
#[derive(Clone, Copy, Debug)]
pub enum Visibility<'a> {
    /// Nothing hides them.
    Open,
    /// Per light, the visibility of every vertex; interpolated.
    OfVertices(&'a [&'a [f32]]),
    /// By shadow rays from the samples that a point stands for, given the hits of its pixel; from the
    /// point itself where none are given.
    Rays(&'a [Hit]),
}

/// What shading found at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaded {
    /// Linear radiance of all lights, red to blue; the fourth number means nothing.
    pub color: Vec4,
    /// The share of the lights' irradiance (by luminance) that reaches the point; lights below
    /// its horizon do not.
    pub visibility: f32,
    /// The share of the weight that came from beyond the sampled range of directions.
    pub beyond: f32,
}

/// Working memory, one per task.
#[derive(Debug, Default)]
pub struct Workspace {
    /// Points that are not kept.
    pub points: SeenPoints,
    /// What shading them needs.
    pub shading: ShadingSpace,
}

/// What shading a point needs.
#[derive(Debug, Default)]
pub struct ShadingSpace {
    lights: Vec<(Incidence, f32)>,
    corners: [Corner; 3],
}

/// The blend at a vertex of a point's triangle.
#[derive(Debug, Default)]
struct Corner {
    blend: Blend,
    /// Luminance of the light that reaches it.
    seen: f32,
    /// The light that a plain colour below the texture receives; zero where there is none.
    irradiance: Vec4,
}

/// Shades a point of the surface that nothing is known of.
pub fn shade_hit(
    scene: &ShadingScene,
    visibility: Visibility,
    hit: &Hit,
    work: &mut Workspace,
) -> Shaded {
    let Workspace { points, shading } = work;
    points.forget();
    let point = points.see(scene, hit);
    shade(scene, visibility, &point, points, shading)
}

/// Shades a point of the surface, one of `points`.
pub fn shade(
    scene: &ShadingScene,
    visibility: Visibility,
    point: &SeenPoint,
    points: &SeenPoints,
    work: &mut ShadingSpace,
) -> Shaded {
    match &scene.lookup.table {
        AnyTable::Half(table) => shade_point(scene, table, visibility, point, points, work),
        AnyTable::Single(table) => shade_point(scene, table, visibility, point, points, work),
    }
}

#[apply(vectorized!)]
fn shade_point<T: Stored>(
    scene: &ShadingScene,
    table: &TexelTable<T>,
    visibility: Visibility,
    point: &SeenPoint,
    points: &SeenPoints,
    work: &mut ShadingSpace,
) -> Shaded {
    let (map, lookup, hit) = (scene.map, scene.lookup, &point.hit);
    let ShadingSpace { lights, corners } = work;
    let all = gather_lights(scene, visibility, point, lights);
    // First what is to be read, for all three, then the reading: so that it continues at once.
    let triangle = &map.mesh.triangles[hit.triangle as usize];
    for ((corner, seen), &vertex) in corners.iter_mut().zip(&point.corners).zip(triangle) {
        let vertex = vertex as usize;
        lookup.begin_known(&mut corner.blend, seen.view, points.weights(seen));
        corner.blend.set_reach(scene.reach(vertex));
        corner.seen = 0.0;
        corner.irradiance = Vec4::ZERO;
        let axes = Axes::of_vertex(map, vertex).turned(point.turned);
        for (index, (incidence, reaches)) in lights.iter().enumerate() {
            let local = axes.local(incidence.towards.as_dvec3());
            if local.z > 0.0 && *reaches > 0.0 {
                let irradiance = incidence.irradiance.map(|value| value * reaches);
                let known = scene.weights.of(index, vertex);
                let weights = known.filter(|_| !point.turned);
                corner.add_light::<T>(scene, weights, local, irradiance);
            }
        }
        if lights.len() > 1 {
            lookup.merge_lights(&mut corner.blend);
        }
        corner.irradiance += scene.add_fill::<T>(&mut corner.blend, &axes, vertex, point.turned);
    }
    let mut shaded = Shaded::default();
    let read = corners.iter_mut().zip(&point.corners).zip(triangle);
    for (((corner, seen), &vertex), share) in read.zip(hit.barycentric()) {
        if corner.blend.is_dark() || share <= 0.0 {
            continue;
        }
        let texture = lookup.at(table, seen.coord, seen.detail, &mut corner.blend);
        let color = match scene.cover {
            Some(cover) => cover.mixed(vertex as usize, texture, corner.irradiance),
            None => texture,
        };
        shaded.color += share * color;
        shaded.visibility += share * corner.seen / all.max(f32::MIN_POSITIVE);
        shaded.beyond += share * corner.blend.beyond();
    }
    shaded
}

impl Corner {
    #[inline(always)]
    fn add_light<T: Stored>(
        &mut self,
        scene: &ShadingScene,
        weights: Option<&[Weight]>,
        local: DVec3,
        irradiance: [f32; 3],
    ) {
        let (lookup, blend) = (scene.lookup, &mut self.blend);
        match weights {
            Some(weights) => lookup.add_weighted::<T>(blend, local, weights, irradiance),
            None => lookup.add_light::<T>(blend, local, irradiance),
        }
        if scene.cover.is_some() {
            self.irradiance += received(irradiance, local.z);
        }
        self.seen += luminance(irradiance);
    }
}

/// The lights at a point and the share of each that reaches it; returns the luminance of all.
#[inline(always)]
fn gather_lights(
    scene: &ShadingScene,
    visibility: Visibility,
    point: &SeenPoint,
    lights: &mut Vec<(Incidence, f32)>,
) -> f32 {
    let (hit, p) = (&point.hit, point.place);
    let corners = scene.map.mesh.triangles[hit.triangle as usize];
    // Blend what is known of the vertices.
    let interpolated = |of_vertices: &[f32], light: &Light| -> f32 {
        let shares = corners.iter().zip(hit.barycentric());
        shares
            .map(
                |(&v, share)| match reaches_side(scene, v as usize, light, point.turned) {
                    true => share * of_vertices[v as usize],
                    false => 0.0,
                },
            )
            .sum()
    };
    // Ask per light how much of it reaches the point.
    lights.clear();
    let mut all = 0.0;
    for (index, light) in scene.lights.iter().enumerate() {
        let incidence = light.at(p);
        let reaches = match visibility {
            Visibility::Open => 1.0,
            Visibility::OfVertices(lists) => interpolated(lists[index], light),
            Visibility::Rays(pixel) => piece_visibility(scene, index, point, pixel),
        };
        all += luminance(incidence.irradiance);
        lights.push((incidence, reaches));
    }
    all
}

/// Whether what is known of a light at a vertex applies to the side that is seen. Without borders it always applies to
/// the outside.
#[inline(always)]
fn reaches_side(scene: &ShadingScene, vertex: usize, light: &Light, turned: bool) -> bool {
    if !scene.has_border {
        return true;
    }
    let towards = light.at(scene.map.mesh.positions[vertex]).towards;
    (towards.dot(scene.map.normals[vertex]) > 0.0) != turned
}
