//! The base colour image of a model: colour and alpha in one PNG, or colour over a plain one.

use crate::error::Result;
use crate::exemplar::channels::ChannelKind;
use crate::format::image::{PngImage, PngNumbers, Precision};
use crate::textures::image_file::bits8;
use crate::textures::surface_color::SurfaceColor;
use crate::textures::texture::Texture;

/// Colour and alpha in one PNG; white where there is alpha alone. With a `plain` colour, this shows where alpha is
/// below 1, mixed in linear light, and the image has no alpha.
pub(super) fn base_color(
    color: Option<&Texture>,
    alpha: Option<&Texture>,
    plain: Option<SurfaceColor>,
) -> Result<Option<Vec<u8>>> {
    match (color, alpha, plain) {
        (color, Some(alpha), Some(plain)) => {
            let covered = covered(color, alpha, plain);
            png8(&covered, &bits8(&covered), true).map(Some)
        }
        (Some(color), None, _) => {
            png8(color, bytemuck::cast_slice(&triples(color)), true).map(Some)
        }
        (color, Some(alpha), None) => png8(alpha, &with_alpha(color, alpha), true).map(Some),
        (None, None, _) => Ok(None),
    }
}

/// A texture's 8-bit numbers as PNG.
pub(super) fn png8(texture: &Texture, numbers: &[u8], is_srgb: bool) -> Result<Vec<u8>> {
    let image = PngImage {
        width: texture.width,
        height: texture.height,
        numbers: PngNumbers::Bits8(numbers),
        is_srgb,
    };
    image.encode()
}

/// Red, green and blue of every texel; grey is all three.
fn triples(color: &Texture) -> Vec<[u8; 3]> {
    let numbers = bits8(color);
    let texels = numbers.chunks_exact(color.count);
    texels
        .map(|texel| [0, 1, 2].map(|at| texel[at % color.count]))
        .collect()
}

fn with_alpha(color: Option<&Texture>, alpha: &Texture) -> Vec<u8> {
    let alphas = bits8(alpha);
    let colors = match color {
        Some(color) => triples(color),
        None => vec![[255; 3]; alphas.len()],
    };
    let texels = colors.iter().zip(alphas);
    texels.flat_map(|([r, g, b], a)| [*r, *g, *b, a]).collect()
}

/// The texture over a plain colour, opaque.
fn covered(color: Option<&Texture>, alpha: &Texture, plain: SurfaceColor) -> Texture {
    let shares = alpha.numbers.iter().enumerate();
    let mixed = shares.flat_map(|(texel, &share)| {
        let above = color.map_or([1.0; 3], |color| {
            let numbers = color.texel(texel);
            [0, 1, 2].map(|at| numbers[at % color.count])
        });
        plain.below(above, share)
    });
    Texture {
        name: "base color".into(),
        kind: ChannelKind::Color,
        count: 3,
        low: 0.0,
        high: 1.0,
        precision: Precision::Bits8,
        width: alpha.width,
        height: alpha.height,
        numbers: mixed.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::{decode_srgb, read};
    use crate::textures::texture::tests::texture;

    #[test]
    fn a_plain_colour_shows_where_the_texture_is_transparent() {
        let red = texture(ChannelKind::Color, 3, [1.0, 0.0, 0.0].repeat(4));
        let alpha = texture(ChannelKind::Alpha, 1, vec![1.0, 0.0, 0.5, 0.25]);
        let green = SurfaceColor([0, 255, 0]);
        let folder = tempfile::tempdir().unwrap();
        let decoded = |bytes: Option<Vec<u8>>| {
            let path = folder.path().join("x.png");
            std::fs::write(&path, bytes.unwrap()).unwrap();
            read(&path).unwrap()
        };
        let image = decoded(base_color(Some(&red), Some(&alpha), Some(green)).unwrap());
        assert_eq!(image.channels, 3);
        for (texel, share) in image.data.chunks_exact(3).zip(&alpha.numbers) {
            assert!((decode_srgb(texel[0]) - share).abs() < 5e-3, "{texel:?}");
            assert!((decode_srgb(texel[1]) - (1.0 - share)).abs() < 5e-3);
            assert_eq!(texel[2], 0.0);
        }
        // White where there is alpha alone.
        let image = decoded(base_color(None, Some(&alpha), Some(green)).unwrap());
        assert_eq!(image.data[..6], [1.0, 1.0, 1.0, 0.0, 1.0, 0.0]);
        assert_eq!(
            decoded(base_color(Some(&red), None, None).unwrap()).channels,
            3
        );
        assert_eq!(base_color(None, None, None).unwrap(), None);
    }
}
