//! `mesotex export` of surface texton maps: meshes that other programs read.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;

use crate::btf::direction::Direction;
use crate::btf::sample::Sample;
use crate::cli::clipped_colors::describe_clipped;
use crate::cli::outcome::Outcome;
use crate::error::{Error, Result};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::render::blended_image::blended_image;
use crate::textures::vertex_model::{ModelFormat, VertexModel};

/// Radiance of a white plane that faces a light of unit irradiance.
const WHITE: f32 = std::f32::consts::FRAC_1_PI;

/// Where the colours of vertices come from.
#[derive(Clone, Debug, Default, Args)]
pub struct ColorOptions {
    /// Colour each vertex by its texel in this sample; without it the vertices have no colours.
    #[arg(long, value_name = "X.sample", help_heading = "Maps")]
    pub sample: Option<PathBuf>,
    /// The view direction of the sample's colours, in the frame of each vertex: angle from the normal and azimuth from
    /// s, in degrees. [default: 0,0]
    #[arg(long, value_name = "THETA,PHI", help_heading = "Maps")]
    pub view: Option<Angles>,
    /// The direction of the light, in the same form; a white plane that faces it is white. [default: 0,0]
    #[arg(long, value_name = "THETA,PHI", help_heading = "Maps")]
    pub light: Option<Angles>,
}

/// Two angles in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Angles {
    theta: f64,
    phi: f64,
}

impl FromStr for Angles {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = |part: &str| part.trim().parse::<f64>().ok();
        let angles = text
            .split_once(',')
            .map(|(theta, phi)| (number(theta), number(phi)));
        match angles {
            Some((Some(theta), Some(phi)))
                if (0.0..=90.0).contains(&theta) && phi.abs() <= 360.0 =>
            {
                Ok(Self { theta, phi })
            }
            _ => Err(format!(
                "`{text}` is not THETA,PHI in degrees, 0 to 90 and −360 to 360, as 45,120"
            )),
        }
    }
}

impl Angles {
    fn direction(self) -> Direction {
        Direction::from_angles(self.theta.to_radians(), self.phi.to_radians())
    }
}

/// Writes a map as a mesh.
pub(super) fn run(
    input: &Path,
    format: ModelFormat,
    options: &ColorOptions,
    output: &Path,
) -> Result<Outcome> {
    let map = SurfaceTextonMap::read(input)?;
    let colors = match &options.sample {
        Some(path) => Some(colors(&map, path, options)?),
        None => None,
    };
    VertexModel {
        map: &map,
        colors: colors.as_deref(),
    }
    .write(output, format)?;
    let (vertices, triangles) = (map.mesh.positions.len(), map.mesh.triangles.len());
    let outcome = Outcome::default()
        .line(format!("{vertices} vertices, {triangles} triangles"))
        .figure("vertices", vertices)
        .figure("triangles", triangles);
    Ok(describe_clipped(outcome, colors.as_deref().unwrap_or_default()).wrote(output))
}

/// The sample's colour at every vertex: linear, white for a white plane that faces the light.
fn colors(map: &SurfaceTextonMap, path: &Path, options: &ColorOptions) -> Result<Vec<[f32; 3]>> {
    let sample = Sample::open(path)?;
    let grid = sample.grid();
    let [width, height] = map.header.exemplar;
    if [grid.width, grid.height] != [width, height] {
        return Err(
            Error::data("size", format!("{} × {} texels", grid.width, grid.height))
                .expected(format!("{width} × {height}, as the map states"))
                .in_file(path),
        );
    }
    if map.header.sample != *sample.id() {
        return Err(Error::data("id", sample.id().to_string())
            .expected(format!(
                "{}, the sample that the map was made from",
                map.header.sample
            ))
            .in_file(path));
    }
    let [view, light] =
        [options.view, options.light].map(|angles| angles.unwrap_or_default().direction());
    let image = blended_image(&sample, view, light)?;
    let (texels, _) = image.as_chunks::<3>();
    let color = |at| texels[grid.texel_nearest(at).index()].map(|value| value / WHITE);
    Ok(map.coords.iter().map(|&at| color(at)).collect())
}
