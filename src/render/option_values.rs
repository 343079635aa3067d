//! The values that options of rendering take, and how they are written.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use serde::Serialize;

/// Types that are written as one string.
macro_rules! as_string {
    ($($name:ty),*) => {$(
        impl From<$name> for String {
            fn from(value: $name) -> Self {
                value.to_string()
            }
        }
    )*};
}
as_string!(Sweep, ImageSize, LightSpec, Point);

/// What changes from frame to frame.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum Sweep {
    /// Nothing.
    #[default]
    None,
    /// The azimuth of the first light changes.
    LightAzimuth,
    /// The first light rises on its side and sets on the other.
    LightElevation,
    /// The azimuth of the first light changes while it sinks.
    LightSpiral,
    /// The camera orbits the mesh.
    ViewOrbit,
    /// A CSV file with a row for each frame.
    File(PathBuf),
}

const SWEEPS: [(&str, Sweep); 5] = [
    ("none", Sweep::None),
    ("light-azimuth", Sweep::LightAzimuth),
    ("light-elevation", Sweep::LightElevation),
    ("light-spiral", Sweep::LightSpiral),
    ("view-orbit", Sweep::ViewOrbit),
];

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let named = SWEEPS.into_iter().find(|(name, _)| *name == text);
        if let Some((_, sweep)) = named {
            return Ok(sweep);
        }
        if text.to_lowercase().ends_with(".csv") {
            return Ok(Self::File(text.into()));
        }
        let names = SWEEPS.map(|(name, _)| name).join(", ");
        Err(format!("`{text}` is none of {names}, nor a .csv file"))
    }
}

impl fmt::Display for Sweep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Self::File(path) = self {
            return write!(f, "{}", path.display());
        }
        let named = SWEEPS.into_iter().find(|(_, sweep)| sweep == self);
        f.write_str(named.map_or("", |(name, _)| name))
    }
}

/// Columns × rows of a frame, as `1280x960`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub struct ImageSize(pub [u32; 2]);

/// The longest side of a frame.
const LONGEST_SIDE: u32 = 16_384;

impl FromStr for ImageSize {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parts = text.split_once('x');
        let sides = parts.and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
        match sides {
            Some(size) if Self(size).is_possible() => Ok(Self(size)),
            _ => Err(format!("`{text}` is not {}", Self::expected())),
        }
    }
}

impl ImageSize {
    /// Sizes that frames can have, in words.
    pub(super) fn expected() -> String {
        format!("a size WxH of 1 to {LONGEST_SIDE} pixels per side, as 1280x960")
    }

    /// Whether a frame can have it.
    pub(super) fn is_possible(self) -> bool {
        self.0.iter().all(|side| (1..=LONGEST_SIDE).contains(side))
    }
}

impl fmt::Display for ImageSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

/// A point or vector, as `x,y,z`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub struct Point(pub [f64; 3]);

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match numbers(text)?[..] {
            [x, y, z] => Ok(Self([x, y, z])),
            _ => Err(format!("`{text}` is not a point x,y,z")),
        }
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x},{y},{z}")
    }
}

/// Finite numbers, separated by commas.
fn numbers(text: &str) -> std::result::Result<Vec<f64>, String> {
    let number = |part: &str| match part.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{part}` in `{text}` is not a number")),
    };
    text.split(',').map(number).collect()
}

/// A light: `sun:AZIMUTH,ELEVATION[,IRRADIANCE]` in degrees, or `point:X,Y,Z[,IRRADIANCE]` in mesh
/// units, its irradiance meant at the centre of the mesh's bounding box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub enum LightSpec {
    /// Parallel rays.
    Sun {
        /// Degrees, counter-clockwise seen from above; 0 towards the first frame's camera.
        azimuth: f64,
        /// Degrees above the horizontal.
        elevation: f64,
        /// In place of `--irradiance`.
        irradiance: Option<f64>,
    },
    /// A point.
    Point {
        /// In mesh units.
        position: [f64; 3],
        /// In place of `--irradiance`.
        irradiance: Option<f64>,
    },
}

impl FromStr for LightSpec {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let values = numbers(rest).unwrap_or_default();
        let spec = match (kind, &values[..]) {
            ("sun", &[azimuth, elevation, ref rest @ ..]) if rest.len() < 2 => Self::Sun {
                azimuth,
                elevation,
                irradiance: rest.first().copied(),
            },
            ("point", &[x, y, z, ref rest @ ..]) if rest.len() < 2 => Self::Point {
                position: [x, y, z],
                irradiance: rest.first().copied(),
            },
            _ => {
                return Err(format!(
                    "`{text}` is neither sun:AZIMUTH,ELEVATION[,IRRADIANCE] nor point:X,Y,Z[,IRRADIANCE]"
                ));
            }
        };
        Ok(spec)
    }
}

impl fmt::Display for LightSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let irradiance = match self {
            Self::Sun {
                azimuth,
                elevation,
                irradiance,
            } => {
                write!(f, "sun:{azimuth},{elevation}")?;
                irradiance
            }
            Self::Point {
                position: [x, y, z],
                irradiance,
            } => {
                write!(f, "point:{x},{y},{z}")?;
                irradiance
            }
        };
        irradiance.map_or(Ok(()), |value| write!(f, ",{value}"))
    }
}

/// How the camera projects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ProjectionKind {
    /// Lines of sight meet in the camera.
    #[default]
    Perspective,
    /// Lines of sight are parallel.
    Orthographic,
}

/// Whether coarser levels of the sample are used where its texels are smaller than pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Mip {
    /// On for pixel shading, off for vertex shading.
    #[default]
    Auto,
    /// Always.
    On,
    /// Never.
    Off,
}

/// Groups of channels in a frame's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Layer {
    /// `R G B A`: linear colour, premultiplied, and coverage.
    Rgba,
    /// `Z`: distance along the view axis.
    Depth,
    /// `N.X N.Y N.Z`: normals in world space.
    Normal,
    /// `uv.U uv.V`: texture coordinates over the sample's size.
    Uv,
    /// `texton.I`: texton labels.
    Texton,
    /// `shadow.Y`: the share of the lights that reaches the surface.
    Shadow,
    /// `weight.Y`: the share of the blend that lies beyond the sampled directions.
    Weight,
}

/// The layers every frame has unless told otherwise.
pub const STANDARD_LAYERS: [Layer; 5] = [
    Layer::Rgba,
    Layer::Depth,
    Layer::Normal,
    Layer::Uv,
    Layer::Texton,
];

/// A moving preview of the sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Animation {
    /// No moving preview.
    #[default]
    None,
    /// `sweep.gif`: 256 colours, at most 480 pixels wide.
    Gif,
    /// `sweep.apng`: an animated PNG in all colours, at most 480 pixels wide.
    Apng,
    /// `sweep.mp4`, as large as the frames; needs an installed ffmpeg.
    Mp4,
    /// `sweep.webm`, as large as the frames; needs an installed ffmpeg.
    Webm,
}

impl Animation {
    /// The name of its file.
    pub fn file_name(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Gif => Some("sweep.gif"),
            Self::Apng => Some("sweep.apng"),
            Self::Mp4 => Some("sweep.mp4"),
            Self::Webm => Some("sweep.webm"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_round_trip() {
        for text in [
            "sun:30,-5",
            "sun:0,90,2.5",
            "point:1,2,3",
            "point:0,-1,0.5,10",
        ] {
            assert_eq!(text.parse::<LightSpec>().unwrap().to_string(), text);
        }
        for text in ["light-azimuth", "none", "my/path.csv"] {
            assert_eq!(text.parse::<Sweep>().unwrap().to_string(), text);
        }
        for text in ["sun:1", "lamp:1,2", "point:1,2,x", "sun:1,2,3,4"] {
            assert!(text.parse::<LightSpec>().is_err(), "{text}");
        }
        assert!("0x5".parse::<ImageSize>().is_err());
        assert!(
            "light-azimut"
                .parse::<Sweep>()
                .unwrap_err()
                .contains("light-azimuth")
        );
    }
}
