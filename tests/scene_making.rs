//! Scenes made by `init`, run as a draft, up to a stage, and planned beforehand.

mod program;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use mesotex::format::image::write_png;
use program::{files, refuse, succeed, write_capture, write_obj};
use serde_json::Value;
use tempfile::TempDir;

/// A folder with a material's maps, a sample, a capture, an image and a mesh.
fn inputs() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name);
    fs::create_dir(at("bark")).unwrap();
    let wave = |scale: f64, at: u32, colors: u32| -> Vec<u8> {
        (0..32 * 16 * colors)
            .map(|place| place / colors)
            .map(|pixel| {
                let (row, col) = (f64::from(pixel / 32), f64::from(pixel % 32));
                let angle = std::f64::consts::TAU * (col / 16.0 + f64::from(at) * row / 16.0);
                (128.0 + scale * angle.sin()) as u8
            })
            .collect()
    };
    write_png(&at("bark/bark_height.png"), 32, 16, &wave(120.0, 1, 1)).unwrap();
    write_png(&at("bark/bark_albedo.png"), 32, 16, &wave(60.0, 2, 3)).unwrap();
    write_png(&at("cloth.png"), 32, 16, &wave(60.0, 2, 3)).unwrap();
    write_capture(&at("capture"));
    write_obj(&at("bell.obj"), 400);
    root
}

/// A scene of the maps on the mesh, with few directions and vertices.
fn small_scene() -> TempDir {
    let root = inputs();
    succeed(
        root.path(),
        &["init", "--material", "bark", "--mesh", "bell.obj"],
    );
    let path = root.path().join("scene.toml");
    let text = fs::read_to_string(&path).unwrap();
    let small = text
        .replace("\"12x5\"", "\"fibonacci:5\"")
        .replace("textons = 200", "textons = 8")
        .replace("vertices = 8200", "vertices = 1200")
        .replace("frames = 24", "frames = 4")
        .replace("960x720", "48x32");
    assert!(small.contains("vertices = 1200"), "{text}");
    fs::write(path, small).unwrap();
    root
}

fn report(folder: &Path, words: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, words)).unwrap()
}

#[test]
fn a_scene_fits_its_material_and_its_mesh_and_runs_as_it_is() {
    let root = inputs();
    let words = program::words("init --material bark --mesh bell.obj -o bark.toml");
    let told = succeed(root.path(), &words);
    assert!(
        told.contains("maps of 32 × 16 texels, baked at 32 × 16"),
        "{told}"
    );
    assert!(
        told.contains("next: mesotex run bark.toml --plan"),
        "{told}"
    );
    let text = fs::read_to_string(root.path().join("bark.toml")).unwrap();
    let scene: toml::Table = text.parse().unwrap();
    assert_eq!(scene["name"].as_str(), Some("bark-on-bell"));
    assert_eq!(scene["bake"]["size"].as_integer(), Some(32));
    // 512 texels, laid about four times across: 16 vertices for each.
    assert_eq!(scene["mesh"]["vertices"].as_integer(), Some(8200));
    let depth = scene["bake"]["depth"].as_float().unwrap();
    assert!((0.01..0.5).contains(&depth), "{depth}");
    assert_eq!(scene["textons"]["levels"].as_integer(), Some(2));
    let comments = text.lines().filter(|line| line.contains('#')).count();
    assert!(comments > 15, "{text}");
    let commands = succeed(root.path(), &["run", "bark.toml", "--dry-run"]);
    assert!(
        commands.contains("mesotex bake bark -o out/bark-on-bell.sample"),
        "{commands}"
    );
    // The user's scene is not replaced.
    let error = refuse(root.path(), &words, 2);
    assert!(error.contains("scenes are made to be edited"), "{error}");
}

#[test]
fn every_kind_of_material_makes_a_scene() {
    let root = inputs();
    let bake = "bake --preset weave --size 16 --samples 1 --views fibonacci:3 --lights fibonacci:3 -o weave.sample";
    succeed(root.path(), &bake.split(' ').collect::<Vec<_>>());
    fs::create_dir(root.path().join("scenes")).unwrap();
    for (material, stage) in [
        ("bark", "mesotex bake ../bark"),
        ("weave.sample", "mesotex textons ../weave.sample"),
        ("capture", "mesotex import ../capture"),
        ("cloth.png", "mesotex exemplar ../cloth.png"),
    ] {
        let scene = format!("scenes/{material}.toml");
        let words = [
            "init",
            "--material",
            material,
            "--mesh",
            "bell.obj",
            "-o",
            &scene,
        ];
        succeed(root.path(), &words);
        let commands = succeed(root.path(), &["run", &scene, "--dry-run"]);
        assert!(commands.contains(stage), "{material}: {commands}");
        assert!(commands.contains("../bell.obj"), "{commands}");
    }
    let not_toml = program::words("init --material bark --mesh bell.obj -o scene.ply");
    assert!(refuse(root.path(), &not_toml, 2).contains("ends in .ply"));
    let no_material = program::words("init --material bell.obj --mesh bell.obj -o b.toml");
    assert!(refuse(root.path(), &no_material, 1).contains("bell.obj"));
}

#[test]
fn a_draft_is_coarser_and_lies_beside_the_final_run() {
    let root = small_scene();
    succeed(root.path(), &["run", "scene.toml", "--quality", "draft"]);
    let made = files(&root.path().join("out"));
    assert!(made.keys().all(|path| {
        let name = path.to_string_lossy();
        name.starts_with("bark-on-bell-draft.") || name == "run.json" || name.contains("cache")
    }));
    assert!(made.contains_key(Path::new("bark-on-bell-draft.report.html")));
    let sample = report(
        root.path(),
        &["info", "out/bark-on-bell-draft.sample", "--json"],
    );
    assert_eq!(
        (&sample["width"], &sample["height"]),
        (&16.into(), &8.into())
    );
    assert!(!made.contains_key(Path::new("bark-on-bell-draft.frames/frame.0002.exr")));
    let commands = succeed(root.path(), &["run", "scene.toml", "--dry-run"]);
    assert!(
        !commands.contains("draft") && !commands.contains("skipped"),
        "{commands}"
    );
    let words = ["run", "scene.toml", "--quality", "draft", "--dry-run"];
    let skipped = succeed(root.path(), &words);
    assert_eq!(
        skipped.matches("skipped, nothing changed").count(),
        7,
        "{skipped}"
    );
}

#[test]
fn a_run_stops_after_a_stage() {
    let root = small_scene();
    succeed(root.path(), &["run", "scene.toml", "--until", "gram"]);
    let made = files(&root.path().join("out"));
    assert!(made.contains_key(Path::new("bark-on-bell.space.npz")));
    assert!(!made.contains_key(Path::new("bark-on-bell.knn.npz")));
    assert!(made.keys().all(|path| path.extension().unwrap() != "html"));
    let told = succeed(root.path(), &["run", "scene.toml", "--until", "knn"]);
    assert_eq!(
        told.matches("skipped, nothing changed").count(),
        3,
        "{told}"
    );
    let error = refuse(root.path(), &["run", "scene.toml", "--until", "sinth"], 2);
    assert!(
        error.contains("--until: sinth; expected a stage of the scene: bake, textons")
            && error.contains("did you mean `synth`?"),
        "{error}"
    );
}

#[test]
fn a_plan_says_what_every_stage_takes_and_writes_nothing() {
    let root = small_scene();
    let before = files(root.path());
    let plan = report(root.path(), &["run", "scene.toml", "--plan", "--json"]);
    assert!(files(root.path()) == before);
    let stages = plan["plan"]["stages"].as_array().unwrap();
    let names: Vec<&str> = stages
        .iter()
        .map(|stage| stage["stage"].as_str().unwrap())
        .collect();
    let all = [
        "bake",
        "textons",
        "gram",
        "knn",
        "mesh",
        "synth",
        "render frames",
        "pages",
    ];
    assert_eq!(names, all);
    for stage in stages {
        assert!(stage["seconds"].as_f64().unwrap() > 0.0, "{stage}");
        assert!(stage["bytes"].as_f64().unwrap() > 1e6, "{stage}");
        assert_eq!(stage["skipped"], false);
    }
    let told = succeed(root.path(), &["run", "scene.toml", "--plan"]);
    assert!(
        told.starts_with("plan: about ") && told.contains("at the peak"),
        "{told}"
    );
    // A run tells it before it begins, and one that has nothing to do does not.
    let told = succeed(root.path(), &["run", "scene.toml"]);
    assert!(told.starts_with("plan: about "), "{told}");
    let told = succeed(root.path(), &["run", "scene.toml", "--plan"]);
    assert_eq!(told, "nothing to do: no stage has changed\n");
    let begun = Instant::now();
    let told = succeed(root.path(), &["run", "scene.toml"]);
    assert!(
        begun.elapsed() < Duration::from_secs(2),
        "{:?}",
        begun.elapsed()
    );
    assert!(!told.contains("plan: "), "{told}");
}

#[test]
fn a_changed_light_renders_and_nothing_else() {
    let root = small_scene();
    succeed(root.path(), &["run", "scene.toml"]);
    let changed = |name: &str| -> SystemTime {
        let path = root.path().join("out").join(format!("bark-on-bell.{name}"));
        fs::metadata(path).unwrap().modified().unwrap()
    };
    let kept = ["view.html", "map.ply", "mesh.ply", "knn.npz"];
    let before = kept.map(changed);
    let page = changed("report.html");
    let scene = root.path().join("scene.toml");
    let text = fs::read_to_string(&scene).unwrap() + "light-elevation = 20\n";
    fs::write(&scene, text).unwrap();
    let told = succeed(root.path(), &["run", "scene.toml"]);
    assert_eq!(
        told.matches("skipped, nothing changed").count(),
        6,
        "{told}"
    );
    assert!(
        told.lines().any(|line| line.starts_with("render frames")),
        "{told}"
    );
    assert_eq!(kept.map(changed), before);
    assert!(
        changed("report.html") > page,
        "the report shows the new frames"
    );
}

#[test]
fn options_without_effect_are_faults_of_a_scene_too() {
    let root = small_scene();
    let scene = root.path().join("scene.toml");
    let text = fs::read_to_string(&scene).unwrap() + "turns = 3.0\n";
    fs::write(&scene, text).unwrap();
    let error = refuse(root.path(), &["run", "scene.toml"], 2);
    assert!(
        error.contains("[render] turns: --turns: given with --sweep light-azimuth"),
        "{error}"
    );
}

#[test]
fn a_name_that_ends_as_a_product_is_refused() {
    let root = small_scene();
    let scene = root.path().join("scene.toml");
    let text = fs::read_to_string(&scene).unwrap();
    fs::write(&scene, text.replace("\"bark-on-bell\"", "\"x.sample\"")).unwrap();
    let error = refuse(root.path(), &["run", "scene.toml"], 1);
    assert!(error.contains("name: x.sample: ends in .sample"), "{error}");
}
