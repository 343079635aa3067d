//! Captures as users have them: lists of other programs, images elsewhere, axes the other way; and what
//! `info` says of all that.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use image::{Rgb, RgbImage};
use mesotex::btf::{Direction, Sample};
use serde_json::Value;

fn mesotex(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    command.args(words).current_dir(folder).output().unwrap()
}

fn succeed(folder: &Path, words: &[&str]) -> Value {
    let output = mesotex(folder, &[words, &["--json"]].concat());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words:?}: {errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(folder: &Path, words: &[&str]) -> String {
    let output = mesotex(folder, words);
    assert!(!output.status.success(), "{words:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Photographs of grey 40, 80 and 120.
fn photographs(folder: &Path, names: [&str; 3]) {
    fs::create_dir_all(folder).unwrap();
    for (name, grey) in names.iter().zip([40, 80, 120]) {
        RgbImage::from_pixel(4, 3, Rgb([grey; 3]))
            .save(folder.join(name))
            .unwrap();
    }
}

const NAMES: [&str; 3] = ["photo0.png", "photo1.png", "photo2.png"];
const LIGHTS: [[f64; 3]; 3] = [[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [0.0, -0.6, 0.8]];

/// A list with these lights, `line` putting a name and a position together.
fn list(line: impl Fn(&str, [f64; 3]) -> String) -> String {
    let lines = NAMES
        .iter()
        .zip(LIGHTS)
        .map(|(name, light)| line(name, light));
    lines.collect::<Vec<_>>().join("\n") + "\n"
}

/// Imports and holds lights and greys against those of the capture, y times `sign`.
fn check_import(folder: &Path, words: &[&str], sign: f64) -> Value {
    let words = [&["import"], words, &["-o", "x.sample", "--dtype", "f4"]].concat();
    let report = succeed(folder, &words);
    let sample = Sample::open(&folder.join("x.sample")).unwrap();
    for (image, light) in LIGHTS.iter().enumerate() {
        let wanted = Direction::from([light[0], sign * light[1], light[2]]);
        let found = sample.description().lights[image];
        assert!(found.angle_to(wanted) < 1e-4, "{words:?}: {found:?}");
    }
    let greys: Vec<f32> = (0..3)
        .map(|image| sample.image(image).unwrap().get(0))
        .collect();
    assert!(
        greys[0] < greys[1] && greys[1] < greys[2],
        "{words:?}: {greys:?}"
    );
    report
}

#[test]
fn lists_of_every_kind_are_read() {
    let plain = |name: &str, [x, y, z]: [f64; 3]| format!("{name} {x} {y} {z}");
    let comma = |v: f64| v.to_string().replace('.', ",");
    let text = list(plain);
    let utf16: Vec<u8> = format!("\u{feff}3\r\n{text}")
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let latin: Vec<u8> = format!("# K\u{f6}ln\n3\n{text}")
        .chars()
        .map(|c| c as u8)
        .collect();
    let lists: Vec<Vec<u8>> = vec![
        format!("3\n{text}").into(),
        text.clone().into(),
        format!("\u{feff}3\r\n{}", text.replace('\n', "\r\n")).into(),
        format!("# dome 7\n\n3\n# lights\n{text}").into(),
        list(|name, [x, y, z]| format!("{name}   {x:.6}\t {y:.6}  {z:.6}  ")).into(),
        list(|name, [x, y, z]| format!("C:\\old\\{name} {} {} {}", comma(x), comma(y), comma(z)))
            .into(),
        list(|name, [x, y, z]| format!("\"{name}\", {x}, {y}, {z}")).into(),
        list(|name, light| plain(name, light.map(|v| 250.0 * v))).into(),
        utf16,
        latin,
    ];
    for (number, bytes) in lists.into_iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        photographs(folder.path(), NAMES);
        fs::write(folder.path().join("dirs.lp"), bytes).unwrap();
        let report = check_import(folder.path(), &["dirs.lp"], 1.0);
        let warnings = report["warnings"].to_string();
        let expected = match number {
            7 => "not unit vectors (lengths 250.000 to 250.000)",
            9 => "Latin-1",
            _ => "[]",
        };
        assert!(warnings.contains(expected), "{number}: {warnings}");
    }
}

#[test]
fn faults_of_lists_name_both_numbers_and_every_light() {
    let folder = tempfile::tempdir().unwrap();
    photographs(folder.path(), NAMES);
    let error = |text: &str| {
        fs::write(folder.path().join("dirs.lp"), text).unwrap();
        refused(folder.path(), &["import", "dirs.lp", "-o", "x.sample"])
    };
    let text = list(|name, [x, y, z]| format!("{name} {x} {y} {z}"));
    let count = error(&format!("5\n{text}"));
    assert!(
        count.contains("dirs.lp: line 1: 5 images announced; expected 3"),
        "{count}"
    );
    let below = error(&text.replace(" 0.8", " -0.8"));
    assert!(
        below.contains("3 of 3 lights lie below the horizon: photo0.png (53.1° below, line 1)"),
        "{below}"
    );
}

#[test]
fn tables_of_spreadsheets_are_read() {
    let angles = [(36.87, 0.0), (36.87, 90.0), (36.87, 270.0)];
    let header = "File,View_Theta_Deg,View_Phi_Deg,Light_Theta_Deg,Light_Phi_Deg";
    let rows = NAMES.iter().zip(angles);
    let rows: Vec<String> = rows
        .map(|(name, (t, p))| format!("{name}|0|0|{t}|{p}"))
        .collect();
    let rows = rows.join("\r\n");
    let tables = [
        format!("{header}\r\n{}", rows.replace('|', ",")),
        format!(
            "\u{feff}{}\r\n{}",
            header.replace(',', ";"),
            rows.replace('.', ",")
                .replace("o0,", "o0.")
                .replace("o1,", "o1.")
                .replace("o2,", "o2.")
                .replace('|', ";")
        ),
        format!(
            "sep=;\r\n{}\r\n{}",
            header.replace(',', ";"),
            rows.replace('|', ";")
        ),
        format!(
            "{}\r\n{}",
            header.replace(',', "\t"),
            rows.replace('|', "\t")
        ),
        format!(
            "\"{}\"\r\n{}",
            header.replace(',', "\",\""),
            rows.replace('|', ",")
        ),
    ];
    for table in tables {
        let folder = tempfile::tempdir().unwrap();
        photographs(folder.path(), NAMES);
        fs::write(folder.path().join("angles.csv"), table).unwrap();
        check_import(folder.path(), &["."], 1.0);
    }
}

#[test]
fn images_are_found_elsewhere_and_axes_turned_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let text = list(|name, [x, y, z]| format!("D:\\dome\\{name} {x} {y} {z}"));
    fs::create_dir(folder.path().join("lists")).unwrap();
    fs::write(folder.path().join("lists/dirs.lp"), &text).unwrap();
    photographs(
        &folder.path().join("jpg"),
        ["Photo0.PNG", "photo1.png", "photo2.png"],
    );
    let report = check_import(folder.path(), &["lists/dirs.lp"], 1.0);
    assert!(report["warnings"].to_string().contains("images found in"));
    check_import(folder.path(), &["lists/dirs.lp", "--images", "jpg"], 1.0);
    check_import(
        folder.path(),
        &["lists/dirs.lp", "--handedness", "left"],
        -1.0,
    );
    let info = succeed(folder.path(), &["info", "x.sample"]);
    assert_eq!(info["source"]["handedness"], "left");
    photographs(&folder.path().join("images"), NAMES);
    let twice = refused(
        folder.path(),
        &["import", "lists/dirs.lp", "-o", "x.sample"],
    );
    assert!(
        twice.contains("jpg") && twice.contains("images") && twice.contains("--images"),
        "{twice}"
    );
}

#[test]
fn a_calibrated_dome_lights_images_of_other_names() {
    let folder = tempfile::tempdir().unwrap();
    let text = list(|name, [x, y, z]| format!("ball_{name} {x} {y} {z}"));
    fs::write(folder.path().join("dome.lp"), &text).unwrap();
    photographs(
        &folder.path().join("coin"),
        ["img9.png", "img10.png", "img11.png"],
    );
    for images in ["coin", "coin/*.png", "coin/img?*.png"] {
        let report = check_import(folder.path(), &["dome.lp", "--images", images], 1.0);
        assert!(report["warnings"].to_string().contains("in their order"));
    }
    let words = ["import", "dome.lp", "-o", "x.sample", "--images"];
    let few = refused(folder.path(), &[&words[..], &["coin/img1*.png"]].concat());
    assert!(few.contains("2 in coin/img1*.png; expected 3"), "{few}");
    let none = refused(folder.path(), &[&words[..], &["coin/*.tif"]].concat());
    assert!(none.contains("matches no file"), "{none}");
}

#[test]
fn info_tells_every_kind() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    let write = |name: &str, text: &str| fs::write(root.join(name), text).unwrap();
    photographs(&root.join("capture"), NAMES);
    let text = list(|name, [x, y, z]| format!("{name} {x} {y} {z}"));
    write("capture/dirs.lp", &text);
    write("lost.lp", "gone.png 0 0 1\n");
    write("set.csv", "theta_deg;phi_deg\n0;0\n45,5;90\n");
    write("path.csv", "light_azimuth,light_elevation\n0,30\n10,30\n");
    write("m.toml", "albedo = [0.5, 0.4, 0.3]\nroughness = 0.4\n");
    write(
        "guides.json",
        r#"{"guides": [{"vertex": 7, "direction": [1, 0, 0]}]}"#,
    );
    write(
        "scene.toml",
        "name = \"small\"\n[bake]\nmaterial = \"m.toml\"\nsize = 16\nviews = \"rings:0:1\"\n\
         lights = \"rings:0:1\"\nsamples = 1\n[mesh]\ninput = \"a.obj\"\n[textons]\n[synth]\n[[render]]\n",
    );
    write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let kind = |path: &str| {
        succeed(root, &["info", path])["kind"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    for (path, wanted) in [
        ("capture", "capture"),
        ("capture/dirs.lp", "capture"),
        ("lost.lp", "capture"),
        ("set.csv", "direction set"),
        ("path.csv", "camera path"),
        ("m.toml", "material recipe"),
        ("guides.json", "guides"),
        ("scene.toml", "scene"),
        ("capture/photo0.png", "image"),
        ("a.obj", "mesh"),
    ] {
        assert_eq!(kind(path), wanted, "{path}");
    }
    let capture = succeed(root, &["info", "capture"]);
    assert_eq!(
        (capture["images"].as_u64(), capture["lights"].as_u64()),
        (Some(3), Some(3))
    );
    assert_eq!(
        succeed(root, &["info", "lost.lp"])["missing"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
    let scene = succeed(root, &["info", "scene.toml"]);
    assert_eq!(scene["stages"][0]["products"][0], "small.sample");
    assert_eq!(scene["stages"][0]["done"], false);
    write("notes.txt", "hello");
    fs::create_dir(root.join("empty")).unwrap();
    for path in ["notes.txt", "empty"] {
        let error = refused(root, &["info", path]);
        assert!(
            error.contains("a kind of file that info does not know; expected a sample"),
            "{error}"
        );
    }
    let missing = refused(root, &["info", "no/such"]);
    assert!(missing.contains("cannot read"), "{missing}");
}

#[test]
fn info_tells_what_a_run_left() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    let scene = "name = \"s\"\n[bake]\npreset = \"weave\"\nsize = 32\nviews = \"rings:0:1\"\n\
        lights = \"rings:0:1,40:3\"\nsamples = 1\n[textons]\ntextons = 8\nimages = 4\nlevels = 2\n[mesh]\ninput = \"m.obj\"\n\
        vertices = 200\n[synth]\nlevels = 2\n[[render]]\nframes = 1\nsize = \"32x32\"\n";
    fs::write(root.join("scene.toml"), scene).unwrap();
    let mesh = mesotex::mesh::builtin::kettlebell(300);
    let mut text = String::new();
    for p in &mesh.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    fs::write(root.join("m.obj"), text).unwrap();
    succeed(root, &["run", "scene.toml"]);
    let info = succeed(root, &["info", "scene.toml"]);
    let stages = info["stages"].as_array().unwrap();
    assert!(
        stages.len() > 5 && stages.iter().all(|stage| stage["done"] == true),
        "{info}"
    );
    let record = succeed(root, &["info", "run.json"]);
    assert_eq!(record["kind"], "record of a scene");
    // The two pages are no stages of the scene, but the record tells when each was made.
    assert_eq!(record["stages"].as_array().unwrap().len(), stages.len() + 2);
    let sample = succeed(root, &["info", "s.sample"]);
    assert_eq!(sample["source"]["kind"], "bake");
    assert_eq!(
        succeed(root, &["info", "s.sample/btf.json"])["id"],
        sample["id"]
    );
    assert_eq!(succeed(root, &["info", "s.frames"])["kind"], "frames");
}
