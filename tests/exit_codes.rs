//! Who must act, by the exit code: 1 for data and machine, 2 for options.

use std::fs;
use std::path::Path;
use std::process::Command;

use mesotex::format::image::write_png;

/// The exit code and what was said on stderr.
fn run(folder: &Path, words: &str) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .args(words.split(' '))
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), said)
}

/// A folder with a sample, its space, its table and a map on a grid.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for words in [
        "bake --preset weave --size 32 --views fibonacci:5 --lights fibonacci:5 --samples 1 -o a.sample",
        "textons a.sample -o a.textons.npz --textons 20 --levels 1",
        "gram a.textons.npz -o a.space.npz",
        "knn a.space.npz -o a.knn.npz",
        "synth a.space.npz a.knn.npz --grid 40x40 -o a.map.ply",
    ] {
        let (code, said) = run(at, words);
        assert_eq!(code, Some(0), "{words}: {said}");
    }
    fs::write(
        at.join("tetrahedron.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
    )
    .unwrap();
    let rows: String = (0..40)
        .flat_map(|row| (0..40).map(move |col| format!("{col} {row} 0 1e-6\n")))
        .collect();
    let faces: String = (0..39 * 39)
        .map(|cell| cell / 39 * 40 + cell % 39)
        .map(|v| format!("4 {v} {} {} {}\n", v + 1, v + 41, v + 40))
        .collect();
    let header = "ply\nformat ascii 1.0\nelement vertex 1600\nproperty float x\nproperty float y\n\
        property float z\nproperty float scale\nelement face 1521\n\
        property list uchar int vertex_indices\nend_header\n";
    fs::write(at.join("shrunk.ply"), format!("{header}{rows}{faces}")).unwrap();
    write_png(
        &at.join("x_normal.png"),
        16,
        16,
        &[128, 128, 255].repeat(256),
    )
    .unwrap();
    write_png(
        &at.join("x_height.png"),
        16,
        16,
        &[128, 128, 128].repeat(256),
    )
    .unwrap();
    for map in ["normal", "height"] {
        let text = format!("{map} = \"x_{map}.png\"\n");
        fs::write(at.join(format!("{map}.toml")), text).unwrap();
    }
    fs::write(
        at.join("path.csv"),
        "camera_x,camera_y,camera_z\n19.5,19.5,0\n",
    )
    .unwrap();
    folder
}

#[test]
fn the_exit_code_says_who_must_act() {
    let folder = prepared();
    let bake = "--size 16 --views fibonacci:2 --lights fibonacci:2 --samples 1 -o b.sample";
    let synth = "synth a.space.npz a.knn.npz";
    let render = "render a.sample a.map.ply -o b --size 32x32";
    let cases = [
        // No option helps: the target is too coarse, its own scale too small, a file is not there.
        (1, format!("{synth} tetrahedron.obj -o b.map.ply"), "target"),
        (1, format!("{synth} shrunk.ply -o b.map.ply"), "`scale`"),
        (1, format!("{synth} none.obj -o b.map.ply"), "none.obj"),
        (
            2,
            format!("{synth} tetrahedron.obj --texel 1e-9 --levels 7 -o b.map.ply"),
            "--levels",
        ),
        // A camera or a light is the option's, or that of the file that moves it.
        (2, format!("{render} --light point:19.5,19.5,0"), "--light"),
        (
            2,
            format!("{render} --camera-position 1,1,1 --camera-target 1,1,1"),
            "--camera",
        ),
        (
            1,
            format!("{render} --camera-path path.csv --camera-target 19.5,19.5,0"),
            "frame 1",
        ),
        // A depth for normals, heights in millimetres of a map without a size.
        (2, format!("bake normal.toml --depth 0.1 {bake}"), "--depth"),
        (
            2,
            format!("bake height.toml --height-mm 3 {bake}"),
            "--height-mm",
        ),
        (
            2,
            "mesh tetrahedron.obj -o b.ply --vertices 1".into(),
            "--vertices",
        ),
        (
            2,
            "mesh tetrahedron.obj -o b.ply --no-such-option".into(),
            "--no-such-option",
        ),
    ];
    for (code, words, says) in cases {
        let (found, said) = run(folder.path(), &words);
        assert_eq!(found, Some(code), "{words}: {said}");
        assert!(said.contains(says), "{words}: {said}");
    }
}
