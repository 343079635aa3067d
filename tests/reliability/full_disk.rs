//! A disk that is full: one error of ours, nothing half written, nothing left behind.
//!
//! A limit of the size of files stands in for the disk: writes fail in the middle, at another place for
//! each limit.
#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{PROGRAM, copy_of, files, small_files};

/// Commands that write, and whether what they finished before the failure stays.
const WRITERS: &[(&str, bool)] = &[
    (
        "bake --preset weave --size 16 --samples 1 --views fibonacci:4 --lights fibonacci:4 -o o.sample",
        false,
    ),
    (
        "bake --preset weave --size 16 --samples 1 --views fibonacci:2 --lights fibonacci:2 -o o.sample \
         --preview o.png --surface o.npz",
        true,
    ),
    ("import c.lp -o o.sample", false),
    (
        "textons s.sample -o o.textons.npz --textons 8 --levels 2 --report o.json --montage o.png \
         --label-map o2.png",
        true,
    ),
    (
        "textons s.sample -o o.textons.npz --textons 8 --levels 2",
        false,
    ),
    ("gram s.textons.npz -o o.space.npz", false),
    ("knn s.space.npz -o o.knn.npz --k 3 --neighborhood 3", false),
    (
        "exemplar a.png -o o --levels 2 --k 3 --neighborhood 3",
        true,
    ),
    ("mesh m.ply -o o.ply", false),
    ("mesh m.ply -o o.obj", false),
    ("mesh m.ply -o o.glb", false),
    (
        "mesh m.ply -o o.ply --orient --report o.json --pictures o",
        true,
    ),
    ("synth s.space.npz s.knn.npz m.ply -o o.map.ply", true),
    (
        "synth s.space.npz s.knn.npz -o o.map.ply --grid 16x16 --report o.json --pictures o",
        true,
    ),
    ("render s.sample s.map.ply -o o.frames --size 64x48", true),
    (
        "render s.sample s.map.ply -o o.frames --size 32x24 --frames 2 --sweep view-orbit \
         --table-memory 0 --vertex-colors o.ply --animation gif",
        true,
    ),
    ("run scene.toml", true),
];

const SCENE: &str = "name = \"o\"\n[bake]\npreset = \"weave\"\nsize = 16\nviews = \"fibonacci:4\"\n\
                     lights = \"fibonacci:4\"\nsamples = 1\n[textons]\ntextons = 8\nlevels = 2\n[knn]\nk = 3\n\
                     neighborhood = 3\n[mesh]\ninput = \"m.ply\"\n[synth]\n[[render]]\nsize = \"32x24\"\n";

/// Files a finished stage leaves on purpose when a later one fails: what a run goes on from.
fn is_kept(path: &Path) -> bool {
    path.file_name()
        .is_some_and(|name| name == ".o.map.ply.resume")
}

#[test]
fn every_command_fails_with_one_error_and_leaves_nothing_half_written() {
    for (line, some_stays) in WRITERS {
        let mut failures = 0;
        for blocks in [0, 1, 2, 4, 8, 16, 24, 32, 64, 128] {
            let folder = copy_of(small_files());
            fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
            let before = files(folder.path());
            let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec {PROGRAM} {line} --quiet");
            let mut shell = Command::new("sh");
            let shell = shell.args(["-c", &script]).current_dir(folder.path());
            let output = shell.output().unwrap();
            if output.status.success() {
                break;
            }
            failures += 1;
            let said = String::from_utf8_lossy(&output.stderr);
            let place = format!("{line}, {blocks} blocks: {said}");
            assert_eq!(output.status.code(), Some(1), "{place}");
            assert!(
                said.starts_with("error: ") && said.lines().count() == 1,
                "{place}"
            );
            assert!(said.contains("cannot"), "{place}");
            let after = files(folder.path());
            let left: Vec<&PathBuf> = after
                .keys()
                .filter(|path| !before.contains_key(*path))
                .collect();
            for path in left {
                let hidden = path
                    .iter()
                    .any(|part| part.to_string_lossy().starts_with('.'));
                assert!(
                    !hidden || is_kept(path),
                    "{} is left: {place}",
                    path.display()
                );
                assert!(
                    *some_stays || is_kept(path),
                    "{} is left: {place}",
                    path.display()
                );
            }
            let changed = before
                .iter()
                .find(|(path, bytes)| after.get(*path) != Some(bytes));
            assert!(
                changed.is_none(),
                "{:?} changed: {place}",
                changed.map(|(path, _)| path)
            );
        }
        assert!(failures > 0, "{line} never failed");
    }
}
