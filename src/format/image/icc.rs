//! ICC profiles: matrices and curves (RGB) and curves alone (grey), through `moxcms`.
//!
//! Not handled: profiles with tables only (printers, some scanners) and profiles of CMYK or Lab; they
//! are refused for colour.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use moxcms::{ColorProfile, DataColorSpace, ProfileText, ToneReprCurve};

use crate::format::image::color::{Curve, Statement};
use crate::format::image::primaries::{D50_XYZ, D65, bradford, white_xyz, xyz_to_rec709};

/// A matrix this near to none, and a curve this near to sRGB's, are sRGB: profiles round both.
const SAME_MATRIX: f64 = 1e-3;
const SAME_CURVE: f32 = 2e-4;

/// What the profile of an image with `channels` colour channels says.
pub(super) fn statement(profile: &[u8], channels: u32) -> Statement {
    let parsed = match ColorProfile::new_from_slice(profile) {
        Ok(parsed) => parsed,
        Err(error) => {
            let why = format!("its ICC profile cannot be read ({error})");
            return Statement::unusable("ICC profile", why);
        }
    };
    let text = format!("ICC profile `{}`", name(&parsed));
    match (parsed.color_space, channels) {
        (DataColorSpace::Gray, 1) => grey(&parsed, text),
        (DataColorSpace::Rgb, _) => rgb(&parsed, text),
        (space, _) => {
            let why = format!("its ICC profile is one of {space:?}, the image is not");
            Statement::unusable(text, why)
        }
    }
}

fn name(profile: &ColorProfile) -> String {
    let text = match &profile.description {
        Some(ProfileText::PlainString(text)) => text.as_str(),
        Some(ProfileText::Localizable(texts)) => texts.first().map_or("", |t| t.value.as_str()),
        Some(ProfileText::Description(texts)) => texts.ascii_string.as_str(),
        None => "",
    };
    text.chars().filter(|c| !c.is_control()).take(80).collect()
}

fn grey(profile: &ColorProfile, text: String) -> Statement {
    match curves([&profile.gray_trc; 3]) {
        Some(curve) => Statement {
            curve: Some(simplest(curve)),
            text,
            ..Statement::default()
        },
        None => Statement::unusable(text, "its grey ICC profile has no curve"),
    }
}

fn rgb(profile: &ColorProfile, text: String) -> Statement {
    let curve = curves([&profile.red_trc, &profile.green_trc, &profile.blue_trc]);
    let (Some(curve), Some(matrix)) = (curve, matrix(profile)) else {
        return Statement::unusable(text, "its ICC profile has tables in place of a matrix");
    };
    let near_none = (0..3).all(|column| {
        let difference = matrix.col(column) - DMat3::IDENTITY.col(column);
        difference.abs().max_element() < SAME_MATRIX
    });
    Statement {
        curve: Some(simplest(curve)),
        matrix: (!near_none).then_some(matrix),
        text,
        unusable: None,
    }
}

fn curves(tags: [&Option<ToneReprCurve>; 3]) -> Option<Curve> {
    let [red, green, blue] = tags;
    let curve = |tag: &Option<ToneReprCurve>| {
        let evaluator = tag.as_ref()?.make_linear_evaluator().ok()?;
        Some(Arc::from(evaluator))
    };
    Some(Curve::Profile([curve(red)?, curve(green)?, curve(blue)?]))
}

/// sRGB's own curve, or none, where the profile means it.
fn simplest(curve: Curve) -> Curve {
    let near = |other: &Curve| {
        (0..=512).all(|step| {
            let stored = step as f32 / 512.0;
            (0..3).all(|channel| {
                let difference = curve.decode(channel, stored) - other.decode(channel, stored);
                difference.abs() < SAME_CURVE
            })
        })
    };
    match [Curve::Srgb, Curve::Linear].into_iter().find(near) {
        Some(simple) => simple,
        None => curve,
    }
}

/// From the profile's RGB by way of D50 to linear Rec. 709.
fn matrix(profile: &ColorProfile) -> Option<DMat3> {
    let [red, green, blue] = [
        profile.red_colorant,
        profile.green_colorant,
        profile.blue_colorant,
    ]
    .map(|colorant| DVec3::new(colorant.x, colorant.y, colorant.z));
    let colorants = DMat3::from_cols(red, green, blue);
    let sound = colorants.is_finite() && colorants.determinant().abs() > 1e-6;
    let adapted = bradford(D50_XYZ, white_xyz(D65)?)?;
    sound.then_some(xyz_to_rec709()? * adapted * colorants)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::Precision;

    fn stated(profile: &ColorProfile, channels: u32) -> Statement {
        statement(&profile.encode().unwrap(), channels)
    }

    #[test]
    fn a_profile_of_srgb_is_srgb() {
        let found = stated(&ColorProfile::new_srgb(), 3);
        assert!(matches!(found.curve, Some(Curve::Srgb)) && found.matrix.is_none());
        assert!(found.text.contains("sRGB"), "{}", found.text);
    }

    #[test]
    fn other_primaries_and_curves_are_converted() {
        let found = stated(&ColorProfile::new_adobe_rgb(), 3);
        // Green of Adobe RGB (1998) in linear Rec. 709; its gamma is 563/256.
        let green = found.matrix.unwrap() * DVec3::Y;
        assert!(
            (green - DVec3::new(-0.3982, 1.0, -0.0430)).length() < 2e-3,
            "{green}"
        );
        let mid = found.curve.unwrap().decode(0, 0.5);
        assert!((mid - 0.5_f32.powf(563.0 / 256.0)).abs() < 1e-4, "{mid}");
    }

    #[test]
    fn grey_profiles_have_a_curve_alone() {
        let found = stated(&ColorProfile::new_gray_with_gamma(1.8), 1);
        assert!((found.curve.unwrap().decode(0, 0.5) - 0.5_f32.powf(1.8)).abs() < 1e-3);
        assert!(found.matrix.is_none());
    }

    #[test]
    fn what_cannot_be_followed_is_said() {
        let wrong = stated(&ColorProfile::new_gray_with_gamma(1.8), 3);
        assert!(
            wrong.reading(Precision::Bits8).contains("Gray"),
            "{}",
            wrong.text
        );
        let broken = statement(&[1, 2, 3], 3);
        assert!(broken.unusable.unwrap().contains("cannot be read"));
        let mut tables = ColorProfile::new_srgb();
        tables.red_trc = None;
        assert!(stated(&tables, 3).unusable.unwrap().contains("tables"));
    }
}
