//! The whole chain as a user runs it: a scene, its record, its bytes, and what happens to files
//! that are cut, mixed up or in the way.

mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use program::{copy_of, files, refuse, succeed, write_obj};
use tempfile::TempDir;

const SCENE: &str = r#"
name = "small"
[bake]
preset = "weave"
size = 32
views = "fibonacci:9"
lights = "fibonacci:9"
samples = 1
[textons]
textons = 24
images = 20
levels = 2
[knn]
k = 4
[mesh]
input = "kettlebell.ply"
vertices = 2000
[synth]
levels = 2
k = 4
[[render]]
sweep = "light-azimuth"
frames = 2
size = "64x48"
"#;

fn new_scene(threads: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_obj(&folder.path().join("kettlebell.obj"), 2000);
    let scene = SCENE.replace("kettlebell.ply", "kettlebell.obj");
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    succeed(folder.path(), &["run", "scene.toml", "--threads", threads]);
    folder
}

/// One finished scene that the tests below read (and copy before they change it).
fn finished() -> &'static Path {
    static FINISHED: OnceLock<TempDir> = OnceLock::new();
    FINISHED.get_or_init(|| new_scene("2")).path()
}

#[test]
fn the_same_bytes_come_out_at_any_thread_count() {
    let (one, eight) = (new_scene("1"), new_scene("8"));
    let (mut one, mut eight) = (files(one.path()), files(eight.path()));
    for folder in [&mut one, &mut eight] {
        // It holds times and inodes of files.
        assert!(folder.remove(Path::new("run.json")).is_some());
        // It holds times of stages.
        assert!(folder.remove(Path::new("small.report.html")).is_some());
    }
    assert!(one.keys().eq(eight.keys()));
    assert!(one.keys().any(|path| path.ends_with("frame.0002.exr")));
    for (path, bytes) in &one {
        assert!(*bytes == eight[path], "{} differs", path.display());
    }
}

#[test]
fn a_scene_runs_again_only_what_changed() {
    let folder = copy_of(finished());
    let again = succeed(folder.path(), &["run", "scene.toml"]);
    assert_eq!(again.matches("skipped").count(), 7, "{again}");
    let scene = fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    fs::write(
        folder.path().join("scene.toml"),
        scene.replace("frames = 2", "frames = 1"),
    )
    .unwrap();
    let plan = succeed(folder.path(), &["run", "scene.toml", "--dry-run"]);
    assert!(
        plan.contains("# render frames: would run\nmesotex render"),
        "{plan}"
    );
    assert_eq!(plan.matches("skipped").count(), 6, "{plan}");
    fs::write(
        folder.path().join("scene.toml"),
        scene.replace("k = 4\n[mesh]", "k = 3\n[mesh]"),
    )
    .unwrap();
    let plan = succeed(folder.path(), &["run", "scene.toml", "--dry-run"]);
    assert_eq!(
        plan.matches("would run").count(),
        3,
        "knn, synth and render:\n{plan}"
    );
}

#[test]
fn a_scene_with_an_unknown_option_is_refused() {
    let folder = copy_of(finished());
    let path = folder.path().join("scene.toml");
    let scene = fs::read_to_string(&path).unwrap();
    fs::write(&path, scene.replace("[knn]", "[knn]\nneighbours = 3")).unwrap();
    let error = refuse(folder.path(), &["run", "scene.toml"], 2);
    assert!(error.contains("--neighbours"), "{error}");
}

#[test]
fn info_describes_every_file_of_the_chain() {
    for (file, says) in [
        ("small.sample", "81 images"),
        ("small.textons.npz", "24"),
        ("small.space.npz", "24"),
        ("small.knn.npz", "4"),
        ("small.mesh.ply", "triangles"),
        ("small.map.ply", "2000 vertices"),
        ("small.frames/frame.0001.exr", "64 × 48"),
        ("small.sample/radiance.npy", "[9, 9, 32, 32, 3]"),
    ] {
        let text = succeed(finished(), &["info", file]);
        assert!(text.contains(says), "{file}: {text}");
        let json = succeed(finished(), &["info", file, "--json"]);
        assert!(serde_json::from_str::<serde_json::Value>(&json).unwrap()["kind"].is_string());
    }
    let text = succeed(
        finished(),
        &["info", "small.map.ply", "--against", "small.space.npz"],
    );
    assert!(text.contains("belongs"), "{text}");
}

/// The commands that read each file of the chain.
const READERS: [(&str, &[&str]); 6] = [
    (
        "small.sample/radiance.npy",
        &[
            "textons",
            "small.sample",
            "-o",
            "new",
            "--textons",
            "9",
            "--levels",
            "1",
        ],
    ),
    (
        "small.sample/btf.json",
        &["render", "small.sample", "small.map.ply", "-o", "new"],
    ),
    (
        "small.textons.npz",
        &["gram", "small.textons.npz", "-o", "new"],
    ),
    ("small.space.npz", &["knn", "small.space.npz", "-o", "new"]),
    (
        "small.knn.npz",
        &[
            "synth",
            "small.space.npz",
            "small.knn.npz",
            "small.mesh.ply",
            "-o",
            "new",
            "--k",
            "2",
        ],
    ),
    (
        "small.map.ply",
        &["render", "small.sample", "small.map.ply", "-o", "new"],
    ),
];

#[test]
fn cut_files_are_refused_by_name_and_nothing_is_written() {
    for (file, words) in READERS {
        let folder = copy_of(finished());
        let path = folder.path().join(file);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let before = files(folder.path());
        let error = refuse(folder.path(), words, 1);
        assert!(
            error.contains(file.split('/').next().unwrap()),
            "{file}: {error}"
        );
        assert!(
            files(folder.path()).keys().eq(before.keys()),
            "{file} left something behind"
        );
        fs::remove_file(&path).unwrap();
        refuse(folder.path(), words, 1);
    }
}

#[test]
fn radiance_that_is_not_a_number_is_found_by_place() {
    let folder = copy_of(finished());
    let path = folder.path().join("small.sample/radiance.npy");
    let mut bytes = fs::read(&path).unwrap();
    let at = bytes.len() - 2 * 3 * 32;
    for (bad, says) in [([0x00, 0x7e], "NaN"), ([0x00, 0xbc], "-1")] {
        bytes[at..at + 2].copy_from_slice(&bad);
        fs::write(&path, &bytes).unwrap();
        let error = refuse(folder.path(), READERS[0].1, 1);
        assert!(
            error.contains(says) && error.contains("row 31, column 0"),
            "{error}"
        );
    }
    let error = refuse(folder.path(), &["info", "small.sample"], 1);
    assert!(error.contains("radiance.npy"), "{error}");
}

#[test]
fn files_of_different_runs_are_refused_unless_forced() {
    let folder = copy_of(finished());
    succeed(
        folder.path(),
        &[
            "textons",
            "small.sample",
            "-o",
            "b.textons.npz",
            "--textons",
            "20",
            "--levels",
            "2",
        ],
    );
    succeed(
        folder.path(),
        &["gram", "b.textons.npz", "-o", "b.space.npz"],
    );
    let mixed = [
        "synth",
        "b.space.npz",
        "small.knn.npz",
        "small.mesh.ply",
        "-o",
        "b.map.ply",
        "--levels",
        "2",
        "--k",
        "4",
    ];
    let error = refuse(folder.path(), &mixed, 1);
    assert!(error.contains("--force"), "{error}");
    let forced: Vec<&str> = mixed.iter().copied().chain(["--force"]).collect();
    succeed(folder.path(), &forced);
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
            "fibonacci:4",
            "--lights",
            "fibonacci:4",
            "-o",
            "c.sample",
        ],
    );
    let error = refuse(
        folder.path(),
        &[
            "render",
            "c.sample",
            "small.map.ply",
            "-o",
            "new",
            "--force",
        ],
        1,
    );
    assert!(
        error.contains("16") && error.contains("32"),
        "a size is not to be forced: {error}"
    );
}

#[test]
fn a_map_whose_labels_disagree_with_its_space_is_found() {
    let folder = copy_of(finished());
    let path = folder.path().join("small.map.ply");
    let mut map = mesotex::maps::SurfaceTextonMap::read(&path).unwrap();
    map.textons[7].0 ^= 1;
    map.write(&path).unwrap();
    let error = refuse(
        folder.path(),
        &["info", "small.map.ply", "--against", "small.space.npz"],
        1,
    );
    assert!(error.contains("vertex 7"), "{error}");
}

#[test]
fn impossible_usage_is_refused_before_work_begins() {
    let gram = |extra: &[&str]| -> Vec<String> {
        ["gram", "small.textons.npz"]
            .iter()
            .chain(extra)
            .map(ToString::to_string)
            .collect()
    };
    for (words, says) in [
        (gram(&["-o", "new", "--threads", "0"]), "threads"),
        (gram(&["-o", "small.textons.npz"]), "also an input"),
        (gram(&["-o", "nowhere/new"]), "nowhere"),
        (gram(&["-o", "scene.toml/new"]), "scene.toml"),
        (gram(&["-o", "new", "--unknown"]), "--unknown"),
    ] {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let error = refuse(finished(), &words, 2);
        assert!(error.contains(says), "{words:?}: {error}");
    }
}

#[cfg(unix)]
#[test]
fn an_output_that_another_run_writes_is_refused() {
    let folder = copy_of(finished());
    let lock = mesotex::format::OutputLock::acquire(&folder.path().join("new")).unwrap();
    let words = ["gram", "small.textons.npz", "-o", "new"];
    let error = refuse(folder.path(), &words, 1);
    assert!(error.contains("another run"), "{error}");
    drop(lock);
    succeed(folder.path(), &words);
}

/// A file-size limit stands in for a full disk: the write fails in the middle.
#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_and_leaves_nothing() {
    let folder = copy_of(finished());
    let before = files(folder.path());
    let script = format!(
        "trap '' XFSZ; ulimit -f 4; exec {} gram small.textons.npz -o new",
        env!("CARGO_BIN_EXE_mesotex")
    );
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("new: cannot write"), "{error}");
    assert!(files(folder.path()).keys().eq(before.keys()));
}

#[cfg(unix)]
#[test]
fn a_reader_that_went_away_is_no_panic() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .args(["info", "small.sample"])
        .current_dir(finished())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.contains("standard output") && !error.contains("panicked"),
        "{error}"
    );
}
