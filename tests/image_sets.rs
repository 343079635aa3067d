//! Image sets in folders and archives as a user imports them: names, formats, options, and all that is wrong.

mod image_set_files;
mod program;

use std::fs;
use std::path::Path;

use mesotex::btf::image_sets::{export_folder, export_ubo2003, export_utia};
use mesotex::btf::{Direction, DirectionSet, Sample};
use serde_json::Value;

use image_set_files::{
    bitmap, compressed, grey, hdr_with_faulty_line, spectral, ubo_name, xyz, zip,
};
use program::{files, mesotex, refuse, succeed};

fn open(folder: &Path) -> Sample {
    Sample::open(&folder.join("x.sample")).unwrap()
}

/// Imports `words` to `x.sample`.
fn import(folder: &Path, words: &[&str]) -> Sample {
    succeed(folder, &[&["import", "-o", "x.sample"], words].concat());
    open(folder)
}

fn refused(folder: &Path, words: &[&str], code: i32) -> String {
    let error = refuse(
        folder,
        &[&["import", "-o", "x.sample"], words].concat(),
        code,
    );
    assert!(!folder.join("x.sample").exists(), "{words:?}");
    error
}

fn value(sample: &Sample, image: usize, at: usize) -> f32 {
    sample.image(image).unwrap().get(at) * std::f32::consts::PI
}

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() < 2e-3
}

/// A folder of 2 × 3 texel PNG files in UTIA's names: 2 views, 3 lights, each of one grey.
fn small_set(folder: &Path) {
    for (view, light) in (0..2).flat_map(|view| (0..3).map(move |light| (view, light))) {
        let name = format!("tl{:03}_pl000_tv{:03}_pv090.png", 30 * light, 30 * view);
        grey(&folder.join(name), 2, 3, 40 * (view * 3 + light + 1) as u8);
    }
}

fn linear(stored: u8) -> f32 {
    mesotex::format::image::decode_srgb(f32::from(stored) / 255.0)
}

#[test]
fn an_archive_made_from_a_bake_imports_to_the_bake() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let rings = "rings:0:1,30:3,60:4";
    succeed(
        folder.path(),
        &[
            "bake",
            "--preset",
            "weave",
            "--size",
            "16",
            "--samples",
            "1",
            "--views",
            rings,
            "--lights",
            rings,
            "-o",
            "bake.sample",
        ],
    );
    let bake = Sample::open(&at("bake.sample")).unwrap();
    for (name, most) in [("ubo", 0.03), ("utia", 0.004), ("plain", 0.0)] {
        let set = at(name);
        match name {
            "ubo" => export_ubo2003(&bake, &set).unwrap(),
            "utia" => export_utia(&bake, &set).unwrap(),
            _ => export_folder(&bake, &set).unwrap(),
        };
        let source = format!("{name}.zip");
        zip(&at(&source), &files(&set), name == "ubo");
        let found = import(folder.path(), &[&source, "--tileable"]);
        let (a, b) = (bake.description(), found.description());
        assert_eq!((a.width, a.height, a.layout), (b.width, b.height, b.layout));
        let pairs = a
            .views
            .iter()
            .zip(&b.views)
            .chain(a.lights.iter().zip(&b.lights));
        for (a, b) in pairs {
            assert!(a.angle_to(*b) < 1e-9);
        }
        let mut squares = 0.0;
        for image in 0..bake.image_count() {
            let (a, b) = (bake.image(image).unwrap(), found.image(image).unwrap());
            for at in 0..a.len() {
                let encoded = |v: f32| {
                    let reflectance = (v * std::f32::consts::PI).min(1.0);
                    mesotex::format::image::encode_srgb(reflectance)
                };
                squares += (encoded(a.get(at)) - encoded(b.get(at))).powi(2) / a.len() as f32;
            }
        }
        let deviation = (squares / bake.image_count() as f32).sqrt();
        assert!(deviation <= most, "{name}: {deviation}");
        if name == "plain" {
            assert_eq!(bake.id(), found.id());
        }
        fs::remove_dir_all(at("x.sample")).unwrap();
    }
}

#[test]
fn an_archive_has_the_81_directions_and_the_same_bytes_at_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let bonn = "bonn81"
        .parse::<DirectionSet>()
        .unwrap()
        .directions()
        .unwrap();
    let mut members = std::collections::BTreeMap::new();
    for (number, light) in bonn.iter().enumerate() {
        let name = ubo_name(number, *light, Direction::from_angles(0.0, 0.0));
        let path = folder.path().join("one.jpg");
        image::RgbImage::from_pixel(8, 8, image::Rgb([number as u8, 90, 30]))
            .save(&path)
            .unwrap();
        members.insert(name.into(), fs::read(&path).unwrap());
    }
    zip(&folder.path().join("a.zip"), &members, true);
    let found = import(folder.path(), &["a.zip"]);
    let lights = &found.description().lights;
    assert_eq!(lights.len(), 81);
    assert!(lights.iter().zip(&bonn).all(|(a, b)| a.angle_to(*b) < 1e-9));
    assert_eq!(found.description().name, "a");
    let first = files(&folder.path().join("x.sample"));
    for threads in ["1", "3"] {
        succeed(
            folder.path(),
            &["import", "a.zip", "-o", "x.sample", "--threads", threads],
        );
        assert_eq!(files(&folder.path().join("x.sample")), first);
    }
    let told = succeed(folder.path(), &["info", "a.zip"]);
    assert!(
        told.contains("ubo2003") && told.contains("81 lights"),
        "{told}"
    );
}

#[test]
fn curet_comes_packed_and_scattered() {
    let folder = tempfile::tempdir().unwrap();
    let mut members = std::collections::BTreeMap::new();
    for number in 1..=205_usize {
        let name = format!("sample11/11-{number:03}.bmp.Z");
        members.insert(name.into(), compressed(&bitmap(4, 2, number as u8)));
    }
    zip(&folder.path().join("sample11.zip"), &members, false);
    let found = import(folder.path(), &["sample11.zip"]);
    let description = found.description();
    assert_eq!(description.image_count(), 205);
    assert_eq!(description.source["kind"], "curet");
    let pairs = description.pairs.clone().unwrap();
    let [view, light] = pairs[1];
    // The second row of the table: θ and φ of the view, then of the light.
    let (view, light) = (
        description.views[view as usize],
        description.lights[light as usize],
    );
    assert!(view.angle_to(Direction::from_angles(0.981_748, 0.0)) < 1e-6);
    assert!(light.angle_to(Direction::from_angles(1.374_447, 0.0)) < 1e-6);
    assert!(close(value(&found, 99, 0), linear(100)));
    let few = members.into_iter().take(9).collect();
    zip(&folder.path().join("few.zip"), &few, false);
    let few = import(folder.path(), &["few.zip", "--directions", "curet"]);
    assert_eq!(few.image_count(), 9);
}

#[test]
fn spectra_become_colours_under_a_light() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("set")).unwrap();
    for light in [0.0, 60.0] {
        let name = format!("set/tv0.0_pv0.0_tl{light:.1}_pl90.exr");
        spectral(&folder.path().join(name), |nm| {
            if nm < 500.0 { 0.25 } else { 0.75 }
        });
    }
    let found = import(folder.path(), &["set", "--dtype", "f4"]);
    assert_eq!(found.description().source["kind"], "spectral");
    assert_eq!(found.description().source["values"], "no-cosine");
    for (channel, expected) in [0.762_875, 0.757_563, 0.208_210].into_iter().enumerate() {
        assert!((value(&found, 0, channel) - expected).abs() < 5e-4);
        assert!((value(&found, 1, channel) - expected / 2.0).abs() < 5e-4);
    }
    let words = [
        "set",
        "--dtype",
        "f4",
        "--illuminant",
        "a",
        "--values",
        "reflectance",
    ];
    let under_a = import(folder.path(), &words);
    assert!((value(&under_a, 1, 2) - 0.213_196).abs() < 5e-4);
    fs::remove_dir_all(folder.path().join("x.sample")).unwrap();
    fs::remove_dir_all(folder.path().join("set")).unwrap();
    fs::create_dir(folder.path().join("set")).unwrap();
    small_set(&folder.path().join("set"));
    let error = refused(folder.path(), &["set", "--illuminant", "e"], 2);
    assert!(error.contains("no image is spectral"), "{error}");
}

#[test]
fn the_faulty_size_line_of_atrium_is_read_as_its_makers_do() {
    let folder = tempfile::tempdir().unwrap();
    // Rows from the bottom: the first row of the file is the last of the image.
    let bytes = hdr_with_faulty_line(16, 8);
    let members = [("CEILING/00000 tl000 pl000 tv000 pv000.hdr".into(), bytes)].into();
    zip(&folder.path().join("a.zip"), &members, true);
    let output = mesotex(
        folder.path(),
        &["import", "a.zip", "-o", "x.sample", "--dtype", "f4"],
    );
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("size line"));
    let found = open(folder.path());
    assert_eq!((found.grid().width, found.grid().height), (16, 8));
    // Red counts columns, green rows of the file.
    let at =
        |row: usize, col: usize, channel: usize| value(&found, 0, (row * 16 + col) * 3 + channel);
    assert!(at(7, 0, 1) < at(0, 0, 1) && at(0, 0, 0) < at(0, 15, 0));
    assert!(close(at(7, 5, 1), 0.0) && (at(0, 5, 1) - 7.0 / 16.0).abs() < 0.01);
    let stated = import(
        folder.path(),
        &["a.zip", "--size-line", "stated", "--dtype", "f4"],
    );
    let at =
        |row: usize, col: usize, channel: usize| value(&stated, 0, (row * 16 + col) * 3 + channel);
    assert!(at(0, 0, 1) < 0.01 && (at(7, 0, 0) - at(0, 0, 0)).abs() > 0.1);
}

#[test]
fn pictures_are_cropped_downsampled_and_chosen() {
    let folder = tempfile::tempdir().unwrap();
    small_set(folder.path());
    let words = [
        ".",
        "--crop",
        "2x2+0+1",
        "--downsample",
        "2",
        "--texel-mm",
        "0.1",
        "--keep-lights",
        "theta:30",
        "--keep-views",
        "1",
    ];
    let found = import(folder.path(), &words);
    let description = found.description();
    assert_eq!((description.width, description.height), (1, 1));
    assert_eq!((description.views.len(), description.lights.len()), (1, 2));
    assert!((description.texel_mm.unwrap() - 0.2).abs() < 1e-12);
    assert!(close(value(&found, 1, 0), linear(40 * 5)));
    assert_eq!(description.source["crop"], "2x2+0+1");
    fs::remove_dir_all(folder.path().join("x.sample")).unwrap();
    for (words, says) in [
        (vec![".", "--crop", "9x9+0+0"], "9x9+0+0 in images of 2 × 3"),
        (vec![".", "--downsample", "2"], "--crop 2x2+0+0"),
        (vec![".", "--keep-views", "7"], "direction 7 of 2"),
        (vec![".", "--crop", "tall"], "WIDTHxHEIGHT"),
        (vec![".", "--images", "*.png"], "--images"),
        (vec![".", "--pattern", "x{tl}"], "--pattern"),
    ] {
        let error = refused(folder.path(), &words, 2);
        assert!(error.contains(says), "{words:?}: {error}");
    }
}

#[test]
fn a_grey_card_sets_exposure_and_white() {
    let folder = tempfile::tempdir().unwrap();
    for (number, exposure) in [(0, 0.5_f32), (1, 1.0)] {
        let picture = image::RgbImage::from_fn(4, 4, |x, _| {
            let reflectance = if x == 0 { 0.5 } else { 0.25 };
            let stored =
                |tint: f32| mesotex::format::image::encode_srgb8(reflectance * exposure * tint);
            image::Rgb([stored(1.0), stored(0.8), stored(0.5)])
        });
        let name = format!("l{}_0.png", 60 * number);
        picture.save(folder.path().join(name)).unwrap();
    }
    let words = [
        ".",
        "--pattern",
        "l{tl}_{pl}",
        "--grey-card",
        "1x4+0+0:0.5",
        "--crop",
        "3x4+1+0",
    ];
    let found = import(folder.path(), &words);
    for channel in 0..3 {
        assert!((value(&found, 0, channel) - 0.25).abs() < 0.01);
        assert!((value(&found, 1, channel) - 0.125).abs() < 0.01);
    }
    fs::remove_dir_all(folder.path().join("x.sample")).unwrap();
    let words = [
        ".",
        "--pattern",
        "l{tl}_{pl}",
        "--grey-card",
        "1x4+0+0",
        "--values",
        "radiance",
    ];
    assert!(refused(folder.path(), &words, 2).contains("--grey-card"));
}

#[test]
fn hot_pixels_go_and_glints_stay() {
    let folder = tempfile::tempdir().unwrap();
    for light in 0..5_u32 {
        let picture = image::RgbImage::from_fn(6, 6, |x, y| {
            let is_bright = (x, y) == (2, 3) || (x, y) == (light, 0);
            image::Rgb([if is_bright { 250 } else { 60 }; 3])
        });
        picture
            .save(folder.path().join(format!("l{}_0.png", 10 * light)))
            .unwrap();
    }
    let found = import(
        folder.path(),
        &[".", "--pattern", "l{tl}_{pl}", "--hot-pixels"],
    );
    assert_eq!(found.description().source["hot_pixels"], 1);
    assert!(close(value(&found, 0, (3 * 6 + 2) * 3), linear(60)));
    assert!(close(value(&found, 1, 3), linear(250)));
}

#[test]
fn missing_images_are_named_and_filled() {
    let folder = tempfile::tempdir().unwrap();
    small_set(folder.path());
    fs::remove_file(folder.path().join("tl030_pl000_tv000_pv090.png")).unwrap();
    fs::remove_file(folder.path().join("tl060_pl000_tv030_pv090.png")).unwrap();
    let error = refused(folder.path(), &["."], 1);
    for says in [
        "light (30°, 0°), view (0°, 0°)",
        "light (60°, 0°), view (30°, 90°)",
        "2 of 6",
        "--fill",
    ] {
        assert!(error.contains(says), "{says}: {error}");
    }
    let told = succeed(folder.path(), &["info", "."]);
    assert!(told.contains("2 of 6 images are missing"), "{told}");
    let filled = import(folder.path(), &[".", "--fill"]);
    let description = filled.description();
    assert_eq!(description.image_count(), 6);
    let marked: Value = serde_json::json!([[0, 1], [1, 2]]);
    assert_eq!(description.source["filled"], marked);
    let between = value(&filled, 1, 0);
    assert!(between > 0.05 && between < 1.0, "{between}");
    fs::remove_dir_all(folder.path().join("x.sample")).unwrap();
    let scattered = import(folder.path(), &[".", "--scattered"]);
    assert_eq!(scattered.description().pairs.as_ref().unwrap().len(), 4);
}

#[test]
fn every_image_that_cannot_be_used_is_named() {
    let folder = tempfile::tempdir().unwrap();
    small_set(folder.path());
    let at = |name: &str| folder.path().join(name);
    let broken = ["tl000_pl000_tv030_pv090.png", "tl060_pl000_tv000_pv090.png"];
    for name in broken {
        let bytes = fs::read(at(name)).unwrap();
        fs::write(at(name), &bytes[..bytes.len() / 2]).unwrap();
    }
    grey(&at("tl030_pl000_tv000_pv090.png"), 5, 5, 9);
    let error = refused(folder.path(), &["."], 1);
    for name in broken
        .into_iter()
        .chain(["tl030_pl000_tv000_pv090.png: size: 5 × 5; expected 2 × 3"])
    {
        assert!(error.contains(name), "{name}: {error}");
    }
    assert!(error.contains("3 faults"), "{error}");
}

#[test]
fn repeated_directions_are_named() {
    let folder = tempfile::tempdir().unwrap();
    small_set(folder.path());
    for name in [
        "a tl030 pl000 tv000 pv000.png",
        "b tl030 pl360 tv030 pv090.png",
    ] {
        grey(&folder.path().join(name), 2, 3, 7);
    }
    let error = refused(folder.path(), &["."], 1);
    assert!(error.contains("2 faults"), "{error}");
    for says in ["a tl030 pl000", "b tl030 pl360", "the same directions as"] {
        assert!(error.contains(says), "{says}: {error}");
    }
}

#[test]
fn broken_archives_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    small_set(folder.path());
    let members = files(folder.path());
    let path = folder.path().join("a.zip");
    zip(&path, &members, true);
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 60]).unwrap();
    assert!(refused(folder.path(), &["a.zip"], 1).contains("truncated"));
    let climbing = [("../../evil tl0 pl0 tv0 pv0.png".into(), vec![1])].into();
    zip(&path, &climbing, true);
    let error = refused(folder.path(), &["a.zip"], 1);
    assert!(error.contains("leads out of the archive"), "{error}");
    let bomb = [("tl0_pl0_tv0_pv0.bmp".into(), vec![0; 48 << 20])].into();
    zip(&path, &bomb, false);
    let error = refused(folder.path(), &["a.zip"], 1);
    assert!(error.contains("packed into"), "{error}");
    fs::write(folder.path().join("a.rar"), b"Rar!\x1a\x07").unwrap();
    let error = refused(folder.path(), &["a.rar"], 1);
    assert!(
        error.contains("52 61 72 21") && error.contains("`PK`"),
        "{error}"
    );
}

#[test]
fn tables_of_positions_give_directions_and_their_spread() {
    let folder = tempfile::tempdir().unwrap();
    grey(&folder.path().join("a.png"), 2, 2, 100);
    grey(&folder.path().join("b.png"), 2, 2, 100);
    let table = "file,camera_x_mm,camera_y_mm,camera_z_mm,light_x_mm,light_y_mm,light_z_mm\n\
        a.png,0,0,500,300,0,400\nb.png,0,0,500,0,300,400\n";
    fs::write(folder.path().join("places.csv"), table).unwrap();
    let output = mesotex(
        folder.path(),
        &[
            "import",
            "places.csv",
            "-o",
            "x.sample",
            "--patch-mm",
            "60x80",
        ],
    );
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("5.71°"), "{told}");
    let found = open(folder.path());
    let light = found.description().lights[0];
    assert!((light.theta().to_degrees() - 36.869_897_645_844_02).abs() < 1e-9);
    let spread = &found.description().source["spread_deg"];
    assert!(
        (spread["view"].as_f64().unwrap() - 5.710_593).abs() < 1e-5,
        "{spread}"
    );
    assert!(succeed(folder.path(), &["info", "places.csv"]).contains("--patch-mm"));
}

#[test]
fn sets_are_exported_by_name_and_never_over_files() {
    let folder = tempfile::tempdir().unwrap();
    small_set(folder.path());
    fs::create_dir(folder.path().join("set")).unwrap();
    small_set(&folder.path().join("set"));
    assert!(succeed(folder.path(), &["info", "set"]).contains("(utia): 6 images"));
    let sample = import(folder.path(), &["set", "--dtype", "f4"]);
    for target in ["ubo2003", "utia", "utia-exr", "folder"] {
        let words = ["export", "x.sample", "--to", target, "-o", target, "--json"];
        let report: Value = serde_json::from_str(&succeed(folder.path(), &words)).unwrap();
        assert_eq!(
            (&report["images"], &report["clipped"]),
            (&6.into(), &0.into())
        );
        succeed(
            folder.path(),
            &["import", target, "-o", "back.sample", "--dtype", "f4"],
        );
        let back = Sample::open(&folder.path().join("back.sample")).unwrap();
        for image in 0..6 {
            assert!(
                (value(&back, image, 0) - value(&sample, image, 0)).abs() < 8e-3,
                "{target}"
            );
        }
    }
    let again = ["export", "x.sample", "--to", "utia", "-o", "utia"];
    assert!(refuse(folder.path(), &again, 2).contains("not empty"));
    let inside = ["export", "x.sample", "--to", "utia", "-o", "x.sample"];
    assert!(refuse(folder.path(), &inside, 2).contains("also an input"));
}

/// XYZ of a grey of 0.5 under D65.
const GREY_XYZ: [f32; 3] = [0.475_235, 0.5, 0.544_415];

fn is_grey(sample: &Sample) -> bool {
    (0..3).all(|channel| (value(sample, 0, channel) - 0.5).abs() < 1e-3)
}

#[test]
fn openexr_of_utia_is_xyz_unless_it_says_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let [x, y, z] = GREY_XYZ;
    fs::create_dir(at("utia")).unwrap();
    let image = at("utia/tl000_pl000_tv000_pv000.exr");
    exr::prelude::write_rgb_file(&image, 4, 3, |_, _| (x, y, z)).unwrap();
    let words = ["import", "utia", "-o", "x.sample", "--dtype", "f4"];
    let told = mesotex(folder.path(), &words).stderr;
    assert!(String::from_utf8_lossy(&told).contains("XYZ"));
    assert!(is_grey(&open(folder.path())));
    let as_stored = import(
        folder.path(),
        &["utia", "--dtype", "f4", "--encoding", "linear"],
    );
    assert!((value(&as_stored, 0, 0) - x).abs() < 1e-5);
    // Elsewhere R, G and B are what they are called, and X, Y and Z too.
    fs::rename(at("utia"), at("other")).unwrap();
    let renamed = at("other/l0_0.exr");
    fs::rename(at("other/tl000_pl000_tv000_pv000.exr"), &renamed).unwrap();
    let words = ["other", "--dtype", "f4", "--pattern", "l{tl}_{pl}"];
    assert!((value(&import(folder.path(), &words), 0, 0) - x).abs() < 1e-5);
    xyz(&renamed, GREY_XYZ);
    assert!(is_grey(&import(folder.path(), &words)));
}

#[test]
fn encodings_and_axes_are_as_the_user_says() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("set")).unwrap();
    for (number, phi) in [(0, 0), (1, 90)] {
        let name = format!("set/tl030_pl{phi:03}_tv000_pv000.png");
        grey(&folder.path().join(name), 2, 2, 100 + number);
    }
    let found = import(folder.path(), &["set", "--encoding", "gamma-2.2"]);
    assert!(close(value(&found, 0, 0), (100.0_f32 / 255.0).powf(2.2)));
    let turned = import(folder.path(), &["set", "--handedness", "left"]);
    let lights = &turned.description().lights;
    assert!((lights[1].phi().to_degrees() - 270.0).abs() < 1e-9);
    assert!(close(value(&turned, 1, 0), linear(101)));
}
