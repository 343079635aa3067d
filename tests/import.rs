//! `mesotex import` and `info` as a user runs them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use image::{Rgb, RgbImage};

fn mesotex(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    command.args(words).current_dir(folder).output().unwrap()
}

fn refuse(folder: &Path, words: &[&str]) -> String {
    let output = mesotex(folder, words);
    assert_eq!(output.status.code(), Some(1), "{words:?}");
    assert!(!folder.join("x.sample").exists());
    String::from_utf8(output.stderr).unwrap()
}

/// A capture whose image `i` is lit from azimuth 90°·i and bright on that side.
fn capture(folder: &Path) {
    let mut list = String::from("4\n");
    for (index, (x, y)) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]
        .iter()
        .enumerate()
    {
        let name = format!("shot {index}.png");
        let bright = |col: u32, row: u32| {
            let (right, up) = (f64::from(col) - 3.5, 2.5 - f64::from(row));
            if right * x + up * y > 0.0 { 255 } else { 0 }
        };
        let image = RgbImage::from_fn(8, 6, |col, row| Rgb([bright(col, row); 3]));
        image.save(folder.join(&name)).unwrap();
        list += &format!("C:\\old place\\{name} {x} {y} 1\n");
    }
    fs::write(folder.join("dirs.lp"), list).unwrap();
}

#[test]
fn a_capture_keeps_its_sides_and_its_values() {
    let folder = tempfile::tempdir().unwrap();
    capture(folder.path());
    let output = mesotex(
        folder.path(),
        &["import", "dirs.lp", "-o", "x.sample", "--dtype", "f4"],
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let sample = mesotex::btf::Sample::open(&folder.path().join("x.sample")).unwrap();
    assert_eq!((sample.grid().width, sample.grid().height), (8, 6));
    let value = |image: usize, row: usize, col: usize| {
        sample.image(image).unwrap().get((row * 8 + col) * 3)
    };
    let white = std::f32::consts::FRAC_1_PI;
    // Lit from the right: the last column is white, the first black. Lit from above: the top row.
    assert!((value(0, 3, 7) - white).abs() < 1e-6 && value(0, 3, 0) == 0.0);
    assert!((value(1, 0, 3) - white).abs() < 1e-6 && value(1, 5, 3) == 0.0);
    let up = sample.description().lights[1];
    assert!(
        (up.phi().to_degrees() - 90.0).abs() < 1e-9
            && (up.theta().to_degrees() - 45.0).abs() < 1e-9
    );
    let info = mesotex(folder.path(), &["info", "x.sample", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!(
        (report["views"].as_u64(), report["lights"].as_u64()),
        (Some(1), Some(4))
    );
}

#[test]
fn broken_captures_are_refused_by_file() {
    let folder = tempfile::tempdir().unwrap();
    capture(folder.path());
    let import = ["import", "dirs.lp", "-o", "x.sample"];
    let image = folder.path().join("shot 2.png");
    let sound = fs::read(&image).unwrap();
    fs::write(&image, &sound[..sound.len() / 2]).unwrap();
    assert!(refuse(folder.path(), &import).contains("shot 2.png"));
    fs::remove_file(&image).unwrap();
    assert!(refuse(folder.path(), &import).contains("shot 2.png"));
    RgbImage::from_pixel(5, 5, Rgb([9; 3]))
        .save(&image)
        .unwrap();
    let error = refuse(folder.path(), &import);
    assert!(
        error.contains("shot 2.png") && error.contains("5 × 5"),
        "{error}"
    );
    fs::write(folder.path().join("second.csv"), "file\n").unwrap();
    assert!(refuse(folder.path(), &["import", ".", "-o", "x.sample"]).contains("just one"));
}
