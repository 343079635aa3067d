//! The paper's shading (Tong 2002 §6): a colour at every vertex, from its texel, its view and its
//! lights in its own frame, dimmed by what hides the lights.
//!
//! Vertices are shaded in the order of their texels, so that one texel's images, read once, serve
//! all its vertices.

use glam::{DVec3, Vec3};
use multiversion::multiversion;
use rayon::prelude::*;

use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::render::camera::View;
use crate::render::light::{Incidence, Light};
use crate::render::occlusion::{Cone, Departure, Occluders};
use crate::render::radiance::{Blend, Radiance};
use crate::render::texel_table::{AnyTable, Stored, TexelTable};
use crate::surface_map::SurfaceTextonMap;

/// A vertex and its texel.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// The vertex.
    pub vertex: u32,
    /// The texel of the finest level that holds its coordinate.
    pub texel: TexelIndex,
}

/// What shading found at a vertex, or at any other point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaded {
    /// Linear radiance of all lights.
    pub rgb: [f32; 3],
    /// The share of the lights' irradiance (by luminance) that reaches the point; lights below
    /// its horizon do not.
    pub visibility: f32,
    /// The share of the weight that came from beyond the sampled range of directions.
    pub beyond: f32,
}

/// Everything that shading a point needs.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The decorated surface.
    pub map: &'a SurfaceTextonMap,
    /// The sample.
    pub radiance: &'a Radiance,
    /// The viewer.
    pub view: &'a View,
    /// The lights.
    pub lights: &'a [Light],
    /// What casts shadows; `None` for no shadows.
    pub occluders: Option<&'a Occluders>,
    /// Rays for lights that have a size.
    pub soft_rays: u32,
}

/// Sites handled by one task.
const CHUNK: usize = 1 << 10;

/// All vertices of a map that some triangle uses, in the order of their texels.
pub fn sites_by_texel(map: &SurfaceTextonMap, grid: TexelGrid) -> Vec<Site> {
    let mut used = vec![false; map.mesh.positions.len()];
    for &vertex in map.mesh.triangles.iter().flatten() {
        used[vertex as usize] = true;
    }
    let mut sites: Vec<Site> = (0..used.len())
        .filter(|&vertex| used[vertex])
        .map(|vertex| Site {
            vertex: vertex as u32,
            texel: grid.texel_nearest(map.coords[vertex]),
        })
        .collect();
    sites.par_sort_by_key(|site| (site.texel.0, site.vertex));
    sites
}

/// Shades vertices; the result is in the order of `sites`.
pub fn shade(scene: &Scene, sites: &[Site]) -> Vec<Shaded> {
    let mut shaded = vec![Shaded::default(); sites.len()];
    sites
        .par_chunks(CHUNK)
        .zip(shaded.par_chunks_mut(CHUNK))
        .for_each_init(Blend::default, |blend, (sites, out)| {
            match &scene.radiance.table {
                AnyTable::Half(table) => shade_chunk(scene, table, blend, sites, out),
                AnyTable::Single(table) => shade_chunk(scene, table, blend, sites, out),
            }
        });
    shaded
}

/// The share of one light that reaches each vertex, in the order of `sites`.
pub fn visibilities(scene: &Scene, light: &Light, sites: &[Site]) -> Vec<f32> {
    sites
        .par_iter()
        .map(|site| {
            let (frame, point) = (
                scene.map.frame(site.vertex as usize),
                scene.map.mesh.positions[site.vertex as usize],
            );
            let incidence = light.at(point);
            if incidence.towards.dot(frame.n) <= 0.0 {
                return 0.0;
            }
            let departure = Departure::Vertex(point);
            scene.visibility(light, &incidence, point, frame.n, departure, site.vertex)
        })
        .collect()
}

impl Scene<'_> {
    /// The share of a light that reaches a point on the lit side of the surface.
    #[inline(never)]
    pub fn visibility(
        &self,
        light: &Light,
        incidence: &Incidence,
        point: Vec3,
        normal: Vec3,
        departure: Departure,
        turn: u32,
    ) -> f32 {
        let Some(occluders) = self.occluders else {
            return 1.0;
        };
        let cone = Cone {
            rays: if light.angular_radius > 0.0 {
                self.soft_rays
            } else {
                1
            },
            tangent: light.angular_radius.tan() as f32,
        };
        occluders.visibility(point, normal, departure, incidence, cone, turn)
    }
}

#[multiversion(targets("x86_64+avx2+bmi1+bmi2"))]
fn shade_chunk<T: Stored>(
    scene: &Scene,
    table: &TexelTable<T>,
    blend: &mut Blend,
    sites: &[Site],
    out: &mut [Shaded],
) {
    let one_texel = scene.radiance.reads_one_texel();
    for (site, out) in sites.iter().zip(out) {
        let vertex = site.vertex as usize;
        let point = scene.map.mesh.positions[vertex];
        let (visibility, detail) = begin::<T>(scene, blend, vertex, point);
        let radiance = scene.radiance;
        let rgb = if visibility == 0.0 {
            [0.0; 3]
        } else if one_texel {
            radiance.of_texel(table, site.texel, blend)
        } else {
            radiance.at(table, scene.map.coords[vertex], detail, blend)
        };
        *out = Shaded {
            rgb,
            visibility,
            beyond: blend.beyond(),
        };
    }
}

/// Gathers view and lights of a vertex; returns the lights' visibility and the level of detail.
#[inline(always)]
fn begin<T: Stored>(scene: &Scene, blend: &mut Blend, vertex: usize, point: Vec3) -> (f32, f32) {
    let axes = Axes::of_vertex(scene.map, vertex);
    let viewer = scene.view.towards_viewer(point.as_dvec3());
    let view = axes.local(viewer);
    scene.radiance.begin(blend, view);
    let (mut all, mut seen) = (0.0, 0.0);
    for light in scene.lights {
        let incidence = light.at(point);
        let luminance = crate::render::light::luminance(incidence.irradiance);
        all += luminance;
        let local = axes.local(incidence.towards.as_dvec3());
        if local.z <= 0.0 {
            continue;
        }
        let departure = Departure::Vertex(point);
        let normal = scene.map.normals[vertex];
        let reaches = scene.visibility(light, &incidence, point, normal, departure, vertex as u32);
        if reaches > 0.0 {
            let irradiance = incidence.irradiance.map(|value| value * reaches);
            scene.radiance.add_light::<T>(blend, local, irradiance);
            seen += luminance * reaches;
        }
    }
    if scene.lights.len() > 1 {
        scene.radiance.merge_lights(blend);
    }
    let visibility = if all > 0.0 { seen / all } else { 0.0 };
    (visibility, scene.detail(point, view.z))
}

impl Scene<'_> {
    /// How many pyramid levels up a pixel's footprint at a point is as large as a texel: log₂ of
    /// the longer side of the footprint, in texels. The foreshortening counts up to eightfold.
    #[inline]
    pub fn detail(&self, point: Vec3, view_cosine: f64) -> f32 {
        let depth = self.view.camera_from_world(point.as_dvec3()).z.max(1e-12);
        let pixels = self.view.pixels_per_unit_at(depth) * self.map.texel;
        let footprint = 1.0 / (pixels * view_cosine.abs().max(0.125));
        footprint.log2().max(0.0) as f32
    }
}

/// A vertex's frame in double precision.
#[derive(Clone, Copy, Debug)]
pub struct Axes {
    /// s, t and n.
    axes: [DVec3; 3],
}

impl Axes {
    /// The frame of a vertex.
    #[inline(always)]
    pub fn of_vertex(map: &SurfaceTextonMap, vertex: usize) -> Self {
        let (n, s) = (
            map.normals[vertex].as_dvec3(),
            map.orientations[vertex].as_dvec3(),
        );
        Self {
            axes: [s, n.cross(s), n],
        }
    }

    /// A mesh-space direction in the frame, as a unit vector.
    #[inline(always)]
    pub fn local(&self, direction: DVec3) -> DVec3 {
        let [s, t, n] = self.axes;
        let local = DVec3::new(direction.dot(s), direction.dot(t), direction.dot(n));
        local * (1.0 / local.length())
    }

    /// The offset of a point from the vertex, along s and t.
    #[inline(always)]
    pub fn offset(&self, from_vertex: Vec3) -> (f64, f64) {
        let offset = from_vertex.as_dvec3();
        (offset.dot(self.axes[0]), offset.dot(self.axes[1]))
    }
}
