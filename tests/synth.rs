//! `mesotex exemplar` and `mesotex synth` as a user runs them, on a small picture made here.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use mesotex::exemplar::Space;
use mesotex::format::image::write_png;
use mesotex::maps::SurfaceTextonMap;

fn mesotex(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .current_dir(folder)
        .args(arguments.split(' '))
        .output()
        .unwrap()
}

fn succeeds(folder: &Path, arguments: &str) -> String {
    let output = mesotex(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// The exit code and the message of a command that must fail.
fn fails(folder: &Path, arguments: &str) -> (i32, String) {
    let output = mesotex(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!errors.contains("panicked"), "{errors}");
    (output.status.code().unwrap(), errors)
}

/// A folder with a 24×24 tileable picture of tilted stripes and spots, and its exemplar of 2 levels.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut pixels = Vec::new();
    for row in 0..24i32 {
        for col in 0..24i32 {
            let stripe = (row + col) % 8 < 4;
            let spot = (row % 12 - 4).pow(2) + (col % 24 - 9).pow(2) < 9;
            pixels.extend([
                if stripe { 200 } else { 40 },
                if spot { 220 } else { 60 },
                (5 * row + 3 * col) as u8,
            ]);
        }
    }
    write_png(&folder.path().join("a.png"), 24, 24, &pixels).unwrap();
    succeeds(folder.path(), "exemplar a.png -o a --tile --levels 2 --k 5");
    folder
}

const SYNTH: &str = "synth a.space.npz a.knn.npz --grid 32x32";

#[test]
fn figures_are_reported_with_their_good_ranges() {
    let folder = prepared();
    for (polish, range) in [
        ("--polish 0", "1.00 to 1.10"),
        ("--polish 1", "1.00 to 3.00 after polish"),
    ] {
        let said = succeeds(
            folder.path(),
            &format!("{SYNTH} -o judged.map.ply {polish}"),
        );
        let line = said
            .lines()
            .find(|line| line.starts_with("energy_ratio_full "));
        let end = format!("(good: {range})");
        assert!(line.is_some_and(|line| line.ends_with(&end)), "{said}");
        assert!(
            said.contains("docs/synthesis.md explains these figures."),
            "{said}"
        );
    }
}

#[test]
fn a_picture_becomes_an_exemplar_and_a_flat_map() {
    let folder = prepared();
    let at = |name: &str| folder.path().join(name);
    let report = succeeds(
        folder.path(),
        &format!("{SYNTH} -o flat.map.ply --report r.json --pictures p --sample a.sample --json"),
    );
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert!(report["energy"].as_f64().unwrap() < 0.5, "{report}");
    assert!(report["energy_ratio_full"].as_f64().unwrap() < 1.5);
    assert!(report["histogram_chi2"].is_null());
    let kept: serde_json::Value = serde_json::from_slice(&fs::read(at("r.json")).unwrap()).unwrap();
    assert_eq!(kept["coherence_one"], report["coherence_one"]);
    assert!(kept.get("seconds").is_none());
    let (map, space) = (
        SurfaceTextonMap::read(&at("flat.map.ply")).unwrap(),
        Space::read(&at("a.space.npz")).unwrap(),
    );
    assert_eq!(
        (map.mesh.positions.len(), map.header.exemplar),
        (1024, [24, 24])
    );
    assert_eq!(
        (&map.header.space, &map.header.sample),
        (&space.id, &space.sample)
    );
    assert!(map.textons.iter().all(|texton| texton.0 == u16::MAX));
    for kind in ["coordinate", "label", "energy", "color"] {
        let picture = mesotex::format::image::read(&at(&format!("p.{kind}.png"))).unwrap();
        assert_eq!((picture.width, picture.height), (32, 32));
    }
    // The colours of the picture come back where the map points.
    let (source, drawn) = (
        mesotex::format::image::read(&at("a.png")).unwrap(),
        mesotex::format::image::read(&at("p.color.png")).unwrap(),
    );
    for (site, at) in map.coords.iter().enumerate() {
        let (row, col) = ((24.0 - at.t) as u32, at.s as u32);
        for channel in 0..3 {
            let (row_drawn, col_drawn) = (site as u32 / 32, site as u32 % 32);
            let found = drawn.get(row_drawn, col_drawn, channel);
            assert!((found - source.get(row, col, channel)).abs() < 1.5 / 255.0);
        }
    }
}

#[test]
fn a_picture_may_say_how_large_its_texels_are() {
    let folder = prepared();
    let at = folder.path();
    let exemplar = "exemplar a.png -o b --tile --levels 2 --k 5 --texel-mm";
    succeeds(at, &format!("{exemplar} 2.5"));
    let space = Space::read(&at.join("b.space.npz")).unwrap();
    assert_eq!(space.texel_mm, Some(2.5));
    assert!(succeeds(at, "info b.space.npz").contains("2.5 mm per texel"));
    assert!(succeeds(at, "info b.sample").contains("2.5 mm per texel"));
    let (code, message) = fails(at, &format!("{exemplar} 0"));
    assert_eq!(code, 2);
    assert!(message.contains("--texel-mm: 0"), "{message}");
}

#[test]
fn a_polished_map_is_the_same_at_any_number_of_threads() {
    let folder = prepared();
    let map = |words: &str| {
        succeeds(folder.path(), &format!("{SYNTH} -o m.map.ply {words}"));
        fs::read(folder.path().join("m.map.ply")).unwrap()
    };
    let polished = map("--polish 1 --threads 1");
    assert!(polished == map("--polish 1 --threads 2"));
    assert!(polished != map("--threads 2"));
}

#[test]
fn maps_are_the_same_at_any_thread_count_and_differ_by_seed() {
    let folder = prepared();
    let map = |name: &str, more: &str| {
        succeeds(folder.path(), &format!("{SYNTH} -o {name} {more}"));
        fs::read(folder.path().join(name)).unwrap()
    };
    let one = map("1.map.ply", "--threads 1");
    assert_eq!(one, map("2.map.ply", "--threads 2"));
    assert_eq!(one, map("8.map.ply", "--threads 8"));
    assert_ne!(one, map("s.map.ply", "--seed 1"));
    assert_ne!(one, map("f.map.ply", "--search full"));
}

#[test]
fn a_mesh_takes_the_picture_too() {
    let folder = prepared();
    let mut mesh = String::from("ply\nformat ascii 1.0\n");
    mesh += "element vertex 401\nproperty float x\nproperty float y\nproperty float z\n";
    mesh += "element face 722\nproperty list uchar int vertex_indices\nend_header\n";
    for vertex in 0..400 {
        let (x, y) = ((vertex % 20) as f32, (vertex / 20) as f32);
        mesh += &format!("{x} {y} {}\n", 0.02 * x * y);
    }
    mesh += "90 90 90\n";
    for cell in (0..380).filter(|cell| cell % 20 != 19) {
        mesh += &format!("3 {cell} {} {}\n", cell + 1, cell + 21);
        mesh += &format!("3 {cell} {} {}\n", cell + 21, cell + 20);
    }
    fs::write(folder.path().join("m.ply"), mesh).unwrap();
    let command = "synth a.space.npz a.knn.npz m.ply -o m.map.ply";
    succeeds(
        folder.path(),
        &format!("{command} --sample a.sample --vertex-colors c.ply"),
    );
    let map = SurfaceTextonMap::read(&folder.path().join("m.map.ply")).unwrap();
    assert_eq!(map.mesh.positions.len(), 401);
    let loose = 400;
    assert_eq!((map.coords[loose].s, map.coords[loose].t), (0.5, 0.5));
    assert!(map.header.texel > 0.9 && map.header.texel < 1.2);
    let colored = mesotex::format::ply::read(&folder.path().join("c.ply")).unwrap();
    assert_eq!(colored.require("green").unwrap().len(), 401);
    let (code, message) = fails(folder.path(), &format!("{command} --texel 0.01"));
    assert_eq!(code, 2, "{message}");
    assert!(
        message.contains("--texel") && message.contains("--vertices"),
        "{message}"
    );
}

#[test]
fn the_scale_of_a_mesh_stays_in_its_map() {
    let folder = prepared();
    let mesh = |name: &str, scale: [f32; 2]| {
        let mut text = String::from("ply\nformat ascii 1.0\nelement vertex 400\n");
        for property in ["x", "y", "z", "scale"] {
            text += &format!("property float {property}\n");
        }
        text += "element face 722\nproperty list uchar int vertex_indices\nend_header\n";
        for vertex in 0..400 {
            let scale = scale[usize::from(vertex % 20 >= 10)];
            text += &format!("{} {} 0 {scale}\n", vertex % 20, vertex / 20);
        }
        for cell in (0..380).filter(|cell| cell % 20 != 19) {
            text += &format!("3 {cell} {} {}\n", cell + 1, cell + 21);
            text += &format!("3 {cell} {} {}\n", cell + 21, cell + 20);
        }
        fs::write(folder.path().join(name), text).unwrap();
    };
    let map_of = |name: &str| {
        let synth = format!("synth a.space.npz a.knn.npz {name} -o m.map.ply --texel 1");
        succeeds(folder.path(), &synth);
        SurfaceTextonMap::read(&folder.path().join("m.map.ply")).unwrap()
    };
    mesh("m.ply", [1.0, 1.5]);
    let map = map_of("m.ply");
    let expected: Vec<f32> = (0..400)
        .map(|vertex| if vertex % 20 < 10 { 1.0 } else { 1.5 })
        .collect();
    assert_eq!(map.scale, Some(expected));
    let said = succeeds(folder.path(), "info m.map.ply");
    assert!(said.contains("scale from 1 to 1.5"), "{said}");
    mesh("one.ply", [1.0, 1.0]);
    assert_eq!(map_of("one.ply").scale, None);
    let said = succeeds(folder.path(), "info m.map.ply");
    assert!(!said.contains("scale from"), "{said}");
    mesh("tiny.ply", [1.0, 1e-20]);
    let synth = "synth a.space.npz a.knn.npz tiny.ply -o m.map.ply --texel 1";
    let (code, message) = fails(folder.path(), synth);
    assert_eq!(code, 1);
    let named = [
        "tiny.ply",
        "vertex 10, property scale: 0.00000000000000000001",
    ];
    assert!(
        named.iter().all(|words| message.contains(words)),
        "{message}"
    );
}

#[test]
fn what_does_not_fit_is_refused_with_a_reason() {
    let folder = prepared();
    let refused = |more: &str, code: i32, words: &[&str]| {
        let (found, message) = fails(folder.path(), &format!("{SYNTH} -o x.map.ply {more}"));
        assert_eq!(found, code, "{more}: {message}");
        for word in words {
            assert!(message.contains(word), "{more}: {message}");
        }
        assert!(!folder.path().join("x.map.ply").exists());
    };
    refused("--k 6", 2, &["the table lists 5", "knn --k 6"]);
    refused("--levels 3", 2, &["the sample has 2"]);
    refused("--neighborhood 6", 2, &["odd"]);
    refused("--neighborhood 5", 2, &["the table's is 7"]);
    refused("--metric gram", 2, &["no Gram matrix"]);
    refused("--spectrum 0", 2, &["--spectrum"]);
    refused("--coherence 0.5", 2, &["--coherence"]);
    refused("--texel 2", 2, &["--texel"]);
    refused("--sample a.sample", 2, &["--pictures"]);
    let other = folder.path();
    fs::copy(other.join("a.png"), other.join("b.png")).unwrap();
    succeeds(other, "exemplar b.png a.png -o b --tile --levels 2 --k 5");
    let mixed = "synth a.space.npz b.knn.npz --grid 32x32 -o y.map.ply";
    let (code, message) = fails(other, mixed);
    assert_eq!(code, 1, "{message}");
    succeeds(other, &format!("{mixed} --force"));
    let (code, message) = fails(other, "synth a.space.npz a.knn.npz --grid 9x9 -o y.map.ply");
    assert_eq!((code, message.contains("--grid")), (2, true), "{message}");
    let (code, _) = fails(
        other,
        "synth a.space.npz a.knn.npz --grid 32x32 -o a.knn.npz",
    );
    assert_eq!(code, 2);
    let (code, message) = fails(other, "exemplar a.png -o z --levels 5 --tile");
    assert_eq!(
        (code, message.contains("divisible")),
        (2, true),
        "{message}"
    );
}
