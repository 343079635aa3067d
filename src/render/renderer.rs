//! From view and lights to a frame: visibility, shading, resolving.
//!
//! What depends on the view alone (which point each sample sees, which vertices are needed, the
//! geometry layers) is kept until the view changes, so that a light sweep pays for it once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::render::bounds::Bounds;
use crate::render::camera::View;
use crate::render::fragment::{Pieces, point};
use crate::render::frame::{Frame, GeometryLayers};
use crate::render::light::Light;
use crate::render::occlusion::Occluders;
use crate::render::pixel_shading::{self, Visibility, Workspace, ray_visibility};
use crate::render::radiance::Radiance;
use crate::render::raster::{Hit, Samples, SurfaceBuffer};
use crate::render::vertex_shading::{self, Scene, Site};
use crate::surface_map::SurfaceTextonMap;

/// The rate at which colour is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// At every vertex, interpolated (Tong et al. 2002).
    #[default]
    Vertex,
    /// In every pixel: a coarse mesh shows the sample at full resolution.
    Pixel,
}

/// Where lights are found to be hidden.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
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
pub struct Manner {
    /// The rate of colour.
    pub shading: Shading,
    /// The rate of shadows.
    pub shadows: Shadows,
    /// Samples a pixel.
    pub samples: Samples,
    /// Shadow rays for lights that have a size.
    pub soft_rays: u32,
    /// Whether frames carry `shadow.Y` and `weight.Y`.
    pub extra_layers: bool,
}

/// A decorated mesh and a sample, ready to be seen from anywhere.
pub struct Renderer<'a> {
    map: &'a SurfaceTextonMap,
    radiance: &'a Radiance,
    manner: Manner,
    bounds: Bounds,
    occluders: Option<Occluders>,
    sites: Vec<Site>,
    seen: Option<Seen>,
}

/// What one view sees.
struct Seen {
    view: View,
    surface: SurfaceBuffer,
    layers: Arc<GeometryLayers>,
    /// The vertices of seen triangles, by texel.
    sites: Vec<Site>,
}

impl<'a> Renderer<'a> {
    /// Prepares a map for rendering from a sample.
    pub fn new(map: &'a SurfaceTextonMap, radiance: &'a Radiance, manner: Manner) -> Result<Self> {
        let bounds = Bounds::of(&map.mesh)?;
        let casts_shadows = manner.shadows != Shadows::None;
        Ok(Self {
            map,
            radiance,
            manner,
            bounds,
            occluders: casts_shadows.then(|| Occluders::new(&map.mesh, &bounds)),
            sites: vertex_shading::sites_by_texel(map, radiance.grid()),
            seen: None,
        })
    }

    /// The space the mesh fills.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Renders one frame.
    pub fn frame(&mut self, view: &View, lights: &[Light]) -> Frame {
        let seen = match self.seen.take() {
            Some(seen) if seen.view == *view => seen,
            _ => self.look(view),
        };
        let rgba = self.resolve(&seen, lights);
        let extra = self.manner.extra_layers;
        let (shadow, beyond) = if extra {
            let (shadow, beyond) = self.extra_layers(&seen, lights);
            (Some(shadow), Some(beyond))
        } else {
            (None, None)
        };
        let frame = Frame {
            size: view.size,
            rgba,
            geometry: Arc::clone(&seen.layers),
            shadow,
            beyond,
        };
        self.seen = Some(seen);
        frame
    }

    /// Shades every vertex that a triangle uses for one view and lights, whether or not the view
    /// sees it; others stay black.
    pub fn vertex_colors(&self, view: &View, lights: &[Light]) -> Vec<[f32; 3]> {
        let shadows = self.manner.shadows != Shadows::None;
        let scene = self.scene(view, lights, shadows);
        let shaded = vertex_shading::shade(&scene, &self.sites);
        let mut colors = vec![[0.0; 3]; self.map.mesh.positions.len()];
        for (site, shaded) in self.sites.iter().zip(shaded) {
            colors[site.vertex as usize] = shaded.rgb;
        }
        colors
    }

    fn scene<'b>(&'b self, view: &'b View, lights: &'b [Light], shadows: bool) -> Scene<'b> {
        Scene {
            map: self.map,
            radiance: self.radiance,
            view,
            lights,
            occluders: self.occluders.as_ref().filter(|_| shadows),
            soft_rays: self.manner.soft_rays,
        }
    }

    fn look(&self, view: &View) -> Seen {
        let mesh = &self.map.mesh;
        let surface = SurfaceBuffer::draw(view, mesh, self.manner.samples, self.bounds.nearest());
        let layers = GeometryLayers::of_surface(&surface, self.map, view);
        Seen {
            view: *view,
            sites: needed_sites(mesh, &surface, &self.sites),
            surface,
            layers: Arc::new(layers),
        }
    }

    fn resolve(&self, seen: &Seen, lights: &[Light]) -> Vec<[f32; 4]> {
        match (self.manner.shading, self.manner.shadows) {
            (Shading::Vertex, Shadows::None | Shadows::Vertex) => {
                let colors = self.colors_of_seen(seen, lights, true);
                let mesh = &self.map.mesh;
                seen.surface.map_pixels(
                    CLEAR,
                    || (),
                    |(), hits| mean_color(mesh, &colors, seen.surface.color_hits(hits)),
                )
            }
            (Shading::Vertex, Shadows::Pixel) => self.resolve_pixel_shadows(seen, lights),
            (Shading::Pixel, _) => self.resolve_pixels(seen, lights),
        }
    }

    /// Colours of the seen vertices, by vertex, with their coverage of 1.
    fn colors_of_seen(&self, seen: &Seen, lights: &[Light], shadows: bool) -> Vec<[f32; 4]> {
        let scene = self.scene(&seen.view, lights, shadows);
        let shaded = vertex_shading::shade(&scene, &seen.sites);
        let mut colors = vec![CLEAR; self.map.mesh.positions.len()];
        for (site, shaded) in seen.sites.iter().zip(shaded) {
            let [r, g, b] = shaded.rgb;
            colors[site.vertex as usize] = [r, g, b, 1.0];
        }
        colors
    }

    /// Vertex colours, light by light, under shadows found in every pixel.
    fn resolve_pixel_shadows(&self, seen: &Seen, lights: &[Light]) -> Vec<[f32; 4]> {
        let mut sum: Vec<[f32; 4]> = Vec::new();
        for light in lights {
            let part = self.resolve_shadows_of(seen, light);
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

    fn resolve_shadows_of(&self, seen: &Seen, light: &Light) -> Vec<[f32; 4]> {
        let (mesh, order) = (&self.map.mesh, seen.surface.by_distance());
        let lights = std::slice::from_ref(light);
        let colors = self.colors_of_seen(seen, lights, false);
        let scene = self.scene(&seen.view, lights, true);
        let share = 1.0 / order.len() as f32;
        seen.surface.map_pixels(
            CLEAR,
            || (),
            |(), hits| {
                let pieces = Pieces::of_pixel(mesh, &seen.view, hits, order);
                let mut reaches = [0.0; 16];
                for (reaches, hit) in reaches.iter_mut().zip(pieces.hits()) {
                    let p = point(mesh, hit);
                    *reaches = ray_visibility(&scene, 0, &light.at(p), hit, p);
                }
                let mut pixel = CLEAR;
                for &sample in order {
                    if hits[sample].is_surface() {
                        let lit = share * reaches[pieces.of_sample(sample)];
                        let [r, g, b, _] = color_at(mesh, &colors, &hits[sample]);
                        add(&mut pixel, [r * lit, g * lit, b * lit, share]);
                    }
                }
                pixel
            },
        )
    }

    /// Colours found in every pixel.
    fn resolve_pixels(&self, seen: &Seen, lights: &[Light]) -> Vec<[f32; 4]> {
        let (mesh, order) = (&self.map.mesh, seen.surface.by_distance());
        let scene = self.scene(&seen.view, lights, true);
        let of_vertices = self.visibilities(seen, lights);
        let visibility = self.pixel_visibility(&of_vertices);
        seen.surface
            .map_pixels(CLEAR, Workspace::default, |work, hits| {
                let pieces = Pieces::of_pixel(mesh, &seen.view, hits, order);
                let mut pixel = CLEAR;
                for (piece, hit) in pieces.hits().iter().enumerate() {
                    let [r, g, b] = pixel_shading::shade(&scene, visibility, hit, work).rgb;
                    let share = pieces.share(piece);
                    add(&mut pixel, [r * share, g * share, b * share, share]);
                }
                pixel
            })
    }

    /// Per light the visibility of the seen vertices, by vertex, where pixels interpolate it.
    fn visibilities(&self, seen: &Seen, lights: &[Light]) -> Vec<Vec<f32>> {
        if self.manner.shadows != Shadows::Vertex {
            return Vec::new();
        }
        let scene = self.scene(&seen.view, lights, true);
        let of_light = |light: &Light| {
            let found = vertex_shading::visibilities(&scene, light, &seen.sites);
            let mut of_vertices = vec![0.0; self.map.mesh.positions.len()];
            for (site, reaches) in seen.sites.iter().zip(found) {
                of_vertices[site.vertex as usize] = reaches;
            }
            of_vertices
        };
        lights.iter().map(of_light).collect()
    }

    fn pixel_visibility<'b>(&self, of_vertices: &'b [Vec<f32>]) -> Visibility<'b> {
        match self.manner.shadows {
            Shadows::None => Visibility::Open,
            Shadows::Vertex => Visibility::OfVertices(of_vertices),
            Shadows::Pixel => Visibility::Rays,
        }
    }

    /// `shadow.Y` and `weight.Y`, where the other layers are taken from.
    fn extra_layers(&self, seen: &Seen, lights: &[Light]) -> (Vec<f32>, Vec<f32>) {
        let scene = self.scene(&seen.view, lights, true);
        let of_vertices = self.visibilities(seen, lights);
        let visibility = self.pixel_visibility(&of_vertices);
        let pairs = seen
            .surface
            .map_pixels([0.0; 2], Workspace::default, |work, hits| {
                let hit = seen.surface.layer_hit(hits);
                if !hit.is_surface() {
                    return [0.0; 2];
                }
                let shaded = pixel_shading::shade(&scene, visibility, &hit, work);
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

/// The vertices of all triangles that some sample sees, in the order of `sites`.
fn needed_sites(mesh: &TriangleMesh, surface: &SurfaceBuffer, sites: &[Site]) -> Vec<Site> {
    let needed: Vec<AtomicBool> = (0..mesh.positions.len())
        .map(|_| AtomicBool::new(false))
        .collect();
    surface.for_each_surface(|hit| {
        for vertex in mesh.triangles[hit.triangle as usize] {
            needed[vertex as usize].store(true, Ordering::Relaxed);
        }
    });
    let is_needed = |site: &&Site| needed[site.vertex as usize].load(Ordering::Relaxed);
    sites.iter().filter(is_needed).copied().collect()
}

/// The interpolated colour of a sample.
#[inline]
fn color_at(mesh: &TriangleMesh, colors: &[[f32; 4]], hit: &Hit) -> [f32; 4] {
    let [a, b, c] = mesh.triangles[hit.triangle as usize].map(|v| colors[v as usize]);
    let [u, v, w] = hit.barycentric();
    [0, 1, 2, 3].map(|k| a[k] * u + b[k] * v + c[k] * w)
}

/// The mean colour of a pixel's samples, those that see nothing included.
#[inline]
fn mean_color(mesh: &TriangleMesh, colors: &[[f32; 4]], hits: &[Hit]) -> [f32; 4] {
    let mut sum = CLEAR;
    let mut covered = 0;
    for hit in hits.iter().filter(|hit| hit.is_surface()) {
        add(&mut sum, color_at(mesh, colors, hit));
        covered += 1;
    }
    let share = 1.0 / hits.len() as f32;
    [
        sum[0] * share,
        sum[1] * share,
        sum[2] * share,
        covered as f32 * share,
    ]
}

#[inline]
fn add(sum: &mut [f32; 4], part: [f32; 4]) {
    for (sum, part) in sum.iter_mut().zip(part) {
        *sum += part;
    }
}
