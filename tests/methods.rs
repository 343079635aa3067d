//! The methods of `mesotex synth`: each on a mesh and on a grid, the same bytes at any number of threads, and what
//! is refused of each.

mod program;

use std::fs;
use std::path::Path;

use mesotex::format::image::write_png;
use mesotex::maps::SurfaceTextonMap;
use mesotex::mesh::{shapes, write_mesh};
use mesotex::synthesis::Method;
use program::{refuse, succeed};
use serde_json::Value;

/// A folder with a tileable picture of stripes and spots, its exemplar, and a torus of about its texels.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut pixels = Vec::new();
    for (row, col) in (0..32i32).flat_map(|row| (0..32i32).map(move |col| (row, col))) {
        let stripe = (row + col) % 8 < 4;
        let spot = (row % 16 - 8).pow(2) + (col % 16 - 5).pow(2) < 9;
        let [stripe, spot] =
            [(stripe, 200, 40), (spot, 220, 60)].map(|(on, a, b)| if on { a } else { b });
        pixels.extend([stripe, spot, (3 * row + 4 * col) as u8]);
    }
    write_png(&folder.path().join("a.png"), 32, 32, &pixels).unwrap();
    let torus = shapes::torus(60, 24, 1.0, 0.4);
    write_mesh(&folder.path().join("torus.obj"), &torus).unwrap();
    let words = [
        "exemplar", "a.png", "-o", "a", "--tile", "--levels", "2", "--k", "5",
    ];
    succeed(folder.path(), &words);
    folder
}

fn synth(folder: &Path, target: &[&str], output: &str, more: &[&str]) -> Value {
    let words = ["synth", "a.space.npz", "a.knn.npz", "-o", output, "--json"];
    let told = succeed(folder, &[&words, target, more].concat());
    serde_json::from_str(&told).unwrap()
}

/// The methods that need neither faces nor controls.
fn methods() -> impl Iterator<Item = &'static str> {
    let ordinary = Method::ALL.iter().filter(|method| method.is_ordinary());
    ordinary.map(|method| method.name())
}

const GRID: [&str; 2] = ["--grid", "40x40"];
const MESH: [&str; 1] = ["torus.obj"];

#[test]
fn every_method_beats_chance_on_a_mesh_and_on_a_grid() {
    let folder = prepared();
    for method in methods() {
        for target in [&GRID[..], &MESH] {
            let more = ["--method", method, "--report", "r.json"];
            let told = synth(folder.path(), target, "m.map.ply", &more);
            assert_eq!(told["method"], method);
            let energy = told["energy"].as_f64().unwrap();
            assert!(energy < 0.75, "{method} on {target:?}: {energy}");
            let map = SurfaceTextonMap::read(&folder.path().join("m.map.ply")).unwrap();
            assert_eq!(map.header.method, method);
            let info = succeed(folder.path(), &["info", "m.map.ply"]);
            assert!(info.contains(&format!("method {method}")), "{info}");
        }
    }
}

#[test]
fn threads_and_the_cache_change_no_byte() {
    let folder = prepared();
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    for method in methods().filter(|method| *method != "k-coherence") {
        for target in [&GRID[..], &MESH] {
            for threads in ["1", "2", "8"] {
                let cache = folder.path().join("torus.obj.mesotex-cache");
                if threads == "8" && cache.exists() {
                    fs::remove_dir_all(&cache).unwrap();
                }
                let fewer: &[&str] = match method {
                    "wei-levoy" => &["--passes", "2"],
                    _ => &[],
                };
                let more = [&["--method", method, "--threads", threads], fewer].concat();
                synth(folder.path(), target, &format!("{threads}.map.ply"), &more);
            }
            assert!(
                bytes("1.map.ply") == bytes("2.map.ply"),
                "{method} on {target:?}"
            );
            assert!(
                bytes("1.map.ply") == bytes("8.map.ply"),
                "{method} on {target:?}"
            );
        }
    }
}

#[test]
fn another_field_costs_no_marching() {
    let folder = prepared();
    let circles = |more: &[&str]| {
        let more = [&["--method", "adaptive"], more].concat();
        let told = synth(folder.path(), &MESH, "m.map.ply", &more);
        told["circles"].as_str().unwrap().to_owned()
    };
    assert_eq!(circles(&[]), "marched");
    assert_eq!(circles(&[]), "read from the cache");
    assert_eq!(circles(&["--direction", "0,1,0"]), "read from the cache");
    assert_eq!(circles(&["--rings", "2"]), "marched");
    // Round neighbourhoods are not compared with the square windows of the exemplar.
    let told = synth(folder.path(), &MESH, "m.map.ply", &["--method", "adaptive"]);
    assert!(
        told.get("energy").is_none() && told["k"].is_null(),
        "{told}"
    );
}

#[test]
fn a_toroidal_grid_of_whole_periods_is_a_copy() {
    let folder = prepared();
    let target = ["--grid", "64x64"];
    let told = synth(
        folder.path(),
        &target,
        "m.map.ply",
        &["--method", "adaptive"],
    );
    assert!(told["coherence_half"].as_f64().unwrap() > 0.95, "{told}");
}

#[test]
fn what_a_method_does_not_use_is_refused() {
    let folder = prepared();
    let words = ["synth", "a.space.npz", "a.knn.npz", "-o", "m.map.ply"];
    let refused = |more: &str, said: &str| {
        let more: Vec<&str> = more.split(' ').collect();
        let error = refuse(folder.path(), &[&words[..], &more].concat(), 2);
        assert!(error.contains(said), "{more:?}: {error}");
    };
    refused(
        "--grid 40x40 --method adaptive --coherence 2",
        "--coherence: given with --method adaptive",
    );
    refused(
        "--grid 40x40 --method wei-levoy --rings 5",
        "--rings: given with --method wei-levoy",
    );
    refused("--grid 40x40 --method adaptive --metric gram", "--metric");
    refused("--grid 40x40 --method adaptive --rings 9", "1 to 8");
    refused(
        "--grid 40x40 --method coherent --window 5",
        "--window: given with --method coherent",
    );
    refused(
        "--grid 40x40 --method multiscale --passes 4",
        "--passes: given with --method multiscale",
    );
    refused(
        "--grid 40x40 --method multiscale --levels 2 --window 17",
        "--window: 17 texels wide on the sample's level 1 of 16×16",
    );
    refused("--grid 12x12 --method multiscale", "--grid: 12x12");
    refused(
        "torus.obj --method coherent --crease 20",
        "--crease: given for --method coherent",
    );
    refused("--grid 6x6 --method adaptive", "--grid: 6x6");
    refused("--grid 40x40 --onto vertices", "--onto: vertices");
    refused("torus.obj --onto grid", "--onto: grid");
    refused(
        "--grid 40x40 --direction 0,1,0",
        "--direction: given for a flat grid",
    );
    refused(
        "torus.obj --method adaptive --crease 20",
        "--crease: given for --method adaptive",
    );
    refused(
        "--grid 40x40 --method wei-levoy --polish 1",
        "--polish: given with --method wei-levoy",
    );
    refused("--grid 40x40 --noise 0.1", "--distance-floor 0.1");
    refused("--grid 40x40 --mends 1", "--repair-rounds 1");
    refused("--grid 40x40 --evenness 1", "--reuse-penalty 1");
    refused("--grid 40x40 --energy 1", "--spectrum 1");
    assert!(!folder.path().join("m.map.ply").exists());
}

#[test]
fn an_adaptive_run_goes_on_after_an_interruption() {
    let folder = prepared();
    synth(
        folder.path(),
        &MESH,
        "whole.map.ply",
        &["--method", "adaptive"],
    );
    let words = ["--method", "adaptive", "--resume"];
    synth(folder.path(), &MESH, "again.map.ply", &words);
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("whole.map.ply") == bytes("again.map.ply"));
}
