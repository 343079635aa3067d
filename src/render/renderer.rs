//! From view and lights to a frame: visibility, shading, resolving.
//!
//! What depends on the view alone (which point each sample sees, which vertices are needed, the
//! geometry layers) is kept until the view changes, so that a light sweep pays for it once.

use std::sync::Arc;

use glam::{DVec3, Vec4};
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::render::bounds::Bounds;
use crate::render::btf_lookup::BtfLookup;
use crate::render::camera::View;
use crate::render::cover::Cover;
use crate::render::fill::{Fill, openness};
use crate::render::fragment::{Pieces, point};
use crate::render::frame::{Frame, GeometryLayers};
use crate::render::ground::Ground;
use crate::render::known_weights::KnownWeights;
use crate::render::light::Light;
use crate::render::occlusion::Occluders;
use crate::render::parallax::PatchReach;
use crate::render::pixel_shading::{self, Visibility, Workspace};
use crate::render::pixel_shadows::sample_visibilities;
use crate::render::raster::{Hit, Samples, SurfaceBuffer};
use crate::render::seen_points::KeptPoints;
use crate::render::sides::has_border;
use crate::render::vertex_lights::VertexLights;
use crate::render::vertex_shading::{self, ShadingScene, Site};
use crate::render::vertex_shadows::{ShadowCaster, VertexShadows};
use crate::render::vertices::Vertices;

/// The rate at which colour is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// At every vertex, interpolated between them (Tong et al. 2002).
    #[default]
    Vertex,
    /// In every pixel: a coarse mesh shows the sample at full resolution.
    Pixel,
}

/// Where lights are found to be hidden.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shadows {
    /// Nowhere: no cast shadows.
    None,
    /// At every vertex, by shadow rays; interpolated.
    #[default]
    Vertex,
    /// In every pixel, by shadow rays.
    Pixel,
}

/// How frames are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// The rate of colour.
    pub shading: Shading,
    /// The rate of shadows.
    pub shadows: Shadows,
    /// Samples per pixel.
    pub samples: Samples,
    /// Shadow rays for lights that have a size.
    pub soft_rays: u32,
    /// The light that fills the shade.
    pub fill: Option<Fill>,
    /// Up, where a ground shows the shadow.
    pub ground: Option<DVec3>,
    /// Whether frames carry the layers of the view: depth, normals, uv, textons.
    pub geometry_layers: bool,
    /// Whether frames carry `shadow.Y` and `weight.Y`.
    pub extra_layers: bool,
}

/// A decorated mesh and a sample, ready to be seen from anywhere.
pub struct Renderer<'a> {
    map: &'a SurfaceTextonMap,
    lookup: &'a BtfLookup,
    settings: RenderSettings,
    cover: Option<&'a Cover>,
    patches: Option<PatchReach>,
    progress: Progress<'a>,
    has_border: bool,
    bounds: Bounds,
    caster: Option<ShadowCaster>,
    ground: Option<Ground>,
    /// Per vertex the share of the fill light that reaches it.
    openness: Option<Vec<f32>>,
    shadows: VertexShadows,
    weights: VertexLights,
    vertices: Vertices,
    seen: Option<Seen>,
}

/// What one view sees.
struct Seen {
    view: View,
    surface: SurfaceBuffer,
    layers: Option<Arc<GeometryLayers>>,
    /// The vertices of seen triangles.
    vertices: Vertices,
    /// What pixel shading finds of the view, once it has stayed for a second frame.
    points: Option<KeptPoints>,
}

/// Lights that vertices are shaded by in one go: bounds the memory for what reaches them.
const LIGHTS_AT_ONCE: usize = 64;

impl<'a> Renderer<'a> {
    /// Prepares a map for rendering from a sample; frames stop when `progress` asks to.
    pub fn new(
        map: &'a SurfaceTextonMap,
        lookup: &'a BtfLookup,
        settings: RenderSettings,
        progress: Progress<'a>,
    ) -> Result<Self> {
        // Prepare what shadows need.
        let bounds = Bounds::of(&map.mesh)?;
        let has_border = has_border(&map.mesh);
        let casts_shadows = settings.shadows != Shadows::None;
        let occluders = || Occluders::new(&map.mesh, &bounds);
        let caster = casts_shadows.then(|| ShadowCaster::new(&map.mesh, occluders(), has_border));
        // Prepare the ground, and how open each vertex is to fill light.
        let (mut ground, mut open) = (None, None);
        if let Some(caster) = &caster {
            let below = |up| Ground::below(&bounds, up, &caster.occluders, settings.fill.is_some());
            ground = settings.ground.map(below);
            let openness = |_| openness(&caster.occluders, map, caster.vertices(), progress);
            open = settings.fill.map(openness);
        }
        progress.check()?;
        Ok(Self {
            map,
            ground,
            openness: open,
            lookup,
            settings,
            cover: None,
            patches: lookup.has_parallax().then(|| PatchReach::of_map(map)),
            progress,
            has_border,
            bounds,
            vertices: Vertices {
                by_texel: vertex_shading::sites_by_texel(map, lookup.grid()),
                by_place: caster
                    .iter()
                    .flat_map(ShadowCaster::vertices)
                    .copied()
                    .collect(),
            },
            caster,
            shadows: VertexShadows::default(),
            weights: VertexLights::default(),
            seen: None,
        })
    }

    /// Lets a plain colour show where the texture is transparent; `cover` has an entry per vertex of the map.
    #[must_use]
    pub fn over(self, cover: Option<&'a Cover>) -> Self {
        Self { cover, ..self }
    }

    /// Renders one frame. Every loop over pixels or vertices leaves off once it is interrupted; what
    /// it made till then is dropped.
    pub fn frame(&mut self, view: &View, lights: &[Light]) -> Result<Frame> {
        // Find what is seen; keep it where the camera stands still.
        let seen = match self.seen.take() {
            Some(seen) if seen.view == *view => self.revisit(seen),
            _ => self.rasterize(view),
        };
        // Shade it.
        self.refresh_weights(&seen, lights);
        let mut shadows = std::mem::take(&mut self.shadows);
        let mut rgba = self.resolve(&seen, lights, &mut shadows);
        let mut geometry = seen.layers.clone();
        // Darken the ground.
        if let Some(ground) = &self.ground {
            let scene = self.scene(view, lights, KnownWeights::default());
            ground.darken(&scene, &seen.surface, &mut rgba, geometry.as_mut());
        }
        // Fill the other layers.
        let extra = self.settings.extra_layers;
        let (shadow, beyond) = if extra {
            let (shadow, beyond) = self.extra_layers(&seen, lights, &mut shadows);
            (Some(shadow), Some(beyond))
        } else {
            (None, None)
        };
        let frame = Frame {
            size: view.size,
            rgba,
            geometry,
            shadow,
            beyond,
        };
        (self.seen, self.shadows) = (Some(seen), shadows);
        self.progress.check()?;
        Ok(frame)
    }

    /// Shades every vertex that a triangle uses for one view and lights, whether or not the view
    /// sees it; others stay black.
    pub fn vertex_colors(&self, view: &View, lights: &[Light]) -> Result<Vec<[f32; 3]>> {
        let shadows = &mut VertexShadows::default();
        let scene = self.scene(view, lights, KnownWeights::default());
        let colors = self.shade_vertices(&scene, &self.vertices, Some(shadows));
        self.progress.check()?;
        Ok(colors
            .into_iter()
            .map(|color| color.truncate().to_array())
            .collect())
    }

    /// Finds what will be asked of the lights more than once: by pixels, or by frames to come.
    fn refresh_weights(&mut self, seen: &Seen, lights: &[Light]) {
        let mut weights = std::mem::take(&mut self.weights);
        let needs: &[Site] = match self.settings.shading {
            Shading::Pixel => &seen.vertices.by_texel,
            Shading::Vertex => &[],
        };
        let scene = self.scene(&seen.view, lights, KnownWeights::default());
        weights.refresh(&scene, needs, &self.vertices.by_texel);
        self.weights = weights;
    }

    pub(super) fn scene<'b>(
        &'b self,
        view: &'b View,
        lights: &'b [Light],
        weights: KnownWeights<'b>,
    ) -> ShadingScene<'b> {
        ShadingScene {
            weights,
            map: self.map,
            lookup: self.lookup,
            view,
            lights,
            occluders: self.caster.as_ref().map(|caster| &caster.occluders),
            has_border: self.has_border,
            shows_inside: self.has_border,
            soft_rays: self.settings.soft_rays,
            patches: self.patches.as_ref(),
            cover: self.cover,
            fill: self.settings.fill,
            openness: self.openness.as_deref(),
            side: None,
            progress: self.progress,
        }
    }

    fn rasterize(&self, view: &View) -> Seen {
        let mesh = &self.map.mesh;
        let surface = SurfaceBuffer::draw(
            view,
            mesh,
            self.settings.samples,
            self.bounds.nearest(),
            self.progress,
        );
        let scene = self.scene(view, &[], KnownWeights::default());
        let inside = |hit: &Hit| scene.turns(hit.triangle, point(mesh, hit));
        let layers = || Arc::new(GeometryLayers::of_surface(&surface, self.map, view));
        Seen {
            view: *view,
            vertices: self.vertices.seen_in(&surface, mesh, inside),
            layers: self.settings.geometry_layers.then(layers),
            points: None,
            surface,
        }
    }

    /// What the view sees, for one more frame.
    fn revisit(&self, seen: Seen) -> Seen {
        if self.settings.shading == Shading::Vertex || seen.points.is_some() {
            return seen;
        }
        let scene = self.scene(&seen.view, &[], KnownWeights::default());
        Seen {
            points: KeptPoints::find(&scene, &seen.surface),
            ..seen
        }
    }

    fn resolve(&self, seen: &Seen, lights: &[Light], shadows: &mut VertexShadows) -> Vec<[f32; 4]> {
        let scene = self.scene(&seen.view, lights, self.weights.all());
        match (self.settings.shading, self.settings.shadows) {
            (Shading::Vertex, Shadows::None | Shadows::Vertex) => {
                self.resolve_vertices(seen, &scene, Some(shadows))
            }
            (Shading::Vertex, Shadows::Pixel) => self.resolve_pixel_shadows(seen, &scene),
            (Shading::Pixel, _) => self.resolve_pixels(seen, &scene, shadows),
        }
    }

    /// Colours of vertices, interpolated; without `shadows` as if nothing cast any.
    fn resolve_vertices(
        &self,
        seen: &Seen,
        scene: &ShadingScene,
        shadows: Option<&mut VertexShadows>,
    ) -> Vec<[f32; 4]> {
        let colors = self.shade_vertices(scene, &seen.vertices, shadows);
        let mesh = &self.map.mesh;
        seen.surface.map_pixels(
            CLEAR,
            || (),
            |(), hits| mean_color(mesh, &colors, seen.surface.color_hits(hits)),
        )
    }

    /// Colours by vertex, red to blue, of the chosen ones; without `shadows` as if nothing cast any.
    fn shade_vertices(
        &self,
        scene: &ShadingScene,
        chosen: &Vertices,
        mut shadows: Option<&mut VertexShadows>,
    ) -> Vec<Vec4> {
        let mut colors = vec![Vec4::ZERO; self.map.mesh.positions.len()];
        let parts = scene.lights.len().div_ceil(LIGHTS_AT_ONCE).max(1);
        for part in 0..parts {
            let first = part * LIGHTS_AT_ONCE;
            let last = scene.lights.len().min(first + LIGHTS_AT_ONCE);
            let lights = &scene.lights[first..last];
            let scene = ShadingScene {
                lights,
                weights: scene.weights.from(first),
                fill: scene.fill.filter(|_| part == 0),
                ..*scene
            };
            let reaches = match shadows.as_deref_mut() {
                Some(shadows) => self.find_shadows(lights, chosen, shadows),
                None => Vec::new(),
            };
            let shaded = vertex_shading::shade(&scene, &reaches, &chosen.by_texel);
            for (site, shaded) in chosen.by_texel.iter().zip(shaded) {
                colors[site.vertex as usize] += shaded;
            }
        }
        colors
    }

    /// Light by light the share that reaches the chosen vertices; nothing where nothing casts
    /// shadows.
    fn find_shadows<'s>(
        &self,
        lights: &[Light],
        chosen: &Vertices,
        shadows: &'s mut VertexShadows,
    ) -> Vec<&'s [f32]> {
        let Some(caster) = &self.caster else {
            return Vec::new();
        };
        let rays = self.settings.soft_rays;
        let vertices = &chosen.by_place;
        shadows.find(caster, self.map, lights, rays, vertices, self.progress);
        shadows.of_lights()
    }

    /// Vertex colours, light by light, under shadows found in every pixel.
    fn resolve_pixel_shadows(&self, seen: &Seen, scene: &ShadingScene) -> Vec<[f32; 4]> {
        let filled = scene.fill.map(|_| ShadingScene {
            lights: &[],
            ..*scene
        });
        let mut sum = match filled {
            Some(scene) => self.resolve_vertices(seen, &scene, None),
            None => Vec::new(),
        };
        for (index, light) in scene.lights.iter().enumerate() {
            let scene = ShadingScene {
                lights: std::slice::from_ref(light),
                weights: scene.weights.from(index),
                fill: None,
                ..*scene
            };
            let part = self.resolve_shadows_of(seen, &scene);
            if sum.is_empty() {
                sum = part;
                continue;
            }
            sum.par_iter_mut().zip(part).for_each(|(sum, part)| {
                for channel in 0..3 {
                    sum[channel] += part[channel];
                }
            });
        }
        sum
    }

    /// Colours under the scene's one light.
    fn resolve_shadows_of(&self, seen: &Seen, scene: &ShadingScene) -> Vec<[f32; 4]> {
        let (mesh, order) = (&self.map.mesh, seen.surface.by_distance());
        let colors = self.shade_vertices(scene, &seen.vertices, None);
        let share = 1.0 / order.len() as f32;
        seen.surface.map_pixels(
            CLEAR,
            || (),
            |(), hits| {
                if self.progress.is_interrupted() {
                    return CLEAR;
                }
                let pieces = Pieces::of_pixel(mesh, &seen.view, hits, order);
                let mut pixel = Pixel::default();
                for (piece, hit) in pieces.hits().iter().enumerate() {
                    let (samples, place) = (pieces.samples(piece), point(mesh, hit));
                    let reaches = sample_visibilities(scene, 0, hits, samples, place);
                    for sample in samples.iter() {
                        let lit = share * reaches[sample];
                        pixel.color += color_at(mesh, &colors, &hits[sample]) * lit;
                        pixel.coverage += share;
                    }
                }
                pixel.rgba()
            },
        )
    }

    /// Colours found in every pixel.
    fn resolve_pixels(
        &self,
        seen: &Seen,
        scene: &ShadingScene,
        shadows: &mut VertexShadows,
    ) -> Vec<[f32; 4]> {
        // Prepare the shadows.
        let of_vertices = self.interpolated_shadows(&seen.vertices, scene.lights, shadows);
        let visibility = self.pixel_visibility(&of_vertices);
        let surface = &seen.surface;
        // Shade the points of each band, and add them up per pixel.
        surface.map_bands(CLEAR, Workspace::default, |work, band, pixels| {
            let Workspace { points, shading } = work;
            let points = match &seen.points {
                Some(kept) => &kept.bands[band],
                None => {
                    points.find_band(scene, surface, band);
                    &*points
                }
            };
            for (pixel, share, point) in points.points() {
                if self.progress.is_interrupted() {
                    return;
                }
                let visibility = match visibility {
                    Visibility::Rays(_) => {
                        Visibility::Rays(surface.band_pixel(band, *pixel as usize))
                    }
                    other => other,
                };
                let shaded = pixel_shading::shade(scene, visibility, point, points, shading);
                let pixel = &mut pixels[*pixel as usize];
                *pixel =
                    (Vec4::from_array(*pixel) + (shaded.color * *share).with_w(*share)).to_array();
            }
        })
    }

    /// Whether views are blended with their parallax.
    pub(super) fn has_parallax(&self) -> bool {
        self.lookup.has_parallax()
    }

    /// Who may ask to stop.
    pub(super) fn progress(&self) -> Progress<'a> {
        self.progress
    }

    /// Per light the visibility of all vertices, by vertex, where points interpolate it.
    pub(super) fn visibility_of_all<'s>(
        &self,
        lights: &[Light],
        shadows: &'s mut VertexShadows,
    ) -> Vec<&'s [f32]> {
        self.interpolated_shadows(&self.vertices, lights, shadows)
    }

    /// Per light the visibility of the chosen vertices, by vertex, where pixels interpolate it.
    fn interpolated_shadows<'s>(
        &self,
        chosen: &Vertices,
        lights: &[Light],
        shadows: &'s mut VertexShadows,
    ) -> Vec<&'s [f32]> {
        match self.settings.shadows {
            Shadows::Vertex => self.find_shadows(lights, chosen, shadows),
            Shadows::None | Shadows::Pixel => Vec::new(),
        }
    }

    pub(super) fn pixel_visibility<'b>(&self, of_vertices: &'b [&'b [f32]]) -> Visibility<'b> {
        match self.settings.shadows {
            Shadows::None => Visibility::Open,
            Shadows::Vertex => Visibility::OfVertices(of_vertices),
            Shadows::Pixel => Visibility::Rays(&[]),
        }
    }

    /// `shadow.Y` and `weight.Y`, where the other layers are taken from.
    fn extra_layers(
        &self,
        seen: &Seen,
        lights: &[Light],
        shadows: &mut VertexShadows,
    ) -> (Vec<f32>, Vec<f32>) {
        let scene = self.scene(&seen.view, lights, self.weights.all());
        let of_vertices = self.interpolated_shadows(&seen.vertices, lights, shadows);
        let visibility = self.pixel_visibility(&of_vertices);
        let pairs = seen
            .surface
            .map_pixels([0.0; 2], Workspace::default, |work, hits| {
                let hit = seen.surface.layer_hit(hits);
                if !hit.is_surface() || self.progress.is_interrupted() {
                    return [0.0; 2];
                }
                let shaded = pixel_shading::shade_hit(&scene, visibility, &hit, work);
                [shaded.visibility, shaded.beyond]
            });
        pairs
            .into_iter()
            .map(|[shadow, beyond]| (shadow, beyond))
            .unzip()
    }
}

/// Nothing seen.
const CLEAR: [f32; 4] = [0.0; 4];

/// A pixel's colour as it grows, sample by sample.
#[derive(Clone, Copy, Default)]
struct Pixel {
    /// Red to blue; the fourth number means nothing.
    color: Vec4,
    coverage: f32,
}

impl Pixel {
    fn rgba(self) -> [f32; 4] {
        self.color.with_w(self.coverage).to_array()
    }
}

/// The interpolated colour of a sample.
#[inline]
fn color_at(mesh: &TriangleMesh, colors: &[Vec4], hit: &Hit) -> Vec4 {
    let [a, b, c] = mesh.triangles[hit.triangle as usize];
    let [u, v, w] = hit.barycentric();
    colors[a as usize] * u + colors[b as usize] * v + colors[c as usize] * w
}

/// The mean colour of a pixel's samples, those that see nothing included.
#[inline]
fn mean_color(mesh: &TriangleMesh, colors: &[Vec4], hits: &[Hit]) -> [f32; 4] {
    let mut pixel = Pixel::default();
    for hit in hits.iter().filter(|hit| hit.is_surface()) {
        pixel.color += color_at(mesh, colors, hit);
        pixel.coverage += 1.0;
    }
    let share = 1.0 / hits.len() as f32;
    pixel.color *= share;
    pixel.coverage *= share;
    pixel.rgba()
}
