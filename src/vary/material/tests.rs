//! Materials of a few pixels.

use std::path::Path;

use super::*;
use crate::btf::Direction;
use crate::btf::writer::SampleWriter;

fn directions(angles: &[f64]) -> Vec<Direction> {
    angles
        .iter()
        .map(|&theta| Direction::from_angles(theta, 0.0))
        .collect()
}

/// A sample of 2 × 1 texels whose image i holds `first` + i, and twice that.
fn sample(folder: &Path, name: &str, lights: &[f64], first: f32) -> Sample {
    let path = folder.join(name);
    let description = Description {
        tileable: true,
        ..Description::product(name, [2, 1], directions(&[0.0]), directions(lights))
    };
    let mut writer = SampleWriter::create(&path, description).unwrap();
    for image in 0..lights.len() {
        let value = first + image as f32;
        writer
            .push(&[value, value, value, 2.0 * value, 2.0 * value, 2.0 * value])
            .unwrap();
    }
    writer.finish().unwrap();
    Sample::open(&path).unwrap()
}

#[test]
fn samples_are_blended_direction_by_direction() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name, first| {
        let sample = sample(folder.path(), name, &[0.0, 0.5, 1.0], first);
        Material::of_sample(sample, 2, Progress::silent()).unwrap()
    };
    let materials = [&read("a", 1.0), &read("b", 11.0)];
    materials[0].check_partner(materials[1]).unwrap();
    // The mean, the image from above, and the one farthest from it.
    let first: Vec<f32> = materials[0]
        .images
        .iter()
        .map(|of| of.image.data[0] / PI)
        .collect();
    assert!(
        first
            .iter()
            .zip([2.0, 1.0, 3.0])
            .all(|(a, b)| (a - b).abs() < 1e-6),
        "{first:?}"
    );
    let picks = Picks {
        output: (1, 3),
        texels: vec![vec![0, 1, 0], vec![1, 0, 0]],
        shares: vec![0.0, 1.0, 0.25],
    };
    let of_image = |image| {
        let pixels =
            materials.map(|material| material.sample.as_ref().unwrap().image(image).unwrap());
        picks.sample_image(&pixels)
    };
    let grey = |values: &[f32]| values.iter().step_by(3).copied().collect::<Vec<_>>();
    assert_eq!(grey(&of_image(0)), [1.0, 11.0, 3.5]);
    assert_eq!(grey(&of_image(2)), [3.0, 13.0, 5.5]);
    assert_eq!(picks.images(&materials)[0].image.width, 3);
}

#[test]
fn partners_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name, lights: &[f64]| {
        let sample = sample(folder.path(), name, lights, 1.0);
        Material::of_sample(sample, 1, Progress::silent()).unwrap()
    };
    let own = read("a", &[0.0, 0.5]);
    let said = |other: &Material| own.check_partner(other).unwrap_err().to_string();
    assert!(said(&read("b", &[0.0, 0.6])).contains("the set of the first"));
    assert!(said(&read("c", &[0.0, 0.5, 0.6])).contains("1 views, 3 lights"));
    let image = |width: u32, channels: u32| FloatImage {
        width,
        height: 1,
        channels,
        data: vec![0.5; (width * channels) as usize],
        encoding: Encoding::Srgb,
        precision: Precision::Bits8,
    };
    let plain = Material::of_image(image(2, 3), false);
    assert!(said(&plain).contains("an image and a sample"));
    assert!(said(&Material::of_image(image(3, 3), false)).contains("3×1; expected 2×1"));
    let grey = Material::of_image(image(2, 1), false);
    assert!(
        plain
            .check_partner(&grey)
            .unwrap_err()
            .to_string()
            .contains("1 channels")
    );
    assert_eq!(plain.numbers().dim(), (1, 2, 3));
}
