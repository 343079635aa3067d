//! The plain colour that shows where a texture is transparent, in place of a hole: "blended with a green
//! surface color" (Ying 2001, Figure 9).

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::format::image::SrgbColor;
use crate::textures::texture::Texture;

/// A colour as 8-bit sRGB: `R,G,B` with numbers from 0 to 255, or `#RRGGBB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub struct SurfaceColor(pub [u8; 3]);

impl SurfaceColor {
    /// Linear Rec. 709.
    pub fn linear(self) -> [f32; 3] {
        SrgbColor(self.0).linear()
    }

    /// A linear colour of the texture over this one: `alpha` is the share of the texture.
    pub fn below(self, color: [f32; 3], alpha: f32) -> [f32; 3] {
        let (plain, share) = (self.linear(), alpha.clamp(0.0, 1.0));
        [0, 1, 2].map(|at| share * color[at] + (1.0 - share) * plain[at])
    }

    /// Refuses an alpha that is missing, or 1 everywhere: the colour would not be seen. `place` names what has it.
    pub fn check_seen_through(self, alpha: Option<&Texture>, place: &str) -> Result<()> {
        match alpha {
            None => Err(self.unseen(&format!("{place} has no channel of alpha"))),
            Some(alpha) if alpha.numbers.iter().all(|&share| share >= 1.0) => {
                Err(self.unseen(&format!("alpha is 1 at every texel of {place}")))
            }
            Some(_) => Ok(()),
        }
    }

    /// The error of a colour that nothing shows, with the reason.
    pub(super) fn unseen(self, reason: &str) -> Error {
        Error::option(
            "surface-color",
            format!("{self}, but {reason}"),
            "a channel of kind alpha that is below 1 somewhere",
        )
    }
}

impl FromStr for SurfaceColor {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let SrgbColor(color) = text.parse()?;
        Ok(Self(color))
    }
}

impl fmt::Display for SurfaceColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        SrgbColor(self.0).fmt(f)
    }
}

impl From<SurfaceColor> for String {
    fn from(color: SurfaceColor) -> Self {
        color.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::decode_srgb;

    #[test]
    fn blending_is_linear() {
        let grey = SurfaceColor([188; 3]);
        let [red, ..] = grey.below([1.0, 0.0, 0.0], 0.25);
        let plain = decode_srgb(188.0 / 255.0);
        assert!((red - (0.25 + 0.75 * plain)).abs() < 1e-6);
        assert_eq!(grey.below([0.3; 3], 1.5), [0.3; 3]);
    }
}
