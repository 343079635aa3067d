//! How much memory work on an atlas takes, before the atlas is read.
//!
//! Figures are of the lists that dominate. The files of an atlas state its size and the size is compared with
//! their lengths before; the mesh counts by what its displaced or cut form may have at the most.

use crate::exemplar::channels::ChannelKind;
use crate::maps::atlas_map::Description;
use crate::textures::channel::SampleChannel;
use crate::textures::model::ModelOptions;
use crate::textures::relief::MOST_TRIANGLES;

/// Bytes per texel of an atlas in memory: its chart, point, frame, coordinate and label.
const MAP: u64 = 62;
/// Bytes per texel of an atlas, while it is read: arrays of three numbers on the way from its file.
const READ: u64 = 106;
/// Bytes per texel of an image with its surface points: triangle, weights, and what is padded.
const POINT: u64 = 24;
/// Bytes per texel while it is found what continues the surface beyond charts: a small triangle per texel, and
/// the hierarchy over them. Measured where charts fill two thirds of the image.
const PADDING: u64 = 200;
/// Bytes per number of a texture.
const NUMBER: u64 = 4;
/// Bytes per number of a texture on its way into a file: as integers, and compressed.
const ENCODED: u64 = 4;
/// Bytes per texel while normals are turned: which texel shows it, and the rings that grow.
const TURNED: u64 = 20;
/// Bytes per texel of an image of heights or alpha that is read.
const IMAGE: u64 = 16;
/// Bytes per texel that is shaded: its place in the sample, its frame, what reaches it, its colour. Measured where
/// charts fill two thirds of the image.
const SHADED: u64 = 130;
/// Bytes per texel of the two images of a bake, and of their files.
const BAKED: u64 = 60;
/// Bytes per triangle of a surface that is cut, while the last pass is made: corners, edges, places.
const TRIANGLE: u64 = 200;
/// Bytes per triangle of a model: corners of its own with texture coordinates, and the file.
const MODEL: u64 = 150;
/// Triangles per texel of a cut surface, about.
const CUT: u64 = 4;
/// The program, and working memory of its threads.
const PROGRAM: u64 = 16 << 20;

/// Bytes that an atlas takes until it is ready to be rendered: read, its images too, and cut.
pub fn bytes_to_draw(description: &Description) -> u64 {
    let texels = description.texels();
    let read = texels * (READ + IMAGE * drawn_images(description));
    let cut = texels * (MAP + IMAGE * drawn_images(description));
    read.max(cut + TRIANGLE * cut_triangles(texels)) + PROGRAM
}

/// The images of an atlas that change its shape.
fn drawn_images(description: &Description) -> u64 {
    let kinds = [ChannelKind::Alpha, ChannelKind::Height].map(ChannelKind::name);
    let images = description.channels.iter();
    let images = images.filter(|file| kinds.contains(&file.kind.as_str()));
    images.count().min(kinds.len()) as u64
}

/// Bytes that baking the look of an atlas takes, the sample apart.
pub fn bytes_to_bake(description: &Description) -> u64 {
    let texels = description.texels();
    let kept = texels * (MAP + POINT + IMAGE * drawn_images(description));
    let shading = TRIANGLE * cut_triangles(texels) + texels * SHADED;
    kept + shading.max(texels * BAKED).max(texels * PADDING) + PROGRAM
}

/// Bytes that carrying channels onto an atlas takes, with `finer` times its columns and rows.
pub fn bytes_to_transfer(
    description: &Description,
    finer: u32,
    channels: &[SampleChannel],
    model: &ModelOptions,
) -> u64 {
    let texels = description.texels();
    let fine = texels.saturating_mul(u64::from(finer).pow(2));
    let coarse_points = if finer > 1 { POINT } else { 0 };
    let counts = channels.iter().map(|channel| channel.count as u64);
    let is_turned = channels
        .iter()
        .any(|channel| channel.kind == ChannelKind::Normal);
    let numbers = NUMBER * counts.clone().sum::<u64>() + ENCODED * counts.max().unwrap_or(0);
    let turned = if is_turned { TURNED } else { 0 };
    let of_model = match model.displace {
        Some(_) => (TRIANGLE + MODEL) * cut_triangles(fine),
        None => 0,
    };
    let textures = fine
        .saturating_mul(numbers + turned)
        .saturating_add(of_model);
    let beside_map = fine
        .saturating_mul(POINT)
        .saturating_add(textures.max(fine.saturating_mul(PADDING)));
    let working = (texels * (MAP + coarse_points)).saturating_add(beside_map);
    working.max(texels * READ).saturating_add(PROGRAM)
}

fn cut_triangles(texels: u64) -> u64 {
    (CUT * texels).min(MOST_TRIANGLES as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::{Encoding, FloatImage, Precision};
    use crate::maps::atlas_map::tests::square;

    #[test]
    fn memory_grows_with_texels_channels_and_finer_maps() {
        let folder = tempfile::tempdir().unwrap();
        let map = square();
        map.write_into(folder.path(), Vec::new()).unwrap();
        let mut description = Description::read(folder.path()).unwrap();
        (description.width, description.height) = (8192, 8192);
        let image = FloatImage {
            width: 8,
            height: 4,
            channels: 3,
            data: vec![0.5; 96],
            encoding: Encoding::Data,
            precision: Precision::Bits8,
        };
        let color = SampleChannel::of_image("c".into(), ChannelKind::Color, image, map.grid(), 1);
        let channels = [color.unwrap()];
        let model = ModelOptions::default();
        let bytes = |finer, channels| bytes_to_transfer(&description, finer, channels, &model);
        // What must be there at the least: coordinates, frames and the texture.
        let texels = 1 << 26;
        let (bare, one) = (bytes(1, &[]), bytes(1, &channels));
        assert!(bare > 58 * texels && one >= bare, "{bare} {one}");
        let many = vec![channels[0].clone(); 30];
        assert!(bytes(1, &many) > (58 + 30 * 12) * texels);
        assert!(bytes(2, &channels) > one + 3 * 12 * texels);
        // No number on the command line is beyond counting.
        assert!(bytes(u32::MAX, &channels) > 1 << 60);
        assert!(bytes_to_bake(&description) > bytes_to_draw(&description));
    }
}
