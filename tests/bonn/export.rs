//! Samples go out as `.btf` files and come back.

use std::path::Path;

use mesotex::btf::bonn::{Color, ColorModel};
use mesotex::btf::{DType, Description, HeightMap, Layout, Sample, SampleWriter};
use mesotex::format::ContentId;
use serde_json::Value;

use crate::files::{Dfmf, directions};
use crate::program::{refuse, succeed};
use crate::variants;

const SIDE: usize = 6;

/// Smooth values of rank 3 per channel, so that few components hold them.
fn value(view: usize, light: usize, texel: usize, channel: usize) -> f32 {
    let (row, column) = (texel / SIDE, texel % SIDE);
    let wave = |a: usize, b: usize| ((a * b) as f32 * 0.37).sin();
    0.3 + 0.05 * wave(view + 1, light + channel) * wave(row, column + 1)
        + 0.02 * channel as f32 * wave(light + 2, view + 3) * wave(column, 2)
}

/// A sample of 7 × 5 directions and 6 × 6 texels.
fn write_sample(path: &Path) {
    let description = Description {
        format: "mesotex-btf".into(),
        version: 1,
        name: "waves".into(),
        width: SIDE as u32,
        height: SIDE as u32,
        channels: 3,
        dtype: DType::F4,
        texel_mm: Some(0.25),
        layout: Layout::Product,
        views: directions("rings:0:1,40:6"),
        lights: directions("rings:10:5:15"),
        pairs: None,
        tileable: false,
        id: ContentId::of_bytes(b""),
        source: Value::Null,
    };
    let mut writer = SampleWriter::create(path, description).unwrap();
    for image in 0..35 {
        let numbers = (0..SIDE * SIDE * 3).map(|at| value(image / 5, image % 5, at / 3, at % 3));
        writer.push(&numbers.collect::<Vec<f32>>()).unwrap();
    }
    writer.finish().unwrap();
}

/// The largest difference, and ‖a − b‖ / ‖a‖.
fn differences(a: &Path, b: &Path) -> (f32, f64) {
    let (a, b) = (Sample::open(a).unwrap(), Sample::open(b).unwrap());
    let angles = |sample: &Sample| {
        let description = sample.description();
        [description.views.clone(), description.lights.clone()].concat()
    };
    for (a, b) in angles(&a).iter().zip(angles(&b)) {
        assert!(a.angle_to(b) < 1e-6);
    }
    let texel = b.description().texel_mm.unwrap();
    assert!((texel - 0.25).abs() < 1e-9);
    let image = |sample: &Sample, at| {
        let pixels = sample.image(at).unwrap();
        (0..pixels.len())
            .map(|at| pixels.get(at))
            .collect::<Vec<f32>>()
    };
    let (mut largest, mut left, mut all) = (0.0_f32, 0.0, 0.0);
    for at in 0..a.image_count() {
        for (a, b) in image(&a, at).into_iter().zip(image(&b, at)) {
            largest = largest.max((a - b).abs());
            left += f64::from(a - b).powi(2);
            all += f64::from(a).powi(2);
        }
    }
    (largest, (left / all).sqrt())
}

/// Exports and imports; the largest difference, the relative error, and the report of the export.
fn there_and_back(words: &[&str]) -> (f32, f64, Value) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write_sample(&at("a.sample"));
    let export = [&["export", "a.sample", "-o", "a.btf", "--json"], words].concat();
    let exported = succeed(folder.path(), &export);
    let import = [
        "import", "a.btf", "-o", "b.sample", "--dtype", "f4", "--json",
    ];
    succeed(folder.path(), &import);
    let info = succeed(folder.path(), &["info", "a.btf", "--json"]);
    let json = |text: &str| serde_json::from_str::<Value>(text).unwrap();
    assert_eq!(json(&info)["format"], json(&exported)["format"]);
    let (largest, relative) = differences(&at("a.sample"), &at("b.sample"));
    (largest, relative, json(&exported))
}

#[test]
fn bdi_holds_every_number_as_a_half() {
    let (difference, _, report) = there_and_back(&["--to", "bdi"]);
    // Half an ulp of a half at 1.3 over π.
    assert!(
        difference <= 0.000_49 / std::f32::consts::PI,
        "{difference}"
    );
    assert_eq!(report["rank"], Value::Null);
}

#[test]
fn factors_of_enough_rank_hold_every_number() {
    for to in ["dfmf", "fmf", "pvf"] {
        let rank = if to == "fmf" { "20" } else { "12" };
        let words = ["--to", to, "--rank", rank, "--scalar", "f4"];
        let (difference, _, report) = there_and_back(&words);
        assert!(difference < 1e-5, "{to}: {difference}");
        assert!(report["error"].as_f64().unwrap() < 1e-5, "{to}: {report}");
        let (difference, ..) = there_and_back(&words[..4]);
        assert!(difference < 2e-3, "{to} of halves: {difference}");
    }
}

#[test]
fn too_few_components_leave_the_error_that_is_told() {
    for to in ["dfmf", "fmf", "pvf"] {
        let (_, left, report) = there_and_back(&["--to", to, "--rank", "1", "--scalar", "f4"]);
        let error = report["error"].as_f64().unwrap();
        assert!(error > 1e-4 && error < 0.2, "{to}: {error}");
        assert!(
            (error - left).abs() < 1e-6,
            "{to}: {error} told, {left} found"
        );
    }
}

#[test]
fn a_factored_sample_goes_out_and_comes_back_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let run = |words: &[&str]| succeed(folder.path(), words);
    write_sample(&folder.path().join("a.sample"));
    run(&[
        "export", "a.sample", "--to", "dfmf", "--rank", "4", "-o", "a.btf",
    ]);
    run(&["import", "a.btf", "-o", "b.sample"]);
    run(&["export", "b.sample", "--to", "dfmf", "-o", "b.btf"]);
    run(&["import", "b.btf", "-o", "c.sample"]);
    let id = |name: &str| {
        Sample::open(&folder.path().join(name))
            .unwrap()
            .id()
            .to_string()
    };
    assert_eq!(id("b.sample"), id("c.sample"));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("a.btf"), bytes("b.btf"));
}

/// A colour step with a mean, as a PCA file leaves it, goes into every format.
#[test]
fn a_factored_sample_with_a_colour_step_goes_out_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let run = |words: &[&str]| succeed(folder.path(), words);
    let at = |name: &str| folder.path().join(name);
    let file = Dfmf {
        color: variants::pca(),
        ..Dfmf::default()
    };
    std::fs::write(at("pca.btf"), file.bytes()).unwrap();
    run(&["import", "pca.btf", "-o", "a.sample", "--dtype", "f4"]);
    for to in ["dfmf", "fmf", "pvf", "bdi"] {
        let mut export = vec!["export", "a.sample", "-o", "a.btf", "--to", to, "--json"];
        if to != "bdi" {
            export.extend(["--scalar", "f4"]);
        }
        if to == "pvf" {
            export.extend(["--rank", "12"]);
        }
        let report: Value = serde_json::from_str(&run(&export)).unwrap();
        if ["dfmf", "fmf"].contains(&to) {
            assert_eq!(report["error"], Value::Null, "{to}: nothing is left out");
        }
        run(&["import", "a.btf", "-o", "b.sample", "--dtype", "f4"]);
        let (largest, relative) = differences(&at("a.sample"), &at("b.sample"));
        let most = if to == "bdi" { 1e-3 } else { 1e-5 };
        assert!(
            largest < most && f64::from(most) > relative,
            "{to}: {largest} {relative}"
        );
    }
}

#[test]
fn the_table_of_the_dome_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dome.sample");
    let dome = directions("bonn151");
    let description = Description {
        width: 1,
        height: 1,
        views: dome.clone(),
        lights: dome.clone(),
        ..small_description()
    };
    let mut writer = SampleWriter::create(&path, description).unwrap();
    (0..dome.len().pow(2)).for_each(|_| writer.push(&[0.1; 3]).unwrap());
    writer.finish().unwrap();
    let run = |words: &[&str]| succeed(folder.path(), words);
    run(&["export", "dome.sample", "--to", "bdi", "-o", "dome.btf"]);
    run(&["import", "dome.btf", "-o", "back.sample"]);
    let back = Sample::open(&folder.path().join("back.sample")).unwrap();
    for set in [&back.description().views, &back.description().lights] {
        assert_eq!(set.len(), 151);
        let farthest = set.iter().zip(&dome).map(|(a, b)| a.angle_to(*b));
        assert!(farthest.fold(0.0, f64::max) < 1e-6);
    }
}

/// Millimetres in the file, halves of them; left out where a texel's size is not known, or the format has no place.
#[test]
fn heights_go_out_in_fmf_files_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sample");
    write_sample(&path);
    let grid = Sample::open(&path).unwrap().grid();
    let heights: Vec<f32> = (0..36).map(|at| at as f32 - 17.5).collect();
    let map = HeightMap::new(grid, heights).unwrap();
    map.write(&path).unwrap();
    let run = |words: &[&str]| succeed(folder.path(), words);
    let said = run(&[
        "export", "a.sample", "--to", "fmf", "--rank", "4", "-o", "a.btf",
    ]);
    assert!(!said.contains("left out"), "{said}");
    run(&["import", "a.btf", "-o", "b.sample"]);
    let back = Sample::open(&folder.path().join("b.sample")).unwrap();
    assert_eq!(back.heights().unwrap(), Some(map));
    let said = run(&[
        "export", "a.sample", "--to", "pvf", "--rank", "4", "-o", "b.btf",
    ]);
    assert!(said.contains("heights are left out"), "{said}");
}

fn small_description() -> Description {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sample");
    write_sample(&path);
    Sample::open(&path).unwrap().description().clone()
}

#[test]
fn what_cannot_be_exported_is_refused_with_words() {
    let folder = tempfile::tempdir().unwrap();
    write_sample(&folder.path().join("a.sample"));
    let refused = |words: &[&str], code| {
        let words = [&["export", "a.sample", "-o", "a.btf"], words].concat();
        let error = refuse(folder.path(), &words, code);
        assert!(!folder.path().join("a.btf").exists());
        error
    };
    assert!(refused(&["--to", "dfmf"], 2).contains("--rank"));
    assert!(refused(&["--to", "dfmf", "--rank", "0"], 2).contains("at least 1"));
    assert!(refused(&["--to", "bdi", "--scalar", "f4"], 2).contains("--scalar"));
    assert!(refused(&["--to", "fmf", "--rank", "99"], 2).contains("--rank"));
    assert!(refused(&["--to", "folder", "--rank", "9"], 2).contains("--rank"));
    std::fs::write(folder.path().join("mine.btf"), "!DFMF08FCR of others").unwrap();
    let words = ["export", "a.sample", "--to", "bdi", "-o", "mine.btf"];
    assert!(refuse(folder.path(), &words, 2).contains("not a .btf file of this program"));
}

#[test]
fn options_that_do_not_concern_a_file_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.btf"), Dfmf::default().bytes()).unwrap();
    let refused = |words: &[&str]| {
        let words = [&["import", "a.btf", "-o", "x.sample"], words].concat();
        refuse(folder.path(), &words, 2)
    };
    assert!(refused(&["--encoding", "srgb"]).contains("--encoding"));
    assert!(refused(&["--layer", "x"]).contains("--layer"));
    assert!(refused(&["--images", "."]).contains("--images"));
    assert!(refused(&["--crop", "2x2+4+0"]).contains("--crop"));
    assert!(refused(&["--downsample", "2"]).contains("--downsample"));
    assert!(refused(&["--pattern", "{tl}"]).contains("--pattern"));
    assert!(refused(&["--rank", "2"]).contains("--rank"));
    assert!(refused(&["--rank", "2", "--expand"]).contains("--expand"));
}

/// A logarithmic file, multiplied out and factored anew.
#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let folder = tempfile::tempdir().unwrap();
    let file = Dfmf {
        color: Color::of(ColorModel::LogYRatios),
        ..Dfmf::default()
    };
    std::fs::write(folder.path().join("a.btf"), file.bytes()).unwrap();
    let id = |threads: &str, more: &[&str]| {
        let words = [
            "import",
            "a.btf",
            "-o",
            "a.sample",
            "--json",
            "--threads",
            threads,
        ];
        let report = succeed(folder.path(), &[&words[..], more].concat());
        serde_json::from_str::<Value>(&report).unwrap()["id"].clone()
    };
    for more in [&[][..], &["--expand"], &["--rank", "2"]] {
        assert_eq!(id("1", more), id("3", more), "{more:?}");
    }
}

#[test]
fn what_is_said_of_the_values_goes_before_the_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.btf"), Dfmf::default().bytes()).unwrap();
    let value = |values: &str| {
        let words = [
            "import", "a.btf", "-o", "x.sample", "--dtype", "f4", "--values", values,
        ];
        succeed(folder.path(), &words);
        let sample = Sample::open(&folder.path().join("x.sample")).unwrap();
        sample.image(0).unwrap().get(0)
    };
    let (auto, radiance) = (value("auto"), value("radiance"));
    assert!((radiance / auto - std::f32::consts::PI).abs() < 1e-5);
    assert_eq!(value("reflectance"), auto);
    let cosine = 20_f32.to_radians().cos();
    assert!((value("no-cosine") / auto - cosine).abs() < 1e-5);
}

#[test]
fn repeated_and_differing_directions_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut header = crate::files::header();
    header.sampling.lights[3] = header.sampling.lights[1];
    let file = Dfmf {
        header,
        ..Dfmf::default()
    };
    let mut bytes = file.bytes();
    // The azimuth of the last light of the last view.
    let lights = bytes.len() - crate::files::channels_length() - 56 - 4 - 8 - 4;
    bytes[lights..lights + 4].copy_from_slice(&1.0_f32.to_le_bytes());
    std::fs::write(folder.path().join("a.btf"), bytes).unwrap();
    let report = succeed(folder.path(), &["info", "a.btf", "--json"]);
    let notes = serde_json::from_str::<Value>(&report).unwrap()["notes"].to_string();
    assert!(notes.contains("light 3 repeats"), "{notes}");
    assert!(notes.contains("lights of view 2 differ"), "{notes}");
}

#[test]
fn handedness_turns_the_y_axis() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.btf"), Dfmf::default().bytes()).unwrap();
    let words = [
        "import",
        "a.btf",
        "-o",
        "x.sample",
        "--handedness",
        "left",
        "--values",
        "radiance",
    ];
    succeed(folder.path(), &words);
    let sample = Sample::open(&folder.path().join("x.sample")).unwrap();
    let phi = sample.description().lights[1].phi().to_degrees();
    assert!((phi - 270.0).abs() < 1e-4, "{phi}");
}
