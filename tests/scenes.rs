//! Scenes: checked whole before they run, run again as far as something changed, told as they go.

mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use program::{copy_of, files, mesotex, refuse, succeed, write_capture, write_obj};
use tempfile::TempDir;

/// A scene of which every stage reads something beside its main input.
const SCENE: &str = r#"
name = "small"
output = "out"

[bake]
preset = "weave"
size = 16
views = "views.csv"
lights = "fibonacci:4"
samples = 1
preview = "out/preview.png"
surface = "out/surface.npz"

[textons]
textons = 8
images = 9
levels = 2
report = "out/textons.json"
montage = "out/montage.png"

[knn]
k = 3
neighborhood = 3

[mesh]
input = "k.gltf"
guide = "guide.json"
orient = true
pictures = "out/pictures"

[synth]
levels = 2
k = 2
report = "out/synth.json"
pictures = "out/drawn"

[[render]]
sweep = "sweep.csv"
size = "32x24"
environment = "sky.hdr"
environment-lights = 4

[[render]]
name = "path"
camera-path = "path.csv"
size = "32x24"
"#;

const STAGES: [&str; 7] = [
    "bake",
    "textons",
    "gram",
    "knn",
    "mesh",
    "synth",
    "render frames",
];

/// The built-in mesh as glTF with its buffer in a file of its own.
fn write_gltf(folder: &Path) {
    let mesh = mesotex::mesh::builtin::kettlebell(400);
    let mut bytes: Vec<u8> = mesh
        .positions
        .iter()
        .flat_map(|p| p.to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    let points = bytes.len();
    bytes.extend(
        mesh.triangles
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes()),
    );
    let (low, high) = mesh
        .positions
        .iter()
        .fold((mesh.positions[0], mesh.positions[0]), |(low, high), p| {
            (low.min(*p), high.max(*p))
        });
    let text = serde_json::json!({
        "asset": {"version": "2.0"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "images": [{"uri": "skin.png"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3",
             "min": low.to_array(), "max": high.to_array()},
            {"bufferView": 1, "componentType": 5125, "count": 3 * mesh.triangles.len(), "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points},
            {"buffer": 0, "byteOffset": points, "byteLength": bytes.len() - points}
        ],
        "buffers": [{"uri": "k.bin", "byteLength": bytes.len()}]
    });
    fs::write(folder.join("k.gltf"), text.to_string()).unwrap();
    fs::write(folder.join("k.bin"), bytes).unwrap();
    mesotex::format::image::write_png(&folder.join("skin.png"), 2, 2, &[9; 12]).unwrap();
}

fn write_sky(path: &Path, grey: u8) {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    for pixel in 0..32u8 {
        bytes.extend([grey, grey / 2 + pixel, grey, 128]);
    }
    fs::write(path, bytes).unwrap();
}

fn new_scene() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(root.path().join(name), text).unwrap();
    write_gltf(root.path());
    write_sky(&root.path().join("sky.hdr"), 100);
    write(
        "views.csv",
        "theta_deg,phi_deg\n0,0\n30,0\n30,120\n30,240\n60,60\n",
    );
    write(
        "guide.json",
        "{\"guides\": [{\"vertex\": 7, \"direction\": [1, 0, 0.5]}]}",
    );
    write("sweep.csv", "camera_azimuth\n0\n40\n");
    write("path.csv", "camera_x,camera_y,camera_z\n0,0.5,6\n");
    write("scene.toml", SCENE);
    root
}

/// One finished scene, copied by the tests that change it.
fn finished() -> &'static Path {
    static FINISHED: OnceLock<TempDir> = OnceLock::new();
    let root = FINISHED.get_or_init(|| {
        let root = new_scene();
        succeed(root.path(), &["run", "scene.toml"]);
        root
    });
    root.path()
}

/// The stages that a run would repeat.
fn stale(folder: &Path) -> Vec<String> {
    let before = files(folder);
    let plan = succeed(folder, &["run", "scene.toml", "--dry-run"]);
    assert!(files(folder) == before, "a dry run wrote something");
    let lines = plan
        .lines()
        .filter_map(|line| line.strip_prefix("# ")?.strip_suffix(": would run"));
    lines.map(str::to_owned).collect()
}

#[test]
fn every_byte_that_a_stage_reads_or_wrote_counts() {
    let scene = copy_of(finished());
    // The copy has other times and inodes: its content is compared.
    assert_eq!(stale(scene.path()), [""; 0]);
    for (file, first) in [
        ("views.csv", "bake"),
        ("out/small.sample/radiance.npy", "bake"),
        ("out/preview.png", "bake"),
        ("out/surface.npz", "bake"),
        ("out/textons.json", "textons"),
        ("out/montage.png", "textons"),
        ("out/small.space.npz", "gram"),
        ("k.bin", "mesh"),
        ("skin.png", "mesh"),
        ("guide.json", "mesh"),
        ("out/pictures/field.png", "mesh"),
        ("out/synth.json", "synth"),
        ("out/drawn.label.png", "synth"),
        ("sweep.csv", "render frames"),
        ("sky.hdr", "render frames"),
        ("out/small.frames/frame.0002.exr", "render frames"),
        ("out/small.frames/frame.0001.png", "render frames"),
        ("out/small.frames/contact.png", "render frames"),
        ("path.csv", "render path"),
        ("out/small.path/contact.png", "render path"),
    ] {
        let path = scene.path().join(file);
        let kept = fs::read(&path).unwrap();
        let mut changed = kept.clone();
        let last = changed.len() - 1;
        changed[last] ^= 1;
        fs::write(&path, changed).unwrap();
        assert_eq!(
            stale(scene.path()).first().map(String::as_str),
            Some(first),
            "{file} changed"
        );
        if file.starts_with("out/") {
            fs::remove_file(&path).unwrap();
            assert_eq!(
                stale(scene.path()).first().map(String::as_str),
                Some(first),
                "{file} deleted"
            );
        }
        fs::write(&path, kept).unwrap();
    }
    assert_eq!(stale(scene.path()), [""; 0]);
}

/// Outputs that were written over are made again, whatever they hold now.
#[test]
fn outputs_changed_beyond_recognition_are_made_again() {
    let scene = copy_of(finished());
    let spoilt = [
        "out/small.sample/btf.json",
        "out/small.space.npz",
        "out/small.mesh.ply",
        "out/drawn.label.png",
        "out/small.frames/frame.0001.exr",
        "out/small.frames/contact.png",
    ];
    let whole: Vec<_> = spoilt
        .iter()
        .map(|file| fs::read(scene.path().join(file)).unwrap())
        .collect();
    for file in spoilt {
        fs::write(scene.path().join(file), "spoilt").unwrap();
    }
    succeed(scene.path(), &["run", "scene.toml"]);
    for (file, bytes) in spoilt.iter().zip(whole) {
        let found = fs::read(scene.path().join(file)).unwrap();
        let (now, before) = (found.len(), bytes.len());
        assert!(found == bytes, "{file}: {now} bytes, {before} before");
    }
    // What a user put into the sample's folder keeps the folder from being replaced.
    fs::write(scene.path().join("out/small.sample/notes.txt"), "mine").unwrap();
    fs::write(scene.path().join("out/small.sample/radiance.npy"), "spoilt").unwrap();
    let error = refuse(scene.path(), &["run", "scene.toml"], 2);
    assert!(error.contains("`notes.txt`"), "{error}");
    assert!(scene.path().join("out/small.sample/btf.json").exists());
}

#[test]
fn a_change_runs_what_depends_on_it_and_nothing_else() {
    let scene = copy_of(finished());
    write_sky(&scene.path().join("sky.hdr"), 50);
    let report = succeed(scene.path(), &["run", "scene.toml"]);
    assert_eq!(
        report.matches("skipped, nothing changed").count(),
        STAGES.len(),
        "{report}"
    );
    assert_eq!(stale(scene.path()), [""; 0]);
}

#[test]
fn the_images_behind_a_capture_count() {
    let root = tempfile::tempdir().unwrap();
    write_capture(&root.path().join("cap"));
    write_obj(&root.path().join("k.obj"), 300);
    let scene = "name = \"c\"\nsurface = \"k.obj\"\n[import]\npath = \"cap\"\ntileable = true\n\
        [textons]\ntextons = 4\nimages = 3\nlevels = 1\n[knn]\nk = 2\nneighborhood = 3\n[synth]\nk = 2\n";
    fs::write(root.path().join("scene.toml"), scene).unwrap();
    succeed(root.path(), &["run", "scene.toml"]);
    assert_eq!(stale(root.path()), [""; 0]);
    mesotex::format::image::write_png(&root.path().join("cap/3.png"), 16, 16, &[77; 256]).unwrap();
    assert_eq!(stale(root.path())[0], "import");
    succeed(root.path(), &["run", "scene.toml"]);
    assert_eq!(stale(root.path()), [""; 0]);
}

/// A scene with a fault in every kind of place; the line of each, and a word of what is said.
#[test]
fn all_faults_of_a_scene_are_told_at_once_before_anything_runs() {
    let scene = new_scene();
    let text = SCENE
        .replace("views = \"views.csv\"", "veiws = \"views.csv\"")
        .replace("size = 16", "size = \"large\"")
        .replace(
            "levels = 2\nreport = \"out/textons.json\"",
            "levels = 99\nthreads = 4\nshard = \"0/2\"",
        )
        .replace("neighborhood = 3", "neighborhood = 4")
        .replace("k.gltf", "kk.gltf")
        .replace("orient = true", "orient = 3")
        .replace("name = \"path\"", "name = \"frames\"")
        .replace("[synth]", "[synht]\n[synth]")
        .replace(
            "output = \"out\"",
            "output = \"out\"\nsample = \"other.sample\"",
        );
    fs::write(scene.path().join("scene.toml"), &text).unwrap();
    let before = files(scene.path());
    for words in [
        &["run", "scene.toml"][..],
        &["run", "scene.toml", "--dry-run"],
    ] {
        let error = refuse(scene.path(), words, 2);
        for (written, says) in [
            ("veiws", "did you mean `views`?"),
            ("size = \"large\"", "large"),
            ("levels = 99", "--levels: 99"),
            ("threads = 4", "not allowed in a stage"),
            ("shard = ", "`mesotex plan --shards` splits stages"),
            ("neighborhood = 4", "odd width"),
            ("input = \"kk.gltf\"", "kk.gltf does not exist"),
            ("orient = 3", "true or false"),
            ("[synht]", "did you mean `synth`?"),
        ] {
            let line = text
                .lines()
                .position(|line| line.contains(written))
                .unwrap()
                + 1;
            let told = error
                .lines()
                .find(|told| told.contains(&format!("line {line}: ")));
            assert!(
                told.is_some_and(|told| told.contains(says)),
                "line {line}, {written}:\n{error}"
            );
        }
        assert!(error.contains("2 sources of the sample"), "{error}");
        assert!(
            error.contains("is written by line"),
            "two sequences of one name:\n{error}"
        );
        assert!(files(scene.path()) == before, "something was written");
    }
}

#[test]
fn a_missing_file_is_a_fault_of_the_data() {
    let scene = new_scene();
    fs::remove_file(scene.path().join("sky.hdr")).unwrap();
    let error = refuse(scene.path(), &["run", "scene.toml"], 1);
    assert!(
        error.contains("[render] environment: sky.hdr does not exist"),
        "{error}"
    );
    assert!(!scene.path().join("out").exists());
}

#[test]
fn one_stage_must_not_write_over_what_another_reads() {
    let scene = new_scene();
    let text = SCENE.replace("out/synth.json", "guide.json");
    fs::write(scene.path().join("scene.toml"), text).unwrap();
    let error = refuse(scene.path(), &["run", "scene.toml"], 1);
    assert!(
        error.contains("guide.json would be written, but is an input"),
        "{error}"
    );
}

#[test]
fn a_dry_run_writes_nothing_and_its_lines_can_be_pasted() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("my scenes");
    fs::create_dir(&folder).unwrap();
    for (path, bytes) in files(new_scene().path()) {
        fs::write(folder.join(path), bytes).unwrap();
    }
    let text = SCENE
        .replace("\"out\"", "\"out put\"")
        .replace("out/", "out put/");
    let text = text.replace("output =", "seed = 3\noutput =");
    fs::write(folder.join("scene.toml"), text).unwrap();
    let before = files(root.path());
    let plan = succeed(root.path(), &["run", "my scenes/scene.toml", "--dry-run"]);
    assert!(files(root.path()) == before);
    assert!(!folder.join("out put").exists());
    assert!(
        plan.contains("cd 'my scenes'") && plan.contains("--seed 3"),
        "{plan}"
    );
    // Pasted into a shell, the plan does what the run does.
    fs::create_dir(folder.join("out put")).unwrap();
    let bin = Path::new(env!("CARGO_BIN_EXE_mesotex")).parent().unwrap();
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let pasted = Command::new("sh")
        .args(["-e", "-c", &plan])
        .env("PATH", path)
        .current_dir(root.path())
        .output()
        .unwrap();
    assert!(
        pasted.status.success(),
        "{}",
        String::from_utf8_lossy(&pasted.stderr)
    );
    let by_hand = files(&folder.join("out put"));
    fs::remove_dir_all(folder.join("out put")).unwrap();
    succeed(root.path(), &["run", "my scenes/scene.toml"]);
    let mut by_run = files(&folder.join("out put"));
    for by_run_alone in ["run.json", "small.view.html", "small.report.html"] {
        assert!(by_run.remove(Path::new(by_run_alone)).is_some());
    }
    for report in ["textons.json", "synth.json"] {
        // Reports hold times.
        by_run.remove(Path::new(report));
    }
    for (path, bytes) in by_run {
        assert!(by_hand[&path] == bytes, "{}", path.display());
    }
}

#[test]
fn stages_are_told_as_they_finish_and_when_a_later_one_fails() {
    let scene = new_scene();
    // A sky that is no image: found by the stage that reads it.
    fs::write(scene.path().join("sky.hdr"), "no sky").unwrap();
    let output = mesotex(scene.path(), &["run", "scene.toml"]);
    let told = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1));
    for stage in &STAGES[..6] {
        assert!(
            told.lines().any(|line| line.starts_with(stage)),
            "{stage}:\n{told}"
        );
    }
    let json = mesotex(scene.path(), &["run", "scene.toml", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["failed"], "render frames");
    assert_eq!(json["stages"].as_array().map(Vec::len), Some(6));
}

/// A reader at the end of a pipe sees the first stage's report before the last stage is done.
#[test]
fn reports_reach_a_pipe_while_the_scene_runs() {
    use std::io::{BufRead, BufReader};
    let scene = new_scene();
    let mut child = Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .args(["run", "scene.toml"])
        .current_dir(scene.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    // The plan stands before the first stage.
    let mut stages = lines
        .map(Result::unwrap)
        .filter(|line| !line.starts_with(' '));
    assert!(stages.next().unwrap().starts_with("plan: "));
    assert!(stages.next().unwrap().starts_with("bake"));
    assert!(!scene.path().join("out/small.path/contact.png").exists());
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_users_file_called_run_json_is_not_written_over() {
    let scene = new_scene();
    fs::create_dir(scene.path().join("out")).unwrap();
    let path = scene.path().join("out/run.json");
    fs::write(&path, "{\"distance_km\": 10}").unwrap();
    let error = refuse(scene.path(), &["run", "scene.toml"], 1);
    assert!(error.contains("no record of `mesotex run`"), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "{\"distance_km\": 10}");
}

#[test]
fn a_damaged_record_is_said_and_begun_anew() {
    let scene = copy_of(finished());
    let path = scene.path().join("out/run.json");
    let text = fs::read(&path).unwrap();
    fs::write(&path, &text[..text.len() / 2]).unwrap();
    let output = mesotex(scene.path(), &["run", "scene.toml"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() && said.contains("run.json"),
        "{said}"
    );
    assert_eq!(stale(scene.path()), [""; 0]);
}

#[test]
fn texts_with_byte_order_marks_are_read() {
    let folder = new_scene();
    for name in [
        "scene.toml",
        "views.csv",
        "guide.json",
        "sweep.csv",
        "path.csv",
    ] {
        let path = folder.path().join(name);
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, format!("\u{feff}{}", text.replace('\n', "\r\n"))).unwrap();
    }
    succeed(folder.path(), &["run", "scene.toml", "--dry-run"]);
    succeed(folder.path(), &["run", "scene.toml"]);
}
