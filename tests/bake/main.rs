//! `mesotex bake`: closed forms, conservation laws, the same bytes however it is run, bad input.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod highlights;
mod refused;

use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::Vec3;
use mesotex::btf::bake::{
    AngularFilter, BakeOptions, Baked, Diffuse, Material, Preset, Samples, bake,
};
use mesotex::btf::{DType, Sample};
use mesotex::error::Error;
use mesotex::grid::TexelGrid;
use mesotex::progress::{Event, Progress};
use rand::Rng;

fn mesotex(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    command.args(words).current_dir(folder).output().unwrap()
}

fn succeed(folder: &Path, words: &[&str]) -> String {
    let output = mesotex(folder, words);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// A white matte material with these heights, in texels.
fn white(side: u32, heights: Vec<f32>) -> Material {
    Material {
        name: "white".into(),
        grid: TexelGrid {
            width: side,
            height: side,
            tileable: true,
        },
        texel_mm: None,
        heights,
        albedo: vec![Vec3::ONE; (side * side) as usize],
        roughness: None,
        metallic: None,
        reflectance: 0.04,
        diffuse: Diffuse::Lambert,
    }
}

fn options(views: &str, lights: &str) -> BakeOptions {
    BakeOptions {
        views: views.parse().unwrap(),
        lights: lights.parse().unwrap(),
        dtype: DType::F4,
        samples: Samples::Fixed(1),
        ..BakeOptions::default()
    }
}

fn baked(material: &Material, options: &BakeOptions) -> (tempfile::TempDir, Sample) {
    let (folder, sample, _) = reported(material, options);
    (folder, sample)
}

/// A sample and what its bake said.
fn reported(material: &Material, options: &BakeOptions) -> (tempfile::TempDir, Sample, Baked) {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    let baked = bake(material, options, &target, Progress::silent()).unwrap();
    let sample = Sample::open(&target).unwrap();
    (folder, sample, baked)
}

/// Σ |difference| / Σ wanted over all images of two samples.
fn relative_error(found: &Sample, wanted: &Sample) -> f64 {
    let (mut off, mut all) = (0.0, 0.0);
    for image in 0..wanted.image_count() {
        let (found, wanted) = (found.image(image).unwrap(), wanted.image(image).unwrap());
        for i in 0..wanted.len() {
            off += f64::from((found.get(i) - wanted.get(i)).abs());
            all += f64::from(wanted.get(i));
        }
    }
    off / all
}

fn mean(sample: &Sample, view: usize, light: usize) -> f64 {
    let image = sample
        .image(view * sample.description().lights.len() + light)
        .unwrap();
    let sum: f64 = (0..image.len()).map(|i| f64::from(image.get(i))).sum();
    sum / image.len() as f64
}

#[test]
fn a_flat_lambertian_plane_is_albedo_cosine_over_pi() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("flat.toml"), "albedo = [0.8, 0.5, 0.1]").unwrap();
    for (dtype, tolerance) in [("f4", 1e-4), ("f2", 5e-4)] {
        let words = [
            "bake",
            "flat.toml",
            "-o",
            "x.sample",
            "--size",
            "8",
            "--dtype",
            dtype,
        ];
        let sets = ["--views", "bonn81", "--lights", "bonn151", "--samples", "1"];
        let words = [&words[..], &sets].concat();
        succeed(folder.path(), &words);
        let sample = Sample::open(&folder.path().join("x.sample")).unwrap();
        for image in 0..sample.image_count() {
            let (_, light) = sample.description().view_and_light(image);
            let cos = sample.description().lights[light].cos_theta();
            for (channel, albedo) in [0.8, 0.5, 0.1].into_iter().enumerate() {
                let wanted = albedo * cos / PI;
                let found = f64::from(sample.image(image).unwrap().get(3 * 17 + channel));
                assert!(
                    (found - wanted).abs() <= tolerance * wanted,
                    "{found} {wanted}"
                );
            }
        }
    }
}

#[test]
fn a_sphere_cap_casts_the_shadow_of_a_sphere() {
    const SIDE: u32 = 96;
    // A cap of height 6 from a sphere of radius 12, on a plane.
    let (radius, cap, centre) = (12.0_f64, 6.0_f64, 48.0_f64);
    let heights = (0..SIDE * SIDE)
        .map(|i| {
            let (x, y) = (f64::from(i % SIDE) - centre, f64::from(i / SIDE) - centre);
            let z = (radius * radius - x * x - y * y).max(0.0).sqrt() - (radius - cap);
            z.max(0.0) as f32
        })
        .collect();
    let lights = "rings:75:1,65:1,55:1";
    let (_folder, sample) = baked(&white(SIDE, heights), &options("rings:0:1", lights));
    for (light, elevation) in [15.0_f64, 25.0, 35.0].into_iter().enumerate() {
        let (sin, cos) = elevation.to_radians().sin_cos();
        // The ray that touches the sphere meets the plane this far from its middle.
        let wanted = (radius - (radius - cap) * cos) / sin;
        let image = sample.image(light).unwrap();
        let dark = |col: u32| image.get(((48 * SIDE + col) * 3) as usize) == 0.0;
        let tip = (0..48).find(|&col| dark(col)).unwrap();
        let found = centre - f64::from(tip);
        assert!(
            (found - wanted).abs() <= 1.0,
            "{elevation}°: {found} {wanted}"
        );
        assert!((tip..40).all(dark) && !(60..SIDE).any(dark));
    }
}

#[test]
fn what_stands_above_the_mean_plane_moves_with_the_view() {
    const SIDE: u32 = 64;
    // A plateau 4 texels over the rest on half of the tile: z = ±2 about the mean.
    let heights = (0..SIDE * SIDE)
        .map(|i| if i % SIDE < SIDE / 2 { 4.0 } else { 0.0 })
        .collect();
    let mut material = white(SIDE, heights);
    let color = |col: u32| 0.2 + 0.6 * col as f32 / SIDE as f32;
    material.albedo = (0..SIDE * SIDE)
        .map(|i| Vec3::splat(color(i % SIDE)))
        .collect();
    // Four samples lie round the texel's centre evenly: their mean is the centre's value.
    let four = BakeOptions {
        samples: Samples::Fixed(4),
        ..options("rings:45:1", "rings:0:1")
    };
    let (_folder, sample) = baked(&material, &four);
    // Seen from +x at 45° (tan = 1): z = 2 is met two texels further towards the viewer.
    let value = |col: u32| {
        sample.image(0).unwrap().get((5 * SIDE + col) as usize * 3) * std::f32::consts::PI
    };
    for (col, wanted) in [(10, color(12)), (20, color(22)), (45, color(43))] {
        assert!(
            (value(col) - wanted).abs() < 1e-5,
            "{col}: {} {wanted}",
            value(col)
        );
    }
}

#[test]
fn a_white_furnace_is_white() {
    const SIDE: u32 = 12;
    let mut random = mesotex::random::stream(1, "furnace", 0, 0);
    let heights = (0..SIDE * SIDE)
        .map(|_| random.gen_range(0.0..1.6))
        .collect();
    let lights = 300;
    let furnace = BakeOptions {
        samples: Samples::Fixed(32),
        bounces: 16,
        ..options("rings:0:1,35:1:20,60:1:200", &format!("fibonacci:{lights}"))
    };
    let (_folder, sample) = baked(&white(SIDE, heights), &furnace);
    for view in 0..3 {
        let sum: f64 = (0..lights).map(|light| mean(&sample, view, light)).sum();
        let total = 2.0 * PI / lights as f64 * sum;
        assert!((total - 1.0).abs() < 0.02, "view {view}: {total}");
    }
}

#[test]
fn view_and_light_may_be_exchanged() {
    let material = Preset::Cobbles.material(32, 3, Progress::silent()).unwrap();
    let directions = "rings:0:1,25:2:10,50:3:40";
    let exchange = BakeOptions {
        samples: Samples::Fixed(16),
        ..options(directions, directions)
    };
    let (_folder, sample) = baked(&material, &exchange);
    let directions = &sample.description().views;
    for a in 0..directions.len() {
        for b in 0..a {
            let forth = mean(&sample, a, b) / directions[b].cos_theta();
            let back = mean(&sample, b, a) / directions[a].cos_theta();
            assert!((forth / back - 1.0).abs() < 0.02, "{a} {b}: {forth} {back}");
        }
    }
}

#[test]
fn the_same_bytes_at_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for samples in ["3", "auto --error 0.5"] {
        let ids = ["1", "2", "8"].map(|threads| id_of_random_bake(folder.path(), samples, threads));
        assert!(ids.iter().all(|id| *id == ids[0]), "{samples}: {ids:?}");
    }
}

fn id_of_random_bake(folder: &Path, samples: &str, threads: &str) -> String {
    let words = format!(
        "bake --preset scales --size 20 -o x.sample --seed 7 --bounces 3 --light-diameter 5 --json \
         --samples {samples} --views fibonacci:5 --lights fibonacci:6 --threads {threads}"
    );
    let words: Vec<&str> = words.split(' ').collect();
    let report: serde_json::Value = serde_json::from_str(&succeed(folder, &words)).unwrap();
    report["id"].as_str().unwrap().to_owned()
}

#[test]
fn an_interrupted_bake_goes_on_to_the_same_bytes() {
    for samples in [Samples::Fixed(1), Samples::Auto] {
        // More lights than `auto` decides by, so that a run of them holds only a part of those.
        let options = BakeOptions {
            bounces: 1,
            samples,
            error: (samples == Samples::Auto).then_some(0.5),
            ..options("fibonacci:5", "fibonacci:17")
        };
        interrupt_and_go_on(&options);
    }
}

fn interrupt_and_go_on(options: &BakeOptions) {
    let material = Preset::Weave.material(16, 1, Progress::silent()).unwrap();
    let (_whole_folder, whole) = baked(&material, options);
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    let (stop, seen) = (AtomicBool::new(false), AtomicUsize::new(0));
    let listener = |event: Event| {
        if matches!(event, Event::Advance(_)) && seen.fetch_add(1, Ordering::Relaxed) == 30 {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let interrupted = bake(
        &material,
        options,
        &target,
        Progress::new(&listener, Some(&stop)),
    );
    assert!(matches!(interrupted, Err(Error::Interrupted)));
    assert!(!target.exists());
    let rest = bake(&material, options, &target, Progress::silent()).unwrap();
    assert!((1..85).contains(&rest.resumed), "{}", rest.resumed);
    assert_eq!(&rest.description, whole.description());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn soft_shadows_have_a_penumbra_and_keep_the_irradiance() {
    const SIDE: u32 = 32;
    let wall = (0..SIDE * SIDE)
        .map(|i| {
            if (8..12).contains(&(i % SIDE)) {
                6.0
            } else {
                0.0
            }
        })
        .collect();
    let material = white(SIDE, wall);
    let distinct = |diameter: f64| {
        let soft = BakeOptions {
            light_diameter: diameter,
            samples: Samples::Fixed(64),
            ..options("rings:0:1", "rings:45:1:180")
        };
        let (_folder, sample) = baked(&material, &soft);
        let value = |col: u32| sample.image(0).unwrap().get((16 * SIDE + col) as usize * 3);
        let lit = 45_f32.to_radians().cos() / std::f32::consts::PI;
        assert!((value(28) - lit).abs() < 0.01 * lit, "{}", value(28));
        (12..28)
            .filter(|&col| value(col) > 0.02 * lit && value(col) < 0.98 * lit)
            .count()
    };
    assert!(distinct(20.0) > distinct(0.0) + 1);
}

#[test]
fn previews_and_surfaces_are_written_beside() {
    let folder = tempfile::tempdir().unwrap();
    let words = [
        "bake", "--preset", "hammered", "--size", "16", "-o", "x.sample",
    ];
    let sets = ["--views", "fibonacci:2", "--lights", "fibonacci:3"];
    let beside = ["--preview", "x.png", "--surface", "x.npz"];
    let text = succeed(folder.path(), &[&words[..], &sets, &beside].concat());
    assert!(
        text.contains("wrote x.png") && text.contains("wrote x.npz"),
        "{text}"
    );
    let picture = image::open(folder.path().join("x.png")).unwrap();
    assert_eq!(picture.width(), 2 * 64 + 4);
    let mut surface = mesotex::format::npz::Reader::open(&folder.path().join("x.npz")).unwrap();
    let heights: ndarray::Array2<f32> = surface.array("heights").unwrap();
    assert!(heights.mean().unwrap().abs() < 1e-5);
    let metallic: ndarray::Array2<f32> = surface.array("metallic").unwrap();
    assert_eq!(metallic[[3, 4]], 1.0);
}

#[test]
fn looking_straight_down_is_like_looking_nearly_so() {
    for preset in [Preset::Bark, Preset::Cobbles] {
        let material = preset.material(48, 3, Progress::silent()).unwrap();
        for samples in [1, 4] {
            let views = BakeOptions {
                samples: Samples::Fixed(samples),
                ..options("rings:0:1,0.2:1", "rings:20:3,50:3")
            };
            let (_folder, sample) = baked(&material, &views);
            let (mut off, mut all) = (0.0, 0.0);
            for light in 0..6 {
                let (straight, tilted) = (
                    sample.image(light).unwrap(),
                    sample.image(6 + light).unwrap(),
                );
                for i in 0..straight.len() {
                    off += f64::from((straight.get(i) - tilted.get(i)).abs());
                    all += f64::from(straight.get(i));
                }
            }
            // With a sample on the vertices of the height field: 12 to 42 %.
            assert!(off / all < 0.02, "{preset:?}, {samples}: {}", off / all);
        }
    }
}

#[test]
fn default_samples_halve_the_error_of_one() {
    let material = Preset::Cobbles.material(32, 3, Progress::silent()).unwrap();
    let bake = |samples| {
        let some = BakeOptions {
            samples,
            ..options("fibonacci:4", "fibonacci:5")
        };
        baked(&material, &some)
    };
    let (_a, truth) = bake(Samples::Fixed(64));
    let (_b, one) = bake(Samples::Fixed(1));
    let (_c, default) = bake(BakeOptions::default().samples);
    let (one, default) = (
        relative_error(&one, &truth),
        relative_error(&default, &truth),
    );
    assert!(default <= 0.5 * one, "{default} {one}");
}

#[test]
fn auto_takes_the_samples_that_an_error_needs() {
    let material = Preset::Cobbles.material(20, 3, Progress::silent()).unwrap();
    let bake = |samples, error| {
        let some = BakeOptions {
            samples,
            error,
            ..options("fibonacci:3", "fibonacci:20")
        };
        reported(&material, &some)
    };
    let (_a, truth, _) = bake(Samples::Fixed(512), None);
    let mut taken = 4.0;
    for wanted in [0.05, 0.02] {
        let (_b, sample, report) = bake(Samples::Auto, Some(wanted));
        let left = relative_error(&sample, &truth);
        assert!(left < wanted, "{left} {wanted}");
        // What is said of the error is measured at a few places.
        let said = report.error_left.unwrap();
        assert!((0.5..2.0).contains(&(said / left)), "{said} {left}");
        assert!(
            report.samples > taken && report.samples < 200.0,
            "{report:?}"
        );
        assert_eq!(report.view_rays as f64, (report.samples * 1200.0).round());
        taken = report.samples;
    }
    let (_c, _, plain) = bake(Samples::Fixed(4), None);
    assert_eq!((plain.error_left, plain.samples), (None, 4.0));
}
