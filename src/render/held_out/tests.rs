//! Samples whose values between directions are known.

use std::f64::consts::FRAC_1_PI;
use std::path::Path;

use clap::ValueEnum;

use super::*;
use crate::btf::direction::Direction;
use crate::btf::direction_set::DirectionSet;
use crate::btf::sample::{Description, Layout};
use crate::btf::writer::SampleWriter;

/// A sample of 20 × 15 texels whose value is `value(view, light, texel)` times the light's cosine over π.
fn sample(
    folder: &Path,
    pairs: Option<Vec<[u32; 2]>>,
    value: impl Fn(Direction, Direction, usize) -> f64,
) -> Sample {
    let directions = |count| DirectionSet::Fibonacci(count).directions().unwrap();
    let description = Description {
        layout: if pairs.is_some() {
            Layout::Pairs
        } else {
            Layout::Product
        },
        pairs,
        ..Description::product("test", [20, 15], directions(12), directions(30))
    };
    let target = folder.join("x.sample");
    let mut writer = SampleWriter::create(&target, description.clone()).unwrap();
    for image in 0..description.image_count() {
        let (view, light) = description.view_and_light(image);
        let (view, light) = (description.views[view], description.lights[light]);
        let of_texel = |texel| {
            let value = value(view, light, texel) * light.cos_theta() * FRAC_1_PI;
            [value as f32; 3]
        };
        let pixels: Vec<f32> = (0..300).flat_map(of_texel).collect();
        writer.push(&pixels).unwrap();
    }
    writer.finish().unwrap();
    Sample::open(&target).unwrap()
}

#[test]
fn angles_on_a_border_belong_to_what_begins_there() {
    let mut errors = HeldOutErrors::default();
    errors.add(30f64.to_radians(), &ErrorSum::default());
    errors.add(90f64.to_radians(), &ErrorSum::default());
    let bins: Vec<f64> = errors.by_angle().map(|bin| bin.from_deg).collect();
    assert_eq!(bins, [30.0, 75.0]);
}

fn part(report: &HeldOutReport, held: &str, weighting: Weighting) -> HeldOutPart {
    let is_wanted = |part: &&HeldOutPart| part.held == held && part.weighting == weighting;
    report.parts.iter().find(is_wanted).unwrap().clone()
}

#[test]
fn a_matte_sample_is_predicted_and_a_glossy_one_less_well() {
    let folder = tempfile::tempdir().unwrap();
    let matte = sample(folder.path(), None, |_, _, texel| {
        0.3 + 0.001 * texel as f64
    });
    let found = measure(&matte, LeaveOut::Each, 0, Progress::silent()).unwrap();
    assert_eq!(found.texels, (256, 300));
    let continuous = part(&found, "lights", Weighting::Continuous);
    assert_eq!(continuous.directions, (30, 30));
    // Ratios of cosines make Lambert exact, but for lights below all others.
    let highest = continuous.errors.by_angle().next().unwrap();
    assert!(highest.sum.psnr() > 80.0, "{highest:?}");
    let literal = part(&found, "lights", Weighting::InverseAngle);
    assert!(literal.errors.whole().psnr() < continuous.errors.whole().psnr());
    assert!(
        part(&found, "views", Weighting::InverseAngle)
            .errors
            .whole()
            .psnr()
            > 80.0
    );
    let glossy = sample(folder.path(), None, |view, light, _| {
        0.1 + (view.0 + light.0).normalize().z.powi(40)
    });
    let found = measure(&glossy, LeaveOut::Each, 0, Progress::silent()).unwrap();
    let glossy = part(&found, "lights", Weighting::Continuous).errors.whole();
    assert!(
        glossy.psnr() < 40.0 && glossy.relative() > 0.05,
        "{glossy:?}"
    );
}

/// The error of one light that is left out, computed by hand.
#[test]
fn errors_are_those_of_the_blend() {
    let folder = tempfile::tempdir().unwrap();
    let sample = sample(folder.path(), None, |_, light, _| {
        0.2 + 0.7 * light.0.x.abs()
    });
    let found = measure(&sample, LeaveOut::Each, 3, Progress::silent()).unwrap();
    let lights = &sample.description().lights;
    let mut errors = 0.0;
    for (held, light) in lights.iter().enumerate() {
        let others = lights
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != held);
        let mut near: Vec<(f64, Direction)> =
            others.map(|(_, o)| (o.angle_to(*light), *o)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let sum: f64 = near[..4].iter().map(|(angle, _)| 1.0 / angle).sum();
        let value = |d: Direction| (0.2 + 0.7 * d.0.x.abs()) * d.cos_theta();
        let lowest = near.iter().map(|(_, d)| d.cos_theta()).fold(1.0, f64::min);
        let scale = (light.cos_theta() / lowest).min(1.0);
        let blend: f64 = near[..4]
            .iter()
            .map(|(angle, d)| value(*d) / angle / sum)
            .sum();
        errors += (scale * blend - value(*light)).powi(2);
    }
    let whole = part(&found, "lights", Weighting::InverseAngle)
        .errors
        .whole();
    let mean = whole.errors / whole.count as f64;
    assert!(
        (mean - errors / 30.0).abs() < 1e-6,
        "{mean} {}",
        errors / 30.0
    );
}

#[test]
fn a_tenth_is_drawn_by_the_seed() {
    let folder = tempfile::tempdir().unwrap();
    let sample = sample(folder.path(), None, |_, light, texel| {
        0.5 + 0.4 * light.0.y + 0.0001 * texel as f64
    });
    let psnr = |seed| {
        let found = measure(&sample, LeaveOut::Tenth, seed, Progress::silent()).unwrap();
        let part = part(&found, "lights", Weighting::Continuous);
        assert_eq!(part.directions, (3, 30));
        part.errors.whole().psnr()
    };
    assert_eq!(psnr(1), psnr(1));
    assert_ne!(psnr(1), psnr(2));
}

#[test]
fn scattered_pairs_are_left_out_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut pairs: Vec<[u32; 2]> = (0..60).map(|k| [k % 12, k * 7 % 30]).collect();
    // Stands there twice: it would predict itself.
    pairs.push(pairs[4]);
    let sample = sample(folder.path(), Some(pairs), |_, light, _| {
        0.5 + 0.3 * light.0.x
    });
    let found = measure(&sample, LeaveOut::Each, 0, Progress::silent()).unwrap();
    // `quadratic` is not for pairs.
    assert_eq!(found.parts.len(), Weighting::value_variants().len() - 1);
    let continuous = part(&found, "pairs", Weighting::Continuous);
    assert_eq!(continuous.directions, (60, 60));
    let psnr = continuous.errors.whole().psnr();
    assert!((10.0..60.0).contains(&psnr), "{psnr}");
}
