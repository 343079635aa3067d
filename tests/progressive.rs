//! Progressively-variant textures on surfaces: keys, the map that comes of them, and what is refused.

mod program;

use std::fs;
use std::path::Path;

use mesotex::format::image::write_png;
use mesotex::maps::SurfaceTextonMap;
use mesotex::mesh::{shapes, write_mesh};
use program::{refuse, succeed, with_other};
use serde_json::{Value, json};

const WIDTH: i32 = 64;
const HEIGHT: i32 = 32;

/// Whether a texel lies on a dark stripe; stripes grow wider to the right.
fn is_dark(col: i32) -> bool {
    ((col as f32 / 6.0).powf(0.75) * 2.0).fract() < 0.5
}

/// A folder with an exemplar of stripes that grow wider, a torus and keys on it.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let image = |name: &str, value: &dyn Fn(i32, i32) -> u8| {
        let pixels = (0..WIDTH * HEIGHT).flat_map(|at| [value(at / WIDTH, at % WIDTH); 3]);
        let path = folder.path().join(name);
        write_png(
            &path,
            WIDTH as u32,
            HEIGHT as u32,
            &pixels.collect::<Vec<_>>(),
        )
        .unwrap();
    };
    image("color.png", &|row, col| {
        (40 + 160 * i32::from(is_dark(col)) + 5 * (row % 3)) as u8
    });
    image("mask.png", &|_, col| u8::from(is_dark(col)));
    image("transition.png", &|_, col| (255 * col / (WIDTH - 1)) as u8);
    write_mesh(
        &folder.path().join("torus.obj"),
        &shapes::torus(60, 28, 1.0, 0.4),
    )
    .unwrap();
    write_keys(folder.path(), &[(0, 0.1), (30 * 28, 0.9)]);
    let words = "exemplar color.png -o a --levels 2 --k 6 --mask mask.png --transition transition.png \
                 --transition-tolerance 0.1";
    succeed(
        folder.path(),
        &words
            .split(' ')
            .filter(|word| !word.is_empty())
            .collect::<Vec<_>>(),
    );
    folder
}

fn write_keys(folder: &Path, keys: &[(u64, f64)]) {
    let key =
        |&(vertex, transition): &(u64, f64)| json!({"vertex": vertex, "transition": transition});
    let keys: Vec<Value> = keys.iter().map(key).collect();
    fs::write(folder.join("keys.json"), json!({"keys": keys}).to_string()).unwrap();
}

const SYNTH: [&str; 10] = [
    "synth",
    "a.space.npz",
    "a.knn.npz",
    "torus.obj",
    "-o",
    "a.map.ply",
    "--method=progressive",
    "--keys=keys.json",
    "--mask-window=7",
    "--json",
];

#[test]
fn textures_follow_the_keys() {
    let folder = prepared();
    let told = succeed(folder.path(), &SYNTH);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert!(told["searched"].is_u64() && told["components"].as_u64().unwrap() > 0);
    let map = SurfaceTextonMap::read(&folder.path().join("a.map.ply")).unwrap();
    let (transition, mask) = (map.transition.unwrap(), map.mask.unwrap());
    assert!((transition[0] - 0.1).abs() < 1e-6 && (transition[30 * 28] - 0.9).abs() < 1e-6);
    for (vertex, at) in map.coords.iter().enumerate() {
        let here = at.s.floor() / (WIDTH - 1) as f32;
        assert!(
            (here - transition[vertex]).abs() < 0.1 + 1.0 / 255.0,
            "{vertex}"
        );
        assert_eq!(mask[vertex], u8::from(is_dark(at.s as i32)));
    }
    // The same whatever the threads.
    let before = fs::read(folder.path().join("a.map.ply")).unwrap();
    succeed(folder.path(), &[&SYNTH[..], &["--threads=1"]].concat());
    assert_eq!(fs::read(folder.path().join("a.map.ply")).unwrap(), before);
}

#[test]
fn grids_and_atlases_have_transitions_too() {
    let folder = prepared();
    let keys = json!({"keys": [
        {"point": [0, 12, 0], "transition": 0.05}, {"point": [40, 12, 0], "transition": 0.95},
    ]});
    fs::write(folder.path().join("plane.json"), keys.to_string()).unwrap();
    let words = "synth a.space.npz a.knn.npz --grid 40x24 -o g.map.ply --method progressive \
                 --keys plane.json --border open";
    succeed(folder.path(), &words.split_whitespace().collect::<Vec<_>>());
    let map = SurfaceTextonMap::read(&folder.path().join("g.map.ply")).unwrap();
    let transition = map.transition.unwrap();
    let row: Vec<f32> = (0..40).map(|col| transition[12 * 40 + col]).collect();
    assert!(row.is_sorted() && row[0] < 0.1 && row[39] > 0.9, "{row:?}");
    let words = "synth a.space.npz a.knn.npz torus.obj -o a.atlas --method progressive --keys keys.json \
                 --onto atlas --resolution 96 --unwrap";
    succeed(folder.path(), &words.split_whitespace().collect::<Vec<_>>());
    assert!(folder.path().join("a.atlas/color.png").exists());
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let folder = prepared();
    let path = folder.path();
    let with = |more: &[&str]| refuse(path, &[&SYNTH[..], more].concat(), 1);
    write_keys(path, &[(0, 0.5)]);
    assert!(with(&[]).contains("1 vertex with a transition"));
    write_keys(path, &[(0, 0.5), (3, 1.5)]);
    let said = with(&[]);
    assert!(
        said.contains("keys.json") && said.contains("key 1: transition 1.5"),
        "{said}"
    );
    write_keys(path, &[(0, 0.5), (0, 0.6), (4, 0.1)]);
    assert!(with(&[]).contains("key 1: transition 0.6 at a vertex that has 0.5"));
    write_keys(path, &[(0, 0.0), (900, 1.0)]);
    let without: Vec<&str> = SYNTH
        .iter()
        .copied()
        .filter(|word| !word.contains("keys"))
        .collect();
    let said = refuse(path, &without, 1);
    assert!(
        said.contains("transition: of the exemplar, none of the surface"),
        "{said}"
    );
    let other: Vec<&str> = SYNTH
        .iter()
        .copied()
        .filter(|word| !word.contains("method"))
        .collect();
    let said = refuse(path, &other, 2);
    assert!(
        said.contains("--mask-window: given with --method k-coherence"),
        "{said}"
    );
    let words = "knn a.space.npz -o b.knn.npz --k 6";
    succeed(path, &words.split_whitespace().collect::<Vec<_>>());
    let table = with_other(&SYNTH, "a.knn.npz", "b.knn.npz");
    assert!(refuse(path, &table, 1).contains("knn --transition-tolerance 0.1"));
}
