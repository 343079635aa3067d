//! Sets that `import` reads again.

use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use crate::btf::direction::Direction;
use crate::btf::direction_set::DirectionSet;
use crate::btf::import::{ImportOptions, ListOptions, SetOptions, assemble, read_source};
use crate::btf::sample::{DType, Description, FORMAT, Layout, VERSION};
use crate::btf::writer::SampleWriter;
use crate::format::id::ContentId;

/// A sample of 6 × 4 texels whose numbers differ in every image and texel.
fn sample(folder: &Path, views: &str, lights: &str, dtype: DType, layout: Layout) -> Sample {
    let set = |text: &str| text.parse::<DirectionSet>().unwrap().directions().unwrap();
    let description = Description {
        format: FORMAT.into(),
        version: VERSION,
        name: "test".into(),
        width: 6,
        height: 4,
        channels: 3,
        dtype,
        texel_mm: None,
        layout,
        views: set(views),
        lights: set(lights),
        pairs: (layout == Layout::Pairs).then(|| vec![[0, 1], [1, 0], [2, 2]]),
        tileable: true,
        id: ContentId::of_bytes(b""),
        source: serde_json::Value::Null,
    };
    let images = description.image_count();
    let path = folder.join("original.sample");
    let mut writer = SampleWriter::create(&path, description).unwrap();
    for image in 0..images {
        let number = |at: usize| ((image * 31 + at * 7) % 97) as f32 / 97.0 * 0.3;
        let numbers: Vec<f32> = (0..72).map(number).collect();
        writer.push(&numbers).unwrap();
    }
    writer.finish().unwrap();
    Sample::open(&path).unwrap()
}

fn import(source: &Path, dtype: DType) -> Sample {
    let list = read_source(&[source], &ListOptions::default(), &SetOptions::default()).unwrap();
    let target = source.with_extension("sample");
    let options = ImportOptions {
        dtype,
        ..ImportOptions::default()
    };
    assemble(&list, &options, target.as_path(), Progress::silent()).unwrap();
    Sample::open(&target).unwrap()
}

fn numbers(sample: &Sample, image: usize) -> Vec<f32> {
    let pixels = sample.image(image).unwrap();
    let mut numbers = vec![0.0; pixels.len()];
    pixels.copy_to(&mut numbers);
    numbers
}

fn same_directions(a: &[Direction], b: &[Direction]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.angle_to(*b) < 1e-9)
}

/// Differences of reflectance in 8-bit sRGB steps: the largest, and the root of the mean square.
fn steps_apart(a: &Sample, b: &Sample) -> [f32; 2] {
    let encoded = |v: f32| crate::format::image::encode_srgb(v * std::f32::consts::PI) * 255.0;
    let (mut most, mut squares, mut count) = (0.0_f32, 0.0, 0.0);
    for image in 0..a.image_count() {
        for (a, b) in numbers(a, image).into_iter().zip(numbers(b, image)) {
            let apart = (encoded(a) - encoded(b)).abs();
            most = most.max(apart);
            squares += apart * apart;
            count += 1.0;
        }
    }
    [most, (squares / count).sqrt()]
}

fn check_directions(a: &Sample, b: &Sample) {
    let (a, b) = (a.description(), b.description());
    assert!(same_directions(&a.views, &b.views) && same_directions(&a.lights, &b.lights));
    assert_eq!((&a.layout, &a.pairs), (&b.layout, &b.pairs));
}

const RINGS: &str = "rings:0:1,15:6";

#[test]
fn ubo2003_comes_back_within_its_quantisation() {
    let folder = tempfile::tempdir().unwrap();
    let original = sample(
        folder.path(),
        RINGS,
        "rings:30:4,75:3",
        DType::F4,
        Layout::Product,
    );
    let out = folder.path().join("set");
    let exported = export_ubo2003(&original, &out).unwrap();
    assert_eq!(
        exported,
        Exported {
            images: 49,
            clipped: 0
        }
    );
    let file = out.join("tv015_pv060/00009 tl030 pl090 tv015 pv060.jpg");
    assert!(file.is_file(), "{}", file.display());
    let found = import(&out, DType::F4);
    check_directions(&original, &found);
    assert_eq!(found.description().source["kind"], "ubo2003");
    let apart = steps_apart(&original, &found);
    // Noise is the hardest picture for JPEG.
    assert!(apart[0] < 8.0 && apart[1] < 1.5, "{apart:?}");
}

#[test]
fn utia_comes_back_within_its_quantisation() {
    let folder = tempfile::tempdir().unwrap();
    let original = sample(
        folder.path(),
        RINGS,
        "rings:30:4",
        DType::F4,
        Layout::Product,
    );
    let out = folder.path().join("set");
    export_utia(&original, &out).unwrap();
    assert!(
        out.join("tv000_pv000/tl030_pl270_tv000_pv000.png")
            .is_file()
    );
    let found = import(&out, DType::F4);
    check_directions(&original, &found);
    assert!(steps_apart(&original, &found)[0] < 0.51);
    let xyz = folder.path().join("xyz");
    export_set(&original, ImageSet::UtiaExr, &xyz, Progress::silent()).unwrap();
    let found = import(&xyz, DType::F4);
    assert_eq!(found.description().source["kind"], "utia");
    for image in 0..found.image_count() {
        for (a, b) in numbers(&original, image)
            .into_iter()
            .zip(numbers(&found, image))
        {
            assert!((a - b).abs() < 1.5e-3, "{a} {b}");
        }
    }
}

#[test]
fn a_folder_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for layout in [Layout::Product, Layout::Pairs] {
        let original = sample(
            folder.path(),
            "fibonacci:3",
            "fibonacci:4",
            DType::F2,
            layout,
        );
        let out = folder.path().join(format!("{layout:?}"));
        export_folder(&original, &out).unwrap();
        let found = import(&out, DType::F2);
        if layout == Layout::Product {
            check_directions(&original, &found);
        }
        for image in 0..original.image_count() {
            let (found, original) = (found.image(image).unwrap(), original.image(image).unwrap());
            assert_eq!(found, original, "{layout:?} {image}");
        }
    }
}

#[test]
fn what_a_set_cannot_hold_is_refused_or_counted() {
    let folder = tempfile::tempdir().unwrap();
    let original = sample(
        folder.path(),
        "fibonacci:3",
        RINGS,
        DType::F4,
        Layout::Product,
    );
    let out = folder.path().join("set");
    let error = export_ubo2003(&original, &out).unwrap_err().to_string();
    assert!(
        error.contains("views: 3 of 3") && error.contains("`folder`"),
        "{error}"
    );
    assert!(!out.exists());
    fs::create_dir(&out).unwrap();
    fs::write(out.join("mine.txt"), "x").unwrap();
    let error = export_folder(&original, &out).unwrap_err().to_string();
    assert!(error.contains("not empty"), "{error}");
    let left: Vec<PathBuf> = fs::read_dir(&out)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    assert_eq!(left.len(), 1);
}
