//! Estimates against reliefs that are known.

use glam::DVec3;

use crate::btf::DirectionSet;
use crate::btf::bake::brdf::Diffuse;
use crate::btf::bake::material::Material;
use crate::btf::bake::{BakeOptions, Samples, bake};
use crate::btf::heights::photometric::normal;
use crate::btf::heights::{HeightOptions, estimate};
use crate::btf::sample::Sample;
use crate::grid::TexelGrid;
use crate::progress::Progress;

fn set(text: &str) -> DirectionSet {
    text.parse().unwrap()
}

/// Matte values are ρ n·l/π. Of 18, three in shadow, one nearly so and a highlight turn the normal by less than 4°.
#[test]
fn normals_are_found_in_spite_of_shadows_and_highlights() {
    let directions = set("rings:20:6,45:12").directions().unwrap();
    let lights: Vec<DVec3> = directions.iter().map(|light| light.0).collect();
    let wanted = DVec3::new(0.3, -0.2, 1.0).normalize();
    let mut values: Vec<f64> = lights
        .iter()
        .map(|light| 0.2 * wanted.dot(*light))
        .collect();
    assert!(normal(&lights, &values).angle_between(wanted) < 1e-6);
    values[1] = 0.0;
    values[4] = 0.0;
    values[9] = 0.01;
    values[12] = 0.0;
    values[15] = 0.9;
    let found = normal(&lights, &values);
    assert!(found.angle_between(wanted) < 0.065, "{found}");
    assert_eq!(normal(&lights, &[0.0; 18]), DVec3::Z);
}

/// Bumps with a colour that changes from texel to texel.
fn bumps(side: u32, depth: f32) -> Material {
    let texels = (0..side).flat_map(|row| (0..side).map(move |col| (row, col)));
    let turn = |at: u32| std::f32::consts::TAU * at as f32 / side as f32;
    let (mut heights, mut albedo) = (Vec::new(), Vec::new());
    for (row, col) in texels {
        heights.push(depth * ((2.0 * turn(col)).sin() * (2.0 * turn(row)).cos() + turn(row).sin()));
        let mixed = (row * 7919 + col * 104_729) % 251;
        albedo.push(glam::Vec3::splat(0.2 + 0.6 * mixed as f32 / 250.0));
    }
    Material {
        name: "bumps".into(),
        grid: TexelGrid {
            width: side,
            height: side,
            tileable: true,
        },
        texel_mm: None,
        heights,
        albedo,
        roughness: None,
        metallic: None,
        reflectance: 0.0,
        diffuse: Diffuse::Lambert,
    }
}

#[test]
fn heights_of_a_bake_are_found_again() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("bumps.sample");
    let options = BakeOptions {
        views: set("rings:15:6,35:6"),
        lights: set("rings:20:4,45:6"),
        samples: Samples::Fixed(1),
        ..BakeOptions::default()
    };
    bake(&bumps(24, 1.2), &options, &target, Progress::silent()).unwrap();
    let sample = Sample::open(&target).unwrap();
    let wanted = sample.heights().unwrap().unwrap();
    let options = HeightOptions { range: 4.0 };
    let found = estimate(&sample, &options, Progress::silent()).unwrap();
    let agreement = found.agreement;
    assert!(agreement.correlation > 0.85, "{agreement:?}");
    assert!((agreement.scale - 1.0).abs() < 0.4, "{agreement:?}");
    let pairs = found.heights.heights().iter().zip(wanted.heights());
    let squares: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let error = (squares / 576.0).sqrt();
    assert!(
        error < 0.35 * wanted.deviation(),
        "{error} of {}",
        wanted.deviation()
    );
}

#[test]
fn samples_that_show_no_heights_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (views, lights, says) in [
        ("rings:0:1", "rings:30:6", "views"),
        ("rings:30:6", "rings:0:1,30:1", "lights"),
    ] {
        let target = folder.path().join("a.sample");
        let options = BakeOptions {
            views: set(views),
            lights: set(lights),
            samples: Samples::Fixed(1),
            ..BakeOptions::default()
        };
        bake(&bumps(8, 1.0), &options, &target, Progress::silent()).unwrap();
        let sample = Sample::open(&target).unwrap();
        let refused = estimate(&sample, &HeightOptions::default(), Progress::silent());
        let error = refused.unwrap_err().to_string();
        assert!(
            error.contains(says) && error.contains("at least 3"),
            "{error}"
        );
    }
    assert!(HeightOptions { range: f64::NAN }.validate().is_err());
}
