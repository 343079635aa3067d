//! Fits over lights, arrays and held-out errors as a user meets them.

mod program;

use std::fs;
use std::path::Path;

use mesotex::btf::fits::hsh::Lists;
use mesotex::btf::fits::{Basis, Colors, Fit, fit_sample, hsh, ptm};
use mesotex::btf::{Direction, DirectionSet, Sample};
use mesotex::format::image::{decode_srgb, encode_srgb};
use mesotex::format::npy;
use mesotex::progress::Progress;
use ndarray::Array3;
use program::{refuse, succeed, write_capture};
use serde_json::Value;

/// A sample of one view and 40 lights of coloured, not quite matte texels.
fn write_sample(folder: &Path) -> Sample {
    let lights = DirectionSet::Fibonacci(40).directions().unwrap();
    let numbers = ndarray::Array5::from_shape_fn((1, 40, 6, 9, 3), |(_, light, row, col, c)| {
        let normal = Direction::from_angles(0.05 * col as f64, row as f64);
        let cosine = lights[light].0.dot(normal.0).max(0.0);
        ((0.2 + 0.2 * c as f64) * cosine + 0.2 * cosine.powi(8)) as f32
    });
    npy::write(&folder.join("a.npy"), numbers.view().into_dyn()).unwrap();
    let words = "import a.npy --views rings:0:1 --lights fibonacci:40 --dtype f4 -o a.sample";
    succeed(folder, &words.split(' ').collect::<Vec<_>>());
    Sample::open(&folder.join("a.sample")).unwrap()
}

/// The root mean square of display steps between two samples of the same images.
fn difference(a: &Sample, b: &Sample) -> f64 {
    let (mut error, mut count) = (0.0, 0.0);
    let display = |radiance: f32| 255.0 * encode_srgb(radiance * std::f32::consts::PI);
    for image in 0..a.image_count() {
        let (a, b) = (a.image(image).unwrap(), b.image(image).unwrap());
        for number in 0..a.len() {
            error += f64::from(display(a.get(number)) - display(b.get(number))).powi(2);
            count += 1.0;
        }
    }
    (error / count).sqrt()
}

#[test]
fn a_fitted_file_gives_the_lights_it_was_fitted_to() {
    let folder = tempfile::tempdir().unwrap();
    let sample = write_sample(folder.path());
    let at = |name: &str| folder.path().join(name);
    for (basis, colors) in [
        (Basis::Polynomial, Colors::Lrgb),
        (Basis::Polynomial, Colors::Rgb),
        (Basis::Hemispherical(9), Colors::Rgb),
    ] {
        let fitted = fit_sample(&sample, basis, colors, Progress::silent()).unwrap();
        let file = match basis {
            Basis::Polynomial => ptm::write(&at("b.ptm"), &fitted.fit).map(|()| "b.ptm"),
            Basis::Hemispherical(_) => {
                hsh::write(&at("b.rti"), &fitted.fit, Lists::ScaleOffset).map(|()| "b.rti")
            }
        };
        let words = [
            "import",
            file.unwrap(),
            "--lights",
            "fibonacci:40",
            "--dtype",
            "f4",
        ];
        succeed(folder.path(), &[&words[..], &["-o", "b.sample"]].concat());
        let again = Sample::open(&at("b.sample")).unwrap();
        assert_eq!(again.description().lights, sample.description().lights);
        let found = difference(&sample, &again);
        assert!(
            found < 1.2 * fitted.residual,
            "{basis:?} {colors:?}: {found} {fitted:?}"
        );
    }
}

#[test]
fn export_writes_a_file_and_replaces_only_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let sample = write_sample(folder.path());
    let folder = folder.path();
    let export = ["export", "a.sample", "--to", "ptm", "-o", "a.ptm"];
    for colors in ["lrgb", "rgb"] {
        let words = [&export[..], &["--colors", colors, "--json"]].concat();
        let told: Value = serde_json::from_str(&succeed(folder, &words)).unwrap();
        let lights = [
            "--lights",
            "fibonacci:40",
            "--dtype",
            "f4",
            "-o",
            "b.sample",
        ];
        succeed(folder, &[&["import", "a.ptm"], &lights[..]].concat());
        let again = Sample::open(&folder.join("b.sample")).unwrap();
        let (residual, found) = (
            told["residual"].as_f64().unwrap(),
            difference(&sample, &again),
        );
        assert!(found < 1.2 * residual, "{colors}: {found} {told}");
        assert!(told["stored_residual"].as_f64().unwrap() < 1.1 * residual);
    }
    let other = [
        "export", "a.sample", "--to", "folder", "--colors", "rgb", "-o", "f",
    ];
    assert!(refuse(folder, &other, 2).contains("--colors"));
    let whole = fs::read(folder.join("a.ptm")).unwrap();
    fs::write(folder.join("a.ptm"), &whole[..whole.len() - 8]).unwrap();
    let error = refuse(folder, &export, 2);
    assert!(error.contains("not a PTM of this program"), "{error}");
    let words = "import a.npy --views rings:0:1 --lights fibonacci:40 -o tilted.sample";
    let tilted = words.replace("rings:0:1", "rings:30:1");
    succeed(folder, &tilted.split(' ').collect::<Vec<_>>());
    let words = ["export", "tilted.sample", "--to", "ptm", "-o", "t.ptm"];
    let output = program::mesotex(folder, &words);
    let warned = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.success() && warned.contains("30.0° from directly above"),
        "{warned}"
    );
}

/// Two texels, one above the other, whose sums are known.
fn small_fit() -> Fit {
    Fit {
        width: 1,
        height: 2,
        basis: Basis::Polynomial,
        colors: Colors::Lrgb,
        scale: vec![1.0; 6],
        offset: vec![0.0, 0.0, 0.0, -100.0, -100.0, 0.0],
        coefficients: vec![0, 0, 0, 100, 100, 255, 0, 0, 0, 200, 100, 100],
        texel_colors: vec![255, 128, 0, 255, 255, 255],
        white: 255.0,
    }
}

#[test]
fn values_rows_and_axes_are_those_of_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let (folder, path) = (folder.path(), folder.path().join("a.ptm"));
    ptm::write(&path, &small_fit()).unwrap();
    fs::write(folder.join("two.lp"), "a 0 0 1\nb 0.6 0 0.8\n").unwrap();
    let import = |words: &[&str]| {
        let fixed = [
            "import", "a.ptm", "--lights", "two.lp", "--dtype", "f4", "-o", "a.sample",
        ];
        succeed(folder, &[&fixed[..], words].concat());
        Sample::open(&folder.join("a.sample")).unwrap()
    };
    let sample = import(&[]);
    let near = |found: f32, wanted: f32| assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
    let white = std::f32::consts::FRAC_1_PI;
    let above = sample.image(0).unwrap();
    near(above.get(0), white);
    near(above.get(1), white * decode_srgb(128.0 / 255.0));
    near(above.get(3), white * decode_srgb(100.0 / 255.0));
    // From the right the lower texel is brighter by 0.6 · 100 steps.
    near(
        sample.image(1).unwrap().get(3),
        white * decode_srgb(160.0 / 255.0),
    );
    let linear = import(&["--encoding", "linear", "--values", "radiance"]);
    near(linear.image(1).unwrap().get(3), 160.0 / 255.0);
    let told: Value = serde_json::from_str(&succeed(folder, &["info", "a.ptm", "--json"])).unwrap();
    assert_eq!(
        (&told["terms"], &told["colors"]),
        (&6.into(), &"lrgb".into())
    );
}

#[test]
fn options_without_effect_on_a_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ptm::write(&folder.join("a.ptm"), &small_fit()).unwrap();
    write_capture(&folder.join("capture"));
    let with = |words: &str| {
        let words = format!("import {words} -o x.sample");
        let error = refuse(folder, &words.split(' ').collect::<Vec<_>>(), 2);
        assert!(!folder.join("x.sample").exists());
        error
    };
    assert!(with("a.ptm").contains("--lights: not given"));
    assert!(with("a.ptm --lights 12x5 --views 12x5").contains("--views"));
    assert!(with("a.ptm --lights 12x5 --alpha ignore").contains("--alpha"));
    assert!(with("a.ptm --lights 12x5 --images photos").contains("--images"));
    assert!(with("a.ptm --lights 12x5 --corners c.csv").contains("--corners"));
    assert!(with("capture --lights 12x5").contains("--lights"));
    fs::write(folder.join("cut.ptm"), "PTM_1.2\nPTM_FORMAT_LRGB\n9 9\n").unwrap();
    let cut = refuse(
        folder,
        &["import", "cut.ptm", "--lights", "12x5", "-o", "x.sample"],
        1,
    );
    assert!(cut.contains("cut.ptm: scale 0"), "{cut}");
}

#[test]
fn the_mean_of_a_patch_wraps_as_one_texel() {
    let folder = tempfile::tempdir().unwrap();
    let mean = Array3::from_shape_fn((81, 151, 3), |(v, l, c)| (v + l + c) as f32 * 1e-3);
    npy::write(&folder.path().join("mean.npy"), mean.view().into_dyn()).unwrap();
    let words = [
        "import", "mean.npy", "-o", "x.sample", "--views", "bonn81", "--lights",
    ];
    let with = |lights| [&words[..], &[lights]].concat();
    let error = refuse(folder.path(), &with("bonn81"), 1);
    assert!(
        error.contains("mean.npy: shape") && error.contains("81 lights"),
        "{error}"
    );
    succeed(folder.path(), &with("bonn151"));
    let sample = Sample::open(&folder.path().join("x.sample")).unwrap();
    let description = sample.description();
    assert_eq!(
        (description.views.len(), description.lights.len()),
        (81, 151)
    );
    assert_eq!((description.width, description.height), (1, 1));
}

#[test]
fn info_tells_how_well_directions_predict_each_other() {
    let folder = tempfile::tempdir().unwrap();
    write_sample(folder.path());
    let told = succeed(folder.path(), &["info", "a.sample", "--leave-out"]);
    assert!(told.contains("each left out in turn") && told.contains("  40 lights, continuous: "));
    let json = succeed(
        folder.path(),
        &["info", "a.sample", "--json", "--leave-out", "tenth"],
    );
    let json: Value = serde_json::from_str(&json).unwrap();
    let parts = json["leave_out"]["parts"].as_array().unwrap();
    // One view alone: only lights can be predicted.
    assert!(
        parts
            .iter()
            .all(|part| part["held"] == "lights" && part["directions"] == 4)
    );
    for part in parts {
        let psnr = part["psnr"].as_f64().unwrap();
        assert!((20.0..80.0).contains(&psnr), "{part}");
        assert!(!part["by_angle"].as_array().unwrap().is_empty());
    }
    let error = refuse(folder.path(), &["info", "a.npy", "--leave-out"], 2);
    assert!(error.contains("--leave-out"), "{error}");
}
