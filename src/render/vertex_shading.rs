//! The paper's shading (Tong 2002 §6): a colour at every vertex, from its texel, its view and its
//! lights in its own frame, dimmed by what hides the lights.
//!
//! Vertices are shaded in the order of their texels, so that one texel's images, read once, serve
//! all its vertices.

use glam::{Vec3, Vec4};
use macro_rules_attribute::apply;
use rayon::prelude::*;

use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::lanes::vectorized;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::render::btf_lookup::{Blend, BtfLookup};
use crate::render::camera::View;
use crate::render::cover::{Cover, received};
use crate::render::fill::Fill;
use crate::render::known_weights::KnownWeights;
use crate::render::light::{Incidence, Light};
use crate::render::occlusion::{Cone, Occluders, RayOrigin};
use crate::render::parallax::PatchReach;
use crate::render::sides::shows_inside;
use crate::render::texel_table::{AnyTable, Stored, TexelTable};
use crate::render::vertex_frame::Axes;

/// A vertex to shade, with all that shading reads of the map.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// The vertex.
    pub vertex: u32,
    /// The texel of the finest level that holds its coordinate.
    pub texel: TexelIndex,
    /// Where it is.
    pub point: Vec3,
    /// Whether the [inside](crate::render::sides) is seen.
    pub turned: bool,
    normal: Vec3,
    orientation: Vec3,
}

/// Everything that shading a point needs.
#[derive(Clone, Copy)]
pub struct ShadingScene<'a> {
    /// The decorated surface.
    pub map: &'a SurfaceTextonMap,
    /// The sample.
    pub lookup: &'a BtfLookup,
    /// The viewer.
    pub view: &'a View,
    /// The lights.
    pub lights: &'a [Light],
    /// What casts shadows where pixels ask; `None` for no shadows.
    pub occluders: Option<&'a Occluders>,
    /// Whether the mesh has a border, so that light reaches both sides of it.
    pub has_border: bool,
    /// Whether a triangle seen from behind shows its [inside](crate::render::sides); else its outside is seen as the
    /// view grazes it.
    pub shows_inside: bool,
    /// Rays for lights that have a size.
    pub soft_rays: u32,
    /// What is known of the lights at vertices.
    pub weights: KnownWeights<'a>,
    /// How far images may be read from each vertex's coordinate, where views are blended with their parallax.
    pub patches: Option<&'a PatchReach>,
    /// A plain colour below the texture, where it is transparent.
    pub cover: Option<&'a Cover>,
    /// The light that fills the shade.
    pub fill: Option<Fill>,
    /// Per vertex the share of that light which reaches its outside; all of it where it is `None`.
    pub openness: Option<&'a [f32]>,
    /// The side of what is shaded, in mesh units, by which levels of the sample are chosen; a pixel's footprint
    /// where it is `None`.
    pub side: Option<f64>,
    /// Who may ask to stop.
    pub progress: Progress<'a>,
}

/// Sites handled by one task.
const CHUNK: usize = 1 << 10;
/// Sites on one texel from which on its numbers are brought near at once: read one by one, each
/// would be waited for.
const SHARED: usize = 6;

/// All vertices of a map that some triangle uses, in the order of their texels.
pub fn sites_by_texel(map: &SurfaceTextonMap, grid: TexelGrid) -> Vec<Site> {
    let mut used = vec![false; map.mesh.positions.len()];
    for &vertex in map.mesh.triangles.iter().flatten() {
        used[vertex as usize] = true;
    }
    sites_of(map, grid, |vertex| used[vertex])
}

/// The vertices of a map that are `wanted`, in the order of their texels.
pub fn sites_of(
    map: &SurfaceTextonMap,
    grid: TexelGrid,
    wanted: impl Fn(usize) -> bool,
) -> Vec<Site> {
    let mut sites: Vec<Site> = (0..map.mesh.positions.len())
        .filter(|&vertex| wanted(vertex))
        .map(|vertex| Site {
            vertex: vertex as u32,
            texel: grid.texel_nearest(map.coords[vertex]),
            point: map.mesh.positions[vertex],
            turned: false,
            normal: map.normals[vertex],
            orientation: map.orientations[vertex],
        })
        .collect();
    sites.par_sort_by_key(|site| (site.texel.0, site.vertex));
    sites
}

/// Shades vertices: linear radiance red to blue, in the order of `sites`; the fourth number means
/// nothing. `reaches` has for each light the share that reaches each vertex, or nothing at all
/// where nothing casts shadows.
pub fn shade(scene: &ShadingScene, reaches: &[&[f32]], sites: &[Site]) -> Vec<Vec4> {
    let mut shaded = vec![Vec4::ZERO; sites.len()];
    sites
        .par_chunks(CHUNK)
        .zip(shaded.par_chunks_mut(CHUNK))
        .for_each_init(Blend::default, |blend, (sites, out)| {
            if scene.progress.is_interrupted() {
                return;
            }
            match &scene.lookup.table {
                AnyTable::Half(table) => shade_chunk(scene, table, reaches, blend, sites, out),
                AnyTable::Single(table) => shade_chunk(scene, table, reaches, blend, sites, out),
            }
        });
    shaded
}

impl ShadingScene<'_> {
    /// How far images may be read from a vertex's coordinate, in texels.
    #[inline(always)]
    pub fn reach(&self, vertex: usize) -> f32 {
        self.patches.map_or(0.0, |patches| patches.of(vertex))
    }

    /// Adds the light that fills the shade at a vertex to a blend; returns what a plane receives of it.
    #[inline(always)]
    pub fn add_fill<T: Stored>(
        &self,
        blend: &mut Blend,
        axes: &Axes,
        vertex: usize,
        turned: bool,
    ) -> Vec4 {
        let Some(fill) = &self.fill else {
            return Vec4::ZERO;
        };
        let up = axes.local(fill.up);
        let open = match self.openness {
            Some(open) if !turned => open[vertex],
            _ => 1.0,
        };
        let shares = fill.shares(up).map(|share| share * open);
        self.lookup.add_fill::<T>(blend, shares);
        let received = open * fill.irradiance(up.z);
        Vec4::new(received, received, received, 0.0)
    }

    /// Whether the inside of a triangle is seen at a point of it.
    #[inline(always)]
    pub fn turns(&self, triangle: u32, point: Vec3) -> bool {
        let viewer = || self.view.towards_viewer(point.as_dvec3());
        self.shows_inside && shows_inside(&self.map.mesh, triangle, viewer())
    }

    /// The share of a light that reaches a point on the lit side of the surface.
    #[inline(never)]
    pub fn visibility(
        &self,
        light: &Light,
        incidence: &Incidence,
        point: Vec3,
        normal: Vec3,
        ray_origin: RayOrigin,
        turn: u32,
    ) -> f32 {
        let Some(occluders) = self.occluders else {
            return 1.0;
        };
        let cone = Cone::of_light(light, self.soft_rays);
        occluders.visibility(point, normal, ray_origin, incidence, cone, turn)
    }
}

#[apply(vectorized!)]
fn shade_chunk<T: Stored>(
    scene: &ShadingScene,
    table: &TexelTable<T>,
    reaches: &[&[f32]],
    blend: &mut Blend,
    sites: &[Site],
    out: &mut [Vec4],
) {
    let lookup = scene.lookup;
    let one_texel = lookup.reads_one_texel();
    let mut near = Vec::new();
    let mut out = out.iter_mut();
    // Visit the vertices that share a texel together.
    for sharing in sites.chunk_by(|a, b| a.texel == b.texel) {
        let mut numbers = table.levels[0].texel(sharing[0].texel);
        if one_texel && sharing.len() >= SHARED {
            near.clear();
            near.extend_from_slice(numbers);
            numbers = &near;
        }
        // Shade each.
        for (site, out) in sharing.iter().zip(&mut out) {
            let begun = begin::<T>(scene, reaches, blend, site);
            let vertex = site.vertex as usize;
            let color = if blend.is_dark() {
                Vec4::ZERO
            } else if one_texel {
                lookup.blend_texel(numbers, blend)
            } else {
                let texel = scene.map.texel_at(vertex);
                let detail = scene.detail(site.point, begun.view_cosine, texel);
                lookup.at(table, scene.map.coords[vertex], detail, blend)
            };
            *out = match scene.cover {
                Some(cover) => cover.mixed(vertex, color, begun.irradiance),
                None => color,
            };
        }
    }
}

/// What is known of a vertex before its sample is read.
struct Begun {
    /// The view's cosine.
    view_cosine: f64,
    /// The light that a plain colour below the texture receives; zero where there is none.
    irradiance: Vec4,
}

/// Gathers view and lights of a vertex.
#[inline(always)]
fn begin<T: Stored>(
    scene: &ShadingScene,
    reaches: &[&[f32]],
    blend: &mut Blend,
    site: &Site,
) -> Begun {
    // Turn the view to the frame of the vertex.
    let mut received_light = Vec4::ZERO;
    let axes = Axes::new(site.normal, site.orientation).turned(site.turned);
    let view = axes.local(scene.view.towards_viewer(site.point.as_dvec3()));
    scene.lookup.begin(blend, view);
    blend.set_reach(scene.reach(site.vertex as usize));
    // Add the lights that reach it.
    for (index, light) in scene.lights.iter().enumerate() {
        let incidence = light.at(site.point);
        let local = axes.local(incidence.towards.as_dvec3());
        let reaches = reaches
            .get(index)
            .map_or(1.0, |of| of[site.vertex as usize]);
        if local.z > 0.0 && reaches > 0.0 {
            let irradiance = incidence.irradiance.map(|value| value * reaches);
            let known = scene.weights.of(index, site.vertex as usize);
            let weights = known.filter(|_| !site.turned);
            let lookup = scene.lookup;
            if scene.cover.is_some() {
                received_light += received(irradiance, local.z);
            }
            match weights {
                Some(weights) => lookup.add_weighted::<T>(blend, local, weights, irradiance),
                None => lookup.add_light::<T>(blend, local, irradiance),
            }
        }
    }
    // Join lights that read the same images, and add the fill light.
    if scene.lights.len() > 1 {
        scene.lookup.merge_lights(blend);
    }
    received_light += scene.add_fill::<T>(blend, &axes, site.vertex as usize, site.turned);
    Begun {
        view_cosine: view.z,
        irradiance: received_light,
    }
}

impl ShadingScene<'_> {
    /// How many pyramid levels up a pixel's footprint at a point is as large as a texel of `texel`
    /// mesh units: log₂ of the longer side of the footprint, in texels. The foreshortening counts up to eightfold.
    /// Where the scene states the side of what is shaded, that counts in place of the footprint.
    #[inline]
    pub fn detail(&self, point: Vec3, view_cosine: f64, texel: f64) -> f32 {
        if let Some(side) = self.side {
            return (side / texel).log2().max(0.0) as f32;
        }
        let depth = self.view.camera_from_world(point.as_dvec3()).z.max(1e-12);
        let pixels = self.view.pixels_per_unit_at(depth) * texel;
        let footprint = 1.0 / (pixels * view_cosine.abs().max(0.125));
        footprint.log2().max(0.0) as f32
    }
}
