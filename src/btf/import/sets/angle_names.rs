//! Names that hold angles by their keys: `tl` and `pl` for θ and φ of the light, `tv` and `pv` of the view,
//! in degrees.
//!
//! `00008 tl000 pl000 tv030 pv030.jpg` is an image of UBO2003 and ATRIUM, `tl000_pl000_tv030_pv030.png` one
//! of UTIA, `tv30.0_pv0.0_tl15.0_pl60.0.exr` one of SPECTRAL. Keys are read in any order.

use crate::btf::import::family::Family;
use crate::btf::import::sets::angles::Angles;

/// A name with all four keys.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AngleName {
    pub(super) angles: Angles,
    is_view_first: bool,
    /// Whether every angle has three digits.
    is_padded: bool,
    has_underscores: bool,
    extension: String,
}

impl AngleName {
    /// Reads the last part of a path; `None` where a key is missing.
    pub(super) fn parse(path: &str) -> Option<Self> {
        let lower = path.rsplit('/').next().unwrap_or(path).to_lowercase();
        let (stem, extension) = lower.rsplit_once('.')?;
        let [tl, pl, tv, pv] = ["tl", "pl", "tv", "pv"].map(|key| Number::after(stem, key));
        let (tl, pl, tv, pv) = (tl?, pl?, tv?, pv?);
        Some(Self {
            angles: Angles::new([tv.value, pv.value], [tl.value, pl.value]),
            is_view_first: tv.at < tl.at,
            is_padded: [&tl, &pl, &tv, &pv].iter().all(|number| number.digits == 3),
            has_underscores: stem[tl.at.min(tv.at)..].contains('_'),
            extension: extension.to_owned(),
        })
    }
}

/// A number behind a key.
struct Number {
    /// Where the key stands.
    at: usize,
    value: f64,
    digits: usize,
}

impl Number {
    /// The number behind the only place of a key, which no letter stands before.
    fn after(stem: &str, key: &str) -> Option<Self> {
        let mut found = stem.match_indices(key).filter_map(|(at, _)| {
            let is_inside_a_word = stem[..at].ends_with(|c: char| c.is_alphabetic());
            let rest = &stem[at + key.len()..];
            let length = number_length(rest);
            let value = rest[..length].parse().ok().filter(|_| !is_inside_a_word)?;
            Some(Self {
                at,
                value,
                digits: length,
            })
        });
        let first = found.next()?;
        found.next().is_none().then_some(first)
    }
}

/// How many bytes of a text are digits, with decimals behind a point.
fn number_length(text: &str) -> usize {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let whole = digits(text);
    let decimals = text[whole..].strip_prefix('.').map_or(0, digits);
    match (whole, decimals) {
        (0, _) | (_, 0) => whole,
        _ => whole + 1 + decimals,
    }
}

/// Whose names these are.
pub(super) fn family(names: &[AngleName]) -> Family {
    let all = |is: &dyn Fn(&AngleName) -> bool| names.iter().all(is);
    let ends = |wanted: &[&str]| all(&|name| wanted.contains(&name.extension.as_str()));
    if all(&|name| name.is_view_first) {
        return if ends(&["exr"]) {
            Family::Spectral
        } else {
            Family::Any
        };
    }
    let is_utia = all(&|name| name.has_underscores && name.is_padded);
    if is_utia && ends(&["png", "exr"]) {
        return Family::Utia;
    }
    match ends(&["jpg", "jpeg", "hdr"]) {
        true => Family::Bonn,
        false => Family::Any,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles(path: &str) -> Option<Angles> {
        AngleName::parse(path).map(|name| name.angles)
    }

    #[test]
    fn names_of_every_set_are_read() {
        let expected = Angles::new([30.0, 60.0], [15.0, 120.0]);
        for name in [
            "UBO2003/MANYFILES/tv030_pv060/00008 tl015 pl120 tv030 pv060.jpg",
            "00008_tl015_pl120_tv030_pv060.jpg",
            "tl015 pl120 tv030 pv060.hdr",
            "tv030_pv060/tl015_pl120_tv030_pv060.PNG",
            "TL015PL120TV030PV060.jpg",
            "tv30_pv60.0_tl15.0_pl120.exr",
        ] {
            assert_eq!(angles(name), Some(expected), "{name}");
        }
        assert_eq!(
            angles("x tl7.25 pl0 tv0 pv90.exr"),
            Some(Angles::new([0.0, 0.0], [7.25, 0.0]))
        );
    }

    #[test]
    fn names_without_all_angles_are_none() {
        for name in [
            "tl015 pl120 tv030.jpg",
            "tv030_pv060/image.jpg",
            "atl015 pl120 tv030 pv060.jpg",
            "tl pl120 tv030 pv060.jpg",
            "tl1 tl2 pl120 tv030 pv060.jpg",
            "tl015 pl120 tv030 pv060",
            "",
        ] {
            assert_eq!(angles(name), None, "{name}");
        }
    }

    #[test]
    fn families_are_told_by_order_and_ending() {
        let of = |names: &[&str]| {
            let names: Vec<AngleName> = names
                .iter()
                .map(|name| AngleName::parse(name).unwrap())
                .collect();
            family(&names)
        };
        assert_eq!(of(&["1 tl000 pl000 tv030 pv030.jpg"]), Family::Bonn);
        assert_eq!(of(&["tl000_pl000_tv030_pv030.hdr"]), Family::Bonn);
        assert_eq!(of(&["tl000_pl000_tv030_pv030.exr"]), Family::Utia);
        assert_eq!(of(&["tv30_pv30_tl0_pl0.exr"]), Family::Spectral);
        assert_eq!(of(&["tl0_pl0_tv30_pv30.exr"]), Family::Any);
        assert_eq!(
            of(&["tl000_pl000_tv030_pv030.png", "tl000_pl000_tv000_pv030.tif"]),
            Family::Any
        );
    }
}
