//! The vectors of a tangent-space normal map, however its file stores them.
//!
//! Most maps store (n + 1)/2; float files may store n itself; compressed ones store x and y alone, with blue left at
//! 0 or full. Which it is shows in the numbers: [`NormalKind::Auto`] looks, and the other kinds say. Vectors come out
//! with length 1; maps that are far from it are reported. Maps made for DXT5 (DXT5nm) keep x in the alpha channel and
//! y in green; their red is the same everywhere.

use clap::ValueEnum;
use glam::DVec3;
use serde::Deserialize;

use crate::error::{Error, Result};
use crate::format::image::{FloatImage, Precision};

/// Numbers below this are no rounding of 0: the map is signed.
const NEGATIVE: f32 = -0.02;
/// A signed map of a flat surface has x and y no further from 0 on average.
const NEAR_ZERO: f64 = 0.1;
/// Blue this near to 0 or 1 everywhere says nothing.
const STEP: f32 = 1.5 / 255.0;
/// Vectors whose length is off by more are reported.
const OFF_LENGTH: f64 = 0.1;
/// Shares of such vectors below this are not reported.
const FEW: f64 = 0.05;

/// How a normal map stores its vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum NormalKind {
    /// Recognised by its numbers.
    #[default]
    Auto,
    /// x, y and z, each as (n + 1)/2.
    Unsigned,
    /// x, y and z as they are, −1 to 1 (floats).
    Signed,
    /// x and y, each as (n + 1)/2; z follows from them.
    UnsignedXy,
    /// x and y as they are (floats); z follows from them.
    SignedXy,
    /// x in alpha and y in green, each as (n + 1)/2; z follows from them.
    Dxt5nm,
}

impl NormalKind {
    fn is_signed(self) -> bool {
        matches!(self, Self::Signed | Self::SignedXy)
    }

    fn has_z(self) -> bool {
        matches!(self, Self::Unsigned | Self::Signed)
    }

    /// What a report calls it.
    fn describe(self) -> &'static str {
        match self {
            Self::Auto | Self::Unsigned => "x, y and z in 0 to 1",
            Self::Signed => "x, y and z in −1 to 1",
            Self::UnsignedXy => "x and y in 0 to 1, z computed from them",
            Self::SignedXy => "x and y in −1 to 1, z computed from them",
            Self::Dxt5nm => "x in alpha and y in green, z computed from them",
        }
    }
}

/// The vectors of a map, row 0 at the top, green as stored.
#[derive(Debug)]
pub(super) struct Normals {
    /// Columns.
    pub(super) width: usize,
    /// Rows.
    pub(super) height: usize,
    /// Unit vectors.
    pub(super) vectors: Vec<DVec3>,
    /// What was found, for a report.
    pub(super) note: String,
    /// What the user should know, for a warning.
    pub(super) warning: Option<String>,
}

/// Reads the vectors of a map; `alpha` where any of it is not opaque.
pub(super) fn normals(
    mut map: FloatImage,
    alpha: Option<Vec<f32>>,
    kind: NormalKind,
) -> Result<Normals> {
    // Find the kind of map that the channels say.
    if map.channels != 3 {
        return Err(Error::data("channels", "1")
            .expected("3: a normal map is a colour image")
            .advice("a map with x and y alone needs them in red and green"));
    }
    let kind = match (kind, &alpha) {
        (NormalKind::Auto, Some(_)) if red_says_nothing(&map) => NormalKind::Dxt5nm,
        (kind, _) => kind,
    };
    // Take x from alpha where the kind says so.
    let mut warning = None;
    match (kind, alpha) {
        (NormalKind::Dxt5nm, Some(alpha)) => {
            let texels = map.data.chunks_exact_mut(3).zip(alpha);
            texels.for_each(|(texel, alpha)| texel[0] = alpha);
        }
        (NormalKind::Dxt5nm, None) => {
            return Err(
                Error::data("alpha", "opaque everywhere, or no such channel")
                    .expected("x of the normals, as normal-kind dxt5nm states"),
            );
        }
        (_, Some(_)) => {
            warning =
                Some("the normal map's alpha channel is not used (--normal-kind dxt5nm)".into());
        }
        (_, None) => {}
    }
    // Decode the vectors.
    check_red(&map)?;
    let kind = match kind {
        NormalKind::Auto => found_kind(&map),
        kind => kind,
    };
    let vectors: Vec<DVec3> = texels(&map).map(|texel| vector(texel, kind)).collect();
    Ok(Normals {
        width: map.width as usize,
        height: map.height as usize,
        note: format!("normal map: {}", kind.describe()),
        warning: objection(&vectors, kind).or(warning),
        vectors: vectors.into_iter().map(unit).collect(),
    })
}

fn texels(map: &FloatImage) -> impl Iterator<Item = [f32; 3]> {
    map.data
        .chunks_exact(3)
        .map(|texel| [texel[0], texel[1], texel[2]])
}

/// Refuses maps that have no x in their red channel.
fn check_red(map: &FloatImage) -> Result<()> {
    if texels(map).all(|[red, green, blue]| red == green && green == blue) {
        return Err(Error::data("channels", "the same in red, green and blue")
            .expected("a normal map: x in red, y in green")
            .advice("a grey image may be a height map; name it as `height`"));
    }
    if red_says_nothing(map) {
        return Err(
            Error::data("red channel", format!("{} everywhere", map.data[0]))
                .expected("x of the normals, in red, or in the alpha channel (DXT5nm)"),
        );
    }
    Ok(())
}

/// Whether red is 0 or full everywhere while green varies.
fn red_says_nothing(map: &FloatImage) -> bool {
    let is_end = |red: f32| red <= STEP || red >= 1.0 - STEP;
    let first = map.data[0];
    let green_varies = texels(map).any(|[_, green, _]| (green - map.data[1]).abs() > STEP);
    let is_constant = texels(map).all(|[red, _, _]| (red - first).abs() <= STEP);
    let may_be_zero = map.precision == Precision::Float && first.abs() <= STEP;
    is_end(first) && is_constant && green_varies && !may_be_zero
}

/// The kind that the numbers of a map show.
fn found_kind(map: &FloatImage) -> NormalKind {
    let is_signed = map.precision == Precision::Float && is_signed(map);
    let says_nothing = |blue: f32| blue.abs() <= STEP;
    let full = |blue: f32| (blue - 1.0).abs() <= STEP;
    let blue_is = |is: &dyn Fn(f32) -> bool| texels(map).all(|[_, _, blue]| is(blue));
    let xy_only = blue_is(&says_nothing) || blue_is(&full);
    match (is_signed, xy_only) {
        (false, false) => NormalKind::Unsigned,
        (true, false) => NormalKind::Signed,
        (false, true) => NormalKind::UnsignedXy,
        (true, true) => NormalKind::SignedXy,
    }
}

fn is_signed(map: &FloatImage) -> bool {
    if texels(map).any(|[red, green, _]| red < NEGATIVE || green < NEGATIVE) {
        return true;
    }
    let count = (map.data.len() / 3) as f64;
    let mean = |channel: usize| {
        texels(map)
            .map(|texel| f64::from(texel[channel]))
            .sum::<f64>()
            / count
    };
    mean(0).abs() < NEAR_ZERO && mean(1).abs() < NEAR_ZERO
}

fn vector(texel: [f32; 3], kind: NormalKind) -> DVec3 {
    let stored = DVec3::from_array(texel.map(f64::from));
    let vector = match kind.is_signed() {
        true => stored,
        false => 2.0 * stored - 1.0,
    };
    match kind.has_z() {
        true => vector,
        false => {
            let flat = vector.truncate();
            flat.extend((1.0 - flat.length_squared()).max(0.0).sqrt())
        }
    }
}

fn unit(vector: DVec3) -> DVec3 {
    vector.try_normalize().unwrap_or(DVec3::Z)
}

/// Says when many vectors are far from length 1, or point into the surface.
fn objection(vectors: &[DVec3], kind: NormalKind) -> Option<String> {
    let share = |is: &dyn Fn(&DVec3) -> bool| {
        vectors.iter().filter(|vector| is(vector)).count() as f64 / vectors.len() as f64
    };
    let off = share(&|vector| (vector.length() - 1.0).abs() > OFF_LENGTH);
    let below = share(&|vector| vector.z < 0.0);
    let mean = vectors.iter().map(|vector| vector.length()).sum::<f64>() / vectors.len() as f64;
    if below > FEW {
        return Some(format!(
            "{:.0} % of the normal map's vectors point into the surface; read as {} (--normal-kind)",
            100.0 * below,
            kind.describe()
        ));
    }
    if off > FEW {
        let advice = match kind.has_z() {
            true => "if blue holds no z: --normal-kind unsigned-xy",
            false => "--normal-kind",
        };
        return Some(format!(
            "{:.0} % of the normal map's vectors are far from length 1 ({mean:.2} on average); they are \
             brought to it ({advice})",
            100.0 * off
        ));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::Encoding;

    fn map(precision: Precision, texels: impl IntoIterator<Item = [f32; 3]>) -> FloatImage {
        let data: Vec<f32> = texels.into_iter().flatten().collect();
        FloatImage {
            width: (data.len() / 3) as u32,
            height: 1,
            channels: 3,
            data,
            encoding: Encoding::Linear,
            precision,
        }
    }

    /// Unit vectors leaning several ways.
    fn leaning() -> Vec<DVec3> {
        (0..40)
            .map(|i| {
                let (a, t) = (f64::from(i), 0.02 * f64::from(i));
                DVec3::new(a.cos() * t.sin(), a.sin() * t.sin(), t.cos())
            })
            .collect()
    }

    fn stored(to: impl Fn(DVec3) -> DVec3) -> Vec<[f32; 3]> {
        leaning()
            .into_iter()
            .map(|n| to(n).to_array().map(|v| v as f32))
            .collect()
    }

    #[test]
    fn every_kind_gives_the_same_vectors() {
        let half = |n: DVec3| 0.5 * n + 0.5;
        let with_blue = |n: DVec3, blue: f64| DVec3::new(n.x, n.y, blue);
        for (texels, precision, kind) in [
            (stored(half), Precision::Bits16, "x, y and z in 0 to 1"),
            (stored(half), Precision::Float, "x, y and z in 0 to 1"),
            (stored(|n| n), Precision::Float, "x, y and z in −1 to 1"),
            (
                stored(|n| with_blue(half(n), 0.0)),
                Precision::Bits8,
                "x and y in 0 to 1",
            ),
            (
                stored(|n| with_blue(half(n), 1.0)),
                Precision::Bits8,
                "x and y in 0 to 1",
            ),
            (
                stored(|n| with_blue(n, 0.0)),
                Precision::Float,
                "x and y in −1 to 1",
            ),
            (
                stored(|n| 0.7 * n),
                Precision::Float,
                "x, y and z in −1 to 1",
            ),
        ] {
            let found = normals(map(precision, texels), None, NormalKind::Auto).unwrap();
            assert!(found.note.contains(kind), "{kind}: {}", found.note);
            for (found, wanted) in found.vectors.iter().zip(leaning()) {
                assert!(
                    (*found - wanted).length() < 1e-3,
                    "{kind}: {found} {wanted}"
                );
            }
        }
    }

    #[test]
    fn a_kind_that_is_asked_for_is_taken() {
        let texels = stored(|n| DVec3::new(0.5 * n.x + 0.5, 0.5 * n.y + 0.5, 0.3));
        let map = map(Precision::Bits8, texels);
        let auto = normals(map.clone(), None, NormalKind::Auto).unwrap();
        assert!(auto.warning.unwrap().contains("into the surface"));
        let asked = normals(map, None, NormalKind::UnsignedXy).unwrap();
        assert_eq!(asked.warning, None);
        for (found, wanted) in asked.vectors.iter().zip(leaning()) {
            assert!((*found - wanted).length() < 1e-3);
        }
    }

    #[test]
    fn x_in_alpha_is_found() {
        let alpha: Vec<f32> = leaning().iter().map(|n| (0.5 * n.x + 0.5) as f32).collect();
        let texels = stored(|n| DVec3::new(1.0, 0.5 * n.y + 0.5, 1.0));
        let packed = map(Precision::Bits8, texels);
        let found = normals(packed.clone(), Some(alpha.clone()), NormalKind::Auto).unwrap();
        assert!(found.note.contains("x in alpha"), "{}", found.note);
        for (found, wanted) in found.vectors.iter().zip(leaning()) {
            assert!((*found - wanted).length() < 1e-3);
        }
        let error = normals(packed, None, NormalKind::Dxt5nm).unwrap_err();
        assert!(error.to_string().contains("alpha"), "{error}");
        let half = map(Precision::Bits8, stored(|n| 0.5 * n + 0.5));
        let unused = normals(half, Some(alpha), NormalKind::Auto).unwrap();
        assert!(
            unused
                .warning
                .unwrap()
                .contains("alpha channel is not used")
        );
    }

    #[test]
    fn lengths_far_from_one_are_told_of() {
        let short = map(Precision::Float, stored(|n| 0.5 * n));
        let found = normals(short, None, NormalKind::Auto).unwrap();
        assert!(
            found
                .warning
                .unwrap()
                .contains("length 1 (0.50 on average)")
        );
        let flat = map(Precision::Float, [[0.0, 0.0, 1.0], [0.0, 0.01, 1.0]]);
        assert_eq!(normals(flat, None, NormalKind::Auto).unwrap().warning, None);
    }

    #[test]
    fn maps_without_x_are_refused() {
        let refused = |texels: Vec<[f32; 3]>| {
            let map = map(Precision::Bits8, texels);
            normals(map, None, NormalKind::Auto)
                .unwrap_err()
                .to_string()
        };
        assert!(refused(vec![[0.3; 3], [0.7; 3]]).contains("height map"));
        let in_alpha = refused(vec![[1.0, 0.4, 1.0], [1.0, 0.6, 1.0]]);
        assert!(in_alpha.contains("alpha channel"), "{in_alpha}");
    }
}
