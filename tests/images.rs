//! Images as users have them, through the commands that read them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use image::{Rgba, RgbaImage};

fn mesotex(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    let words = line.split_whitespace();
    command.args(words).current_dir(folder).output().unwrap()
}

fn done(folder: &Path, line: &str) -> Output {
    let output = mesotex(folder, line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {said}");
    output
}

fn refused(folder: &Path, line: &str, code: i32) -> String {
    let output = mesotex(folder, line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{line}: {said}");
    said
}

fn info(folder: &Path, file: &str) -> serde_json::Value {
    let output = done(folder, &format!("info {file} --json"));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Half of `half.png` is transparent with magenta under it; `angles.csv` lists it.
fn half_transparent() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let image = RgbaImage::from_fn(8, 8, |col, _| match col < 4 {
        true => Rgba([255, 0, 255, 0]),
        false => Rgba([188, 188, 188, 255]),
    });
    image.save(folder.path().join("half.png")).unwrap();
    list(folder.path(), "half.png");
    folder
}

fn list(folder: &Path, file: &str) {
    let table = format!(
        "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\n{file},0,0,20,0\n"
    );
    fs::write(folder.join("angles.csv"), table).unwrap();
}

#[test]
fn hidden_colours_reach_no_sample_in_silence() {
    let folder = half_transparent();
    let at = folder.path();
    for line in [
        "import angles.csv -o x.sample",
        "exemplar half.png -o x --levels 1 --k 2",
    ] {
        let said = refused(at, line, 1);
        assert!(said.contains("32 of 64 texels are not opaque"), "{said}");
        assert!(
            said.contains("--alpha ignore") && !at.join("x.sample").exists(),
            "{said}"
        );
        let output = done(at, &format!("{line} --alpha ignore"));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains("taken as stored"), "{said}");
        fs::remove_dir_all(at.join("x.sample")).unwrap();
    }
    fs::write(at.join("m.toml"), "albedo = 'half.png'").unwrap();
    let bake = "bake m.toml -o b.sample --views 12x5 --lights 12x5 --size 8";
    assert!(refused(at, bake, 1).contains("not opaque"));
    let report = info(at, "half.png");
    assert_eq!(report["alpha"]["transparent"], 32);
    assert_eq!(report["alpha"]["invisible"], 32);
}

#[test]
fn the_command_decides_over_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    image::GrayImage::from_pixel(4, 4, image::Luma([188]))
        .save(at.join("a.png"))
        .unwrap();
    list(at, "a.png");
    let value = |options: &str| {
        done(
            at,
            &format!("import angles.csv -o x.sample --values radiance --dtype f4 {options}"),
        );
        let sample = mesotex::btf::Sample::open(&at.join("x.sample")).unwrap();
        sample.image(0).unwrap().get(0)
    };
    assert!((value("") - 0.502_886).abs() < 1e-5);
    assert_eq!(value("--encoding linear"), 188.0 / 255.0);
    let said = refused(at, "import angles.csv -o y.sample --layer diffuse", 2);
    assert!(said.contains("no file has layers"), "{said}");
    assert!(!at.join("y.sample").exists());
    let said = refused(at, "exemplar a.png -o x --encoding data", 2);
    assert!(said.contains("first image"), "{said}");
    let said = refused(at, "exemplar a.png a.png -o x --encoding auto,data,auto", 2);
    assert!(said.contains("3 for 2 images"), "{said}");
}

/// Grey images after the first are data: no curve is put on a float height.
#[test]
fn heights_of_an_exemplar_are_used_as_they_stand() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    image::RgbImage::from_fn(8, 8, |x, y| image::Rgb([x as u8 * 9, y as u8 * 9, 5]))
        .save(at.join("color.png"))
        .unwrap();
    let height = exr::prelude::SpecificChannels::new(
        (exr::prelude::ChannelDescription::named(
            "Z",
            exr::prelude::SampleType::F32,
        ),),
        |_: exr::prelude::Vec2<usize>| (0.25_f32,),
    );
    let image = exr::prelude::Image::from_channels((8, 8), height);
    exr::prelude::WritableImage::write(&image)
        .to_file(at.join("height.exr"))
        .unwrap();
    done(at, "exemplar color.png height.exr -o x --levels 1 --k 2");
    let space = mesotex::exemplar::Space::read(&at.join("x.space.npz")).unwrap();
    let mesotex::exemplar::Features::Plain(vectors) = &space.levels[0].features else {
        panic!("vectors expected")
    };
    assert_eq!(vectors[[3, 3, 3]], 0.25);
    // Depth is no colour.
    let said = refused(at, "exemplar height.exr -o y --levels 1 --k 2", 1);
    assert!(
        said.contains("part 1: Z") && said.contains("--layer"),
        "{said}"
    );
    assert!(info(at, "height.exr")["refused"].is_string());
}

#[test]
fn subsampled_channels_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let grey = exr::prelude::SpecificChannels::new(
        (exr::prelude::ChannelDescription::named(
            "Y",
            exr::prelude::SampleType::F32,
        ),),
        |_: exr::prelude::Vec2<usize>| (0.25_f32,),
    );
    let image = exr::prelude::Image::from_channels((4, 4), grey);
    exr::prelude::WritableImage::write(&image)
        .to_file(at.join("y.exr"))
        .unwrap();
    let mut bytes = fs::read(at.join("y.exr")).unwrap();
    let entry = b"Y\0\x02\0\0\0";
    let place = bytes.windows(entry.len()).position(|w| w == entry).unwrap();
    bytes[place + 10] = 2;
    bytes[place + 14] = 2;
    fs::write(at.join("y.exr"), bytes).unwrap();
    let said = refused(at, "exemplar y.exr -o x", 1);
    assert!(
        said.contains("y.exr") && said.contains("subsampled"),
        "{said}"
    );
    let report = info(at, "y.exr");
    assert_eq!(report["parts"][0]["channels"][0]["sampling"][0], 2);
    assert!(report["refused"].as_str().unwrap().contains("subsampled"));
}
