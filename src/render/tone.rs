//! From linear radiance to 8-bit previews: exposure, a tone curve, the sRGB curve; over a background.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::format::image::{SrgbColor, encode_srgb8};

/// How previews show what is bright.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ToneCurve {
    /// Unchanged up to 0.6; brighter values approach 1 smoothly.
    #[default]
    Soft,
    /// Unchanged up to 1, then clipped.
    Clip,
}

/// Up to here the soft curve keeps values.
const KNEE: f32 = 0.6;

impl ToneCurve {
    /// What a linear value of 0 or more is shown as, from 0 to 1.
    #[inline]
    pub fn shown(self, value: f32) -> f32 {
        match self {
            Self::Soft if value > KNEE => {
                // The slope is 1 at the knee, and 0 in the end.
                1.0 - (1.0 - KNEE) * ((KNEE - value) / (1.0 - KNEE)).exp()
            }
            Self::Soft | Self::Clip => value.clamp(0.0, 1.0),
        }
    }
}

/// What is behind the surface in previews.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub enum Background {
    /// A linear grey from 0 to 1.
    Grey(f32),
    /// A colour.
    Color(SrgbColor),
}

impl Background {
    /// Linear Rec. 709.
    pub fn linear(self) -> [f32; 3] {
        match self {
            Self::Grey(grey) => [grey; 3],
            Self::Color(color) => color.linear(),
        }
    }
}

impl Default for Background {
    fn default() -> Self {
        Self::Grey(0.03)
    }
}

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let grey = text.trim().parse().ok();
        if let Some(grey) = grey.filter(|grey| (0.0..=1.0).contains(grey)) {
            return Ok(Self::Grey(grey));
        }
        text.parse().map(Self::Color).map_err(|_| {
            format!("`{text}` is neither a grey from 0 to 1 nor a colour R,G,B of numbers from 0 to 255 or #RRGGBB")
        })
    }
}

impl fmt::Display for Background {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grey(grey) => grey.fmt(f),
            Self::Color(color) => color.fmt(f),
        }
    }
}

impl From<Background> for String {
    fn from(background: Background) -> Self {
        background.to_string()
    }
}

/// How a preview shows linear values: out = sRGB(curve(2^exposure · value)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tone {
    /// Stops by which values are brightened.
    pub exposure: f32,
    /// What becomes of bright values.
    pub curve: ToneCurve,
    /// Behind what is not covered; neither exposed nor curved.
    pub background: Background,
}

/// Steps of the table that stands for the sRGB curve; fine enough for exact 8-bit results but
/// for one step in 10⁴.
const STEPS: usize = 1 << 14;

/// Turns premultiplied linear RGBA into 8-bit RGB.
pub fn preview(rgba: &[[f32; 4]], tone: Tone) -> Vec<u8> {
    let table: Vec<u8> = (0..=STEPS)
        .map(|step| encode_srgb8(step as f32 / STEPS as f32))
        .collect();
    let gain = tone.exposure.exp2();
    let encode = |linear: f32| table[(linear.clamp(0.0, 1.0) * STEPS as f32 + 0.5) as usize];
    let background = tone.background.linear();
    rgba.iter()
        .flat_map(|&[r, g, b, a]| {
            // The curve is for the surface's own values, not for those mixed with the background.
            let surface = |value: f32| match a > 0.0 {
                true => a * tone.curve.shown(value * gain / a),
                false => 0.0,
            };
            let channels = [0, 1, 2].map(|k| (([r, g, b])[k], background[k]));
            channels.map(|(value, behind)| encode(surface(value) + (1.0 - a) * behind))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_are_srgb_over_the_background() {
        let tone = Tone {
            exposure: 1.0,
            curve: ToneCurve::Clip,
            background: Background::Grey(1.0),
        };
        let pixels = [
            [0.5, 0.25, 0.107, 1.0],
            [0.0, 0.0, 0.0, 0.0],
            [9.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0, 0.786],
        ];
        let shown = preview(&pixels, tone);
        assert_eq!(shown[..3], [255, 188, 127]);
        assert_eq!(shown[3..6], [255, 255, 255]);
        assert_eq!(shown[6..9], [255, 0, 0]);
        assert_eq!(shown[9..], [127, 127, 127]);
        let teal = Tone {
            background: "#008080".parse().unwrap(),
            ..Tone::default()
        };
        assert_eq!(preview(&[[0.0; 4]], teal), [0, 128, 128]);
    }

    #[test]
    fn the_soft_curve_keeps_what_is_dark_and_never_turns() {
        let soft = |value| ToneCurve::Soft.shown(value);
        assert_eq!(soft(0.37), 0.37);
        assert!((soft(1.0) - 0.853).abs() < 1e-3);
        let steps: Vec<f32> = (0..4000).map(|k| soft(k as f32 * 1e-3)).collect();
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0]));
        assert!(steps.windows(2).all(|pair| pair[1] - pair[0] < 1.001e-3));
        assert!(soft(1e9) <= 1.0);
        // Half covered: the curve sees the surface, not the mixture.
        let half = preview(&[[0.5, 0.5, 0.5, 0.5]], Tone::default());
        let whole = 0.5 * soft(1.0) + 0.5 * 0.03;
        assert_eq!(half[0], encode_srgb8(whole));
    }

    #[test]
    fn backgrounds_are_greys_or_colours() {
        let read = |text: &str| text.parse::<Background>();
        assert_eq!(read("0.5"), Ok(Background::Grey(0.5)));
        assert_eq!(read("1").unwrap().to_string(), "1");
        assert_eq!(read("0,128,255").unwrap().to_string(), "#0080ff");
        for wrong in ["", "-1", "1.5", "nan", "white", "1,2"] {
            assert!(
                read(wrong).unwrap_err().contains("a grey from 0 to 1"),
                "{wrong}"
            );
        }
    }
}
