//! Exposure and white balance by a grey card that lies in every picture, in the plane of the patch.
//!
//! A matt card of reflectance ρ lit from θ has ρ · cos θ where a white plane facing the light has 1. Each
//! picture's channels are scaled so that the card's mean is just that.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::btf::direction::Direction;
use crate::btf::import::prepare::region::Region;
use crate::error::{Error, Result};
use crate::format::image::{FloatImage, Precision};

/// The reflectance of photographers' grey cards.
const USUAL_REFLECTANCE: f32 = 0.18;
/// A card darker than this in a picture is not lit.
const DARKEST: f64 = 1e-4;
/// Integers at this or more are overexposed.
const BRIGHTEST: f64 = 0.99;

/// Where the card lies in the pictures, and how much light it reflects.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "String")]
pub struct GreyCard {
    /// The card, or a part of it.
    pub region: Region,
    /// Its reflectance, 0 to 1.
    pub reflectance: f32,
}

impl GreyCard {
    /// Scales a picture lit from `light`.
    pub(super) fn balance(&self, image: &mut FloatImage, light: Direction) -> Result<()> {
        self.region
            .check_inside("grey-card", (image.width, image.height))?;
        let mean = self.mean(image);
        let cosine = light.cos_theta();
        let wanted = f64::from(self.reflectance) * cosine;
        let is_lit = mean.iter().all(|&channel| channel > DARKEST) && cosine > DARKEST;
        let is_clipped =
            mean.iter().any(|&channel| channel >= BRIGHTEST) && image.precision != Precision::Float;
        if !is_lit || is_clipped {
            let state = if is_clipped { "overexposed" } else { "not lit" };
            return Err(Error::data(
                format!("grey card {}", self.region),
                format!("{state}: mean {:.4} {:.4} {:.4}", mean[0], mean[1], mean[2]),
            )
            .expected("a card in the light, exposed below white"));
        }
        let gains = mean.map(|channel| (wanted / channel) as f32);
        for texel in image.data.chunks_exact_mut(3) {
            texel.iter_mut().zip(gains).for_each(|(v, gain)| *v *= gain);
        }
        Ok(())
    }

    /// The card's mean red, green and blue.
    fn mean(&self, image: &FloatImage) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for row in self.region.rows(image.width) {
            for texel in image.data[row.start * 3..row.end * 3].chunks_exact(3) {
                sums.iter_mut()
                    .zip(texel)
                    .for_each(|(sum, &v)| *sum += f64::from(v));
            }
        }
        let texels = f64::from(self.region.width) * f64::from(self.region.height);
        sums.map(|sum| sum / texels)
    }
}

impl FromStr for GreyCard {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (region, reflectance) = match text.split_once(':') {
            Some((region, number)) => (region, number.parse().ok()),
            None => (text, Some(USUAL_REFLECTANCE)),
        };
        let reflectance = reflectance
            .filter(|share: &f32| *share > 0.0 && *share <= 1.0)
            .ok_or_else(|| {
                format!("`{text}`: expected a reflectance above 0, at most 1, behind the colon")
            })?;
        Ok(Self {
            region: region.parse()?,
            reflectance,
        })
    }
}

impl fmt::Display for GreyCard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.region, self.reflectance)
    }
}

impl From<GreyCard> for String {
    fn from(card: GreyCard) -> Self {
        card.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::Encoding;

    fn picture(card: [f32; 3], rest: [f32; 3]) -> FloatImage {
        let texel = |at: usize| if at.is_multiple_of(4) { card } else { rest };
        FloatImage {
            width: 4,
            height: 2,
            channels: 3,
            data: (0..8).flat_map(texel).collect(),
            encoding: Encoding::Linear,
            precision: Precision::Bits8,
        }
    }

    #[test]
    fn the_card_becomes_grey_and_the_rest_follows() {
        let card: GreyCard = "1x2+0+0:0.5".parse().unwrap();
        let mut image = picture([0.2, 0.1, 0.4], [0.4, 0.4, 0.4]);
        let light = Direction::from_angles(60.0_f64.to_radians(), 0.0);
        card.balance(&mut image, light).unwrap();
        for (found, expected) in image.data.iter().zip([0.25, 0.25, 0.25, 0.5, 1.0, 0.25]) {
            assert!((found - expected).abs() < 1e-6, "{:?}", &image.data[..6]);
        }
    }

    #[test]
    fn cards_that_show_nothing_are_refused() {
        let card: GreyCard = "1x2+0+0".parse().unwrap();
        assert_eq!(card.reflectance, USUAL_REFLECTANCE);
        let above = Direction::from_angles(0.0, 0.0);
        let refused = |color: [f32; 3], light| {
            let mut image = picture(color, [0.5; 3]);
            card.balance(&mut image, light).unwrap_err().to_string()
        };
        assert!(refused([0.0; 3], above).contains("not lit"));
        assert!(refused([0.2, 0.2, 1.0], above).contains("overexposed"));
        let grazing = Direction::from_angles(std::f64::consts::FRAC_PI_2, 0.0);
        assert!(refused([0.2; 3], grazing).contains("not lit"));
        assert!("1x2+0+0:2".parse::<GreyCard>().is_err());
    }
}
