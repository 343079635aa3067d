//! A texture as a file: PNG of 8 or 16 bits, colours by the sRGB curve, or OpenEXR where numbers lie outside
//! what a PNG holds or where steps of 16 bits would lose some.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::exr::{self, Attribute, Compression, ExrImage, Numbers};
use crate::format::image::{PngImage, PngNumbers, Precision, ReadOptions, encode_srgb, read_with};
use crate::maps::atlas_map::ChannelFile;
use crate::textures::texture::Texture;

/// How a texture is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Coding {
    Png8,
    Png16,
    Exr,
}

impl Coding {
    fn of(texture: &Texture) -> Self {
        let fits = texture.low >= 0.0 && texture.high <= 1.0;
        match (texture.kind, texture.precision) {
            (ChannelKind::Normal, Precision::Bits8) => Self::Png8,
            (ChannelKind::Normal, _) => Self::Png16,
            (_, Precision::Float) => Self::Exr,
            _ if !fits => Self::Exr,
            // Heights between those of two texels have finer steps than the texels'.
            (ChannelKind::Height, _) => Self::Png16,
            (_, Precision::Bits8) => Self::Png8,
            _ => Self::Png16,
        }
    }

    fn ending(self) -> &'static str {
        match self {
            Self::Png8 | Self::Png16 => "png",
            Self::Exr => "exr",
        }
    }
}

/// Writes a texture into a folder under a name that none of `taken` has.
pub(super) fn write(
    texture: &Texture,
    folder: &Path,
    taken: &[ChannelFile],
) -> Result<ChannelFile> {
    let coding = Coding::of(texture);
    let file = file_name(&texture.name, coding.ending(), taken);
    let path = folder.join(&file);
    match coding {
        Coding::Png8 => png(texture, PngNumbers::Bits8(&bits8(texture))).write(&path)?,
        Coding::Png16 => png(texture, PngNumbers::Bits16(&bits16(texture))).write(&path)?,
        Coding::Exr => exr::write(&path, &encode_exr(texture)?)?,
    }
    let (low, high) = match (coding, texture.kind) {
        (Coding::Exr, _) => (texture.low, texture.high),
        (_, ChannelKind::Normal) => (-1.0, 1.0),
        _ => (0.0, 1.0),
    };
    Ok(ChannelFile {
        name: texture.name.clone(),
        kind: texture.kind.name().into(),
        file,
        low,
        high,
    })
}

/// Reads the image of a height, mask or alpha back from a folder.
pub fn read(folder: &Path, file: &ChannelFile, kind: ChannelKind) -> Result<Texture> {
    let path = folder.join(&file.file);
    let image = read_with(&path, &ReadOptions::data())?.image;
    image.check_finite().map_err(|error| error.in_file(&path))?;
    if image.channels != 1 {
        return Err(Error::data("channels", image.channels.to_string())
            .expected("a grey image")
            .in_file(&path));
    }
    let (low, high) = (file.low as f32, file.high as f32);
    let numbers = match image.precision {
        Precision::Float => image.data,
        _ => image
            .data
            .iter()
            .map(|share| low + share * (high - low))
            .collect(),
    };
    Ok(Texture {
        name: file.name.clone(),
        kind,
        count: 1,
        low: file.low,
        high: file.high,
        precision: image.precision,
        width: image.width,
        height: image.height,
        numbers,
    })
}

/// A channel's name without signs that some file system refuses, numbered where it is taken.
fn file_name(name: &str, ending: &str, taken: &[ChannelFile]) -> String {
    let is_fine = |sign: char| sign.is_alphanumeric() || matches!(sign, '-' | '_');
    let stem: String = name
        .chars()
        .map(|sign| if is_fine(sign) { sign } else { '-' })
        .collect();
    let is_free = |name: &String| {
        let name = name.to_lowercase();
        !taken.iter().any(|other| other.file.to_lowercase() == name)
    };
    let numbered = |number: usize| match number {
        1 => format!("{stem}.{ending}"),
        _ => format!("{stem}-{number}.{ending}"),
    };
    let mut names = (1..=taken.len()).map(numbered);
    names
        .find(is_free)
        .unwrap_or_else(|| numbered(taken.len() + 1))
}

fn png<'a>(texture: &Texture, numbers: PngNumbers<'a>) -> PngImage<'a> {
    PngImage {
        width: texture.width,
        height: texture.height,
        numbers,
        is_srgb: texture.kind == ChannelKind::Color,
    }
}

/// A number as a share of the largest integer.
fn share(kind: ChannelKind, number: f32) -> f32 {
    let share = match kind {
        ChannelKind::Color => encode_srgb(number),
        ChannelKind::Normal => 0.5 * number + 0.5,
        _ => number,
    };
    share.clamp(0.0, 1.0)
}

/// The numbers in 8 bits; what a PNG cannot hold is clamped.
pub(super) fn bits8(texture: &Texture) -> Vec<u8> {
    let numbers = texture.numbers.par_iter();
    numbers
        .map(|&number| (share(texture.kind, number) * 255.0 + 0.5) as u8)
        .collect()
}

fn bits16(texture: &Texture) -> Vec<u16> {
    let numbers = texture.numbers.par_iter();
    numbers
        .map(|&number| (share(texture.kind, number) * 65535.0 + 0.5) as u16)
        .collect()
}

fn encode_exr(texture: &Texture) -> Result<Vec<u8>> {
    let names: &[&str] = if texture.count == 1 {
        &["Y"]
    } else {
        &["R", "G", "B"]
    };
    let channel = |(at, name): (usize, &&str)| {
        let numbers: Vec<f32> = texture
            .numbers
            .iter()
            .skip(at)
            .step_by(texture.count)
            .copied()
            .collect();
        ((*name).to_owned(), Numbers::Float(Cow::Owned(numbers)))
    };
    let image = ExrImage {
        size: [texture.width, texture.height],
        channels: names.iter().enumerate().map(channel).collect(),
        attributes: BTreeMap::from([(
            "mesotex:channel".into(),
            Attribute::Text(texture.name.clone()),
        )]),
    };
    exr::encode(&image, Compression::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::read;
    use crate::textures::texture::tests::texture;

    #[test]
    fn colours_go_through_the_curve_and_data_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let numbers = vec![0.0, 0.214_041_14, 0.5, 1.0];
        for (kind, ending, wanted) in [
            (ChannelKind::Color, "png", [0, 127, 188, 255]),
            (ChannelKind::Mask, "png", [0, 55, 128, 255]),
        ] {
            let file = write(&texture(kind, 1, numbers.clone()), folder.path(), &[]).unwrap();
            assert!(file.file.ends_with(ending) && (file.low, file.high) == (0.0, 1.0));
            let image = read(&folder.path().join(&file.file)).unwrap();
            assert_eq!(image.precision, Precision::Bits8);
            let bits: Vec<u8> = image.data.iter().map(|v| (v * 255.0 + 0.5) as u8).collect();
            assert!(
                bits.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 1),
                "{bits:?}"
            );
        }
    }

    #[test]
    fn normals_are_shifted_and_heights_keep_their_steps() {
        let folder = tempfile::tempdir().unwrap();
        let flat = texture(ChannelKind::Normal, 3, [0.0, -1.0, 1.0].repeat(4));
        assert_eq!(bits8(&flat)[..3], [128, 0, 255]);
        let file = write(&flat, folder.path(), &[]).unwrap();
        assert_eq!((file.low, file.high), (-1.0, 1.0));
        let heights = texture(ChannelKind::Height, 1, vec![0.0, 1.0 / 4096.0, 0.5, 1.0]);
        let file = write(&heights, folder.path(), &[]).unwrap();
        let back = super::read(folder.path(), &file, ChannelKind::Height).unwrap();
        assert!((back.numbers[1] - 1.0 / 4096.0).abs() < 1e-5);
        let image = read_with(&folder.path().join(file.file), &ReadOptions::data())
            .unwrap()
            .image;
        assert_eq!(image.precision, Precision::Bits16);
        assert!((image.data[1] - 1.0 / 4096.0).abs() < 1e-5);
    }

    #[test]
    fn what_no_png_holds_is_openexr() {
        let folder = tempfile::tempdir().unwrap();
        let mut bright = texture(ChannelKind::Color, 3, vec![3.5; 12]);
        bright.high = 4.0;
        let mut deep = texture(ChannelKind::Height, 1, vec![-2.0, 0.25, 0.0, 7.0]);
        (deep.low, deep.high, deep.precision) = (-2.0, 7.0, Precision::Float);
        for wanted in [bright, deep] {
            let file = write(&wanted, folder.path(), &[]).unwrap();
            assert!(file.file.ends_with(".exr"));
            let image = read_with(&folder.path().join(file.file), &ReadOptions::data()).unwrap();
            assert_eq!(image.image.data, wanted.numbers);
        }
    }

    #[test]
    fn names_are_plain_and_never_the_same() {
        let taken = |file: &str| ChannelFile {
            name: "x".into(),
            kind: "mask".into(),
            file: file.into(),
            low: 0.0,
            high: 1.0,
        };
        assert_eq!(file_name("../a b", "png", &[]), "---a-b.png");
        assert_eq!(file_name("wear", "png", &[taken("Wear.png")]), "wear-2.png");
        let two = [taken("wear.png"), taken("wear-2.png")];
        assert_eq!(file_name("wear", "png", &two), "wear-3.png");
    }
}
