//! Shading at the rate of pixels: a coarse mesh still shows the sample at full resolution.
//!
//! At a point p of a triangle each of its three vertices is evaluated at its own texture
//! coordinate continued to p, (s + (p − x)·s⃗/texel, t + (p − x)·t⃗/texel), with view and light taken
//! at p in its own frame; the three are blended by p's barycentric weights, so that vertices that
//! come from different patches of the sample meet without a seam.

use glam::{Vec3, Vec4};
use multiversion::multiversion;

use crate::grid::TexCoord;
use crate::render::fragment::point;
use crate::render::light::{Incidence, luminance};
use crate::render::occlusion::Departure;
use crate::render::radiance::Blend;
use crate::render::raster::Hit;
use crate::render::texel_table::{AnyTable, Stored, TexelTable};
use crate::render::vertex_shading::{Axes, Scene};

/// Where a pixel's lights are found to be hidden.
#[derive(Clone, Copy, Debug)]
pub enum Visibility<'a> {
    /// Nothing hides them.
    Open,
    /// Per light, the visibility of every vertex; interpolated.
    OfVertices(&'a [&'a [f32]]),
    /// By shadow rays from the point itself.
    Rays,
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

/// Working memory, one a task.
#[derive(Debug, Default)]
pub struct Workspace {
    blend: Blend,
    lights: Vec<(Incidence, f32)>,
}

/// Shades a point of the surface.
pub fn shade(scene: &Scene, visibility: Visibility, hit: &Hit, work: &mut Workspace) -> Shaded {
    match &scene.radiance.table {
        AnyTable::Half(table) => shade_point(scene, table, visibility, hit, work),
        AnyTable::Single(table) => shade_point(scene, table, visibility, hit, work),
    }
}

#[multiversion(targets("x86_64+avx2+bmi1+bmi2"))]
fn shade_point<T: Stored>(
    scene: &Scene,
    table: &TexelTable<T>,
    visibility: Visibility,
    hit: &Hit,
    work: &mut Workspace,
) -> Shaded {
    let map = scene.map;
    let Workspace { blend, lights } = work;
    let p = point(&map.mesh, hit);
    let all = gather_lights(scene, visibility, hit, p, lights);
    let viewer = scene.view.towards_viewer(p.as_dvec3());
    let corners = map.mesh.triangles[hit.triangle as usize];
    let mut shaded = Shaded::default();
    for (&vertex, share) in corners.iter().zip(hit.barycentric()) {
        let vertex = vertex as usize;
        if share <= 0.0 {
            continue;
        }
        let axes = Axes::of_vertex(map, vertex);
        let view = axes.local(viewer);
        scene.radiance.begin(blend, view);
        let mut seen = 0.0;
        for (incidence, reaches) in lights.iter() {
            let local = axes.local(incidence.towards.as_dvec3());
            if local.z > 0.0 && *reaches > 0.0 {
                let irradiance = incidence.irradiance.map(|value| value * reaches);
                scene.radiance.add_light::<T>(blend, local, irradiance);
                seen += luminance(irradiance);
            }
        }
        if seen == 0.0 {
            continue;
        }
        if lights.len() > 1 {
            scene.radiance.merge_lights(blend);
        }
        let (along_s, along_t) = axes.offset(p - map.mesh.positions[vertex]);
        let coord = TexCoord {
            s: map.coords[vertex].s + (along_s / map.texel) as f32,
            t: map.coords[vertex].t + (along_t / map.texel) as f32,
        };
        let detail = scene.detail(p, view.z);
        shaded.color += share * scene.radiance.at(table, coord, detail, blend);
        shaded.visibility += share * seen / all.max(f32::MIN_POSITIVE);
        shaded.beyond += share * blend.beyond();
    }
    shaded
}

/// The lights at a point and the share of each that reaches it; returns the luminance of all.
#[inline(always)]
fn gather_lights(
    scene: &Scene,
    visibility: Visibility,
    hit: &Hit,
    p: Vec3,
    lights: &mut Vec<(Incidence, f32)>,
) -> f32 {
    let corners = scene.map.mesh.triangles[hit.triangle as usize];
    let interpolated = |of_vertices: &[f32]| -> f32 {
        let shares = corners.iter().zip(hit.barycentric());
        shares
            .map(|(&v, share)| share * of_vertices[v as usize])
            .sum()
    };
    lights.clear();
    let mut all = 0.0;
    for (index, light) in scene.lights.iter().enumerate() {
        let incidence = light.at(p);
        let reaches = match visibility {
            Visibility::Open => 1.0,
            Visibility::OfVertices(lists) => interpolated(lists[index]),
            Visibility::Rays => ray_visibility(scene, index, &incidence, hit, p),
        };
        all += luminance(incidence.irradiance);
        lights.push((incidence, reaches));
    }
    all
}

/// The share of a light that reaches a point of a triangle, by rays that leave the side of the
/// facet that faces the light; 0 where no vertex of the triangle has the light above its horizon.
#[inline(never)]
pub fn ray_visibility(
    scene: &Scene,
    light: usize,
    incidence: &Incidence,
    hit: &Hit,
    p: Vec3,
) -> f32 {
    let triangle = hit.triangle as usize;
    let corners = scene.map.mesh.triangles[triangle];
    let lit = |&v: &u32| scene.map.normals[v as usize].dot(incidence.towards) > 0.0;
    if !corners.iter().any(lit) {
        return 0.0;
    }
    let facet = scene.map.mesh.area_normal(triangle).normalize_or_zero();
    let side = if facet.dot(incidence.towards) < 0.0 {
        -facet
    } else {
        facet
    };
    let turn = p.x.to_bits() ^ p.y.to_bits().rotate_left(11) ^ p.z.to_bits().rotate_left(22);
    let departure = Departure::Triangle(hit.triangle);
    scene.visibility(&scene.lights[light], incidence, p, side, departure, turn)
}
