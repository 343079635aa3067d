//! Small sound image sets in archives.

use std::borrow::Cow;
use std::collections::BTreeMap;

use image::ImageFormat;
use mesotex::format::exr::{self, Compression, ExrImage, Numbers};

use crate::corpus::{hdr, images};
use crate::image_set_files::{compressed, hdr_with_faulty_line, zipped};

/// An archive of two images named by their angles.
fn set(image: &[u8], end: &str, stored: bool) -> Vec<u8> {
    let member = |light: u32| {
        let angles = format!("tl{:03} pl090 tv000 pv000", 15 * light);
        let name = format!("SET/tv000_pv000/{light:05} {angles}.{end}");
        (name.into(), image.to_vec())
    };
    zipped(&(0..2).map(member).collect(), stored)
}

/// Archives of JPEG and PNG, of Radiance with sound and with faulty size lines, of packed bitmaps.
pub fn image_sets() -> Vec<Vec<u8>> {
    let png = &images(ImageFormat::Png)[0];
    let list = b"2\na.png 0 0 1\nb c.png 0.1 0.2 0.9\n".to_vec();
    let listed = [
        ("dome/dirs.lp", &list),
        ("dome/a.png", png),
        ("dome/b c.png", png),
    ];
    let listed = listed.map(|(name, bytes)| (name.into(), bytes.clone()));
    vec![
        zipped(&listed.into(), true),
        set(&images(ImageFormat::Jpeg)[0], "jpg", true),
        set(&images(ImageFormat::Png)[0], "png", false),
        set(&hdr(), "hdr", false),
        set(&hdr_with_faulty_line(13, 9), "hdr", false),
        set(&compressed(&images(ImageFormat::Bmp)[0]), "bmp.Z", true),
    ]
}

/// An archive of one spectral image.
pub fn spectral_set() -> Vec<u8> {
    let channels = (400..=700).step_by(50).map(|nm| {
        let numbers: Vec<f32> = (0..12).map(|k| (k % 7) as f32 * 0.1).collect();
        (format!("{nm}.0"), Numbers::Float(Cow::Owned(numbers)))
    });
    let picture = ExrImage {
        size: [4, 3],
        channels: channels.collect(),
        attributes: BTreeMap::new(),
    };
    let image = exr::encode(&picture, Compression::Zip).unwrap();
    zipped(
        &[("tv0.0_pv0.0_tl30.0_pl0.0.exr".into(), image)].into(),
        false,
    )
}

/// Files of Unix compress: what it makes of twenty letters, and a bitmap.
pub fn compressed_files() -> Vec<Vec<u8>> {
    let letters = b"\x1f\x9d\x90\x61\x02\x0a\x1c\x48\x90\x20".to_vec();
    vec![letters, compressed(&images(ImageFormat::Bmp)[0])]
}
