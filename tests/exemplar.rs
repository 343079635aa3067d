//! `mesotex exemplar` as a user runs it: kinds, weights, alpha, controls, and what is refused.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use exr::prelude::{ChannelDescription, Image, SampleType, SpecificChannels, Vec2, WritableImage};
use image::{GrayImage, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use mesotex::exemplar::{ChannelKind, Features, Space};
use mesotex::format::image::decode_srgb;
use serde_json::{Value, json};

const FEW: &str = "--levels 2 --k 2 --neighborhood 3";

fn mesotex(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    let words = line.split_whitespace();
    command.args(words).current_dir(folder).output().unwrap()
}

/// The space of an exemplar of these images and options.
fn made(folder: &Path, line: &str) -> Space {
    let output = mesotex(folder, &format!("exemplar {line} -o x {FEW}"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {said}");
    Space::read(&folder.join("x.space.npz")).unwrap()
}

fn refused(folder: &Path, line: &str, code: i32) -> String {
    let output = mesotex(folder, &format!("exemplar {line} -o y {FEW}"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{line}: {said}");
    assert!(!folder.join("y.sample").exists(), "{line}");
    assert!(!folder.join("y.space.npz").exists(), "{line}");
    said
}

/// Images of 8 × 8: `c.png` in colour, grey `a.png`, `b.png`, `x_mask.png`, `x_rough.png`, `x_opacity.png`,
/// `x_normal.png`; `leaf.png` half transparent; `h.exr` a float height, `f.exr` float grey light.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let color = |x: u32, y: u32| Rgb([20 * x as u8, 25 * y as u8, (3 * x + 7 * y) as u8]);
    RgbImage::from_fn(8, 8, color).save(at("c.png")).unwrap();
    let grey = |x: u32, y: u32| Luma([(30 * x + y) as u8]);
    for name in ["a", "b", "x_mask", "x_rough", "x_opacity"] {
        let name = format!("{name}.png");
        GrayImage::from_fn(8, 8, grey).save(at(&name)).unwrap();
    }
    let normal = |x: u32, _| Rgb([100 + x as u8, 128, 250]);
    RgbImage::from_fn(8, 8, normal)
        .save(at("x_normal.png"))
        .unwrap();
    let leaf = |x: u32, y: u32| Rgba([200, 25 * y as u8, 9, if x < 4 { 0 } else { 255 }]);
    RgbaImage::from_fn(8, 8, leaf).save(at("leaf.png")).unwrap();
    float_image(&at("h.exr"), "Z", |x, _| -2.0 + x as f32);
    float_image(&at("f.exr"), "Y", |_, _| 0.25);
    folder
}

fn float_image(path: &Path, channel: &str, value: impl Fn(usize, usize) -> f32 + Sync) {
    let described = ChannelDescription::named(channel, SampleType::F32);
    let numbers = SpecificChannels::new((described,), |at: Vec2<usize>| (value(at.x(), at.y()),));
    let image = Image::from_channels((8, 8), numbers);
    image.write().to_file(path).unwrap();
}

/// Name, first, count, weight, low and high of every channel.
fn channels(space: &Space) -> Vec<(&str, u32, u32, f64, f64, f64)> {
    let list = space.channels.list().iter();
    list.map(|c| (c.name.as_str(), c.first, c.count, c.weight, c.low, c.high))
        .collect()
}

#[test]
fn every_kind_is_a_channel_with_its_numbers_as_they_stand() {
    let folder = folder();
    let at = folder.path();
    let space = made(
        at,
        "c.png h.exr a.png b.png x_normal.png --kinds color,height,mask,alpha,normal",
    );
    assert_eq!(
        channels(&space),
        [
            ("color", 0, 3, 1.0, 0.0, 1.0),
            ("height", 3, 1, 1.0, -2.0, 5.0),
            ("mask", 4, 1, 1.0, 0.0, 1.0),
            ("alpha", 5, 1, 1.0, 0.0, 1.0),
            ("normal", 6, 3, 1.0, 0.0, 1.0),
        ]
    );
    let Features::Plain(vectors) = &space.levels[0].features else {
        panic!("vectors expected")
    };
    let texel: Vec<f32> = (0..9).map(|d| vectors[[2, 3, d]]).collect();
    let bytes = [60, 50, 23, 0, 92, 92, 103, 128, 250].map(|byte| byte as f32 / 255.0);
    assert_eq!(texel[..3], bytes[..3]);
    assert_eq!(texel[3], 1.0);
    assert_eq!(texel[4..], bytes[4..]);
}

#[test]
fn kinds_are_told_by_names_and_by_numbers() {
    let folder = folder();
    let at = folder.path();
    let kinds = |line: &str| {
        let space = made(at, line);
        let list = space.channels.list().iter();
        let names: Vec<String> = list.map(|channel| channel.name.clone()).collect();
        names.join(" ")
    };
    assert_eq!(
        kinds("c.png x_mask.png x_rough.png x_opacity.png x_normal.png"),
        "color mask mask-2 alpha normal"
    );
    assert_eq!(
        kinds("c.png a.png h.exr c.png"),
        "color height height-2 color-2"
    );
    assert_eq!(kinds("x_normal.png x_mask.png"), "color mask");
    assert_eq!(
        kinds("c.png x_mask.png --kinds auto,height"),
        "color height"
    );
    // A name does not make a grey map of a colour image.
    fs::copy(at.join("c.png"), at.join("x_height.png")).unwrap();
    assert_eq!(kinds("c.png x_height.png"), "color color-2");
}

#[test]
fn encodings_of_light_are_for_colours() {
    let folder = folder();
    let at = folder.path();
    let last = |line: &str| {
        let space = made(at, line);
        let channel = space.channels.list().last().unwrap();
        let numbers = space.channel_numbers(0, channel).unwrap();
        (channel.kind, numbers[[0, 1, 0]])
    };
    let (kind, encoded) = last("c.png f.exr --kinds auto,color");
    assert_eq!(kind, ChannelKind::Color);
    assert!((decode_srgb(encoded) - 0.25).abs() < 1e-6);
    assert_eq!(last("c.png f.exr"), (ChannelKind::Height, 0.25));
    assert_eq!(
        last("c.png f.exr --encoding linear"),
        (ChannelKind::Height, 0.25)
    );
    let (kind, own) = last("c.png f.exr --encoding auto,linear");
    assert_eq!((kind, own), (ChannelKind::Color, encoded));
    let as_they_stand = "c.png f.exr --kinds auto,color --encoding auto,data";
    assert_eq!(last(as_they_stand), (ChannelKind::Color, 0.25));
    let line = "c.png f.exr --kinds auto,height --encoding auto,linear";
    let said = refused(at, line, 2);
    assert!(said.contains("image 2, of kind height"), "{said}");
}

#[test]
fn weights_are_applied_when_the_file_is_read() {
    let folder = folder();
    let at = folder.path();
    let plain = made(at, "c.png a.png");
    let by_place = made(at, "c.png a.png --weights 1,0.25");
    let by_name = made(at, "c.png a.png --weights height=0.25");
    assert_eq!(by_place, by_name);
    let height = &by_name.channels.list()[1];
    assert_eq!(height.weight, 0.25);
    for (level, of_plain) in plain.levels.iter().enumerate() {
        let numbers = by_name.channel_numbers(level, height).unwrap();
        let (Features::Plain(weighted), Features::Plain(stored)) =
            (&by_name.levels[level].features, &of_plain.features)
        else {
            panic!("vectors expected")
        };
        for ((row, col, _), &number) in numbers.indexed_iter() {
            assert_eq!(number, stored[[row, col, 3]]);
            assert_eq!(weighted[[row, col, 3]], 0.5 * number);
            assert_eq!(weighted[[row, col, 1]], stored[[row, col, 1]]);
        }
    }
    for (weights, expected) in [
        ("1", "for each of 2 images"),
        ("1,1,1", "for each of 2 images"),
        ("1,height=2", "names only"),
        ("0,0", "one above 0"),
        ("color=0,height=0", "one above 0"),
        (
            "depth=2",
            "channel `depth`, which does not exist; expected color, height",
        ),
        ("height=1,height=2", "two for `height`"),
        ("1,-1", "0 to 1e12"),
        ("1,nan", "0 to 1e12"),
    ] {
        let said = refused(at, &format!("c.png a.png --weights {weights}"), 2);
        assert!(said.contains(expected), "{weights}: {said}");
    }
}

#[test]
fn alpha_is_carried() {
    let folder = folder();
    let at = folder.path();
    let space = made(at, "leaf.png a.png --alpha keep --weights alpha=4");
    assert_eq!(
        channels(&space),
        [
            ("color", 0, 3, 1.0, 0.0, 1.0),
            ("alpha", 3, 1, 4.0, 0.0, 1.0),
            ("height", 4, 1, 1.0, 0.0, 1.0),
        ]
    );
    let alpha = space.channel(ChannelKind::Alpha).unwrap();
    let numbers = space.channel_numbers(0, alpha).unwrap();
    assert_eq!((numbers[[5, 3, 0]], numbers[[5, 4, 0]]), (0.0, 1.0));
    // The colour under transparent texels is what the file stores.
    let color = space.channel(ChannelKind::Color).unwrap();
    let numbers = space.channel_numbers(0, color).unwrap();
    assert_eq!(numbers[[5, 0, 0]], 200.0 / 255.0);
    let said = refused(at, "leaf.png", 1);
    assert!(said.contains("32 of 64 texels are not opaque"), "{said}");
    let said = refused(at, "c.png --alpha keep", 2);
    assert!(
        said.contains("every texel of every image is opaque"),
        "{said}"
    );
}

#[test]
fn controls_are_kept_on_every_level_and_told() {
    let folder = folder();
    let at = folder.path();
    let mask = |x: u32, _| Luma([85 * (x / 4) as u8]);
    GrayImage::from_fn(8, 8, mask)
        .save(at.join("m.png"))
        .unwrap();
    let direction = |_, y: u32| Rgb(if y < 4 { [255, 128, 0] } else { [128, 0, 0] });
    RgbImage::from_fn(8, 8, direction)
        .save(at.join("o.png"))
        .unwrap();
    let space = made(
        at,
        "c.png --mask m.png --transition a.png --orientation-map o.png",
    );
    assert_eq!(space.controls.len(), 2);
    for (level, half) in [(0, 4), (1, 2)] {
        let controls = &space.controls[level];
        let mask = controls.mask.as_ref().unwrap();
        assert!(
            mask.indexed_iter()
                .all(|((_, col), &label)| label == u8::from(col >= half))
        );
        let orientation = controls.orientation.as_ref().unwrap();
        assert!((orientation[[0, 1, 0]] - 1.0).abs() < 1e-4);
        assert!((orientation[[half, 1, 1]] + 1.0).abs() < 1e-4);
    }
    let transition = space.controls[0].transition.as_ref().unwrap();
    assert_eq!(transition[[2, 3]], 92.0 / 255.0);
    let output = mesotex(at, "info x.space.npz --json");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        report["controls"],
        json!(["mask", "transition", "orientation"])
    );
    assert_eq!(
        report["channels"],
        json!([{"name": "color", "kind": "color", "first": 0, "count": 3, "weight": 1.0,
                "low": 0.0, "high": 1.0}])
    );
    let said = String::from_utf8(mesotex(at, "info x.space.npz").stdout).unwrap();
    for line in [
        "channel `color`: color, numbers 0 to 2, weight 1, 0 to 1",
        "control `mask`: labels 0, 1",
        "control `transition`: 0 to 0.8509804",
        "control `orientation`: unit vectors (s, t)",
    ] {
        assert!(said.contains(line), "{said}");
    }
}

#[test]
fn controls_that_do_not_fit_are_refused() {
    let folder = folder();
    let at = folder.path();
    GrayImage::new(8, 6).save(at.join("small.png")).unwrap();
    for option in ["--mask", "--transition", "--orientation-map"] {
        let said = refused(at, &format!("c.png {option} small.png"), 1);
        assert!(
            said.contains("small.png: size: 8×6; expected 8×8"),
            "{said}"
        );
        refused(at, &format!("c.png {option} absent.png"), 1);
    }
    let said = refused(at, "c.png --mask a.png", 1);
    assert!(said.contains("a.png: row 0, column 1: grey 30"), "{said}");
    let said = refused(at, "c.png --mask c.png", 1);
    assert!(said.contains("expected a grey image"), "{said}");
    let said = refused(at, "c.png --transition h.exr", 1);
    assert!(
        said.contains("h.exr: transition, row 0, column 0: -2; expected 0 to 1"),
        "{said}"
    );
    let said = refused(at, "c.png --orientation-map a.png", 1);
    assert!(said.contains("a.png: channels: grey"), "{said}");
    RgbImage::from_pixel(8, 8, Rgb([128, 128, 0]))
        .save(at.join("none.png"))
        .unwrap();
    let said = refused(at, "c.png --orientation-map none.png", 1);
    assert!(said.contains("expected a direction"), "{said}");
    // `--orientation` says which way up images are read.
    refused(at, "c.png --orientation none.png", 2);
}

#[test]
fn kinds_that_do_not_fit_are_refused() {
    let folder = folder();
    let at = folder.path();
    for (line, code, expected) in [
        ("c.png a.png --kinds color", 2, "1 for 2 images"),
        (
            "a.png c.png --kinds height,color",
            2,
            "first image is not a colour",
        ),
        ("c.png a.png --kinds color,roughness", 2, "roughness"),
        (
            "c.png c.png --kinds color,height",
            1,
            "c.png: row 0, column 1: red",
        ),
        (
            "c.png a.png --kinds color,normal",
            1,
            "a.png: channels: grey",
        ),
    ] {
        let said = refused(at, line, code);
        assert!(said.contains(expected), "{line}: {said}");
    }
    GrayImage::new(6, 8).save(at.join("small.png")).unwrap();
    let said = refused(at, "c.png small.png", 1);
    assert!(
        said.contains("small.png: size: 6×8; expected 8×8"),
        "{said}"
    );
}
