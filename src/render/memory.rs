//! How much memory a sweep takes, before any work is done.
//!
//! Figures are of the lists that dominate, measured on frames of 320 × 240 to 3840 × 2160 pixels and maps
//! of 30,000 and 250,000 vertices, where the surface fills the frame: at most 1.5 times the peak of the
//! process, and not below it. Parts of a frame that show nothing take less, and so do the points of pixel
//! shading where more are seen than are kept. The sample's own file does not count.

use crate::btf::factored::Factors;
use crate::btf::sample::Sample;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::render::light::Light;
use crate::render::nearest::Weighting;
use crate::render::option_values::{Layer, Sweep};
use crate::render::options::RenderOptions;
use crate::render::parallax::Parallax;
use crate::render::plan::PlannedFrame;
use crate::render::renderer::Shading;
use crate::render::table_levels::TableLevels;

/// Bytes of what a sample of a pixel sees.
const HIT: u64 = 12;
/// Bytes of a pixel's colour and layers, as they are made and encoded.
const PIXEL: u64 = 108;
/// Bytes of a pixel of one more frame, which is written while the next is made.
const WAITING_PIXEL: u64 = 36;
/// Bytes of a pixel whose colour is written in 32 bits, or that has a layer beyond the standard ones.
const WIDE_PIXEL: u64 = 48;
/// Bytes of a pixel of a frame with a ground: layers of its own, and the ground's depth.
const GROUND_PIXEL: u64 = 32;
/// Bytes of a point kept for the next frame by pixel shading, and how many pixels are kept.
const KEPT_POINT: u64 = 320;
const KEPT_PIXELS: u64 = 1 << 20;
/// Bytes of a vertex and of a triangle: the file's columns, frames, the hierarchy that rays meet.
const VERTEX: u64 = 280;
const TRIANGLE: u64 = 150;
/// Bytes that a vertex keeps of each light: whether it is reached; and its weights, of this many lights.
const REACHED: u64 = 4;
const WEIGHTED: u64 = 130;
const WEIGHTED_LIGHTS: u64 = 8;
/// Bytes of a texel's height: as the surface, and as each view sees it, coarser levels included.
const SURFACE_HEIGHT: u64 = 24;
const SEEN_HEIGHT: u64 = 6;
/// Bytes by which a list of quadratic weights is longer.
const LONGER_LIST: u64 = 72;
/// Sums of a view's images that fill light is made of.
const SUMS: usize = 4;
/// Bytes that are filled at a time when the sample laid out for shading goes to disk.
const SLAB: u64 = 256 << 20;
/// The program, and working memory of its threads.
const PROGRAM: u64 = 16 << 20;

/// Bytes that frames and the surface take; the sample laid out for shading apart.
pub fn frame_bytes(options: &RenderOptions, map: &SurfaceTextonMap) -> u64 {
    let [width, height] = options.image.size.0.map(u64::from);
    let many = frame_count(options) > 1;
    let hits = HIT * options.image.samples.stored() as u64;
    let standard = |layer: &Layer| !matches!(layer, Layer::Shadow | Layer::Weight);
    let mut pixel = hits + PIXEL;
    if many {
        pixel += WAITING_PIXEL;
    }
    if many && view_moves(options) {
        pixel += hits;
    }
    if options.files.float || !options.files.layers.iter().all(standard) {
        pixel += WIDE_PIXEL;
    }
    if options.lights.ground {
        pixel += GROUND_PIXEL;
    }
    let mut bytes = width * height * pixel + PROGRAM;
    if many && options.image.shading == Shading::Pixel {
        bytes += (KEPT_POINT + 3 * longer_list(options)) * (width * height).min(KEPT_PIXELS);
    }
    // Weights are listed for what asks more than once: pixels, or frames to come.
    let listed = many || options.image.shading == Shading::Pixel;
    let weighted = match listed {
        true => WEIGHTED + longer_list(options),
        false => 0,
    };
    bytes + surface_bytes(map, light_count(options), weighted) + plan_bytes(options)
}

fn longer_list(options: &RenderOptions) -> u64 {
    match options.image.weights {
        Weighting::Quadratic => LONGER_LIST,
        Weighting::Continuous | Weighting::InverseAngle => 0,
    }
}

/// Whether frames may differ in their cameras.
fn view_moves(options: &RenderOptions) -> bool {
    let swept = matches!(options.sweep.kind, Sweep::ViewOrbit | Sweep::File(_));
    swept || options.camera.camera_path.is_some()
}

/// Bytes of the sample laid out for shading that stay in memory, and of the factors of a factored one.
pub fn table_bytes(options: &RenderOptions, sample: &Sample) -> u64 {
    let description = sample.description();
    let sums = match options.lights.fill > 0.0 {
        true => SUMS * description.views.len(),
        false => 0,
    };
    let numbers = (sample.image_count() + sums) * 3;
    let levels = TableLevels {
        finest: sample.grid(),
        stride: numbers as u64 * description.dtype.size() as u64,
        mip: options.image.uses_mip(),
    };
    let allowed = options.files.table_memory.saturating_mul(1 << 20);
    let slab = match levels.on_disk(allowed) {
        0 => 0,
        _ => SLAB,
    };
    let table = levels.bytes_in_memory(allowed) + slab;
    table + sample.factors().map_or(0, Factors::bytes) + relief_bytes(options, sample)
}

/// Bytes of what views see of the heights that they may be blended over.
fn relief_bytes(options: &RenderOptions, sample: &Sample) -> u64 {
    if options.image.parallax == Parallax::Off {
        return 0;
    }
    let texels = sample.grid().len() as u64;
    texels * (SURFACE_HEIGHT + SEEN_HEIGHT * sample.description().views.len() as u64)
}

/// Bytes of the surface, of which each vertex keeps `weighted` per light that has lists.
fn surface_bytes(map: &SurfaceTextonMap, lights: u64, weighted: u64) -> u64 {
    let vertices = map.mesh.positions.len() as u64;
    let of_lights = REACHED * lights + weighted * lights.min(WEIGHTED_LIGHTS);
    vertices * (VERTEX + of_lights) + TRIANGLE * map.mesh.triangles.len() as u64
}

/// Cameras and lights of all frames, planned before the first is made.
fn plan_bytes(options: &RenderOptions) -> u64 {
    let frame = size_of::<PlannedFrame>() as u64 + 64;
    frame_count(options) * (frame + light_count(options) * size_of::<Light>() as u64)
}

/// Lights of a frame.
pub fn light_count(options: &RenderOptions) -> u64 {
    let environment = match options.lights.environment {
        Some(_) => u64::from(options.lights.environment_lights),
        None => 0,
    };
    (options.lights.light.len() as u64 + environment).max(1)
}

/// Frames of the run; 24 where a file says how many.
pub fn frame_count(options: &RenderOptions) -> u64 {
    match (&options.sweep.frames, options.sweep.sweep_length) {
        (Some(range), _) => range.numbers().count() as u64,
        (None, Some(length)) => u64::from(length),
        (None, None)
            if options.sweep.kind == Sweep::None && options.camera.camera_path.is_none() =>
        {
            1
        }
        (None, None) => 24,
    }
}
