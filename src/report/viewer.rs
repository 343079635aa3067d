//! The page of `mesotex view`: a decorated surface to turn, under a light to move.

use std::borrow::Cow;

use serde_json::{Value, json};

use crate::btf::direction::Direction;
use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::render::Axis;
use crate::render::bounds::Bounds;
use crate::render::even_light;
use crate::render::front::Front;
use crate::report::coarser_surface::coarser_surface;
use crate::report::numbers;
use crate::report::page::{STYLE, bundle, filled, json};
use crate::report::surface_columns::{SurfaceDescription, surface_columns};
use crate::report::view_factors::{Limits, ViewFactors, view_factors};

/// The most bytes of a page.
pub const LARGEST_PAGE: usize = 30_000_000;
/// The part of it that templates and scripts take, and the least that is left to the sample.
const FRAME: usize = 200_000;
const LEAST_SAMPLE: usize = 2_000_000;
/// The fewest vertices that a surface is reduced to.
const FEWEST: usize = 1000;
/// The most texels of all images on the graphics card, 4 bytes each.
const MOST_TEXELS: u64 = 1 << 27;
/// Radiance of the even environment.
const ENVIRONMENT: f64 = 0.35;
/// Whether weights reproduce linear change, as those of `mesotex render` do.
const IS_LINEAR: bool = true;

const MODULES: [&str; 9] = [
    include_str!("web/numbers.js"),
    include_str!("web/vectors.js"),
    include_str!("web/sample.js"),
    include_str!("web/surface.js"),
    include_str!("web/textures.js"),
    include_str!("web/images.js"),
    include_str!("web/camera.js"),
    include_str!("web/candidates.js"),
    include_str!("web/picture.js"),
];
const SHADERS: [(&str, &str); 5] = [
    ("full-vert", include_str!("web/full.vert")),
    ("seen-vert", include_str!("web/seen.vert")),
    ("seen-frag", include_str!("web/seen.frag")),
    ("weights-frag", include_str!("web/weights.frag")),
    ("shade-frag", include_str!("web/shade.frag")),
];

/// How a viewer is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewerOptions {
    /// The error that factors may leave, relative to the root mean square of all values.
    pub error: f64,
    /// The axis of the mesh that points up.
    pub up: Axis,
    /// The side that is seen first; guessed from the mesh's shape where it is `None`.
    pub front: Option<Axis>,
}

impl ViewerOptions {
    /// Refuses errors that no factors have.
    pub fn validate(&self) -> Result<()> {
        match self.error > 0.0 && self.error < 1.0 {
            true => Ok(()),
            false => Err(Error::option(
                "error",
                self.error.to_string(),
                "above 0 and below 1: a share of the root mean square of all values",
            )),
        }
    }
}

/// A page, and what it holds.
#[derive(Clone, Debug)]
pub struct ViewerPage {
    /// The text of the page.
    pub html: String,
    /// Vertices of the surface that it shows.
    pub vertices: usize,
    /// The error that factors leave.
    pub error: f64,
    /// The most eigentextures of a view.
    pub rank: usize,
    /// What a user should know of the page.
    pub notes: Vec<String>,
}

/// Makes the page of a map and its sample.
pub fn viewer_page(
    (sample, map): (&Sample, &SurfaceTextonMap),
    title: &str,
    options: &ViewerOptions,
    progress: Progress<'_>,
) -> Result<ViewerPage> {
    options.validate()?;
    // Pack the surface, and the sample into what room is left.
    let surface = PackedSurface::fitting(map, LARGEST_PAGE)?;
    let limits = Limits {
        error: options.error,
        bytes: surface.left,
        texels: MOST_TEXELS,
    };
    let factors = view_factors(sample, &limits, progress)?;
    // Note what was left out.
    let mut notes = notes(&factors, options, sample);
    if surface.vertices < map.mesh.positions.len() {
        notes.push(format!(
            "the surface's {} vertices are reduced to {}, so that a page holds them",
            map.mesh.positions.len(),
            surface.vertices
        ));
    }
    // Fill the template.
    let front = Front::of(&map.mesh, options.up, options.front)?.axis;
    let description = page_description((sample, &factors), &surface, (options.up, front));
    let mut values = template_values((sample, &factors), &surface, &description)?;
    values["title"] = json!(title);
    values["notes"] = json!(notes);
    let ranks = factors.groups.iter().map(|group| group.rank);
    Ok(ViewerPage {
        html: filled(include_str!("web/view.html"), values)?,
        vertices: surface.vertices,
        error: factors.error,
        rank: ranks.max().unwrap_or(0),
        notes,
    })
}

/// What the scripts draw, and how it is seen first.
fn page_description(
    (sample, factors): (&Sample, &ViewFactors),
    surface: &PackedSurface,
    (up, front): (Axis, Axis),
) -> Value {
    let front = front.vector().to_array();
    json!({
        "sample": sample_description(sample, factors),
        "surface": surface.description,
        "centre": surface.bounds.centre.to_array(),
        "radius": surface.bounds.radius,
        "fov": 30.0,
        "compass": {"up": up.vector().to_array(), "zero": front},
        "lightZero": front,
        "view": {"azimuth": 0.0, "elevation": 15.0},
        "light": {"azimuth": 30.0, "elevation": 45.0},
        "irradiance": std::f64::consts::PI,
        "environment": ENVIRONMENT,
        "background": 0.03,
    })
}

/// What the template holds beside the title and the notes.
fn template_values(
    (sample, factors): (&Sample, &ViewFactors),
    surface: &PackedSurface,
    description: &Value,
) -> Result<Value> {
    Ok(json!({
        "style": STYLE,
        "vertices": surface.vertices,
        "size": format!("{} × {} texels", factors.size[0], factors.size[1]),
        "directions": directions(sample, factors),
        "error": format!("{:.1} %", 100.0 * factors.error),
        "has_environment": sample.description().pairs.is_none(),
        "shaders": shaders(),
        "description": json(description)?,
        "surface": numbers::base64(&surface.columns),
        "sample": numbers::base64(&factors.packed),
        "script": format!("{}\n{}", bundle(&MODULES), bundle(&[include_str!("web/viewer.js")])),
    }))
}

/// A surface as a page holds it.
struct PackedSurface {
    description: SurfaceDescription,
    columns: Vec<u8>,
    bounds: Bounds,
    vertices: usize,
    /// Bytes that it leaves of the page to the sample.
    left: usize,
}

impl PackedSurface {
    /// A map's surface, with fewer vertices where a page of this many bytes has no room for all.
    fn fitting(map: &SurfaceTextonMap, page: usize) -> Result<Self> {
        let mut map = Cow::Borrowed(map);
        loop {
            let packed = Self::new(&map, page)?;
            if packed.left >= LEAST_SAMPLE || packed.vertices <= FEWEST {
                return Ok(packed);
            }
            let room = page.saturating_sub(FRAME + numbers::base64_length(LEAST_SAMPLE));
            let share = room as f64 / numbers::base64_length(packed.columns.len()) as f64;
            let most = (share.min(0.9) * packed.vertices as f64) as usize;
            map = Cow::Owned(coarser_surface(&map, most.max(FEWEST)));
        }
    }

    fn new(map: &SurfaceTextonMap, page: usize) -> Result<Self> {
        let bounds = Bounds::of(&map.mesh)?;
        let (description, columns) = surface_columns(map, &bounds)?;
        let columns = numbers::gzip(&columns)
            .map_err(Error::io(std::path::Path::new("the page"), "compress"))?;
        let left = page.saturating_sub(FRAME + numbers::base64_length(columns.len()));
        Ok(Self {
            description,
            bounds,
            vertices: map.mesh.positions.len(),
            left: left / 4 * 3,
            columns,
        })
    }
}

fn notes(factors: &ViewFactors, options: &ViewerOptions, sample: &Sample) -> Vec<String> {
    let mut notes = vec!["parts of the surface cast no shadows on each other here".to_owned()];
    if factors.error > 1.05 * options.error {
        notes.push(format!(
            "the requested error is {:.1} %; the factors that fit a page of {} MB have an error of {:.1} %",
            100.0 * options.error,
            LARGEST_PAGE / 1_000_000,
            100.0 * factors.error
        ));
    }
    if factors.halvings > 0 {
        let [width, height] = [sample.grid().width, sample.grid().height];
        notes.push(format!(
            "the sample's {width} × {height} texels are reduced to {} × {}, so that its images fit a graphics card",
            factors.size[0], factors.size[1]
        ));
    }
    notes
}

fn directions(sample: &Sample, factors: &ViewFactors) -> String {
    let [views, lights] = factors.directions.each_ref().map(Vec::len);
    let plural =
        |count: usize, name: &str| format!("{count} {name}{}", if count == 1 { "" } else { "s" });
    match sample.description().pairs {
        Some(_) => plural(views, "scattered pair"),
        None => format!("{} × {}", plural(views, "view"), plural(lights, "light")),
    }
}

/// What the scripts need to know of a sample's factors.
pub(super) fn sample_description(sample: &Sample, factors: &ViewFactors) -> Value {
    // List the directions that are kept.
    let of = sample.description();
    let chosen = |indices: &[u32], list: &[Direction]| -> Vec<[f64; 3]> {
        let unit = |&index: &u32| list[index as usize].0.normalize().to_array();
        indices.iter().map(unit).collect()
    };
    let [views, lights] = &factors.directions;
    let is_scattered = of.pairs.is_some();
    let kept: Vec<Direction> = lights
        .iter()
        .map(|&light| of.lights[light as usize])
        .collect();
    // Share out even light.
    let even_light = match is_scattered {
        true => Vec::new(),
        false => even_light::shares(&kept),
    };
    // Describe the groups.
    let groups: Vec<Value> = factors
        .groups
        .iter()
        .map(|group| json!({"images": group.images, "rank": group.rank}))
        .collect();
    json!({
        "width": factors.size[0],
        "height": factors.size[1],
        "tileable": of.tileable,
        "scattered": is_scattered,
        "linear": IS_LINEAR,
        "step": factors.step,
        "groups": groups,
        "views": chosen(views, &of.views),
        "lights": chosen(lights, &of.lights),
        "evenLight": even_light,
    })
}

fn shaders() -> Vec<Value> {
    let kind = |id: &str| {
        if id.ends_with("vert") {
            "vertex"
        } else {
            "fragment"
        }
    };
    let shader = |&(id, text): &(&str, &str)| json!({"id": id, "kind": kind(id), "text": text});
    SHADERS.iter().map(shader).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::coarser_surface::tests::ball;

    #[test]
    fn surfaces_that_a_page_has_no_room_for_are_reduced() {
        let map = ball(5);
        let whole = PackedSurface::fitting(&map, LARGEST_PAGE).unwrap();
        assert_eq!(whole.vertices, map.mesh.positions.len());
        assert!(whole.left > 20_000_000);
        // A page with room for a third of it.
        let third = FRAME + numbers::base64_length(LEAST_SAMPLE) + whole.columns.len() * 4 / 9;
        let reduced = PackedSurface::fitting(&map, third).unwrap();
        assert!(reduced.left >= LEAST_SAMPLE);
        let share = reduced.vertices as f64 / whole.vertices as f64;
        assert!((0.1..0.4).contains(&share), "{share}");
    }
}
