//! Field distortion of stripes.

use super::*;
use crate::format::image::{Encoding, FloatImage, Precision};
use crate::vary::key_values::{ramp, straight_orientation};

/// Upright stripes, 8 columns from one to the next.
fn stripes() -> Material {
    let data = (0..32 * 32).map(|pixel| {
        let angle = f64::from(pixel % 32) * std::f64::consts::TAU / 8.0;
        0.5 + 0.5 * angle.sin() as f32
    });
    let image = FloatImage {
        width: 32,
        height: 32,
        channels: 1,
        data: data.collect(),
        encoding: Encoding::Srgb,
        precision: Precision::Bits8,
    };
    Material::of_image(image, true)
}

fn options() -> DistortionOptions {
    DistortionOptions {
        distortion_levels: 2,
        window: 5,
        ..DistortionOptions::default()
    }
}

fn bright(texels: &[u32], cols: usize) -> Vec<bool> {
    let material = stripes();
    let row = &texels[texels.len() / 2 / cols * cols..][..cols];
    row.iter()
        .map(|&texel| material.images[0].image.data[texel as usize] > 0.5)
        .collect()
}

fn changes(row: &[bool]) -> usize {
    row.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

#[test]
fn stripes_are_twice_as_dense_where_the_scale_is_half() {
    let transition = ramp((24, 80), 0.0, (0.45, 0.55));
    let straight = straight_orientation((24, 80));
    let made = distorted(
        &stripes(),
        (&transition, &straight),
        &options(),
        1,
        Progress::silent(),
    );
    let row = bright(&made.unwrap(), 80);
    let (left, right) = (changes(&row[4..36]), changes(&row[44..76]));
    // 32 columns are 4 stripes, and 8 of half the size.
    assert!((7..=9).contains(&left), "{left}");
    assert!((13..=17).contains(&right), "{right}");
}

#[test]
fn turned_a_quarter_stripes_lie_down() {
    let transition = Array2::from_elem((24, 24), 0.0);
    let up = Array3::from_shape_fn((24, 24, 2), |(_, _, axis)| axis as f32);
    let fields = (&transition, &up);
    let made = distorted(&stripes(), fields, &options(), 1, Progress::silent()).unwrap();
    assert!(changes(&bright(&made, 24)[4..20]) <= 1);
}

#[test]
fn threads_do_not_count_and_sizes_are_checked() {
    let transition = ramp((16, 16), 0.0, (0.0, 1.0));
    let straight = straight_orientation((16, 16));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let fields = (&transition, &straight);
        pool.install(|| distorted(&stripes(), fields, &options(), 3, Progress::silent()).unwrap())
    };
    assert_eq!(with(1), with(2));
    let narrow = straight_orientation((16, 15));
    let fields = (&transition, &narrow);
    assert!(distorted(&stripes(), fields, &options(), 3, Progress::silent()).is_err());
    let wild = DistortionOptions {
        scale_to: 0.0,
        ..options()
    };
    let said = wild.validate().unwrap_err().to_string();
    assert!(said.contains("--scale-to: 0; expected 0.1 to 8"), "{said}");
}
