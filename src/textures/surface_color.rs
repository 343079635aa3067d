//! The plain colour that shows where a texture is transparent, in place of a hole: "blended with a green
//! surface color" (Ying 2001, Figure 9).

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::format::image::decode_srgb;
use crate::textures::texture::Texture;

/// A colour as 8-bit sRGB: `R,G,B` with numbers from 0 to 255, or `#RRGGBB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct SurfaceColor(pub [u8; 3]);

impl SurfaceColor {
    /// Linear Rec. 709.
    pub fn linear(self) -> [f32; 3] {
        self.0.map(|value| decode_srgb(f32::from(value) / 255.0))
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
        let parsed = match text.strip_prefix('#') {
            Some(digits) => hexadecimal(digits),
            None => decimal(text),
        };
        parsed.map(Self).ok_or_else(|| {
            format!("`{text}` is no colour R,G,B of three numbers from 0 to 255, nor #RRGGBB")
        })
    }
}

fn hexadecimal(digits: &str) -> Option<[u8; 3]> {
    let is_whole = digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| is_whole)?;
    let [_, red, green, blue] = number.to_be_bytes();
    Some([red, green, blue])
}

fn decimal(text: &str) -> Option<[u8; 3]> {
    let numbers = text.split(',').map(|part| part.trim().parse().ok());
    let numbers: Option<Vec<u8>> = numbers.collect();
    numbers?.try_into().ok()
}

impl fmt::Display for SurfaceColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [red, green, blue] = self.0;
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

impl TryFrom<String> for SurfaceColor {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        text.parse()
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

    #[test]
    fn colours_are_read_in_two_forms() {
        let read = |text: &str| text.parse::<SurfaceColor>();
        assert_eq!(read("#00ff80"), Ok(SurfaceColor([0, 255, 128])));
        assert_eq!(read("0, 255,128"), read("#00FF80"));
        assert_eq!(read("#00ff80").unwrap().to_string(), "#00ff80");
        for wrong in [
            "",
            "#",
            "#12345",
            "#+12345",
            "green",
            "1,2",
            "1,2,3,4",
            "0.2,0.5,0.1",
            "0,0,256",
        ] {
            let text = read(wrong).unwrap_err();
            assert!(text.contains("0 to 255") && text.contains(wrong), "{text}");
        }
    }

    #[test]
    fn blending_is_linear() {
        let grey = SurfaceColor([188; 3]);
        let [red, ..] = grey.below([1.0, 0.0, 0.0], 0.25);
        let plain = decode_srgb(188.0 / 255.0);
        assert!((red - (0.25 + 0.75 * plain)).abs() < 1e-6);
        assert_eq!(grey.below([0.3; 3], 1.5), [0.3; 3]);
    }
}
