//! Pages as a user makes them: what `view` and `report` put on them, and what is refused. tools/check_pages.sh opens them in a
//! browser.

mod program;

use std::fs;
use std::path::Path;

use program::{copy_of, files, refuse, succeed};
use serde_json::Value;
use tempfile::TempDir;

/// A small scene, run.
fn scene() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("scene.toml"),
        "name = \"ball\"\nsurface = \"ball.ply\"\n\
         [bake]\npreset = \"weave\"\nsize = 16\nsamples = 1\nviews = \"fibonacci:9\"\nlights = \"fibonacci:9\"\n\
         [textons]\ntextons = 12\nimages = 9\nlevels = 2\n[knn]\nk = 4\n[synth]\npolish = 1\n\
         [[render]]\nsweep = \"light-azimuth\"\nframes = 3\nsize = \"48x32\"\n",
    )
    .unwrap();
    write_ball(&folder.path().join("ball.ply"));
    succeed(folder.path(), &["run", "scene.toml"]);
    folder
}

fn write_ball(path: &Path) {
    let mesh = mesotex::mesh::shapes::icosphere(3);
    mesotex::mesh::write_mesh(path, &mesh).unwrap();
}

/// The text of a script element.
fn element<'a>(page: &'a str, id: &str) -> &'a str {
    let rest = page.split_once(&format!("id=\"{id}\">")).unwrap().1;
    rest.split_once("</script>").unwrap().0
}

/// No page names anything to load.
fn check_alone(page: &str) {
    for word in ["http:", "https:", "<link", " src=\"/", "import "] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.contains("default-src 'none'"));
}

fn page(folder: &Path, words: &[&str]) -> String {
    let words: Vec<&str> = words.iter().copied().chain(["-o", "page.html"]).collect();
    succeed(folder, &words);
    fs::read_to_string(folder.join("page.html")).unwrap()
}

#[test]
fn a_scene_is_shown_on_both_pages() {
    let folder = scene();
    viewer_holds_sample_and_surface(folder.path());
    report_holds_every_chapter(folder.path());
    missing_parts_are_said(folder.path());
    wrong_inputs_are_refused(folder.path());
}

fn viewer_holds_sample_and_surface(folder: &Path) {
    let words = [
        "view",
        "ball.sample",
        "ball.map.ply",
        "-o",
        "page.html",
        "--json",
    ];
    let report: Value = serde_json::from_str(&succeed(folder, &words)).unwrap();
    let error = report["relative_error"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.05, "{report}");
    let html = fs::read_to_string(folder.join("page.html")).unwrap();
    assert_eq!(report["bytes"], html.len());
    check_alone(&html);
    assert!(html.contains(&format!("<b id=\"error\">{:.1} %</b>", 100.0 * error)));
    assert!(html.contains("This page needs WebGL 2"));
    let about: Value = serde_json::from_str(element(&html, "description")).unwrap();
    assert_eq!(about["surface"]["vertices"], 642);
    assert_eq!(about["sample"]["groups"].as_array().unwrap().len(), 9);
    assert!(element(&html, "surface").len() > 1000);
    // The same inputs give the same bytes.
    succeed(
        folder,
        &[
            "view",
            "ball.sample",
            "ball.map.ply",
            "-o",
            "again.html",
            "--threads",
            "1",
        ],
    );
    assert_eq!(html, fs::read_to_string(folder.join("again.html")).unwrap());
}

fn report_holds_every_chapter(folder: &Path) {
    let html = page(folder, &["report", "scene.toml"]);
    check_alone(&html);
    for (text, least) in [
        ("<figure><img src=\"data:image/png", 8),
        ("class=\"player\"", 1),
        ("energy_ratio_full", 1),
        ("1.00 to 3.00 after polish", 1),
        ("--preset=weave", 1),
        ("by energy", 1),
        ("the orientation field", 1),
        ("level 1:", 1),
        ("id=\"dome\"", 1),
    ] {
        assert!(html.matches(text).count() >= least, "{text}");
    }
    let about: Value = serde_json::from_str(element(&html, "description")).unwrap();
    assert_eq!(about["sequences"][0]["frames"].as_array().unwrap().len(), 3);
    assert!(!html.contains("class=\"missing\""), "something is missing");
    // A folder with a scene is that scene.
    assert_eq!(html, page(folder, &["report", "."]));
}

fn missing_parts_are_said(folder: &Path) {
    let copy = copy_of(folder);
    let at = copy.path();
    fs::remove_file(at.join("ball.frames/frame.0002.png")).unwrap();
    fs::remove_file(at.join("ball.textons.npz")).unwrap();
    let html = page(at, &["report", "scene.toml"]);
    assert!(html.contains("1 of 3 frames have no preview"));
    assert!(html.contains("no textons are there"));
    // Without a scene, from what lies in the folder.
    fs::remove_file(at.join("scene.toml")).unwrap();
    fs::remove_file(at.join("ball.knn.npz")).unwrap();
    let html = page(at, &["report", "."]);
    for note in [
        "times and options are known of scenes only",
        "no quality figures",
        "no relief to show",
    ] {
        assert!(html.contains(note), "{note}");
    }
    // A scene that was never run has stages, and nothing else.
    let fresh = tempfile::tempdir().unwrap();
    for name in ["scene.toml", "ball.ply"] {
        fs::copy(folder.join(name), fresh.path().join(name)).unwrap();
    }
    let html = page(fresh.path(), &["report", "scene.toml"]);
    for note in [
        "no sample is there yet",
        "not run yet",
        "no frames are there",
        "no surface texton map",
    ] {
        assert!(html.contains(note), "{note}");
    }
}

fn wrong_inputs_are_refused(folder: &Path) {
    let refused = |words: &[&str], code: i32, parts: &[&str]| {
        let before = files(folder);
        let error = refuse(folder, words, code);
        for part in parts {
            assert!(error.contains(part), "{part}: {error}");
        }
        assert_eq!(
            before.keys().collect::<Vec<_>>(),
            files(folder).keys().collect::<Vec<_>>()
        );
    };
    refused(
        &["view", "ball.sample", "ball.map.ply", "-o", "a.ply"],
        2,
        &["--output", ".html"],
    );
    refused(
        &[
            "view",
            "ball.sample",
            "ball.map.ply",
            "-o",
            "a.html",
            "--error",
            "1.5",
        ],
        2,
        &["--error"],
    );
    refused(
        &["view", "ball.sample", "ball.ply", "-o", "a.html"],
        1,
        &["ball.ply", "exemplar"],
    );
    refused(
        &["report", "ball.sample", "-o", "a.html"],
        1,
        &["nothing that mesotex made", "mesotex run"],
    );
    fs::write(folder.join("notes.html"), "<p>mine</p>").unwrap();
    refused(
        &["report", "scene.toml", "-o", "notes.html"],
        2,
        &["not a page of this program"],
    );
    let text = fs::read(folder.join("ball.map.ply")).unwrap();
    let without_faces = changed_header(&text, "element face 1280", "element face 0");
    let vertices = without_faces.len() - 1280 * 13;
    fs::write(folder.join("empty.map.ply"), &without_faces[..vertices]).unwrap();
    let words = ["view", "ball.sample", "empty.map.ply", "-o", "a.html"];
    refused(&words, 1, &["empty.map.ply", "no triangle"]);
    let without = changed_header(&text, "property float nz", "property float mz");
    fs::write(folder.join("flat.map.ply"), without).unwrap();
    refused(
        &["view", "ball.sample", "flat.map.ply", "-o", "a.html"],
        1,
        &["flat.map.ply", "nz"],
    );
}

/// A PLY with other words in its header.
fn changed_header(ply: &[u8], from: &str, to: &str) -> Vec<u8> {
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap();
    let header = String::from_utf8_lossy(&ply[..end]).replace(from, to);
    [header.as_bytes(), &ply[end..]].concat()
}

#[test]
fn one_view_and_another_sample() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_ball(&at.join("ball.ply"));
    let bake = |name: &str, seed: &str| {
        let sets = [
            "--views",
            "rings:0:1",
            "--lights",
            "fibonacci:5",
            "--samples",
            "1",
        ];
        let words = [
            "bake", "--preset", "weave", "--size", "16", "--seed", seed, "-o", name,
        ];
        let words: Vec<&str> = words.into_iter().chain(sets).collect();
        succeed(at, &words);
    };
    bake("one.sample", "0");
    bake("other.sample", "1");
    succeed(
        at,
        &[
            "textons",
            "one.sample",
            "-o",
            "t.npz",
            "--textons",
            "6",
            "--images",
            "all",
            "--levels",
            "1",
        ],
    );
    succeed(at, &["gram", "t.npz", "-o", "s.npz"]);
    succeed(
        at,
        &[
            "knn",
            "s.npz",
            "-o",
            "k.npz",
            "--k",
            "3",
            "--min-separation",
            "1",
        ],
    );
    succeed(
        at,
        &[
            "synth",
            "s.npz",
            "k.npz",
            "ball.ply",
            "-o",
            "ball.map.ply",
            "--levels",
            "1",
        ],
    );
    let html = page(at, &["view", "one.sample", "ball.map.ply"]);
    assert!(html.contains("1 view × 5 lights"));
    let error = refuse(
        at,
        &["view", "other.sample", "ball.map.ply", "-o", "b.html"],
        1,
    );
    assert!(
        error.contains("sample id") && error.contains("--force"),
        "{error}"
    );
    succeed(
        at,
        &[
            "view",
            "other.sample",
            "ball.map.ply",
            "-o",
            "b.html",
            "--force",
        ],
    );
}
