//! Synthesis into a texture atlas: the folder that comes of it, its frames, and what is refused.

mod program;

use std::fs;
use std::path::Path;

use mesotex::exemplar::channels::ChannelKind;
use mesotex::format::image::write_png;
use mesotex::maps::atlas_map::{AtlasMap, Description};
use mesotex::mesh::shapes;
use mesotex::mesh::writing::write_mesh;
use mesotex::progress::Progress;
use mesotex::textures::decorated::{Shape, decorated};
use mesotex::textures::folder::read_channel;
use program::{files, refuse, succeed};
use serde_json::Value;

/// A folder with a tileable picture of stripes, its heights and holes, their exemplar and sample, and a torus.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (mut colors, mut heights, mut alpha) = (Vec::new(), Vec::new(), Vec::new());
    for (row, col) in (0..32i32).flat_map(|row| (0..32i32).map(move |col| (row, col))) {
        let stripe = u8::from((row + col) % 8 < 4);
        let hole = (row % 16 - 8).pow(2) + (col % 16 - 8).pow(2) < 9;
        colors.extend([40 + 160 * stripe, 60, (3 * row + 4 * col) as u8]);
        heights.extend([100 * stripe; 3]);
        alpha.extend([255 * u8::from(!hole); 3]);
    }
    for (name, pixels) in [
        ("color.png", &colors),
        ("height.png", &heights),
        ("alpha.png", &alpha),
    ] {
        write_png(&at(name), 32, 32, pixels).unwrap();
    }
    write_mesh(&at("torus.obj"), &shapes::torus(30, 16, 1.0, 0.4)).unwrap();
    let words = [
        "exemplar",
        "color.png",
        "height.png",
        "alpha.png",
        "-o",
        "a",
        "--tile",
        "--levels",
        "2",
        "--k",
        "5",
    ];
    succeed(folder.path(), &words);
    folder
}

const ATLAS: [&str; 6] = [
    "torus.obj",
    "--onto",
    "atlas",
    "--resolution",
    "64",
    "--unwrap",
];

fn synth(folder: &Path, output: &str, more: &[&str]) -> Value {
    let words = ["synth", "a.space.npz", "a.knn.npz", "-o", output, "--json"];
    let told = succeed(folder, &[&words[..], &ATLAS, more].concat());
    serde_json::from_str(&told).unwrap()
}

#[test]
fn every_method_fills_the_charts_and_threads_change_no_byte() {
    let folder = prepared();
    for method in ["k-coherence", "wei-levoy", "multiscale", "coherent"] {
        let on = |threads: &str| {
            let name = format!("{method}-{threads}.atlas");
            let told = synth(
                folder.path(),
                &name,
                &["--method", method, "--threads", threads],
            );
            assert_eq!(
                (&told["method"], &told["resolution"]),
                (&method.into(), &64.into())
            );
            name
        };
        let [one, two, eight] = ["1", "2", "8"].map(on);
        let map = AtlasMap::read(&folder.path().join(&one)).unwrap();
        let inside = map.chart.iter().filter(|chart| **chart >= 0).count();
        assert_eq!(map.coords.iter().flatten().count(), inside);
        assert!(inside > 64 * 64 / 4, "{inside}");
        let one = files(&folder.path().join(one));
        for name in [
            "color.png",
            "height.png",
            "alpha.png",
            "surface.glb",
            "atlas.json",
        ] {
            assert!(one.contains_key(Path::new(name)), "{name}");
        }
        for other in [two, eight] {
            assert!(
                one == files(&folder.path().join(&other)),
                "{method}, {other}"
            );
        }
    }
}

#[test]
fn frames_show_holes_and_relief() {
    let folder = prepared();
    synth(folder.path(), "a.atlas", &["--method", "coherent"]);
    let frame = |more: &[&str]| {
        let words = [
            "render", "a.sample", "a.atlas", "-o", "frames", "--frames", "1", "--size", "64x64",
        ];
        succeed(folder.path(), &[&words, more].concat());
        fs::read(folder.path().join("frames/frame.0001.exr")).unwrap()
    };
    assert!(frame(&[]) != frame(&["--displace", "0.5"]));
    let atlas = folder.path().join("a.atlas");
    let map = AtlasMap::read(&atlas).unwrap();
    let told = Description::read(&atlas).unwrap();
    let channel = |kind| read_channel(&atlas, &told, kind).unwrap().unwrap();
    let [alpha, heights] = [ChannelKind::Alpha, ChannelKind::Height].map(channel);
    let shown = |relief| {
        let shape = Shape {
            relief,
            alpha: Some(&alpha),
            is_covered: false,
        };
        decorated(&map, shape, Progress::silent()).unwrap().map
    };
    let (level, moved) = (shown(None), shown(Some((&heights, 0.5))));
    let torus = shapes::torus(30, 16, 1.0, 0.4);
    let share = level.mesh.area() / torus.area();
    // Discs of 25 texels in squares of 16 × 16.
    assert!((0.85..0.95).contains(&share), "{share}");
    // Stripes are 100/255 high.
    let grown = (moved.mesh.bounds().1 - level.mesh.bounds().1).max_element();
    assert!((0.15..0.2).contains(&grown), "{grown}");
    let refused = refuse(
        folder.path(),
        &[
            "render",
            "a.sample",
            "a.map.ply",
            "-o",
            "x",
            "--displace",
            "1",
        ],
        2,
    );
    assert!(
        refused.contains("--displace") && refused.contains("an atlas"),
        "{refused}"
    );
}

#[test]
fn what_no_atlas_can_be_is_refused_by_name() {
    let folder = prepared();
    let refused = |words: &[&str], code| {
        let begin = ["synth", "a.space.npz", "a.knn.npz", "torus.obj"];
        refuse(folder.path(), &[&begin[..], words].concat(), code)
    };
    let atlas = ["--onto", "atlas", "--unwrap", "--resolution", "64"];
    let text = refused(&["-o", "x.atlas"], 2);
    assert!(text.contains("--onto atlas"), "{text}");
    let text = refused(&["-o", "x.map.ply", "--displace", "0.1"], 2);
    assert!(text.contains("--displace"), "{text}");
    let text = refused(
        &[&atlas[..], &["-o", "x.atlas", "--method", "adaptive"]].concat(),
        2,
    );
    assert!(text.contains("adaptive"), "{text}");
    let text = refused(
        &["--onto", "atlas", "--resolution", "64", "-o", "x.atlas"],
        1,
    );
    assert!(text.contains("--unwrap"), "{text}");
    let text = refused(
        &[
            "--onto",
            "atlas",
            "--unwrap",
            "--resolution",
            "3",
            "-o",
            "x.atlas",
        ],
        2,
    );
    assert!(text.contains("resolution"), "{text}");
    fs::create_dir(folder.path().join("x.atlas")).unwrap();
    fs::write(folder.path().join("x.atlas/mine.txt"), "mine").unwrap();
    let text = refused(&[&atlas[..], &["-o", "x.atlas"]].concat(), 2);
    assert!(text.contains("mine.txt"), "{text}");
}

#[test]
fn methods_beat_chance_and_report_how_the_atlas_was_sampled() {
    let folder = prepared();
    for more in [
        &["--method", "k-coherence"][..],
        &["--method", "k-coherence", "--sampling", "marching"],
        &["--method", "wei-levoy", "--passes", "1"],
    ] {
        let more = [more, &["--report", "r.json"]].concat();
        let told = synth(folder.path(), "m.atlas", &more);
        let figure = |name: &str| told[name].as_f64().unwrap();
        assert!(figure("energy") < 0.75, "{more:?}: {told}");
        assert!(figure("coherence_one") > 0.3, "{more:?}: {told}");
        assert!((figure("mean_edge") - 1.0).abs() < 0.1, "{told}");
        assert!(figure("stretch_mean") < 0.1, "{more:?}: {told}");
        assert_eq!(figure("samples_outside"), 0.0);
    }
}

#[test]
fn options_that_an_atlas_does_not_have_are_refused() {
    let folder = prepared();
    let refused = |more: &str, code: i32, said: &str| {
        let more: Vec<&str> = more.split(' ').collect();
        let begin = ["synth", "a.space.npz", "a.knn.npz", "torus.obj"];
        let error = refuse(folder.path(), &[&begin[..], &more].concat(), code);
        assert!(error.contains(said), "{more:?}: {error}");
    };
    let atlas = "-o m.atlas --onto atlas";
    for (more, code, said) in [
        ("", 1, "no texture coordinates"),
        (
            " --unwrap --texel 0.1",
            2,
            "--texel: given for --onto atlas",
        ),
        (
            " --unwrap --crease 20",
            2,
            "--crease: given for --onto atlas",
        ),
        (" --resolution 0", 2, "--resolution: 0"),
        (" --texture-scale nan", 2, "--texture-scale: NaN"),
    ] {
        refused(&format!("{atlas}{more}"), code, said);
    }
    refused("-o m.map.ply --unwrap", 2, "--unwrap: given for");
    refused(
        "-o m.map.ply --onto vertices --sampling marching",
        2,
        "--sampling: given for",
    );
    refused(
        "-o m.map.ply --resolution 512",
        2,
        "--resolution: given for",
    );
}
