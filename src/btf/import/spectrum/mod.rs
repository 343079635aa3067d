//! Spectral images: a channel per wavelength becomes linear Rec. 709 by the CIE 1931 observer.
//!
//! Reflectance between the stored wavelengths is interpolated linearly, beyond them it stays what it is at
//! the last one. Seen under an illuminant, it is adapted to the white of Rec. 709 (Bradford), so that a
//! perfect white has R = G = B = 1.

mod illuminant;
mod tables;

use glam::DVec3;

pub use crate::btf::import::spectrum::illuminant::Illuminant;

use crate::btf::import::spectrum::tables::{FIRST_NM, OBSERVER, STEP_NM};
use crate::error::{Error, Result};
use crate::format::image::{Encoding, FloatImage, Planes, Precision, adapted_to_rec709};

/// The fewest wavelengths of a spectral image.
pub(super) const FEWEST: usize = 4;
/// Wavelengths that a channel may have, in nanometres.
const POSSIBLE_NM: std::ops::RangeInclusive<f64> = 200.0..=3000.0;
/// Wavelengths that must lie between the first and the last: 98 % of what the eye sees.
const NEEDED_NM: [f64; 2] = [450.0, 650.0];

/// The wavelength in nanometres that a channel's name states: `450`, `450.5`, `450nm`, or `T.450,5nm` as in
/// "An OpenEXR Layout for Spectral Images" (Fichet 2021), reflectance.
pub(super) fn wavelength(channel: &str) -> Option<f64> {
    let name = channel.strip_prefix("T.").unwrap_or(channel);
    let number = name.strip_suffix("nm").unwrap_or(name).replace(',', ".");
    let is_number = number.starts_with(|c: char| c.is_ascii_digit());
    let nm: f64 = number.parse().ok().filter(|_| is_number)?;
    POSSIBLE_NM.contains(&nm).then_some(nm)
}

/// Whether channels are those of a spectrum.
pub(super) fn is_spectrum(channels: &[String]) -> bool {
    channels
        .iter()
        .filter(|name| wavelength(name).is_some())
        .count()
        >= FEWEST
}

/// The colours of a spectral image; how many numbers were negative and are 0 now.
pub(super) fn to_rgb(planes: &Planes, illuminant: Illuminant) -> Result<(FloatImage, usize)> {
    let mut bands: Vec<(f64, &[f32])> = planes
        .channels
        .iter()
        .filter_map(|(name, numbers)| Some((wavelength(name)?, numbers.as_slice())))
        .collect();
    bands.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wavelengths: Vec<f64> = bands.iter().map(|band| band.0).collect();
    let weights = weights(&wavelengths, illuminant)?;
    let texels = planes.width as usize * planes.height as usize;
    let mut data = Vec::with_capacity(texels * 3);
    let mut negative = 0;
    for texel in 0..texels {
        let mut sum = DVec3::ZERO;
        for ((_, numbers), &weight) in bands.iter().zip(&weights) {
            sum += f64::from(numbers[texel]) * weight;
        }
        negative += usize::from(sum.min_element() < 0.0);
        // NaN stays, so that its texel can be named.
        let clipped = sum.to_array().map(|v| if v < 0.0 { 0.0 } else { v as f32 });
        data.extend(clipped);
    }
    let image = FloatImage {
        width: planes.width,
        height: planes.height,
        channels: 3,
        data,
        encoding: Encoding::Linear,
        precision: Precision::Float,
    };
    Ok((image, negative))
}

/// What reflectance at each wavelength adds to R, G and B.
fn weights(wavelengths: &[f64], illuminant: Illuminant) -> Result<Vec<DVec3>> {
    check(wavelengths)?;
    let white = illuminant.white();
    let matrix = adapted_to_rec709(white)
        .ok_or_else(|| Error::data("illuminant", format!("white {white}")).expected("a white"))?;
    let mut weights = vec![DVec3::ZERO; wavelengths.len()];
    let mut all = 0.0;
    for (row, &seen) in OBSERVER.iter().enumerate() {
        let nm = FIRST_NM + row as f64 * STEP_NM;
        let light = illuminant.power(nm) * DVec3::from_array(seen);
        all += light.y;
        let (below, part) = place(wavelengths, nm);
        weights[below] += light * (1.0 - part);
        if part > 0.0 {
            weights[below + 1] += light * part;
        }
    }
    Ok(weights
        .into_iter()
        .map(|sum| matrix * (sum / all))
        .collect())
}

/// The stored wavelength at or below another one, and how far that lies towards the next.
fn place(wavelengths: &[f64], nm: f64) -> (usize, f64) {
    let above = wavelengths.partition_point(|&stored| stored <= nm);
    match above {
        0 => (0, 0.0),
        end if end == wavelengths.len() => (end - 1, 0.0),
        _ => {
            let (low, high) = (wavelengths[above - 1], wavelengths[above]);
            (above - 1, (nm - low) / (high - low))
        }
    }
}

fn check(wavelengths: &[f64]) -> Result<()> {
    let text = || match wavelengths {
        [first, .., last] => format!("{} wavelengths, {first} to {last} nm", wavelengths.len()),
        _ => format!("{} wavelengths", wavelengths.len()),
    };
    let fault =
        |found: String, expected: String| Err(Error::data("channels", found).expected(expected));
    let is_wide = wavelengths
        .first()
        .is_some_and(|&first| first <= NEEDED_NM[0])
        && wavelengths.last().is_some_and(|&last| last >= NEEDED_NM[1]);
    if wavelengths.len() < FEWEST || !is_wide {
        let expected = format!(
            "at least {FEWEST}, from {} to {} nm",
            NEEDED_NM[0], NEEDED_NM[1]
        );
        return fault(text(), expected);
    }
    match wavelengths.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => fault(
            format!("{} nm twice", pair[0]),
            "each wavelength once".into(),
        ),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(of: impl Fn(f64) -> f32, step: usize) -> Planes {
        let channels = (400..=720).step_by(step);
        Planes {
            width: 1,
            height: 1,
            channels: channels
                .map(|nm| (format!("{nm}"), vec![of(nm as f64)]))
                .collect(),
        }
    }

    fn color(of: impl Fn(f64) -> f32, illuminant: Illuminant) -> Vec<f32> {
        to_rgb(&planes(of, 10), illuminant).unwrap().0.data
    }

    #[test]
    fn channels_are_told_by_their_wavelengths() {
        for (name, nm) in [
            ("450", Some(450.0)),
            ("450.500000", Some(450.5)),
            ("T.450,500000nm", Some(450.5)),
            ("700nm", Some(700.0)),
            ("R", None),
            ("5", None),
            ("nan", None),
            ("S0.450nm", None),
        ] {
            assert_eq!(wavelength(name), nm, "{name}");
        }
    }

    #[test]
    fn grey_is_grey_under_every_light() {
        for illuminant in [
            Illuminant::D65,
            Illuminant::D50,
            Illuminant::A,
            Illuminant::E,
        ] {
            for value in color(|_| 0.25, illuminant) {
                assert!((value - 0.25).abs() < 1e-5, "{illuminant:?}: {value}");
            }
        }
    }

    #[test]
    fn colours_are_those_of_the_observer() {
        // A yellow; its colours summed in NumPy with the tables of colour-science 0.4.7.
        let yellow = |nm: f64| if nm < 500.0 { 0.25 } else { 0.75 };
        for (illuminant, expected) in [
            (Illuminant::D65, [0.762_875, 0.757_563, 0.208_210]),
            (Illuminant::A, [0.778_786, 0.752_695, 0.213_196]),
        ] {
            let found = color(yellow, illuminant);
            let close = found
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 2e-4);
            assert!(close, "{illuminant:?}: {found:?}");
        }
        let (_, negative) = to_rgb(
            &planes(|nm| f32::from(u8::from((490.0..=510.0).contains(&nm))), 10),
            Illuminant::E,
        )
        .unwrap();
        assert_eq!(negative, 1);
    }

    #[test]
    fn spectra_that_see_too_little_are_refused() {
        let refused = |names: &[&str]| {
            let channels = names
                .iter()
                .map(|name| ((*name).to_owned(), vec![0.5]))
                .collect();
            let planes = Planes {
                width: 1,
                height: 1,
                channels,
            };
            to_rgb(&planes, Illuminant::D65).unwrap_err().to_string()
        };
        assert!(refused(&["400", "500", "600"]).contains("3 wavelengths, 400 to 600 nm"));
        assert!(refused(&["400", "500", "600", "640"]).contains("450 to 650"));
        assert!(refused(&["400", "500", "500.0", "700"]).contains("500 nm twice"));
    }
}
