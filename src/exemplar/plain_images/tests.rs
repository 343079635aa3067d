//! Tests of plain images: numbers, means, channels, refusals.

use super::*;
use crate::exemplar::controls::ControlKind;
use crate::format::image::Precision;
use ndarray::{Array2, array};

fn image(width: u32, height: u32, channels: u32, encoding: Encoding) -> FloatImage {
    let count = width * height * channels;
    FloatImage {
        width,
        height,
        channels,
        data: (0..count).map(|i| i as f32 / count as f32).collect(),
        encoding,
        precision: Precision::Bits8,
    }
}

fn channel(kind: ChannelKind, weight: f64, image: FloatImage) -> ChannelImage {
    ChannelImage {
        name: kind.name().into(),
        kind,
        weight,
        image,
    }
}

fn color(weight: f64, image: FloatImage) -> ChannelImage {
    channel(ChannelKind::Color, weight, image)
}

fn vectors(space: &Space, level: usize) -> &Array3<f32> {
    match &space.levels[level].features {
        Features::Plain(vectors) => vectors,
        Features::Textons { .. } => panic!("vectors expected"),
    }
}

fn space(images: &[ChannelImage], levels: u32, tile: bool) -> Result<Space> {
    let id = ContentId::of_bytes(b"sample");
    space_of_images(images, Controls::default(), levels, tile, &id)
}

#[test]
fn texels_hold_the_numbers_of_all_images() {
    let images = [
        color(1.0, image(5, 4, 3, Encoding::Srgb)),
        ChannelImage {
            name: "light".into(),
            ..color(4.0, image(5, 4, 1, Encoding::Linear))
        },
    ];
    let space = space(&images, 2, false).unwrap();
    let fine = vectors(&space, 0);
    assert_eq!(fine.dim(), (4, 5, 4));
    assert_eq!(fine[[2, 3, 1]], images[0].image.get(2, 3, 1));
    let stored = encode_srgb(images[1].image.get(2, 3, 0));
    assert_eq!(fine[[2, 3, 3]], 2.0 * stored);
    // The odd last column is averaged alone.
    let coarse = vectors(&space, 1);
    assert_eq!(coarse.dim(), (2, 3, 4));
    let alone = (fine[[0, 4, 2]] + fine[[1, 4, 2]]) / 2.0;
    assert!((coarse[[0, 2, 2]] - alone).abs() < 1e-6);
    let four: f32 = [(2, 2), (2, 3), (3, 2), (3, 3)]
        .iter()
        .map(|&(r, c)| fine[[r, c, 0]])
        .sum();
    assert!((coarse[[1, 1, 0]] - four / 4.0).abs() < 1e-6);
    // Stored numbers are there beside the weighted ones, on every level.
    let light = &space.channels.list()[1];
    assert_eq!((light.first, light.count, light.weight), (3, 1, 4.0));
    assert_eq!(space.channel_numbers(0, light).unwrap()[[2, 3, 0]], stored);
    let coarse_light = space.channel_numbers(1, light).unwrap();
    assert_eq!(2.0 * coarse_light[[1, 2, 0]], coarse[[1, 2, 3]]);
}

#[test]
fn only_colours_are_put_through_the_curve() {
    for kind in ChannelKind::ALL {
        let count = kind.counts()[0];
        let numbers = image(4, 4, count, Encoding::Linear);
        let images = [
            ChannelImage {
                name: "first".into(),
                ..color(1.0, image(4, 4, 3, Encoding::Srgb))
            },
            channel(kind, 1.0, numbers.clone()),
        ];
        let space = space(&images, 1, false).unwrap();
        let stored = vectors(&space, 0)[[2, 1, 3]];
        let plain = numbers.get(2, 1, 0);
        let expected = match kind {
            ChannelKind::Color => encode_srgb(plain),
            _ => plain,
        };
        assert_eq!(stored, expected, "{}", kind.name());
    }
}

#[test]
fn a_weight_of_0_leaves_a_channel_out_of_distances_only() {
    let images = [
        color(1.0, image(4, 4, 3, Encoding::Srgb)),
        channel(ChannelKind::Height, 0.0, image(4, 4, 1, Encoding::Data)),
    ];
    let space = space(&images, 2, true).unwrap();
    assert!(
        vectors(&space, 1)
            .iter()
            .skip(3)
            .step_by(4)
            .all(|&v| v == 0.0)
    );
    let height = space.required_channel(ChannelKind::Height, "it").unwrap();
    let numbers = space.channel_numbers(0, height).unwrap();
    assert_eq!(numbers[[3, 3, 0]], images[1].image.get(3, 3, 0));
}

#[test]
fn controls_come_on_every_level() {
    let images = [color(1.0, image(3, 2, 1, Encoding::Srgb))];
    let controls = Controls {
        mask: Some(array![[1, 2, 3], [2, 1, 0]]),
        ..Controls::default()
    };
    let id = ContentId::of_bytes(b"sample");
    let space = space_of_images(&images, controls, 2, false, &id).unwrap();
    assert_eq!(space.controls[1].mask, Some(array![[1, 3]]));
    let found = space.required_control(1, ControlKind::Mask, "it").unwrap();
    assert!(found.mask.is_some());
    let other = Controls {
        mask: Some(Array2::zeros((3, 3))),
        ..Controls::default()
    };
    let refused = space_of_images(&images, other, 1, false, &id);
    let message = refused.unwrap_err().to_string();
    assert!(
        message.contains("mask") && message.contains("[2, 3]"),
        "{message}"
    );
}

#[test]
fn the_curve_meets_the_stored_numbers() {
    for value in [0.0, 0.002, 0.2, 0.7, 1.0] {
        let linear = crate::format::image::decode_srgb(value);
        assert!((encode_srgb(linear) - value).abs() < 1e-5);
    }
    assert_eq!(encode_srgb(-0.2), -encode_srgb(0.2));
}

#[test]
fn images_that_do_not_fit_are_refused() {
    let (a, b) = (
        image(8, 8, 3, Encoding::Srgb),
        image(8, 6, 1, Encoding::Data),
    );
    let message = |found: Result<Space>| found.unwrap_err().to_string();
    let two = [color(1.0, a.clone()), channel(ChannelKind::Height, 1.0, b)];
    assert!(message(space(&two, 1, false)).contains("image 2: 8×6"));
    for weight in [-1.0, f64::NAN, 1e13] {
        let refused = message(space(&[color(weight, a.clone())], 1, false));
        assert!(refused.contains("channel `color`: weight"), "{refused}");
    }
    let weightless = message(space(&[color(0.0, a.clone())], 1, false));
    assert!(weightless.contains("every weight is 0"), "{weightless}");
    let same = [color(1.0, a.clone()), color(1.0, a.clone())];
    assert!(message(space(&same, 1, false)).contains("two named `color`"));
    assert!(message(space(&two[..1], 5, false)).contains("1 to 4"));
    let twelve = [color(1.0, image(12, 12, 1, Encoding::Srgb))];
    assert!(message(space(&twelve, 4, true)).contains("divisible by 8"));
    let mut nan = a;
    nan.data[5] = f32::NAN;
    assert!(space(&[color(1.0, nan)], 1, false).is_err());
    assert!(space(&[], 1, false).is_err());
}
