//! What a file says of its colours, and the way from there to linear Rec. 709.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use moxcms::ToneCurveEvaluator;

use crate::format::image::float_image::Precision;
use crate::format::image::options::Gamut;
use crate::format::image::primaries::{Chromaticities, xyz_to_rec709};
use crate::format::image::srgb::decode_srgb;

/// A curve from stored numbers to light.
#[derive(Clone)]
pub(super) enum Curve {
    Linear,
    Srgb,
    /// Light is the stored number to this power.
    Power(f64),
    /// The curve of BT.709 and BT.2020 cameras, undone.
    Rec709,
    /// The curves of an ICC profile, one per channel.
    Profile([Arc<dyn ToneCurveEvaluator + Send + Sync>; 3]),
}

impl Curve {
    /// The light of a stored number.
    pub(super) fn decode(&self, channel: usize, stored: f32) -> f32 {
        match self {
            Self::Linear => stored,
            Self::Srgb => decode_srgb(stored),
            Self::Power(power) => {
                let size = f64::from(stored.abs()).powf(*power) as f32;
                size.copysign(stored)
            }
            Self::Rec709 => {
                let stored = f64::from(stored);
                let light = match stored < 0.081_242_858 {
                    true => stored / 4.5,
                    false => ((stored + 0.099_296_826) / 1.099_296_826).powf(1.0 / 0.45),
                };
                light as f32
            }
            Self::Profile(curves) => curves[channel.min(2)].evaluate_value(stored),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Linear => "in proportion".into(),
            Self::Srgb => "by the sRGB curve".into(),
            Self::Power(power) => format!("by the power {}", (power * 1e4).round() / 1e4),
            Self::Rec709 => "by the curve of BT.709".into(),
            Self::Profile(_) => "by the curves of the profile".into(),
        }
    }
}

/// What a file says of its colours; nothing where all is empty.
#[derive(Clone, Default)]
pub(super) struct Statement {
    /// The curve, where the file says one.
    pub(super) curve: Option<Curve>,
    /// The matrix to linear Rec. 709, where the primaries are others.
    pub(super) matrix: Option<DMat3>,
    /// Where it is said and in which words, as "gAMA 0.45455".
    pub(super) text: String,
    /// Why it cannot be followed.
    pub(super) unusable: Option<String>,
}

impl Statement {
    /// Numbers in sRGB, said by `text`.
    pub(super) fn srgb(text: impl Into<String>) -> Self {
        Self {
            curve: Some(Curve::Srgb),
            text: text.into(),
            ..Self::default()
        }
    }

    /// A statement that cannot be followed.
    pub(super) fn unusable(text: impl Into<String>, why: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            unusable: Some(why.into()),
            ..Self::default()
        }
    }

    /// A curve and primaries, either of which may be left unsaid.
    pub(super) fn of(
        curve: Option<Curve>,
        primaries: Option<Chromaticities>,
        text: impl Into<String>,
    ) -> Self {
        let text = text.into();
        let matrix = match primaries {
            Some(primaries) if !primaries.is(&Chromaticities::REC709) => primaries.to_rec709(),
            _ => None,
        };
        let other = primaries.is_some_and(|found| !found.is(&Chromaticities::REC709));
        if other && matrix.is_none() {
            return Self::unusable(text, "its primaries span no colour space");
        }
        Self {
            curve,
            matrix,
            text,
            unusable: None,
        }
    }

    /// Tristimulus values: XYZ as it is, without adaptation.
    pub(super) fn tristimulus(text: impl Into<String>) -> Self {
        Self {
            curve: Some(Curve::Linear),
            matrix: xyz_to_rec709(),
            text: text.into(),
            unusable: None,
        }
    }

    /// The curve that is followed, guessed by the precision where none is said.
    pub(super) fn followed_curve(&self, precision: Precision) -> Curve {
        self.curve.clone().unwrap_or(match precision {
            Precision::Float => Curve::Linear,
            Precision::Bits8 | Precision::Bits16 => Curve::Srgb,
        })
    }

    /// How the numbers will be read, in words.
    pub(super) fn reading(&self, precision: Precision) -> String {
        if let Some(why) = &self.unusable {
            return format!("refused: {why}");
        }
        let guessed = if self.curve.is_none() {
            " (guessed)"
        } else {
            ""
        };
        let primaries = match self.matrix {
            Some(_) => ", primaries converted to Rec. 709",
            None => "",
        };
        format!(
            "{}{guessed}{primaries}",
            self.followed_curve(precision).text()
        )
    }
}

/// Texels whose colour Rec. 709 cannot show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Outside {
    pub(super) texels: usize,
    /// The least number that conversion made.
    pub(super) least: f32,
}

/// Decodes interleaved numbers in place. Grey goes through the curve alone: it is as white as white.
/// `gamut` says what becomes of numbers that only the conversion made negative.
pub(super) fn decode(
    data: &mut [f32],
    channels: usize,
    curve: &Curve,
    matrix: Option<DMat3>,
    gamut: Gamut,
) -> Outside {
    let mut outside = Outside::default();
    for texel in data.chunks_exact_mut(channels) {
        for (channel, value) in texel.iter_mut().enumerate() {
            *value = curve.decode(channel, *value);
        }
        if let (Some(matrix), [red, green, blue]) = (matrix, &mut *texel) {
            let light = DVec3::new(f64::from(*red), f64::from(*green), f64::from(*blue));
            let mut converted = matrix * light;
            if converted.min_element() < 0.0 && light.min_element() >= 0.0 {
                outside.texels += 1;
                outside.least = outside.least.min(converted.min_element() as f32);
                if gamut == Gamut::Clip {
                    converted = converted.max(DVec3::ZERO);
                }
            }
            *red = converted.x as f32;
            *green = converted.y as f32;
            *blue = converted.z as f32;
        }
    }
    outside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_meet_published_values() {
        assert!((Curve::Rec709.decode(0, 0.5) - 0.259_720_8).abs() < 1e-5);
        assert!((Curve::Power(2.2).decode(0, 0.5) - 0.217_638).abs() < 1e-6);
        assert_eq!(Curve::Power(2.0).decode(0, -0.5), -0.25);
    }

    #[test]
    fn what_is_not_said_is_guessed_and_said_so() {
        let nothing = Statement::default();
        assert!(
            nothing
                .reading(Precision::Bits8)
                .contains("sRGB curve (guessed)")
        );
        assert!(
            nothing
                .reading(Precision::Float)
                .contains("in proportion (guessed)")
        );
        let wide = Statement::of(Some(Curve::Linear), Some(Chromaticities::AP1), "x");
        assert!(
            wide.reading(Precision::Float)
                .ends_with("converted to Rec. 709")
        );
        let same = Statement::of(None, Some(Chromaticities::REC709), "x");
        assert!(same.matrix.is_none() && same.unusable.is_none());
    }

    #[test]
    fn grey_is_not_tinted() {
        let matrix = Chromaticities::AP0.to_rec709();
        let mut grey = [0.25];
        decode(&mut grey, 1, &Curve::Linear, matrix, Gamut::Clip);
        assert_eq!(grey, [0.25]);
        let mut white = [0.25; 3];
        decode(&mut white, 3, &Curve::Linear, matrix, Gamut::Clip);
        assert!(white.iter().all(|v| (v - 0.25).abs() < 1e-6));
    }

    #[test]
    fn colours_outside_are_counted_and_clipped_on_request() {
        let matrix = Chromaticities::REC2020.to_rec709();
        let run = |gamut| {
            let mut green = [0.0, 1.0, 0.0, 0.5, 0.5, 0.5];
            let outside = decode(&mut green, 3, &Curve::Linear, matrix, gamut);
            assert_eq!(outside.texels, 1);
            assert!(outside.least < -0.5, "{outside:?}");
            green[0]
        };
        assert_eq!(run(Gamut::Clip), 0.0);
        assert!(run(Gamut::Keep) < -0.5);
    }
}
