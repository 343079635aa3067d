//! Scenes with a `[matrix]`: many runs, shared stages once, outputs named after the values.

mod program;

use std::fs;
use std::path::Path;

use program::{files, refuse, small_scene, succeed, write_obj};
use serde_json::Value;
use tempfile::TempDir;

fn sweep() -> String {
    small_scene(
        "bake.preset = [\"weave\", \"knit\"]\n\
         \"mesh.input\" = [\"k.obj\", \"in/bell.obj\"]\n\
         \"synth.seed\" = [0, 3]",
        ["", "report = \"out/textons.json\"\n"],
        "",
    )
}

/// One of its runs as a scene of its own.
fn alone(preset: &str, mesh: &str, seed: u32, name: &str) -> String {
    let sweep = sweep();
    let (head, rest) = sweep.split_once("[matrix]").unwrap();
    let (_, stages) = rest.split_once("[bake]").unwrap();
    let scene = format!("{head}[bake]{stages}");
    scene
        .replace("\"small\"", &format!("\"{name}\""))
        .replace("[bake]", &format!("[bake]\npreset = \"{preset}\""))
        .replace("[mesh]", &format!("[mesh]\ninput = \"{mesh}\""))
        .replace("[synth]", &format!("[synth]\nseed = {seed}"))
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    write_obj(&folder.path().join("k.obj"), 300);
    write_obj(&folder.path().join("in/bell.obj"), 400);
    fs::write(folder.path().join("sweep.toml"), sweep()).unwrap();
    folder
}

fn commands(report: &Value, stage: &str) -> Vec<String> {
    let stages = report["stages"].as_array().unwrap().iter();
    let commands = stages.map(|stage| stage["command"].as_str().unwrap().to_owned());
    commands
        .filter(|command| command.split(' ').nth(1) == Some(stage))
        .collect()
}

#[test]
fn shared_stages_appear_once() {
    let folder = folder();
    let said = succeed(folder.path(), &["run", "sweep.toml", "--dry-run", "--json"]);
    let report: Value = serde_json::from_str(&said).unwrap();
    let counts = ["bake", "textons", "gram", "knn", "mesh", "synth", "render"]
        .map(|stage| commands(&report, stage).len());
    assert_eq!(counts, [2, 2, 2, 2, 2, 8, 8]);
    let synth = commands(&report, "synth");
    assert_eq!(
        synth[3],
        "mesotex synth out/small-weave.space.npz out/small-weave.knn.npz out/small-bell.mesh.ply \
         -o out/small-weave-bell-seed3.map.ply --k=2 --levels=2 --seed 3"
    );
    let textons = commands(&report, "textons");
    assert!(
        textons[1].contains("--report=out/textons-knit.json"),
        "{}",
        textons[1]
    );
    let one = [
        "run",
        "sweep.toml",
        "--dry-run",
        "--json",
        "--only",
        "knit-k-seed3",
    ];
    let report: Value = serde_json::from_str(&succeed(folder.path(), &one)).unwrap();
    assert_eq!(report["stages"].as_array().unwrap().len(), 7);
    let plan = succeed(folder.path(), &["run", "sweep.toml", "--plan"]);
    assert!(
        plan.contains("synth ×8") && plan.contains("pages ×8"),
        "{plan}"
    );
}

#[test]
fn every_run_is_as_a_scene_of_its_own_would_be() {
    let folder = folder();
    succeed(folder.path(), &["run", "sweep.toml", "--until", "synth"]);
    let scene = alone("knit", "in/bell.obj", 3, "alone");
    fs::write(folder.path().join("alone.toml"), scene).unwrap();
    succeed(folder.path(), &["run", "alone.toml", "--until", "synth"]);
    let made = files(&folder.path().join("out"));
    let of = |name: &str| &made[Path::new(name)];
    assert_eq!(
        of("small-knit.sample/radiance.npy"),
        of("alone.sample/radiance.npy")
    );
    assert_eq!(of("small-knit.textons.npz"), of("alone.textons.npz"));
    assert_eq!(of("small-bell.mesh.ply"), of("alone.mesh.ply"));
    assert_eq!(of("small-knit-bell-seed3.map.ply"), of("alone.map.ply"));
    assert_ne!(of("small-knit-bell-seed0.map.ply"), of("alone.map.ply"));
    // Nothing changed, so nothing is run; then what one value reaches.
    let again = succeed(folder.path(), &["run", "sweep.toml", "--until", "synth"]);
    assert_eq!(
        again.matches("skipped, nothing changed").count(),
        18,
        "{again}"
    );
    write_obj(&folder.path().join("k.obj"), 500);
    let again = succeed(folder.path(), &["run", "sweep.toml", "--until", "synth"]);
    assert_eq!(
        again.matches("skipped, nothing changed").count(),
        13,
        "{again}"
    );
}

#[test]
fn every_run_has_pages_and_a_report() {
    let folder = folder();
    let sweep = sweep()
        .replace(", \"knit\"", "")
        .replace(", \"in/bell.obj\"", "");
    fs::write(folder.path().join("sweep.toml"), sweep).unwrap();
    succeed(folder.path(), &["run", "sweep.toml"]);
    for kind in ["view", "report"] {
        for seed in [0, 3] {
            let page = format!("out/small-weave-k-seed{seed}.{kind}.html");
            assert!(folder.path().join(&page).is_file(), "no {page}");
        }
    }
    let again = succeed(folder.path(), &["run", "sweep.toml"]);
    assert!(!again.contains("pages"), "{again}");
    let refused = refuse(folder.path(), &["report", "sweep.toml", "-o", "r.html"], 1);
    assert!(
        refused.contains("2 runs") && refused.contains("--only: weave-k-seed0, weave-k-seed3"),
        "{refused}"
    );
    let one = [
        "report",
        "sweep.toml",
        "-o",
        "r.html",
        "--only",
        "weave-k-seed3",
    ];
    succeed(folder.path(), &one);
    let page = fs::read_to_string(folder.path().join("r.html")).unwrap();
    assert!(page.contains("small-weave-k-seed3") && !page.contains("weave-k-seed0"));
}

#[test]
fn faults_name_key_and_value() {
    let folder = folder();
    let refused = |from: &str, to: &str, code: i32| {
        fs::write(folder.path().join("sweep.toml"), sweep().replace(from, to)).unwrap();
        refuse(folder.path(), &["run", "sweep.toml"], code)
    };
    let missing = refused(
        "\"k.obj\", \"in/bell.obj\"",
        "\"k.obj\", \"gone.obj\", \"in/off.obj\"",
        1,
    );
    for name in ["gone.obj", "in/off.obj"] {
        let says = format!("line 7: [matrix] mesh.input = \"{name}\": {name} does not exist");
        assert!(missing.contains(&says), "{missing}");
    }
    let preset = refused("\"knit\"", "\"knot\"", 2);
    assert!(
        preset.contains("line 6: [matrix] bake.preset = \"knot\""),
        "{preset}"
    );
    let seed = refused("[0, 3]", "[0, -3]", 1);
    assert!(
        seed.contains("line 8: [matrix] synth.seed = -3: `-3`; expected"),
        "{seed}"
    );
    let twice = refused("[mesh]", "[mesh]\ninput = \"k.obj\"", 1);
    assert!(
        twice.contains("line 7: [matrix] mesh.input: line 26 sets this key too"),
        "{twice}"
    );
    fs::write(
        folder.path().join("sweep.toml"),
        sweep().replace("synth.seed", "seed"),
    )
    .unwrap();
    let both = refuse(folder.path(), &["run", "sweep.toml", "--seed", "1"], 2);
    assert!(both.contains("a [matrix] that varies `seed`"), "{both}");
    let only = refuse(
        folder.path(),
        &["run", "sweep.toml", "--only", "weave-k-seed7"],
        2,
    );
    assert!(only.contains("did you mean `weave-k-seed"), "{only}");
}
