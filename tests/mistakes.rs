//! Plausible mistakes: each gets a message with what was found, what was expected and what to do.

mod program;

use std::fs;
use std::path::Path;
use std::process::Command;

use program::{mesotex, refuse, succeed};
use serde_json::Value;

/// A folder with a sample, its textons and a mesh.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let few = "--size 16 --samples 1 --views fibonacci:4 --lights fibonacci:4";
    run(at, &format!("bake --preset weave {few} -o weave.sample"));
    run(
        at,
        "textons weave.sample -o weave.textons.npz --textons 8 --levels 1",
    );
    run(at, "gram weave.textons.npz -o weave.space.npz");
    run(at, "knn weave.space.npz -o weave.knn.npz --k 3");
    run(
        at,
        "synth weave.space.npz weave.knn.npz --grid 12x12 -o grid.map.ply",
    );
    program::write_obj(&at.join("kettlebell.obj"), 400);
    fs::write(
        at.join("scene.toml"),
        "name = \"a\"\n[bake]\npreset = \"weav\"\nsise = 32\n",
    )
    .unwrap();
    folder
}

fn run(folder: &Path, line: &str) {
    succeed(folder, &line.split(' ').collect::<Vec<_>>());
}

/// A command line, its exit code, and what its message must say.
const MISTAKES: [(&str, i32, &[&str]); 29] = [
    (
        "bak --preset weave -o b.sample",
        2,
        &["`bak` is not a command", "did you mean `bake`?"],
    ),
    (
        "bake --preset weav -o b.sample",
        2,
        &["--preset: weav", "one of weave", "did you mean `weave`?"],
    ),
    (
        "bake --preset weave --size 50k -o b.sample",
        2,
        &["--size: 50k", "a whole number, written 50000"],
    ),
    (
        "bake --preset weave --size 64x64 -o b.sample",
        2,
        &["--size: 64x64", "a whole number"],
    ),
    (
        "bake --preset weave --size -5 -o b.sample",
        2,
        &["--size: -5", "not negative"],
    ),
    (
        "bake --preset weave --size 1 -o b.sample",
        2,
        &["--size: 1", "16 to 8192"],
    ),
    (
        "bake --preset weave --views 12x6 -o b.sample",
        2,
        &["--views: 12x6", "12x5, bonn81"],
    ),
    (
        "bake --preset weave --depth 0,5 -o b.sample",
        2,
        &["--depth: 0,5", "a number, written 0.5"],
    ),
    (
        "bake --preset weave",
        2,
        &["--output <OUTPUT> is missing", "mesotex bake --help"],
    ),
    (
        "bake --preset weave -o b.npz",
        2,
        &["--output: b.npz", "ends in .npz", "the name of a folder"],
    ),
    (
        "bake weave.sample -o b.sample",
        1,
        &["weave.sample", "expected"],
    ),
    (
        "textons weave.sample weave.textons.npz",
        2,
        &["one argument more", "-o weave.textons.npz"],
    ),
    (
        "textons weav.sample -o b.npz",
        1,
        &["weav.sample", "did you mean weave.sample?"],
    ),
    (
        "textons weave.sample -o b.npz --images al",
        2,
        &["--images: `al`", "`all`"],
    ),
    (
        "textons weave.sample -o b.npz --textons 1,000",
        2,
        &["--textons: 1,000", "written 1000"],
    ),
    (
        "textons weave.textons.npz -o b.npz",
        1,
        &["an archive (.npz)", "expected a BTF sample"],
    ),
    (
        "gram weave.sample -o b.npz",
        1,
        &["a BTF sample", "expected an archive"],
    ),
    (
        "knn weave.textons.npz -o b.npz",
        1,
        &["weave.textons.npz", "mesotex-textons", "mesotex-space"],
    ),
    (
        "mesh kettlebell.obj -o b.stl",
        2,
        &["--output: b.stl", ".ply"],
    ),
    (
        "mesh kettlebel.obj -o b.ply",
        1,
        &["kettlebel.obj", "did you mean kettlebell.obj?"],
    ),
    (
        "mesh weave.sample -o b.ply",
        1,
        &["a BTF sample", "expected a mesh"],
    ),
    (
        "synth weave.space.npz kettlebell.obj -o b.map.ply",
        2,
        &["k-coherence with two files", "SPACE TABLE MESH"],
    ),
    (
        "synth weave.space.npz weave.knn.npz weave.sample -o b.map.ply",
        1,
        &["a BTF sample", "a mesh"],
    ),
    (
        "render weave.sample kettlebell.obj -o b",
        1,
        &["a mesh", "a surface texton map"],
    ),
    (
        "render weave.sample grid.map.ply -o b --elevation -30",
        2,
        &["no option --elevation", "--camera-elevation"],
    ),
    (
        "render weave.sample grid.map.ply -o b --size 1280",
        2,
        &["--size: `1280`", "1280x960"],
    ),
    (
        "render weave.sample grid.map.ply -o b --weights linear",
        2,
        &["--weights: linear", "continuous"],
    ),
    (
        "exemplar a.png -o weave.sample",
        2,
        &["weave.sample", "weave.space.npz"],
    ),
    (
        "run scene.toml",
        2,
        &[
            "line 3",
            "did you mean `weave`?",
            "sise",
            "did you mean `size`?",
        ],
    ),
];

#[test]
fn each_mistake_is_explained() {
    let folder = prepared();
    for (line, code, parts) in MISTAKES {
        let words: Vec<_> = line.split(' ').collect();
        let said = refuse(folder.path(), &words, code);
        for part in parts {
            assert!(said.contains(part), "{line}: no `{part}` in\n{said}");
        }
        assert!(!said.contains("Usage:"), "{line}:\n{said}");
    }
}

#[test]
fn errors_are_json_for_programs() {
    let folder = tempfile::tempdir().unwrap();
    let report = |line: &str| -> Value {
        let words: Vec<_> = line.split(' ').collect();
        serde_json::from_slice(&mesotex(folder.path(), &words).stdout).unwrap()
    };
    let usage = &report("bake --preset weave --size 50k -o b.sample --json")["error"];
    assert_eq!(
        (&usage["kind"], &usage["option"]),
        (&"usage".into(), &"size".into())
    );
    assert_eq!(usage["exit_code"], 2);
    let range = &report("bake --preset weave --size 1 -o b.sample --json")["error"];
    assert_eq!(
        (&range["option"], &range["found"]),
        (&"size".into(), &"1".into())
    );
    let machine = &report("textons no.sample -o b.npz --json")["error"];
    assert_eq!(machine["exit_code"], 1);
    assert!(machine["message"].as_str().unwrap().contains("no.sample"));
}

#[test]
fn completions_and_manual_pages_name_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = succeed(folder.path(), &["completions", shell]);
        assert!(script.contains("bake-maps"), "{shell}");
    }
    let page = succeed(folder.path(), &["man"]);
    assert!(
        page.contains(".TH mesotex 1") && page.contains("12x5"),
        "{page}"
    );
    let page = succeed(folder.path(), &["man", "render"]);
    assert!(
        page.contains("mesotex\\-render") && page.contains("\\-\\-sweep"),
        "{page}"
    );
    let said = refuse(folder.path(), &["man", "rendr"], 2);
    assert!(said.contains("did you mean `render`?"), "{said}");
}

#[test]
fn verbose_tells_each_stage_and_pipes_have_no_colors() {
    let folder = prepared();
    let words = [
        "textons",
        "weave.sample",
        "-o",
        "v.npz",
        "--textons",
        "8",
        "--levels",
        "1",
        "-v",
    ];
    let output = Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .args(words)
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("texton centres: ") && said.contains(" s\n"),
        "{said}"
    );
    let said = refuse(folder.path(), &["textons", "no.sample", "-o", "b.npz"], 1);
    assert!(!said.contains('\u{1b}'), "{said:?}");
}
