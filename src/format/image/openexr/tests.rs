//! OpenEXR files made here, byte by byte or by another writer; what is odd, what is refused.

use std::path::Path;

use exr::image::{Image, Layer, SpecificChannels};
use exr::meta::attribute::{Chromaticities as Primaries, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Encoding as Packing, WritableImage};

use super::*;
use crate::format::image::{FloatImage, inspect, read_with};

/// Red counts columns and green rows of the frame, whatever the window.
fn frame(path: &Path, data: [i32; 4], change: impl Fn(&mut ImageAttributes)) {
    let [left, top, width, height] = data;
    let pixel = |at: Vec2<usize>| {
        (
            (at.0 as i32 + left) as f32,
            (at.1 as i32 + top) as f32,
            0.5_f32,
        )
    };
    let layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::named("main").with_position(Vec2(left, top)),
        Packing::FAST_LOSSLESS,
        SpecificChannels::rgb(pixel),
    );
    let display = IntegerBounds::new((0, 0), (6, 4));
    let mut attributes = ImageAttributes::new(display);
    change(&mut attributes);
    let image = Image::empty(attributes).with_layer(layer);
    image.write().to_file(path).unwrap();
}

fn framed(data: [i32; 4], options: &ReadOptions) -> Result<FloatImage> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    frame(&path, data, |_| {});
    read_with(&path, options).map(|read| read.image)
}

#[test]
fn overscan_is_cut_to_the_display_window() {
    let any = ReadOptions::default();
    let whole = framed([0, 0, 6, 4], &any).unwrap();
    assert_eq!((whole.width, whole.height), (6, 4));
    assert_eq!((whole.get(3, 5, 0), whole.get(3, 5, 1)), (5.0, 3.0));
    assert_eq!(framed([-2, -3, 11, 9], &any).unwrap(), whole);
}

#[test]
fn missing_pixels_are_refused_or_black() {
    let error = framed([1, 1, 3, 2], &ReadOptions::default()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("18 of 24 texels"), "{text}");
    assert!(
        text.contains("(0, 0) to (5, 3)") && text.contains("(1, 1) to (3, 2)"),
        "{text}"
    );
    let black = ReadOptions {
        missing: Missing::Black,
        ..ReadOptions::default()
    };
    let image = framed([1, 1, 3, 2], &black).unwrap();
    assert_eq!((image.get(2, 3, 0), image.get(2, 3, 1)), (3.0, 2.0));
    assert_eq!((image.get(0, 0, 2), image.get(3, 5, 2)), (0.0, 0.0));
    // Nothing of the data is seen.
    assert_eq!(framed([50, 50, 3, 2], &black).unwrap().data, [0.0; 72]);
}

#[test]
fn pixels_that_are_not_square_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    frame(&path, [0, 0, 6, 4], |a| a.pixel_aspect = 2.0);
    let found = inspect(&path, &ReadOptions::default()).unwrap();
    assert_eq!(found.facts.pixel_aspect, 2.0);
    let text = found.read.unwrap_err().to_string();
    assert!(text.contains("pixel aspect ratio: 2"), "{text}");
}

#[test]
fn chromaticities_are_converted_and_tristimulus_is_not_adapted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let primaries = |numbers: [f32; 8]| Primaries {
        red: Vec2(numbers[0], numbers[1]),
        green: Vec2(numbers[2], numbers[3]),
        blue: Vec2(numbers[4], numbers[5]),
        white: Vec2(numbers[6], numbers[7]),
    };
    let first = |numbers: Option<[f32; 8]>, options: &ReadOptions| {
        frame(&path, [0, 0, 6, 4], |a| {
            a.chromaticities = numbers.map(primaries)
        });
        let image = read_with(&path, options).unwrap().image;
        [0, 1, 2].map(|channel| image.get(1, 1, channel))
    };
    let keep = ReadOptions {
        gamut: crate::format::image::Gamut::Keep,
        ..ReadOptions::default()
    };
    let stored = [1.0, 1.0, 0.5];
    assert_eq!(first(None, &keep), stored);
    let xyz = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0];
    let third = 0.5;
    // Rows of the published matrix from XYZ to linear sRGB (IEC 61966-2-1).
    let expected = [
        3.2406 - 1.5372 - 0.4986 * third,
        -0.9689 + 1.8758 + 0.0415 * third,
        0.0557 - 0.2040 + 1.0570 * third,
    ];
    for (found, expected) in first(Some(xyz), &keep).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }
    let p3 = [0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329];
    assert!((first(Some(p3), &keep)[2] - 0.5).abs() > 0.01);
    assert_eq!(first(Some(p3), &ReadOptions::data()), stored);
}

#[test]
fn a_layer_in_a_later_part_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let depth = SpecificChannels::new(
        (exr::meta::attribute::ChannelDescription::named(
            "Z",
            SampleType::F32,
        ),),
        |_: Vec2<usize>| (7.0_f32,),
    );
    let layer = |name: &str| LayerAttributes::named(Text::new_or_panic(name));
    let color = SpecificChannels::rgb(|at: Vec2<usize>| (at.0 as f32, 0.25_f32, 0.5_f32));
    let display = IntegerBounds::new((0, 0), (2, 2));
    let image = Image::empty(ImageAttributes::new(display))
        .with_layer(Layer::new(
            (2, 2),
            layer("depth"),
            Packing::FAST_LOSSLESS,
            depth,
        ))
        .with_layer(Layer::new(
            (2, 2),
            layer("beauty"),
            Packing::FAST_LOSSLESS,
            color,
        ));
    image.write().to_file(&path).unwrap();
    let read = |options: &ReadOptions| read_with(&path, options).unwrap();
    let found = read(&ReadOptions::default());
    assert_eq!(found.image.data[..3], [0.0, 0.25, 0.5]);
    assert!(!found.layer_taken);
    let named = ReadOptions {
        layer: Some("depth".into()),
        ..ReadOptions::default()
    };
    let found = read(&named);
    assert_eq!((found.image.data[0], found.layer_taken), (7.0, true));
}

#[test]
fn luminance_and_chroma_become_colours() {
    let header = Header::new(Text::new_or_panic("a"), (1, 1), smallvec());
    // Grey has no chroma; a red of luminance 0.2126 has RY = 1 / 0.2126 − 1 and BY = −1.
    let mut data = [0.5, 0.0, 0.0, 0.2126, 1.0 / 0.2126 - 1.0, -1.0];
    to_rgb(&mut data, &header);
    let expected = [0.5, 0.5, 0.5, 1.0, 0.0, 0.0];
    for (found, expected) in data.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }
}

fn smallvec() -> exr::prelude::SmallVec<[exr::meta::attribute::ChannelDescription; 5]> {
    ["BY", "RY", "Y"]
        .into_iter()
        .map(|name| exr::meta::attribute::ChannelDescription::named(name, SampleType::F32))
        .collect()
}
