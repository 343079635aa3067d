//! `mesotex mesh` as a user runs it: files written and read back, bad input, damage, threads.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mesotex::format::{PolygonMesh, ply};
use mesotex::mesh::reading::{CleaningOptions, clean, parse, read};
use mesotex::mesh::{TriangleMesh, shapes, write_mesh};
use mesotex::progress::Progress;
use mesotex::random;
use rand::Rng;

fn mesotex(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs a command that must succeed; its JSON report.
fn report(arguments: &[&str], folder: &Path) -> serde_json::Value {
    let output = mesotex(&[arguments, &["--json"]].concat(), folder);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Runs a command that must fail with a code; what it says.
fn refusal(arguments: &[&str], code: i32, folder: &Path) -> String {
    let output = mesotex(arguments, folder);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn with_torus() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("torus.obj");
    write_mesh(&path, &shapes::torus(40, 20, 1.0, 0.4)).unwrap();
    (folder, path)
}

#[test]
fn retiling_meets_the_count_and_keeps_the_shape() {
    let (folder, _) = with_torus();
    let figures = report(
        &["mesh", "torus.obj", "-o", "even.ply", "--vertices", "3000"],
        folder.path(),
    );
    assert_eq!(figures["vertices"], 3000);
    assert_eq!(figures["euler_characteristic"], 0);
    assert!(figures["evenness"]["edge_variation"].as_f64().unwrap() < 0.2);
    assert!(
        figures["evenness"]["smallest_angle_of_99_percent"]
            .as_f64()
            .unwrap()
            > 20.0
    );
    assert!(figures["hausdorff_over_diagonal"].as_f64().unwrap() < 0.01);
    let even = read(&folder.path().join("even.ply"), Progress::silent()).unwrap();
    assert_eq!(even.mesh.positions.len(), 3000);
    assert!(even.report.is_sound());
}

#[test]
fn every_format_that_is_written_reads_back() {
    let (folder, _) = with_torus();
    let torus = shapes::torus(40, 20, 1.0, 0.4);
    for name in ["a.ply", "a.obj", "a.glb"] {
        report(&["mesh", "torus.obj", "-o", name], folder.path());
        let back = read(&folder.path().join(name), Progress::silent()).unwrap();
        assert_eq!(back.mesh, torus, "{name}");
        assert_eq!(back.report.welded_vertices, 0);
        for (normal, position) in back.normals.unwrap().iter().zip(&torus.positions) {
            let axis = position.truncate().normalize().extend(0.0);
            assert!(normal.dot((*position - axis).normalize()) > 0.99);
        }
    }
}

#[test]
fn a_field_is_written_reported_drawn_and_read_as_a_guide() {
    let (folder, _) = with_torus();
    let at = folder.path();
    let guide = r#"{"guides": [{"vertex": 0, "direction": [0, 0, 1]}, {"point": [-1.4, 0, 0], "direction": [0, 1, 0]}]}"#;
    fs::write(at.join("guide.json"), guide).unwrap();
    let figures = report(
        &[
            "mesh",
            "torus.obj",
            "-o",
            "field.ply",
            "--orient",
            "--guide",
            "guide.json",
            "--levels",
            "2",
            "--report",
            "report.json",
            "--pictures",
            "look",
        ],
        at,
    );
    assert_eq!(figures["singularity_index_sum"], 0);
    assert!(at.join("report.json").is_file());
    for name in ["field", "distortion", "level0", "level1"] {
        assert!(at.join(format!("look/{name}.png")).is_file());
        assert!(
            ply::read(&at.join(format!("look/{name}.ply")))
                .unwrap()
                .column("red")
                .is_some()
        );
    }
    let field = read(&at.join("field.ply"), Progress::silent())
        .unwrap()
        .orientation
        .unwrap();
    assert!((field[0] - glam::Vec3::Z).length() < 1e-4, "{}", field[0]);
    report(&["mesh", "field.ply", "-o", "again.ply", "--orient"], at);
    let again = read(&at.join("again.ply"), Progress::silent())
        .unwrap()
        .orientation
        .unwrap();
    for (one, other) in field.iter().zip(&again) {
        assert!((*one - *other).length() < 1e-4);
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    let (folder, _) = with_torus();
    let bytes = |threads: &str| {
        let name = format!("t{threads}.ply");
        let arguments = [
            "mesh",
            "torus.obj",
            "-o",
            &name,
            "--vertices",
            "5000",
            "--orient",
            "--threads",
            threads,
        ];
        report(&arguments, folder.path());
        fs::read(folder.path().join(name)).unwrap()
    };
    let one = bytes("1");
    assert!(one == bytes("2") && one == bytes("8"));
}

#[test]
fn cosines_along_edges_are_no_worse_under_their_own_energy() {
    let (folder, _) = with_torus();
    let figures = |energy: &str| {
        let words = [
            "mesh",
            "torus.obj",
            "-o",
            "x.ply",
            "--orient",
            "--field-energy",
            energy,
        ];
        let told = report(&words, folder.path());
        assert_eq!(told["singularity_index_sum"], 0);
        ["field_energy", "field_cosine"].map(|name| told[name].as_f64().unwrap())
    };
    let ([least, before], [energy, after]) = (figures("dirichlet"), figures("cosine"));
    assert!(after >= before && after <= 1.0, "{before} → {after}");
    assert!(energy >= least * (1.0 - 1e-9), "{least} → {energy}");
}

#[test]
fn bad_options_and_guides_are_refused() {
    let (folder, _) = with_torus();
    let at = folder.path();
    let refused = |more: &[&str], code: i32| {
        refusal(
            &[&["mesh", "torus.obj", "-o", "x.ply"], more].concat(),
            code,
            at,
        )
    };
    for (arguments, said) in [
        (&["--vertices", "99"][..], "100 to 20,000,000"),
        (&["--vertices", "20000001"], "--vertices"),
        (&["--specks", "1"], "--specks"),
        (&["--crease", "0"], "--crease"),
        (&["--texel", "nan", "--orient"], "--texel"),
        (&["--levels", "0", "--orient"], "--levels"),
        (&["--direction", "0,0,0", "--orient"], "--direction"),
    ] {
        let text = refused(arguments, 2);
        assert!(text.contains(said), "{arguments:?}: {text}");
    }
    for (guide, said) in [
        (
            r#"{"vertex": 800, "direction": [1, 0, 0]}"#,
            "below 800 vertices",
        ),
        (
            r#"{"vertex": 0, "direction": [1, 0, 0]}"#,
            "is perpendicular to the surface at vertex 0",
        ),
        (r#"{"vertex": 0, "direction": [0, 0, 0]}"#, "direction"),
        (r#"{"direction": [1, 0, 0]}"#, "\"vertex\" or \"point\""),
    ] {
        fs::write(at.join("guide.json"), format!("{{\"guides\": [{guide}]}}")).unwrap();
        let text = refused(&["--orient", "--guide", "guide.json"], 1);
        assert!(text.contains(said) && text.contains("guide.json"), "{text}");
    }
    assert!(refused(&["--orient", "--align", "uv"], 2).contains("texture coordinates"));
    assert!(!at.join("x.ply").exists());
    let text = refusal(&["mesh", "torus.obj", "-o", "x.xyz"], 2, at);
    assert!(text.contains(".ply, .obj or .glb"));
    assert!(refusal(&["mesh", "none.obj", "-o", "x.ply"], 1, at).contains("none.obj"));
}

#[test]
fn strict_refuses_what_repair_would_mend() {
    let folder = tempfile::tempdir().unwrap();
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n";
    fs::write(folder.path().join("fan.obj"), text).unwrap();
    let figures = report(&["mesh", "fan.obj", "-o", "a.ply"], folder.path());
    assert_eq!(figures["repairs"]["cut_edges"], 1);
    let said = refusal(
        &["mesh", "fan.obj", "-o", "b.ply", "--strict"],
        1,
        folder.path(),
    );
    assert!(
        said.contains("edge 0–1 of 3 triangles") && said.contains("--strict"),
        "{said}"
    );
}

#[test]
fn a_triangle_and_parts_far_apart_in_scale_are_prepared() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let figures = report(
        &["mesh", "one.obj", "-o", "one.ply", "--report", "one.json"],
        at,
    );
    assert_eq!(figures["levels"].as_array().unwrap().len(), 4);
    let mut parts = shapes::icosphere(3);
    let small = shapes::icosphere(1);
    let base = parts.positions.len() as u32;
    parts.positions.extend(
        small
            .positions
            .iter()
            .map(|p| *p * 1e-4 + glam::Vec3::X * 2.0),
    );
    parts
        .triangles
        .extend(small.triangles.iter().map(|t| t.map(|v| v + base)));
    write_mesh(&at.join("parts.obj"), &parts).unwrap();
    let figures = report(
        &[
            "mesh",
            "parts.obj",
            "-o",
            "parts.ply",
            "--report",
            "parts.json",
        ],
        at,
    );
    assert!(
        figures["warnings"][0]
            .as_str()
            .unwrap()
            .contains("--specks")
    );
    let dropped = report(
        &["mesh", "parts.obj", "-o", "p.ply", "--specks", "0.001"],
        at,
    );
    assert_eq!(
        (&dropped["repairs"]["specks"], &dropped["components"]),
        (&1.into(), &1.into())
    );
}

/// The bytes of a small sound file of each format.
fn sound_files() -> Vec<(&'static str, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let sphere = shapes::icosphere(1);
    let mut files = Vec::new();
    for name in ["a.ply", "a.obj", "a.glb"] {
        let path = folder.path().join(name);
        write_mesh(&path, &sphere).unwrap();
        files.push((name, fs::read(path).unwrap()));
    }
    files.push(("a.off", off_of(&sphere).into_bytes()));
    files.push(("text.stl", stl_of(&sphere).into_bytes()));
    files.push(("binary.stl", binary_stl_of(&sphere)));
    files
}

fn off_of(mesh: &TriangleMesh) -> String {
    let mut text = format!("OFF\n{} {} 0\n", mesh.positions.len(), mesh.triangles.len());
    for p in &mesh.positions {
        text += &format!("{} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("3 {a} {b} {c}\n");
    }
    text
}

fn stl_of(mesh: &TriangleMesh) -> String {
    let mut text = "solid sphere\n".to_owned();
    for triangle in 0..mesh.triangles.len() {
        text += "facet normal 0 0 0\nouter loop\n";
        for p in mesh.corners(triangle) {
            text += &format!("vertex {} {} {}\n", p.x, p.y, p.z);
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid sphere\n"
}

fn binary_stl_of(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for triangle in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        for value in mesh.corners(triangle).iter().flat_map(|p| p.to_array()) {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn sound_files_of_every_format_hold_the_sphere() {
    for (name, bytes) in sound_files() {
        let file: PolygonMesh = parse(&bytes, Path::new(name)).unwrap();
        let user = clean(file, &CleaningOptions::default(), Progress::silent()).unwrap();
        assert_eq!(
            (user.mesh.positions.len(), user.mesh.triangles.len()),
            (42, 80),
            "{name}"
        );
    }
}

/// A thousand damaged copies of each format are read or refused: no panic, no vertex or triangle
/// that the bytes could not hold.
#[test]
fn damage_is_survived() {
    for (name, sound) in sound_files() {
        let (mut read, mut refused) = (0, 0);
        for trial in 0..1000 {
            let mut random = random::stream(11, name, 0, trial);
            let mut bytes = sound.clone();
            for _ in 0..random.gen_range(1..6) {
                let at = random.gen_range(0..bytes.len());
                match random.gen_range(0..4) {
                    0 => bytes[at] = random.r#gen(),
                    1 => bytes[at] ^= 1 << random.gen_range(0..8),
                    2 => bytes.truncate(at.max(1)),
                    _ => bytes.insert(at, b"0123456789 -.e\n"[random.gen_range(0..15)]),
                }
            }
            match parse(&bytes, Path::new(name))
                .and_then(|file| clean(file, &CleaningOptions::default(), Progress::silent()))
            {
                Ok(user) => {
                    assert!(user.mesh.triangles.len() <= bytes.len());
                    read += 1;
                }
                Err(_) => refused += 1,
            }
        }
        assert!(read + refused == 1000 && refused > 0, "{name}: {read} read");
    }
}
