//! `mesotex synth --onto atlas`: methods on the texels of a texture atlas, the same bytes at any number of threads,
//! and what is refused.

mod program;

use std::fs;
use std::path::Path;

use mesotex::format::image::write_png;
use mesotex::maps::vertex_map::SurfaceTextonMap;
use mesotex::mesh::shapes;
use mesotex::mesh::writing::write_mesh;
use program::{refuse, succeed};
use serde_json::Value;

/// A folder with a tileable picture of stripes, its exemplar, and a torus without texture coordinates.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut pixels = Vec::new();
    for (row, col) in (0..32_i32).flat_map(|row| (0..32_i32).map(move |col| (row, col))) {
        let stripe = if (row + col) % 8 < 4 { 200 } else { 40 };
        let spot = (row % 16 - 8).pow(2) + (col % 16 - 5).pow(2) < 9;
        pixels.extend([
            stripe,
            if spot { 220 } else { 60 },
            (3 * row + 4 * col) as u8,
        ]);
    }
    write_png(&folder.path().join("a.png"), 32, 32, &pixels).unwrap();
    let torus = shapes::torus(40, 20, 1.0, 0.4);
    write_mesh(&folder.path().join("torus.obj"), &torus).unwrap();
    let words = [
        "exemplar", "a.png", "-o", "a", "--tile", "--levels", "2", "--k", "5",
    ];
    succeed(folder.path(), &words);
    folder
}

const SYNTH: [&str; 4] = ["synth", "a.space.npz", "a.knn.npz", "torus.obj"];
const ATLAS: [&str; 5] = ["--onto", "atlas", "--resolution", "64", "--unwrap"];

fn synth(folder: &Path, output: &str, more: &[&str]) -> Value {
    let words = [&SYNTH[..], &ATLAS, &["-o", output, "--json"], more].concat();
    serde_json::from_str(&succeed(folder, &words)).unwrap()
}

#[test]
fn methods_beat_chance_on_an_atlas_and_report_how_it_was_sampled() {
    let folder = prepared();
    for more in [
        &["--method", "k-coherence"][..],
        &["--method", "k-coherence", "--sampling", "marching"],
        &["--method", "wei-levoy", "--passes", "1"],
    ] {
        let told = synth(
            folder.path(),
            "m.map.ply",
            &[more, &["--report", "r.json"]].concat(),
        );
        let figure = |name: &str| told[name].as_f64().unwrap();
        assert!(figure("energy") < 0.75, "{more:?}: {told}");
        assert!(figure("coherence_one") > 0.3, "{more:?}: {told}");
        assert!((figure("mean_edge") - 1.0).abs() < 0.1, "{told}");
        assert!(figure("stretch_mean") < 0.1, "{more:?}: {told}");
        assert_eq!(
            (figure("resolution"), figure("samples_outside")),
            (64.0, 0.0)
        );
        let map = SurfaceTextonMap::read(&folder.path().join("m.map.ply")).unwrap();
        assert_eq!(map.mesh.positions.len() as f64, figure("vertices"));
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = prepared();
    let bytes = |threads: &str| {
        synth(folder.path(), "m.map.ply", &["--threads", threads]);
        fs::read(folder.path().join("m.map.ply")).unwrap()
    };
    assert!(bytes("1") == bytes("4"));
}

#[test]
fn what_an_atlas_does_not_have_is_refused() {
    let folder = prepared();
    let refused = |more: &str, code: i32, said: &str| {
        let more: Vec<&str> = more.split(' ').collect();
        let words = [&SYNTH[..], &["-o", "m.map.ply"], &more].concat();
        let error = refuse(folder.path(), &words, code);
        assert!(error.contains(said), "{more:?}: {error}");
    };
    refused("--onto atlas", 1, "no texture coordinates");
    refused("--onto atlas", 1, "--unwrap makes them");
    refused(
        "--onto atlas --unwrap --method adaptive",
        2,
        "--onto: atlas with --method adaptive",
    );
    refused(
        "--onto atlas --unwrap --texel 0.1",
        2,
        "--texel: given for --onto atlas",
    );
    refused(
        "--onto atlas --unwrap --crease 20",
        2,
        "--crease: given for --onto atlas",
    );
    refused("--onto atlas --resolution 0", 2, "--resolution: 0");
    refused(
        "--onto atlas --unwrap --resolution 8",
        2,
        "--resolution: 8 is too small",
    );
    refused(
        "--onto atlas --texture-scale nan",
        2,
        "--texture-scale: NaN",
    );
    refused("--unwrap", 2, "--unwrap: given for");
    refused(
        "--onto vertices --sampling marching",
        2,
        "--sampling: given for",
    );
    refused("--resolution 512", 2, "--resolution: given for");
    assert!(!folder.path().join("m.map.ply").exists());
}
