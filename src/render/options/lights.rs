//! What lights the surface.

use std::path::PathBuf;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::format::image::SourceEncoding;
use crate::render::option_values::LightSpec;
use crate::render::options::ranges::{ANGLES, FARTHEST, Plain, check_counts, check_numbers};

/// The largest irradiance, and factor of an environment's radiance: a frame's numbers stay finite.
const BRIGHTEST: f64 = 1e12;
/// Lights at most that are given one by one.
const MOST_LIGHTS: usize = 4096;
/// What limits the number of lights.
const PER_VERTEX: &str = "each light's visibility is kept for each vertex";

/// What lights the surface.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Light")]
pub struct LightOptions {
    /// Azimuth of the light in degrees, counter-clockwise seen from above; 0 towards the first
    /// frame's camera.
    #[arg(long, value_name = "DEGREES", default_value_t = LightOptions::default().light_azimuth, allow_negative_numbers = true)]
    pub light_azimuth: f64,
    /// Elevation of the light in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = LightOptions::default().light_elevation, allow_negative_numbers = true)]
    pub light_elevation: f64,
    /// Light in place of --light-azimuth and --light-elevation, as `sun:AZIMUTH,ELEVATION[,IRRADIANCE]` or
    /// `point:X,Y,Z[,IRRADIANCE]`; repeat for more.
    #[arg(long, value_name = "LIGHT", allow_hyphen_values = true)]
    pub light: Vec<LightSpec>,
    /// Irradiance of the light at normal incidence; for a point light, at the centre of the mesh's bounding box. With
    /// π, a white Lambertian surface that faces the light has the value 1.
    #[arg(long, default_value_t = LightOptions::default().irradiance)]
    pub irradiance: f64,
    /// Angular radius in degrees of each light's disc, for soft shadow edges.
    #[arg(long, value_name = "DEGREES", default_value_t = LightOptions::default().light_radius)]
    pub light_radius: f64,
    /// Shadow rays per point and light when --light-radius is not 0.
    #[arg(long, value_name = "N", default_value_t = LightOptions::default().shadow_rays)]
    pub shadow_rays: u32,
    /// Radiance of a dim environment that lightens shaded parts, brighter from above than from below. A white surface
    /// in shadow has about the value X.
    #[arg(long, value_name = "X", default_value_t = LightOptions::default().fill)]
    pub fill: f64,
    /// A horizontal ground below the mesh that shows only its shadow: black in the frames, with the shadow as
    /// coverage.
    #[arg(long)]
    pub ground: bool,
    /// A latitude-longitude image (OpenEXR, Radiance HDR) that lights the scene from all directions, in place of the
    /// single light; its middle lies at azimuth 180.
    #[arg(long, value_name = "FILE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment: Option<PathBuf>,
    /// How the environment's numbers encode light. [default: as its file states]
    #[arg(long, value_enum)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment_encoding: Option<SourceEncoding>,
    /// The layer, part, view or channel to read from an OpenEXR environment that has several; `mesotex info IMAGE`
    /// lists them.
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment_layer: Option<String>,
    /// Directional lights that represent the environment.
    #[arg(long, value_name = "N", default_value_t = LightOptions::default().environment_lights)]
    pub environment_lights: u32,
    /// Factor on the environment's radiance.
    #[arg(long, value_name = "X", default_value_t = LightOptions::default().environment_scale)]
    pub environment_scale: f64,
    /// Rotation of the environment in degrees, counter-clockwise seen from above.
    #[arg(long, value_name = "DEGREES", default_value_t = LightOptions::default().environment_azimuth, allow_negative_numbers = true)]
    pub environment_azimuth: f64,
}

impl Default for LightOptions {
    fn default() -> Self {
        Self {
            light_azimuth: 30.0,
            light_elevation: 45.0,
            light: Vec::new(),
            irradiance: std::f64::consts::PI,
            light_radius: 0.0,
            shadow_rays: 16,
            fill: 0.0,
            ground: false,
            environment: None,
            environment_encoding: None,
            environment_layer: None,
            environment_lights: 64,
            environment_scale: 1.0,
            environment_azimuth: 0.0,
        }
    }
}

impl LightOptions {
    /// Refuses values that no light can have.
    pub(super) fn validate(&self) -> Result<()> {
        let from_zero = |most: f64| [0.0, most];
        check_numbers(&[
            ("irradiance", Some(self.irradiance), from_zero(BRIGHTEST)),
            ("fill", Some(self.fill), from_zero(1e6)),
            (
                "environment-scale",
                Some(self.environment_scale),
                from_zero(BRIGHTEST),
            ),
            ("light-radius", Some(self.light_radius), from_zero(45.0)),
            ("light-azimuth", Some(self.light_azimuth), ANGLES),
            ("light-elevation", Some(self.light_elevation), ANGLES),
            (
                "environment-azimuth",
                Some(self.environment_azimuth),
                ANGLES,
            ),
        ])?;
        let rays = "each point casts as many for each light";
        check_counts(&[
            ("shadow-rays", self.shadow_rays, 4096, rays),
            (
                "environment-lights",
                self.environment_lights,
                4096,
                PER_VERTEX,
            ),
        ])?;
        if self.light.len() > MOST_LIGHTS {
            return Err(Error::option(
                "light",
                format!("{} lights", self.light.len()),
                format!("at most {MOST_LIGHTS}: {PER_VERTEX}"),
            ));
        }
        self.light.iter().try_for_each(check_light)
    }
}

/// Refuses a light that lies too far away or is too bright.
fn check_light(light: &LightSpec) -> Result<()> {
    let (numbers, irradiance, farthest) = match *light {
        LightSpec::Sun {
            azimuth,
            elevation,
            irradiance,
        } => (vec![azimuth, elevation], irradiance, ANGLES[1]),
        LightSpec::Point {
            position,
            irradiance,
        } => (position.to_vec(), irradiance, FARTHEST),
    };
    let bright = (0.0..=BRIGHTEST).contains(&irradiance.unwrap_or(1.0));
    match bright && numbers.iter().all(|number| number.abs() <= farthest) {
        true => Ok(()),
        false => Err(Error::option(
            "light",
            light.to_string(),
            format!(
                "numbers up to {} and an irradiance of 0 to {}",
                Plain(farthest),
                Plain(BRIGHTEST)
            ),
        )),
    }
}
