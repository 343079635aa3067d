//! The program as a user runs it, and folders as a user sees them.
#![allow(dead_code, reason = "every test file uses its own part")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

pub fn mesotex(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    command.args(words).current_dir(folder).output().unwrap()
}

/// Runs a command that must succeed; returns its stdout.
pub fn succeed(folder: &Path, words: &[&str]) -> String {
    let output = mesotex(folder, words);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words:?} failed:\n{error}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that must fail with this exit code; returns its stderr.
pub fn refuse(folder: &Path, words: &[&str], code: i32) -> String {
    let output = mesotex(folder, words);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{words:?}: {error}");
    assert!(!error.contains("panicked"), "{error}");
    error
}

/// The words of a command line without quotes.
pub fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

/// The same words with another file in the place of one.
pub fn with_other<'a>(words: &[&'a str], file: &str, other: &'a str) -> Vec<&'a str> {
    let exchanged = |&word: &&'a str| if word == file { other } else { word };
    words.iter().map(exchanged).collect()
}

/// Every file below a folder, by its relative path.
pub fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
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

/// A copy that a test may change.
pub fn copy_of(folder: &Path) -> TempDir {
    let copy = tempfile::tempdir().unwrap();
    for (path, bytes) in files(folder) {
        let target = copy.path().join(path);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::write(target, bytes).unwrap();
    }
    copy
}

/// The built-in mesh as an OBJ file.
pub fn write_obj(path: &Path, vertices: usize) {
    let mesh = mesotex::mesh::builtin::kettlebell(vertices);
    let positions = mesh.positions.iter();
    let positions: String = positions
        .map(|p| format!("v {} {} {}\n", p.x, p.y, p.z))
        .collect();
    let faces = mesh.triangles.iter();
    let faces: String = faces
        .map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1))
        .collect();
    fs::write(path, positions + &faces).unwrap();
}

/// An RTI capture of some small images, `dirs.lp` among them.
pub fn write_capture(folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    let mut list = String::from("5\n");
    for light in 0..5u8 {
        let pixel = |at: u32| (60 + 20 * (at % 5) + at / 16 * u32::from(light) * 2) as u8;
        let pixels: Vec<u8> = (0..256).map(pixel).collect();
        mesotex::format::image::write_png(&folder.join(format!("{light}.png")), 16, 16, &pixels)
            .unwrap();
        let (y, x) = f64::from(light).sin_cos();
        list += &format!("{light}.png {} {} 0.8\n", 0.6 * x, 0.6 * y);
    }
    fs::write(folder.join("dirs.lp"), list).unwrap();
}

/// A scene of small stages with a `[matrix]`, and with further lines in `[bake]`, `[textons]` and `[[render]]`.
pub fn small_scene(matrix: &str, [bake, textons]: [&str; 2], render: &str) -> String {
    format!(
        r#"
name = "small"
output = "out"

[matrix]
{matrix}

[bake]
{bake}size = 16
views = "fibonacci:4"
lights = "fibonacci:4"
samples = 1

[textons]
textons = 8
levels = 2
{textons}
[knn]
k = 3
neighborhood = 3

[mesh]
orient = true

[synth]
levels = 2
k = 2

[[render]]
size = "32x24"
{render}"#
    )
}
