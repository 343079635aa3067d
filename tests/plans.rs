//! `mesotex plan`: the tasks of scenes, and what running them makes.

mod program;

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use program::{files, refuse, small_scene, succeed, write_capture, write_obj};
use serde_json::Value;
use tempfile::TempDir;

fn sweep() -> String {
    small_scene(
        "\"mesh.input\" = [\"k.obj\", \"bell.obj\"]",
        ["preset = \"weave\"\n", ""],
        "sweep = \"light-azimuth\"\nframes = 5\n",
    )
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_obj(&folder.path().join("k.obj"), 300);
    write_obj(&folder.path().join("bell.obj"), 400);
    fs::write(folder.path().join("sweep.toml"), sweep()).unwrap();
    folder
}

fn plan(folder: &Path, more: &[&str]) -> Value {
    let words = [&["plan", "sweep.toml"], more].concat();
    serde_json::from_str(&succeed(folder, &words)).unwrap()
}

fn task<'a>(plan: &'a Value, id: &str) -> &'a Value {
    let tasks = plan["tasks"].as_array().unwrap();
    tasks
        .iter()
        .find(|task| task["id"] == id)
        .unwrap_or_else(|| {
            let ids: Vec<_> = tasks.iter().map(|task| &task["id"]).collect();
            panic!("no {id} among {ids:?}")
        })
}

/// Products of a run: everything but what belongs to one machine, pages, parts, and records of tasks.
fn products(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut made = files(&folder.join("out"));
    made.retain(|path, _| {
        let name = path.to_string_lossy();
        let is_part = name.contains("of2") || name.contains("of3");
        let is_record = name == "run.json" || path.starts_with("tasks");
        !name.ends_with(".html") && !is_record && !name.contains("cache") && !is_part
    });
    made
}

/// Runs a script; returns what it prints.
fn sh(folder: &Path, script: &str) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_mesotex")).parent().unwrap();
    let mut paths = vec![program.to_path_buf()];
    paths.extend(env::split_paths(&env::var_os("PATH").unwrap_or_default()));
    let output = Command::new("sh")
        .arg(script)
        .current_dir(folder)
        .env("PATH", env::join_paths(paths).unwrap())
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{script}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_tasks_make_what_a_run_makes() {
    let whole = folder();
    succeed(whole.path(), &["run", "sweep.toml", "--no-pages"]);
    let parted = folder();
    let words = [
        "plan",
        "sweep.toml",
        "--shards",
        "3",
        "--format",
        "shell",
        "-o",
        "plan.sh",
    ];
    let said = succeed(parted.path(), &words);
    assert!(said.contains("wrote plan.sh"), "{said}");
    sh(parted.path(), "plan.sh");
    let (expected, found) = (products(whole.path()), products(parted.path()));
    let names = |made: &BTreeMap<PathBuf, Vec<u8>>| made.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&found), names(&expected));
    for (path, bytes) in expected {
        assert!(found[&path] == bytes, "{} differs", path.display());
    }
}

/// The commands that a script skipped, in order.
fn skipped(printed: &str) -> Vec<&str> {
    let lines = printed.lines();
    lines
        .filter_map(|line| line.strip_suffix(" skipped, nothing changed"))
        .collect()
}

#[test]
fn a_second_run_of_a_shell_list_makes_only_what_changed() {
    let folder = folder();
    let folder = folder.path();
    let words = ["plan", "sweep.toml", "--format", "shell", "-o", "plan.sh"];
    let planned = |more: &[&str]| succeed(folder, &[&words[..], more].concat());
    planned(&["--shards", "2"]);
    assert_eq!(skipped(&sh(folder, "plan.sh")), [""; 0]);
    let made = products(folder);
    let times = || -> Vec<_> {
        // The last shard of a rendering draws the contact sheet of its frames again.
        let paths = made.keys().filter(|path| !path.ends_with("contact.png"));
        let paths = paths.map(|path| folder.join("out").join(path));
        paths
            .map(|path| fs::metadata(&path).unwrap().modified().unwrap())
            .collect()
    };
    let first = times();
    // Parts and frames are kept by their own commands; the rest by records.
    let all = [
        "mesh", "mesh", "bake", "textons", "gram", "knn", "synth", "synth",
    ];
    assert_eq!(skipped(&sh(folder, "plan.sh")), all);
    assert!(times() == first, "nothing is written again");
    assert!(products(folder) == made);
    // Other threads, or another number of them, are no other work.
    planned(&["--shards", "2", "--threads", "2"]);
    assert_eq!(skipped(&sh(folder, "plan.sh")), all);
    // What is gone or damaged is made again, and what follows from other bytes.
    fs::remove_file(folder.join("out/small-k.map.ply")).unwrap();
    fs::write(folder.join("out/small.knn.npz"), "nothing").unwrap();
    let again = ["mesh", "mesh", "bake", "textons", "gram", "synth"];
    assert_eq!(skipped(&sh(folder, "plan.sh")), again);
    assert!(products(folder) == made);
    let scene = sweep().replace("k = 3", "k = 4");
    fs::write(folder.join("sweep.toml"), scene).unwrap();
    planned(&["--shards", "2"]);
    assert_eq!(skipped(&sh(folder, "plan.sh")), all[..5]);
    assert!(products(folder) != made);
}

#[test]
fn a_record_belongs_to_a_command_that_writes_something_else() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("mine.json"), "{\"distance_km\": 10}").unwrap();
    let refused = |line: &str, code: i32| {
        let error = refuse(folder, &program::words(line), code);
        error.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for (once, code, says) in [
        ("k.ply", 2, "--once: k.ply: given for two outputs"),
        ("k.obj", 2, "--once: k.obj: is also an input"),
        ("k.npz", 2, "--once: k.npz: ends in .npz"),
        ("gone/k.json", 2, "--once: the folder gone does not exist"),
        (
            "mine.json",
            1,
            "mine.json: record: no record of `mesotex run`",
        ),
    ] {
        let error = refused(&format!("mesh k.obj -o k.ply --once {once}"), code);
        assert!(error.contains(says), "{error}");
    }
    assert!(!folder.join("k.ply").exists());
    let none = refused("info k.obj --once k.json", 2);
    assert!(
        none.contains("--once: k.json, of a command that names no output"),
        "{none}"
    );
    let scene = sweep().replace("orient = true", "orient = true\nonce = \"m.json\"");
    fs::write(folder.join("once.toml"), scene).unwrap();
    let error = refused("run once.toml", 2);
    assert!(
        error.contains("`mesotex run` skips finished stages by itself"),
        "{error}"
    );
    // A damaged record is begun anew.
    let words = ["mesh", "k.obj", "-o", "k.ply", "--once", "k.json"];
    succeed(folder, &words);
    let record = fs::read_to_string(folder.join("k.json")).unwrap();
    assert!(succeed(folder, &words).contains("mesh skipped"));
    fs::write(folder.join("k.json"), &record[..record.len() / 2]).unwrap();
    assert!(succeed(folder, &words).contains("wrote k.ply"));
    let json: Value =
        serde_json::from_str(&succeed(folder, &[&words[..], &["--json"]].concat())).unwrap();
    assert_eq!(json["skipped"], true);
}

#[test]
fn analyses_state_their_memory() {
    let folder = folder();
    let stated = |scene: &str, id: &str| -> Vec<String> {
        fs::write(folder.path().join("sweep.toml"), scene).unwrap();
        let made = plan(folder.path(), &["--shards", "2"]);
        let command = task(&made, id)["command"].as_array().unwrap().clone();
        let words = command.iter().map(|word| word.as_str().unwrap().to_owned());
        words.filter(|word| word.starts_with("--memory")).collect()
    };
    let own = sweep().replace("textons = 8", "textons = 8\nmemory = \"300MiB\"");
    let parts = ["small.textons.0of2", "small.textons.1of2"];
    let defaults = parts.map(|id| stated(&sweep(), id));
    assert_eq!(defaults[0], defaults[1]);
    assert!(
        matches!(&defaults[0][..], [word] if word.ends_with("MiB")),
        "{defaults:?}"
    );
    for id in parts {
        assert_eq!(stated(&own, id), ["--memory=300MiB"]);
    }
    // The routes of a reduction are those of its parts.
    assert!(stated(&sweep(), "small.textons.reduce").is_empty());
}

const CAPTURE: &str = r#"
name = "coin"
output = "out"
surface = "k.obj"

[import]
path = "capture"

[textons]
textons = 6
levels = 2

[knn]
k = 3
neighborhood = 3

[synth]
levels = 1
k = 2
"#;

#[test]
fn an_import_is_shared_and_tells_the_size_of_what_follows() {
    let fresh = || {
        let folder = folder();
        write_capture(&folder.path().join("capture"));
        fs::write(folder.path().join("sweep.toml"), CAPTURE).unwrap();
        folder
    };
    let (whole, parted) = (fresh(), fresh());
    let made = plan(parted.path(), &["--shards", "2"]);
    let part = task(&made, "coin.import.1of2");
    let words = "mesotex import capture -o out/coin.1of2 --shard=1/2 --seed 0 --threads 1";
    let words: Vec<_> = words.split(' ').collect();
    assert_eq!(part["command"], serde_json::json!(words));
    let join = task(&made, "coin.import.reduce");
    assert_eq!(
        join["inputs"],
        serde_json::json!(["out/coin.0of2", "out/coin.1of2"])
    );
    for task in made["tasks"].as_array().unwrap() {
        assert!(task["seconds"].as_f64().unwrap() > 0.0, "{task}");
    }
    succeed(whole.path(), &["run", "sweep.toml", "--no-pages"]);
    let words = "plan sweep.toml --shards 3 --format shell -o plan.sh";
    succeed(parted.path(), &words.split(' ').collect::<Vec<_>>());
    sh(parted.path(), "plan.sh");
    assert!(products(whole.path()) == products(parted.path()));
}

#[test]
fn tasks_know_their_files_and_what_comes_before() {
    let folder = folder();
    let made = plan(folder.path(), &["--shards", "8", "--threads", "2"]);
    assert_eq!(made["format"], "mesotex-plan");
    assert_eq!(made["threads"], 2);
    let mesh = task(&made, "small.mesh.k");
    assert_eq!(mesh["inputs"], serde_json::json!(["k.obj"]));
    assert_eq!(mesh["outputs"], serde_json::json!(["out/small-k.mesh.ply"]));
    let synth = task(&made, "small.synth.bell");
    assert_eq!(
        synth["after"],
        serde_json::json!(["small.gram", "small.knn", "small.mesh.bell"])
    );
    // Five frames are no work for eight tasks.
    let last = task(&made, "small.render-frames.bell.4of5");
    assert_eq!(
        last["after"],
        serde_json::json!(["small.bake.reduce", "small.synth.bell"])
            .as_array()
            .map(|_| last["after"].clone())
            .unwrap()
    );
    assert_eq!(last["frames"]["first"], 5);
    let command = last["command"].as_array().unwrap();
    assert!(command.contains(&"--shard=4/5".into()) && command.contains(&"--skip-existing".into()));
    for task in made["tasks"].as_array().unwrap() {
        assert!(task["seconds"].as_f64().unwrap() > 0.0, "{task}");
        assert!(task["bytes"].as_u64().unwrap() > 1_000_000, "{task}");
        let first = task["after"].as_array().unwrap().is_empty();
        assert_eq!(task["step"] == 1, first, "{task}");
    }
    let few = task(
        &plan(folder.path(), &["--shards", "2"]),
        "small.render-frames.k.1of2",
    )
    .clone();
    assert_eq!(few["frames"]["first"], 2);
    assert_eq!(few["frames"]["last"], 4);
    assert_eq!(few["frames"]["step"], 2);
}

#[test]
fn the_same_scene_gives_the_same_plan() {
    let folder = folder();
    for format in ["json", "shell", "snakemake"] {
        let words = ["plan", "sweep.toml", "--shards", "2", "--format", format];
        let before = succeed(folder.path(), &words);
        assert_eq!(before, succeed(folder.path(), &words));
        // What runs have made says nothing.
        succeed(folder.path(), &["run", "sweep.toml", "--until", "mesh"]);
        assert_eq!(before, succeed(folder.path(), &words), "{format}");
    }
}

#[test]
fn a_snakefile_has_a_rule_per_task() {
    let folder = folder();
    let words = [
        "plan",
        "sweep.toml",
        "--shards",
        "2",
        "--format",
        "snakemake",
    ];
    let text = succeed(folder.path(), &words);
    for part in [
        "rule small_mesh_k:\n    input:\n        \"k.obj\",\n    output:\n        \"out/small-k.mesh.ply\",\n    threads: 1\n",
        "directory(\"out/small.sample\"),",
        "temp(directory(\"out/small.1of2\")),",
        "temp(\"out/small.textons.0of2.npz\"),",
        "[f\"out/small-k.frames/frame.{n:04d}.exr\" for n in range(2, 5, 2)],",
        "mem_mb=lambda wildcards, attempt: ",
        "rule all:\n    default_target: True\n    input:\n        rules.small_render_frames_k_0of2.output,",
    ] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
}

#[test]
fn scenes_of_several_folders_make_one_plan() {
    let folder = folder();
    let inner = folder.path().join("in ner");
    fs::create_dir(&inner).unwrap();
    write_obj(&inner.join("k.obj"), 300);
    let scene = sweep()
        .replace(", \"bell.obj\"", "")
        .replace("\"small\"", "\"other\"");
    fs::write(inner.join("scene.toml"), scene).unwrap();
    let words = [
        "plan",
        "sweep.toml",
        "in ner/scene.toml",
        "--format",
        "shell",
    ];
    let text = succeed(folder.path(), &words);
    assert!(
        text.contains("mkdir -p 'in ner/out' 'in ner/out/tasks' out out/tasks\n"),
        "{text}"
    );
    assert!(
        text.contains("(cd 'in ner' && mesotex mesh k.obj -o out/other-k.mesh.ply"),
        "{text}"
    );
    assert!(
        text.contains(" --once=out/tasks/other.mesh.k.json)\n"),
        "{text}"
    );
    // The same scene twice is the same tasks.
    let twice = succeed(folder.path(), &["plan", "sweep.toml", "sweep.toml"]);
    assert_eq!(twice, succeed(folder.path(), &["plan", "sweep.toml"]));
    let other = sweep().replace("size = 16", "size = 32");
    fs::write(folder.path().join("other.toml"), other).unwrap();
    let refused = refuse(folder.path(), &["plan", "sweep.toml", "other.toml"], 1);
    assert!(refused.contains("both make out/small.sample"), "{refused}");
}

#[test]
fn a_plan_over_files_that_do_not_exist_is_refused() {
    let folder = folder();
    let scene = sweep()
        .replace("bell.obj", "gone.obj")
        .replace("\"k.obj", "\"lost.obj");
    fs::write(folder.path().join("a.toml"), scene).unwrap();
    let scene = sweep().replace("preset = \"weave\"", "material = \"oak.toml\"");
    fs::write(folder.path().join("b.toml"), scene).unwrap();
    let words = [
        "plan",
        "a.toml",
        "b.toml",
        "c.toml",
        "sweep.toml",
        "-o",
        "p.json",
    ];
    let refused = refuse(folder.path(), &words, 1);
    for part in [
        "3 scenes: 4 faults",
        "a.toml: line 6: [matrix] mesh.input = \"gone.obj\": gone.obj does not exist",
        "lost.obj does not exist",
        "b.toml: line 9: [bake] material: oak.toml: cannot read",
        "c.toml: cannot read",
    ] {
        assert!(refused.contains(part), "no {part} in\n{refused}");
    }
    assert!(!folder.path().join("p.json").exists());
    let none = refuse(folder.path(), &["plan", "sweep.toml", "--shards", "0"], 2);
    assert!(none.contains("--shards: 0; expected 1 to"), "{none}");
    fs::write(folder.path().join("mine.sh"), "echo mine\n").unwrap();
    let words = ["plan", "sweep.toml", "--format", "shell", "-o", "mine.sh"];
    let mine = refuse(folder.path(), &words, 2);
    assert!(mine.contains("not a plan of this program"), "{mine}");
}
