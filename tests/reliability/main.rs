//! What holds whatever is asked and whatever the disk does: caches and checkpoints, numbers that are
//! written and read back, limits of options, full disks.

mod full_disk;
mod kept;
mod limits;
mod numbers;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_mesotex");

fn mesotex(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(words).current_dir(folder).output().unwrap()
}

/// What a command that must succeed says on stderr.
fn succeed(folder: &Path, words: &[&str]) -> String {
    let output = mesotex(folder, words);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{words:?} failed:\n{said}");
    said
}

/// A command line of single words.
fn words(line: &str) -> Vec<&str> {
    line.split(' ').collect()
}

/// A small file of every kind that the commands read.
fn small_files() -> &'static Path {
    static FILES: OnceLock<TempDir> = OnceLock::new();
    let make = || {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let mesh = mesotex::mesh::builtin::kettlebell(400);
        mesotex::mesh::writing::write_mesh(&at.join("m.ply"), &mesh).unwrap();
        for line in [
            "bake --preset weave --size 16 --views fibonacci:4 --lights fibonacci:4 -o s.sample",
            "textons s.sample -o s.textons.npz --textons 8 --levels 2",
            "gram s.textons.npz -o s.space.npz",
            "knn s.space.npz -o s.knn.npz --k 3 --neighborhood 3",
            "synth s.space.npz s.knn.npz m.ply -o s.map.ply",
        ] {
            succeed(at, &words(line));
        }
        fs::remove_dir_all(at.join("m.ply.mesotex-cache")).unwrap();
        write_capture(at);
        folder
    };
    FILES.get_or_init(make).path()
}

/// Images of two lights and their table, for `import` and `exemplar`.
fn write_capture(folder: &Path) {
    for name in ["a.png", "b.png"] {
        let pixels: Vec<u8> = (0..16 * 16 * 3).map(|at| (at * 7 % 251) as u8).collect();
        mesotex::format::image::write_png(&folder.join(name), 16, 16, &pixels).unwrap();
    }
    let table = "2\na.png 0 0 1\nb.png 0.6 0 0.8\n";
    fs::write(folder.join("c.lp"), table).unwrap();
}

fn copy_of(folder: &Path) -> TempDir {
    let copy = tempfile::tempdir().unwrap();
    for (path, bytes) in files(folder) {
        let target = copy.path().join(path);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::write(target, bytes).unwrap();
    }
    copy
}

/// Every file below a folder, by its relative path.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(at) = folders.pop() {
        for entry in fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_path_buf();
                found.insert(name, fs::read(path).unwrap());
            }
        }
    }
    found
}
