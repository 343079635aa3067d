//! Photographs of a patch, and near cameras and lamps, as a user imports them.

mod program;

use std::fs;
use std::path::Path;

use image::{Rgb, RgbImage};
use mesotex::btf::{Layout, Sample};
use mesotex::format::image::decode_srgb;
use program::{refuse, succeed};
use serde_json::Value;

/// A picture with a patch of 6 × 4 pixels at (left, top), whose pixel (column, row) is 40 · column + 30 · row + `shift`.
fn photograph(path: &Path, size: (u32, u32), (left, top): (u32, u32), shift: u8) {
    let pixel = |x: u32, y: u32| {
        let (column, row) = (x.wrapping_sub(left), y.wrapping_sub(top));
        match column < 6 && row < 4 {
            true => Rgb([(20 * column + 30 * row) as u8 + shift, 100, 7]),
            false => Rgb([255, 0, 255]),
        }
    };
    RgbImage::from_fn(size.0, size.1, pixel).save(path).unwrap();
}

/// Two photographs of different sizes, the second turned by 180°.
fn photographs(folder: &Path) {
    photograph(&folder.join("a.png"), (20, 12), (5, 3), 0);
    photograph(&folder.join("b.png"), (13, 17), (2, 9), 50);
    fs::write(
        folder.join("corners.csv"),
        "file,x1,y1,x2,y2,x3,y3,x4,y4\na.png,5,3,11,3,11,7,5,7\nb.png,8,13,2,13,2,9,8,9\n",
    )
    .unwrap();
    let angles = "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\na.png,10,0,30,0\nb.png,20,0,30,90\n";
    fs::write(folder.join("angles.csv"), angles).unwrap();
    let flash = "file,view_theta_deg,view_phi_deg\na.png,10,0\nb.png,20,0\n";
    fs::write(folder.join("flash.csv"), flash).unwrap();
}

fn import(folder: &Path, words: &str) -> Sample {
    let words = format!("import {words} --dtype f4 -o x.sample");
    succeed(folder, &words.split(' ').collect::<Vec<_>>());
    Sample::open(&folder.join("x.sample")).unwrap()
}

fn near(found: f32, byte: u8) {
    let wanted = decode_srgb(f32::from(byte) / 255.0) * std::f32::consts::FRAC_1_PI;
    assert!((found - wanted).abs() < 1e-5, "{found} {wanted}");
}

#[test]
fn patches_are_cut_out_and_turned_upright() {
    let folder = tempfile::tempdir().unwrap();
    photographs(folder.path());
    let sample = import(folder.path(), "angles.csv --corners corners.csv");
    assert_eq!((sample.grid().width, sample.grid().height), (6, 4));
    let (a, b) = (sample.image(0).unwrap(), sample.image(1).unwrap());
    for (row, column) in [(0, 0), (1, 4), (3, 5)] {
        let texel = (row * 6 + column) * 3;
        near(a.get(texel), (20 * column + 30 * row) as u8);
        near(
            b.get(texel),
            (20 * (5 - column) + 30 * (3 - row) + 50) as u8,
        );
        near(a.get(texel + 1), 100);
    }
    let halved = import(folder.path(), "angles.csv --corners corners.csv --size 3x2");
    assert_eq!((halved.grid().width, halved.grid().height), (3, 2));
    near(halved.image(0).unwrap().get(1), 100);
    let cropped = import(
        folder.path(),
        "angles.csv --corners corners.csv --crop 2x1+4+3",
    );
    near(cropped.image(0).unwrap().get(3), 190);
}

#[test]
fn a_flash_at_the_camera_makes_pairs() {
    let folder = tempfile::tempdir().unwrap();
    photographs(folder.path());
    let sample = import(
        folder.path(),
        "flash.csv --collocated --corners corners.csv",
    );
    let description = sample.description();
    assert_eq!(description.layout, Layout::Pairs);
    assert_eq!(description.views, description.lights);
    let words = [
        "import",
        "angles.csv",
        "--collocated",
        "--corners",
        "corners.csv",
        "-o",
        "y.sample",
    ];
    assert!(refuse(folder.path(), &words, 1).contains("light_theta_deg"));
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    photographs(folder.path());
    let with = |words: &str, code| {
        let words = format!("import angles.csv {words} -o y.sample");
        let error = refuse(folder.path(), &words.split(' ').collect::<Vec<_>>(), code);
        assert!(!folder.path().join("y.sample").exists());
        error
    };
    assert!(with("--size 8", 2).contains("--corners"));
    assert!(with("--corners corners.csv --focal 9", 2).contains("--distortion"));
    assert!(with("--corners none.csv", 1).contains("none.csv"));
    let one = "file,x1,y1,x2,y2,x3,y3,x4,y4\na.png,5,3,11,3,11,7,5,7\n";
    fs::write(folder.path().join("one.csv"), one).unwrap();
    assert!(with("--corners one.csv", 1).contains("1 of 2 photographs: b.png"));
    let far = one.to_owned() + "b.png,8,13,2,13,2,9,80,9\n";
    fs::write(folder.path().join("far.csv"), far).unwrap();
    let error = with("--corners far.csv", 1);
    assert!(
        error.contains("b.png: corner 4: (80, 9)") && error.contains("13 × 17"),
        "{error}"
    );
}

/// A matte white patch of 80 × 60 mm under 40 lamps 300 mm away, the camera far above.
fn near_lamps(folder: &Path) {
    let mut table =
        String::from("file,view_theta_deg,view_phi_deg,light_x_mm,light_y_mm,light_z_mm\n");
    for lamp in 0..40u32 {
        let cosine = 1.0 - 0.7 * (f64::from(lamp) + 0.5) / 40.0;
        let sine = (1.0 - cosine * cosine).sqrt();
        let phi = 2.399_963 * f64::from(lamp);
        let at = [sine * phi.cos(), sine * phi.sin(), cosine].map(|part| 300.0 * part);
        table += &format!("{lamp}.png,0,0,{},{},{}\n", at[0], at[1], at[2]);
        let pixel = |x: u32, y: u32| {
            let point = [f64::from(x) * 10.0 - 35.0, 25.0 - f64::from(y) * 10.0, 0.0];
            let way = [0, 1, 2].map(|axis| at[axis] - point[axis]);
            let square: f64 = way.iter().map(|part| part * part).sum();
            // A lamp that is as bright as one far away at the patch's centre.
            let value = 0.6 * way[2] / square.sqrt() * 90_000.0 / square;
            let byte = mesotex::format::image::encode_srgb8(value as f32);
            Rgb([byte; 3])
        };
        RgbImage::from_fn(8, 6, pixel)
            .save(folder.join(format!("{lamp}.png")))
            .unwrap();
    }
    fs::write(folder.join("lamps.csv"), table).unwrap();
}

/// The largest relative difference of any texel from a matte patch under distant lamps.
fn unevenness(sample: &Sample) -> f32 {
    let mut largest = 0.0f32;
    for (image, light) in sample.description().lights.iter().enumerate() {
        let wanted = 0.6 * light.cos_theta() as f32 * std::f32::consts::FRAC_1_PI;
        let pixels = sample.image(image).unwrap();
        for number in 0..pixels.len() {
            largest = largest.max((pixels.get(number) / wanted - 1.0).abs());
        }
    }
    largest
}

#[test]
fn near_lamps_are_resampled_to_distant_ones() {
    let folder = tempfile::tempdir().unwrap();
    near_lamps(folder.path());
    let plain = import(folder.path(), "lamps.csv --patch-mm 80x60");
    assert!(unevenness(&plain) > 0.2, "{}", unevenness(&plain));
    let resampled = import(folder.path(), "lamps.csv --patch-mm 80x60 --near-field");
    assert!(unevenness(&resampled) < 0.04, "{}", unevenness(&resampled));
    assert_eq!(resampled.description().lights, plain.description().lights);
    assert_eq!(
        resampled.description().source["resampled"],
        Value::from("near field")
    );
    // Within a wide limit nothing changes.
    let kept = import(folder.path(), "lamps.csv --patch-mm 80x60 --near-field 30");
    assert_eq!(kept.id(), plain.id());
    let refused = |words: &str| {
        let words = format!("import lamps.csv {words} -o y.sample");
        refuse(folder.path(), &words.split(' ').collect::<Vec<_>>(), 2)
    };
    assert!(refused("--near-field").contains("--patch-mm"));
    assert!(refused("--near-field --patch-mm 80x60 --crop 2x2+0+0").contains("--crop"));
}
