//! A finished frame in memory: colour and the layers beside it, as EXR channels.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use crate::format::exr::Numbers;
use crate::index::TextonLabel;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::render::camera::View;
use crate::render::fragment::point;
use crate::render::raster::{Hit, SurfaceBuffer};

/// The layers that depend on the view alone, row by row from the top.
#[derive(Clone, Debug, Default)]
pub struct GeometryLayers {
    /// Distance along the view axis; +∞ where nothing is seen.
    pub depth: Vec<f32>,
    /// World-space unit normals, interpolated; 0 where nothing is seen.
    pub normals: [Vec<f32>; 3],
    /// Texture coordinate over the sample's size, of the vertex with the largest weight; 0 where
    /// nothing is seen.
    pub uv: [Vec<f32>; 2],
    /// Texton of the vertex with the largest weight; 65535 where nothing is seen.
    pub textons: Vec<u32>,
}

/// A frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Linear Rec. 709, premultiplied by the coverage in A.
    pub rgba: Vec<[f32; 4]>,
    /// Layers of the view, where they were asked for.
    pub geometry: Option<Arc<GeometryLayers>>,
    /// Share of the lights that reaches the surface, where it was asked for.
    pub shadow: Option<Vec<f32>>,
    /// Share of the weight from beyond the sampled range, where it was asked for.
    pub beyond: Option<Vec<f32>>,
}

/// One pixel of [`GeometryLayers`].
#[derive(Clone, Copy)]
struct LayerPixel {
    depth: f32,
    normal: Vec3,
    uv: [f32; 2],
    texton: u32,
}

const NOTHING_SEEN: LayerPixel = LayerPixel {
    depth: f32::INFINITY,
    normal: Vec3::ZERO,
    uv: [0.0; 2],
    texton: TextonLabel::NONE.0 as u32,
};

impl GeometryLayers {
    /// Reads the layers off what the samples see.
    pub fn of_surface(surface: &SurfaceBuffer, map: &SurfaceTextonMap, view: &View) -> Self {
        let pixels = surface.map_pixels(
            NOTHING_SEEN,
            || (),
            |(), hits| layer_pixel(map, view, surface.layer_hit(hits)),
        );
        Self {
            depth: plane(&pixels, |pixel| pixel.depth),
            normals: [
                plane(&pixels, |pixel| pixel.normal.x),
                plane(&pixels, |pixel| pixel.normal.y),
                plane(&pixels, |pixel| pixel.normal.z),
            ],
            uv: [
                plane(&pixels, |pixel| pixel.uv[0]),
                plane(&pixels, |pixel| pixel.uv[1]),
            ],
            textons: plane(&pixels, |pixel| pixel.texton),
        }
    }
}

/// One layer of all pixels.
fn plane<N: Send>(
    pixels: &[LayerPixel],
    number: impl Fn(&LayerPixel) -> N + Sync + Send,
) -> Vec<N> {
    pixels
        .par_iter()
        .with_min_len(1 << 14)
        .map(number)
        .collect()
}

fn layer_pixel(map: &SurfaceTextonMap, view: &View, hit: Hit) -> LayerPixel {
    if !hit.is_surface() {
        return NOTHING_SEEN;
    }
    let corners = map.mesh.triangles[hit.triangle as usize];
    let position = point(&map.mesh, &hit).as_dvec3();
    let [a, b, c] = corners;
    let [u, v, w] = hit.barycentric();
    let normal =
        map.normals[a as usize] * u + map.normals[b as usize] * v + map.normals[c as usize] * w;
    let vertex = corners[hit.nearest_corner()] as usize;
    let coord = map.coords[vertex];
    let [width, height] = map.header.exemplar;
    LayerPixel {
        depth: view.camera_from_world(position).z as f32,
        normal: normal.normalize_or_zero(),
        uv: [coord.s / width as f32, coord.t / height as f32],
        texton: u32::from(map.textons[vertex].0),
    }
}

/// Which groups of channels a frame's file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LayerGroup {
    /// `R G B A`
    Rgba,
    /// `Z`
    Depth,
    /// `N.X N.Y N.Z`
    Normals,
    /// `uv.U uv.V`
    Uv,
    /// `texton.I`
    Texton,
    /// `shadow.Y`
    Shadow,
    /// `weight.Y`
    Weight,
}

/// The largest finite half; brighter colours are clamped to it.
const LARGEST_HALF: f32 = 65504.0;

impl Frame {
    /// The frame's channels by their EXR names; colour in halfs unless `float`.
    pub fn channels(&self, groups: &[LayerGroup], float: bool) -> BTreeMap<String, Numbers<'_>> {
        let mut channels = BTreeMap::new();
        let mut add = |name: &str, numbers| {
            channels.insert(name.to_string(), numbers);
        };
        let layer = |numbers| Numbers::Float(Cow::Borrowed(numbers));
        let geometry = self.geometry.as_deref();
        // Name the planes of each group.
        for group in groups {
            match group {
                LayerGroup::Rgba => {
                    for (channel, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
                        add(name, self.color(channel, float));
                    }
                }
                LayerGroup::Depth => geometry.iter().for_each(|g| add("Z", layer(&g.depth))),
                LayerGroup::Normals => {
                    let planes = geometry.iter().flat_map(|g| &g.normals);
                    let named = ["N.X", "N.Y", "N.Z"].into_iter().zip(planes);
                    named.for_each(|(name, plane)| add(name, layer(plane)));
                }
                LayerGroup::Uv => {
                    let planes = geometry.iter().flat_map(|g| &g.uv);
                    let named = ["uv.U", "uv.V"].into_iter().zip(planes);
                    named.for_each(|(name, plane)| add(name, layer(plane)));
                }
                LayerGroup::Texton => {
                    let labels = geometry.iter().map(|g| Cow::Borrowed(&g.textons[..]));
                    labels.for_each(|labels| add("texton.I", Numbers::Uint(labels)));
                }
                LayerGroup::Shadow => self.shadow.iter().for_each(|p| add("shadow.Y", layer(p))),
                LayerGroup::Weight => self.beyond.iter().for_each(|p| add("weight.Y", layer(p))),
            }
        }
        channels
    }

    fn color(&self, channel: usize, float: bool) -> Numbers<'_> {
        let pixels = self.rgba.par_iter().with_min_len(1 << 14);
        if float {
            let color: Vec<f32> = pixels.map(|pixel| pixel[channel]).collect();
            return Numbers::Float(color.into());
        }
        let half = |pixel: &[f32; 4]| f16::from_f32(pixel[channel].min(LARGEST_HALF));
        let color: Vec<f16> = pixels.map(half).collect();
        Numbers::Half(color.into())
    }
}
