//! What holds whatever is asked and whatever the disk does: caches and checkpoints, numbers that are
//! written and read back, limits of options, full disks.

mod full_disk;
mod kept;
mod limits;
mod numbers;
#[path = "../program/mod.rs"]
mod program;

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use program::{copy_of, files, mesotex};
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_mesotex");

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
        mesotex::mesh::write_mesh(&at.join("m.ply"), &mesh).unwrap();
        for line in [
            "bake --preset weave --size 16 --samples 1 --views fibonacci:4 --lights fibonacci:4 -o s.sample",
            "textons s.sample -o s.textons.npz --textons 8 --levels 2",
            "gram s.textons.npz -o s.space.npz",
            "knn s.space.npz -o s.knn.npz --k 3 --neighborhood 3",
            "synth s.space.npz s.knn.npz m.ply -o s.map.ply",
        ] {
            succeed(at, &words(line));
        }
        fs::remove_dir_all(at.join("m.ply.mesotex-cache")).unwrap();
        write_capture(at);
        write_sky(&at.join("sky.hdr"));
        folder
    };
    FILES.get_or_init(make).path()
}

/// An environment of 8 × 4 pixels.
fn write_sky(path: &Path) {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    for pixel in 0..32 {
        bytes.extend([100, 50 + pixel, 100, 128]);
    }
    fs::write(path, bytes).unwrap();
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
