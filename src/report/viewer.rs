//! The page of `mesotex view`: a decorated surface to turn, under a light to move.

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
use crate::report::page::{STYLE, bundle, filled, json};
use crate::report::view_factors::{Limits, ViewFactors, view_factors};
use crate::report::{numbers, surface_columns};

/// The most bytes of a page.
pub const LARGEST_PAGE: usize = 30_000_000;
/// The part of it that templates and scripts take, and the least that is left to the sample.
const FRAME: usize = 200_000;
const LEAST_SAMPLE: usize = 2_000_000;
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
    let bounds = Bounds::of(&map.mesh)?;
    let (surface, columns) = surface_columns::surface_columns(map, &bounds)?;
    let columns =
        numbers::gzip(&columns).map_err(Error::io(std::path::Path::new("the page"), "compress"))?;
    let limits = Limits {
        error: options.error,
        bytes: bytes_for_sample(map, columns.len())?,
        texels: MOST_TEXELS,
    };
    let factors = view_factors(sample, &limits, progress)?;
    let notes = notes(&factors, options, sample);
    let up = options.up;
    let front = Front::of(&map.mesh, up, options.front)?
        .axis
        .vector()
        .to_array();
    let description = json!({
        "sample": sample_description(sample, &factors),
        "surface": surface,
        "centre": bounds.centre.to_array(),
        "radius": bounds.radius,
        "fov": 30.0,
        "compass": {"up": up.vector().to_array(), "zero": front},
        "lightZero": front,
        "view": {"azimuth": 0.0, "elevation": 15.0},
        "light": {"azimuth": 30.0, "elevation": 45.0},
        "irradiance": std::f64::consts::PI,
        "environment": ENVIRONMENT,
        "background": 0.03,
    });
    let html = filled(
        include_str!("web/view.html"),
        json!({
            "title": title,
            "style": STYLE,
            "vertices": map.mesh.positions.len(),
            "size": format!("{} × {} texels", factors.size[0], factors.size[1]),
            "directions": directions(sample, &factors),
            "error": format!("{:.1} %", 100.0 * factors.error),
            "has_environment": sample.description().pairs.is_none(),
            "notes": notes,
            "shaders": shaders(),
            "description": json(&description)?,
            "surface": numbers::base64(&columns),
            "sample": numbers::base64(&factors.packed),
            "script": format!("{}\n{}", bundle(&MODULES), bundle(&[include_str!("web/viewer.js")])),
        }),
    )?;
    Ok(ViewerPage {
        html,
        error: factors.error,
        rank: factors
            .groups
            .iter()
            .map(|group| group.rank)
            .max()
            .unwrap_or(0),
        notes,
    })
}

/// What the surface leaves of the page to the sample.
fn bytes_for_sample(map: &SurfaceTextonMap, surface: usize) -> Result<usize> {
    let left = LARGEST_PAGE.saturating_sub(FRAME + numbers::base64_length(surface)) / 4 * 3;
    if left >= LEAST_SAMPLE {
        return Ok(left);
    }
    let vertices = map.mesh.positions.len();
    let most = (LARGEST_PAGE - FRAME - numbers::base64_length(LEAST_SAMPLE)) as f64
        / numbers::base64_length(surface) as f64;
    let fitting = (vertices as f64 * most / 10_000.0).floor() * 10_000.0;
    Err(Error::data(
        "map",
        format!("{vertices} vertices, {} MB in a page", surface / 750_000),
    )
    .expected(format!(
        "at most about {fitting} vertices: a page holds {} MB",
        LARGEST_PAGE / 1_000_000
    ))
    .advice(format!(
        "synthesize on a coarser mesh: mesotex mesh IN -o OUT.ply --vertices {fitting}"
    )))
}

fn notes(factors: &ViewFactors, options: &ViewerOptions, sample: &Sample) -> Vec<String> {
    let mut notes = vec!["parts of the surface cast no shadows on each other here".to_owned()];
    if factors.error > 1.05 * options.error {
        notes.push(format!(
            "an error of {:.1} % was asked for; a page of {} MB holds factors that leave {:.1} %",
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
    let even_light = match is_scattered {
        true => Vec::new(),
        false => even_light::shares(&kept),
    };
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
    use crate::format::id::ContentId;
    use crate::grid::TexCoord;
    use crate::index::TextonLabel;
    use crate::maps::MapHeader;
    use crate::mesh::triangle_mesh::TriangleMesh;
    use glam::{DVec3, Vec3};

    fn map(vertices: usize) -> SurfaceTextonMap {
        let id = ContentId::of_bytes(b"x");
        SurfaceTextonMap {
            mesh: TriangleMesh {
                positions: vec![Vec3::ZERO; vertices],
                triangles: Vec::new(),
            },
            normals: vec![Vec3::Z; vertices],
            orientations: vec![Vec3::X; vertices],
            scale: None,
            coords: vec![TexCoord { s: 0.5, t: 0.5 }; vertices],
            textons: vec![TextonLabel(0); vertices],
            transition: None,
            mask: None,
            header: MapHeader {
                exemplar: [8, 8],
                texel: 1.0,
                origin: DVec3::ZERO,
                seed: 0,
                method: "k-coherence".into(),
                sample: id.clone(),
                space: id,
            },
        }
    }

    #[test]
    fn huge_meshes_are_refused_with_what_would_fit() {
        assert!(bytes_for_sample(&map(100_000), 4_000_000).unwrap() > 15_000_000);
        let error = bytes_for_sample(&map(1_000_000), 40_000_000)
            .unwrap_err()
            .to_string();
        for part in [
            "1000000 vertices",
            "53 MB",
            "500000",
            "mesotex mesh IN -o OUT.ply --vertices 500000",
        ] {
            assert!(error.contains(part), "{error}");
        }
    }
}
