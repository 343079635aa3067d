//! Options of rendering, as the command line and TOML files give them.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::format::exr::Compression;
use crate::format::image::SourceEncoding;
use crate::render::compass::Axis;
use crate::render::frame_range::{FramePattern, FrameRange, LAST_FRAME};
use crate::render::nearest::Weighting;
use crate::render::parallax::Parallax;
use crate::render::radiance::Texels;
use crate::render::raster::Samples;
use crate::render::renderer::{Shading, Shadows};
use crate::render::tone::{Background, ToneCurve};
use crate::render::values::{
    Animation, ImageSize, Layer, LightSpec, Mip, Point, ProjectionKind, STANDARD_LAYERS, Sweep,
};
use crate::shard::Shard;

/// Angles in degrees; of larger ones too few digits are left.
const ANGLES: [f64; 2] = [-1e6, 1e6];
/// The largest irradiance, and factor of an environment's radiance: a frame's numbers stay finite.
const BRIGHTEST: f64 = 1e12;
/// The farthest coordinate, in mesh units.
const FARTHEST: f64 = 1e12;
/// Lights at most that are given one by one.
const MOST_LIGHTS: usize = 4096;

/// A limit as a person writes it: 1e12, not 1000000000000.
struct Plain(f64);

impl std::fmt::Display for Plain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 == 0.0 || (1e-3..1e5).contains(&self.0.abs()) {
            true => write!(f, "{}", self.0),
            false => write!(f, "{:e}", self.0),
        }
    }
}

/// How a map is rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RenderOptions {
    /// What changes from frame to frame: none, light-azimuth, light-elevation, light-spiral,
    /// view-orbit, or a .csv file with a row for each frame (columns: see docs/rendering.md).
    #[arg(long, default_value_t = Sweep::None, help_heading = "Sweep")]
    pub sweep: Sweep,
    /// Frames to make: a count, or a range of the sweep as 10-20 or 1-240x2. Default: 1 without a
    /// sweep, 24 with one, all rows of a file.
    #[arg(long, value_name = "N|RANGE", help_heading = "Sweep")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<FrameRange>,
    /// Frames of the whole sweep. Default: the end of --frames.
    #[arg(long, value_name = "N", help_heading = "Sweep")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep_length: Option<u32>,
    /// Where the sweep begins, in degrees. Default: the light's azimuth, elevation 0, elevation 90
    /// (spiral), orbit 0.
    #[arg(
        long,
        value_name = "DEGREES",
        allow_negative_numbers = true,
        help_heading = "Sweep"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep_from: Option<f64>,
    /// Where the sweep ends, in degrees. Default: 360 further, elevation 180, elevation 10 (spiral).
    /// A full turn ends one step before where it began.
    #[arg(
        long,
        value_name = "DEGREES",
        allow_negative_numbers = true,
        help_heading = "Sweep"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep_to: Option<f64>,
    /// Turns of the light in a light-spiral.
    #[arg(long, default_value_t = Self::default().turns, help_heading = "Sweep")]
    pub turns: f64,

    /// Columns × rows of a frame.
    #[arg(long, value_name = "WxH", default_value_t = Self::default().size, help_heading = "Picture")]
    pub size: ImageSize,
    /// Samples a pixel for antialiasing.
    #[arg(long, value_enum, default_value_t, help_heading = "Picture")]
    pub samples: Samples,
    /// Where colour is computed.
    #[arg(long, value_enum, default_value_t, help_heading = "Picture")]
    pub shading: Shading,
    /// Where cast shadows are computed.
    #[arg(long, value_enum, default_value_t, help_heading = "Picture")]
    pub shadows: Shadows,
    /// How the nearest images are weighted.
    #[arg(long, value_enum, default_value_t, help_heading = "Picture")]
    pub weights: Weighting,
    /// How values between texels are found. [default: bilinear with pixel shading, nearest with vertex shading]
    #[arg(long, value_enum, help_heading = "Picture")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texels: Option<Texels>,
    /// Read each view's images where they show the point that is seen, over the sample's heights, before they are
    /// blended.
    #[arg(long, value_enum, default_value_t, help_heading = "Picture")]
    pub parallax: Parallax,
    /// Coarser levels of the sample for distant surfaces.
    #[arg(long, value_enum, default_value_t, help_heading = "Picture")]
    pub mip: Mip,

    /// The axis of the mesh that points up.
    #[arg(
        long,
        value_enum,
        default_value_t,
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub up: Axis,
    /// The side of the mesh that is its front, which the camera sees at azimuth 0. Default: the side that an open mesh
    /// faces, else the broad side.
    #[arg(
        long,
        value_enum,
        value_name = "AXIS",
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub front: Option<Axis>,
    /// Azimuth of the camera in degrees, counter-clockwise seen from above; 0 is in front.
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().camera_azimuth, allow_negative_numbers = true, help_heading = "Camera")]
    pub camera_azimuth: f64,
    /// Elevation of the camera in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().camera_elevation, allow_negative_numbers = true, help_heading = "Camera")]
    pub camera_elevation: f64,
    /// Viewpoint, in place of one fitted to the mesh.
    #[arg(
        long,
        value_name = "X,Y,Z",
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera_position: Option<Point>,
    /// Point in the picture's middle. Default: the middle of what is seen; the centre of the mesh's bounding box where the
    /// camera moves or is given.
    #[arg(
        long,
        value_name = "X,Y,Z",
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera_target: Option<Point>,
    /// How the camera projects.
    #[arg(long, value_enum, default_value_t, help_heading = "Camera")]
    pub projection: ProjectionKind,
    /// How many times as large the picture shows its middle. At 1 a fitted camera sees the whole mesh.
    #[arg(long, value_name = "X", default_value_t = Self::default().zoom, help_heading = "Camera")]
    pub zoom: f64,
    /// Vertical field of view in degrees, at zoom 1.
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().fov, help_heading = "Camera")]
    pub fov: f64,
    /// Focal length in mm for a picture 24 mm high, in place of --fov.
    #[arg(
        long,
        value_name = "MM",
        conflicts_with = "fov",
        help_heading = "Camera"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_length: Option<f64>,
    /// Height of an orthographic picture in mesh units. Default: fitted.
    #[arg(long, value_name = "UNITS", help_heading = "Camera")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_height: Option<f64>,
    /// Cameras from a JSON or CSV file, one for each frame (fields: see docs/rendering.md).
    #[arg(long, value_name = "FILE", help_heading = "Camera")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera_path: Option<PathBuf>,

    /// Azimuth of the light in degrees, counter-clockwise seen from above; 0 towards the first
    /// frame's camera.
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().light_azimuth, allow_negative_numbers = true, help_heading = "Light")]
    pub light_azimuth: f64,
    /// Elevation of the light in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().light_elevation, allow_negative_numbers = true, help_heading = "Light")]
    pub light_elevation: f64,
    /// Lights in place of the one above, as `sun:AZIMUTH,ELEVATION[,IRRADIANCE]` or
    /// `point:X,Y,Z[,IRRADIANCE]`; repeat for more.
    #[arg(
        long,
        value_name = "LIGHT",
        allow_hyphen_values = true,
        help_heading = "Light"
    )]
    pub light: Vec<LightSpec>,
    /// Irradiance at normal incidence; a point light's at the centre of the mesh's bounding box.
    /// With π a white Lambertian surface facing the light shows as 1.
    #[arg(long, default_value_t = Self::default().irradiance, help_heading = "Light")]
    pub irradiance: f64,
    /// Angle in degrees that the radius of each light's disc spans: soft shadow edges.
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().light_radius, help_heading = "Light")]
    pub light_radius: f64,
    /// Shadow rays a point and light when --light-radius is not 0.
    #[arg(long, value_name = "N", default_value_t = Self::default().shadow_rays, help_heading = "Light")]
    pub shadow_rays: u32,
    /// Radiance of a dim environment that fills the shade, brighter from above than from below: with X, white surfaces show
    /// about as X where no light falls.
    #[arg(long, value_name = "X", default_value_t = Self::default().fill, help_heading = "Light")]
    pub fill: f64,
    /// A level ground below the mesh that catches its shadow: black in the frames, as opaque as it is dark.
    #[arg(long, help_heading = "Light")]
    pub ground: bool,
    /// A latitude-longitude image (OpenEXR, Radiance HDR) whose light falls in from all around, in
    /// place of the light above; its middle lies at azimuth 180.
    #[arg(long, value_name = "FILE", help_heading = "Light")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment: Option<PathBuf>,
    /// How the environment's numbers stand for light. [default: as its file says]
    #[arg(long, value_enum, help_heading = "Light")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment_encoding: Option<SourceEncoding>,
    /// The layer, part or view of an environment that has several.
    #[arg(long, value_name = "NAME", help_heading = "Light")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment_layer: Option<String>,
    /// Directional lights that stand for the environment.
    #[arg(long, value_name = "N", default_value_t = Self::default().environment_lights, help_heading = "Light")]
    pub environment_lights: u32,
    /// What the environment's radiance is multiplied by.
    #[arg(long, value_name = "X", default_value_t = Self::default().environment_scale, help_heading = "Light")]
    pub environment_scale: f64,
    /// Degrees by which the environment is turned, counter-clockwise seen from above.
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().environment_azimuth, allow_negative_numbers = true, help_heading = "Light")]
    pub environment_azimuth: f64,

    /// Layers of a frame's file.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = STANDARD_LAYERS, help_heading = "Files")]
    pub layers: Vec<Layer>,
    /// Colour in 16-bit floats (the default).
    #[arg(long, conflicts_with = "float", help_heading = "Files")]
    #[serde(skip_serializing)]
    pub half: bool,
    /// Colour in 32-bit floats.
    #[arg(long, help_heading = "Files")]
    pub float: bool,
    /// Compression of a frame's file; all but pxr24 keep every bit.
    #[arg(long, value_enum, default_value_t, help_heading = "Files")]
    pub compression: Compression,
    /// Names of the frames' files; #### becomes the number.
    #[arg(long, default_value_t, help_heading = "Files")]
    pub pattern: FramePattern,
    /// Keep frames that are there already and were made with the same options and inputs.
    #[arg(long, help_heading = "Files")]
    pub skip_existing: bool,
    /// Make only the i-th of every n frames, so that n runs share a sweep.
    #[arg(long, value_name = "I/N", help_heading = "Files")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// How previews show what is bright; frames keep it as it is.
    #[arg(long, value_enum, default_value_t, help_heading = "Files")]
    pub tone: ToneCurve,
    /// Stops by which previews are brightened.
    #[arg(long, value_name = "STOPS", default_value_t = Self::default().exposure, allow_negative_numbers = true, help_heading = "Files")]
    pub exposure: f32,
    /// What is behind the surface in previews: a linear grey from 0 to 1, or a colour as sRGB, R,G,B with numbers from 0 to
    /// 255 or #RRGGBB.
    #[arg(long, value_name = "GREY|COLOR", default_value_t = Self::default().background, help_heading = "Files")]
    pub background: Background,
    /// A moving preview.
    #[arg(long, value_enum, default_value_t, help_heading = "Files")]
    pub animation: Animation,
    /// Memory in MiB that the sample laid out for shading may take; more is mapped from a
    /// temporary file in the output's folder.
    #[arg(long, value_name = "MIB", default_value_t = Self::default().table_memory, help_heading = "Files")]
    pub table_memory: u64,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            sweep: Sweep::None,
            frames: None,
            sweep_length: None,
            sweep_from: None,
            sweep_to: None,
            turns: 3.0,
            size: ImageSize([960, 720]),
            samples: Samples::default(),
            shading: Shading::default(),
            shadows: Shadows::default(),
            weights: Weighting::default(),
            texels: None,
            parallax: Parallax::default(),
            mip: Mip::default(),
            up: Axis::default(),
            front: None,
            camera_azimuth: 0.0,
            camera_elevation: 15.0,
            camera_position: None,
            camera_target: None,
            projection: ProjectionKind::default(),
            zoom: 1.0,
            fov: 30.0,
            focal_length: None,
            view_height: None,
            camera_path: None,
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
            layers: STANDARD_LAYERS.to_vec(),
            half: false,
            float: false,
            compression: Compression::default(),
            pattern: FramePattern::default(),
            skip_existing: false,
            shard: None,
            tone: ToneCurve::default(),
            exposure: 0.0,
            background: Background::default(),
            animation: Animation::default(),
            table_memory: 4096,
        }
    }
}

impl RenderOptions {
    /// Refuses values that no frame can have.
    pub fn validate(&self) -> Result<()> {
        let from_zero = |most: f64| [0.0, most];
        for (option, value, [least, most]) in [
            ("irradiance", Some(self.irradiance), from_zero(BRIGHTEST)),
            ("fill", Some(self.fill), from_zero(1e6)),
            (
                "environment-scale",
                Some(self.environment_scale),
                from_zero(BRIGHTEST),
            ),
            ("zoom", Some(self.zoom), [1e-3, 1e6]),
            ("fov", Some(self.fov), [0.001, 179.999]),
            ("light-radius", Some(self.light_radius), from_zero(45.0)),
            ("sweep-from", self.sweep_from, ANGLES),
            ("sweep-to", self.sweep_to, ANGLES),
            ("turns", Some(self.turns), [-10_000.0, 10_000.0]),
            ("camera-azimuth", Some(self.camera_azimuth), ANGLES),
            ("camera-elevation", Some(self.camera_elevation), ANGLES),
            ("light-azimuth", Some(self.light_azimuth), ANGLES),
            ("light-elevation", Some(self.light_elevation), ANGLES),
            (
                "environment-azimuth",
                Some(self.environment_azimuth),
                ANGLES,
            ),
            ("exposure", Some(f64::from(self.exposure)), [-100.0, 100.0]),
            ("focal-length", self.focal_length, [0.01, 1e6]),
            ("view-height", self.view_height, [1.0 / FARTHEST, FARTHEST]),
        ] {
            if let Some(value) = value.filter(|value| !(least..=most).contains(value)) {
                let expected = format!("{} to {}", Plain(least), Plain(most));
                return Err(Error::option(option, value.to_string(), expected));
            }
        }
        let per_vertex = "each light's visibility is kept for each vertex";
        let counts = [
            (
                "shadow-rays",
                self.shadow_rays,
                4096,
                "each point casts as many for each light",
            ),
            (
                "environment-lights",
                self.environment_lights,
                4096,
                per_vertex,
            ),
            (
                "sweep-length",
                self.sweep_length.unwrap_or(1),
                LAST_FRAME,
                "frames have no larger numbers",
            ),
        ];
        for (option, count, most, why) in counts {
            if !(1..=most).contains(&count) {
                return Err(Error::option(
                    option,
                    count.to_string(),
                    format!("1 to {most}: {why}"),
                ));
            }
        }
        if self.layers.is_empty() {
            return Err(Error::option("layers", "none", "at least one"));
        }
        if self.ground && self.shadows == Shadows::None {
            return Err(Error::option(
                "ground",
                "given with --shadows none",
                "--shadows vertex or pixel: the ground shows nothing but a shadow",
            ));
        }
        self.check_lights()
    }

    fn check_lights(&self) -> Result<()> {
        if self.light.len() > MOST_LIGHTS {
            return Err(Error::option(
                "light",
                format!("{} lights", self.light.len()),
                format!("at most {MOST_LIGHTS}: each light's visibility is kept for each vertex"),
            ));
        }
        for light in &self.light {
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
            if !bright || numbers.iter().any(|number| number.abs() > farthest) {
                return Err(Error::option(
                    "light",
                    light.to_string(),
                    format!(
                        "numbers up to {} and an irradiance of 0 to {}",
                        Plain(farthest),
                        Plain(BRIGHTEST)
                    ),
                ));
            }
        }
        for (option, point) in [
            ("camera-position", self.camera_position),
            ("camera-target", self.camera_target),
        ] {
            let far = point.is_some_and(|point| point.0.iter().any(|at| at.abs() > FARTHEST));
            if let Some(point) = point.filter(|_| far) {
                let expected = format!("coordinates up to {}", Plain(FARTHEST));
                return Err(Error::option(option, point.to_string(), expected));
            }
        }
        Ok(())
    }

    /// How values between texels are found: as asked, or as the shading needs it. Pixels show single texels.
    pub fn texels(&self) -> Texels {
        self.texels.unwrap_or(match self.shading {
            Shading::Vertex => Texels::Nearest,
            Shading::Pixel => Texels::Bilinear,
        })
    }

    /// Whether coarser levels of the sample are used.
    pub fn uses_mip(&self) -> bool {
        match self.mip {
            Mip::Auto => self.shading == Shading::Pixel,
            Mip::On => true,
            Mip::Off => false,
        }
    }

    /// The vertical field of view in radians.
    pub fn vertical_fov(&self) -> f64 {
        match self.focal_length {
            Some(mm) => 2.0 * (12.0 / mm).atan(),
            None => self.fov.to_radians(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toml_and_default_agree() {
        let options: RenderOptions = toml::from_str("").unwrap();
        assert_eq!(options, RenderOptions::default());
        let text = "sweep = \"view-orbit\"\nframes = 12\nlight = [\"sun:10,20\"]\nup = \"-z\"\nsamples = \"8\"";
        let options: RenderOptions = toml::from_str(text).unwrap();
        assert_eq!(options.sweep, Sweep::ViewOrbit);
        assert_eq!(options.frames, Some(FrameRange::count(12)));
        assert_eq!(options.up, Axis::MinusZ);
        assert!(toml::from_str::<RenderOptions>("swep = 1").is_err());
    }

    #[test]
    fn impossible_values_are_refused_by_name() {
        let refused = |change: fn(&mut RenderOptions)| {
            let mut options = RenderOptions::default();
            change(&mut options);
            options.validate().unwrap_err().to_string()
        };
        assert!(refused(|o| o.irradiance = f64::NAN).contains("--irradiance"));
        assert!(refused(|o| o.fov = 180.0).contains("--fov"));
        assert!(refused(|o| o.layers.clear()).contains("--layers"));
        assert!(refused(|o| o.shadow_rays = 0).contains("--shadow-rays"));
        assert!(RenderOptions::default().validate().is_ok());
    }
}
