//! Synthesis into a texture atlas: the folder that comes of it, its frames, and what is refused.

mod program;

use std::fs;
use std::path::Path;

use mesotex::exemplar::ChannelKind;
use mesotex::format::image::write_png;
use mesotex::maps::{AtlasDescription, AtlasMap};
use mesotex::mesh::{shapes, write_mesh};
use mesotex::progress::Progress;
use mesotex::textures::{Shape, decorated, read_channel};
use program::{copy_of, files, refuse, succeed};
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

/// A torus of quadrilaterals, beside the others.
fn write_quads(folder: &Path) {
    let mesh = shapes::torus(8, 5, 1.0, 0.4);
    let mut text = String::new();
    for p in &mesh.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    let (halves, _) = mesh.triangles.as_chunks::<2>();
    for [[a, b, c], [.., d]] in halves {
        text += &format!("f {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1);
    }
    fs::write(folder.join("quads.obj"), text).unwrap();
}

const FACES: [&str; 6] = [
    "quads.obj",
    "--onto",
    "atlas",
    "--resolution",
    "70",
    "--charts=faces",
];

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
fn faces_of_a_control_mesh_are_charts_of_its_smooth_surface() {
    let folder = prepared();
    write_quads(folder.path());
    for (method, more) in [
        ("multiscale", &[][..]),
        ("coherent", &["--sampling", "marching"]),
        ("coherent", &["--field-energy", "cosine"]),
    ] {
        let on = |threads: &str| {
            let words = ["synth", "a.space.npz", "a.knn.npz", "-o", "q.atlas"];
            let method = ["--json", "--method", method, "--threads", threads];
            let told = succeed(folder.path(), &[&words[..], &FACES, &method, more].concat());
            let told: Value = serde_json::from_str(&told).unwrap();
            (told, files(&folder.path().join("q.atlas")))
        };
        let [(told, one), (_, two)] = ["1", "2"].map(on);
        assert!(one == two, "{method}");
        // 40 faces in 7 columns of 10 texels: 8 to a square's side.
        assert_eq!(
            (&told["charts"], &told["subdivisions"]),
            (&40.into(), &2.into())
        );
        assert!(told["stretch_mean"].as_f64().unwrap() < 0.15, "{told}");
        let map = AtlasMap::read(&folder.path().join("q.atlas")).unwrap();
        assert_eq!(map.mesh.triangles.len(), 40 * 2 * 16);
        assert_eq!(map.coords.iter().flatten().count(), 40 * 64);
    }
    let words = [
        "render", "a.sample", "q.atlas", "-o", "frames", "--frames", "1", "--size", "32x32",
    ];
    succeed(folder.path(), &words);
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
    let told = AtlasDescription::read(&atlas).unwrap();
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
        &program::words("render a.sample a.map.ply -o x --displace 1"),
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
        (" --charts faces", 1, "face 0: 3 corners"),
        (
            " --charts faces --unwrap",
            2,
            "--charts: faces together with --unwrap",
        ),
        (
            " --charts faces --align uv",
            2,
            "--align: uv together with --charts faces",
        ),
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
    refused("-o m.map.ply --charts faces", 2, "--charts: given for");
    refused(
        "-o m.map.ply --resolution 512",
        2,
        "--resolution: given for",
    );
}

/// Two squares side by side as OBJ, their texture coordinates as given; the faces' corners run round each square.
fn squares(uvs: [[[f32; 2]; 4]; 2]) -> String {
    let mut text = String::new();
    for x in 0..3 {
        text += &format!("v {x} 0 0\nv {x} 1 0\n");
    }
    for [u, v] in uvs.into_iter().flatten() {
        text += &format!("vt {u} {v}\n");
    }
    text + "f 1/1 3/2 4/3 2/4\nf 3/5 5/6 6/7 4/8\n"
}

/// A square's texture coordinates: lower left corner and side.
fn square_at(u: f32, v: f32, side: f32) -> [[f32; 2]; 4] {
    [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| [u + side * x, v + side * y])
}

/// The words of a synthesis onto the texture coordinates of a mesh.
fn onto(mesh: &str) -> [&str; 10] {
    let [space, table] = ["a.space.npz", "a.knn.npz"];
    let output = ["-o", "x.atlas", "--onto", "atlas", "--resolution", "64"];
    let [a, b, c, d, e, f] = output;
    ["synth", space, table, mesh, a, b, c, d, e, f]
}

#[test]
fn texture_coordinates_that_are_no_atlas_are_refused_by_place() {
    let folder = prepared();
    let left = square_at(0.05, 0.1, 0.4);
    let refused = |name: &str, second: [[f32; 2]; 4], said: &[&str]| {
        let mesh = format!("{name}.obj");
        fs::write(folder.path().join(&mesh), squares([left, second])).unwrap();
        let text = refuse(folder.path(), &onto(&mesh), 1);
        for said in said {
            assert!(text.contains(said), "{name}: {text}");
        }
        assert!(!folder.path().join("x.atlas").exists());
    };
    let unwrap = "--unwrap makes new";
    refused(
        "over",
        square_at(0.3, 0.3, 0.4),
        &[
            "over.obj: triangle 2",
            "lies over triangle",
            "do not overlap",
            unwrap,
        ],
    );
    refused(
        "outside",
        square_at(0.7, 0.1, 0.4),
        &["outside.obj: triangle 2", "(1.1", "0 to 1", unwrap],
    );
    refused(
        "thin",
        [[0.6, 0.2], [0.7, 0.2], [0.8, 0.2], [0.9, 0.2]],
        &["thin.obj: triangle 2", "no area in the texture", unwrap],
    );
    refused(
        "missing",
        [[f32::NAN; 2], [0.7, 0.2], [0.8, 0.3], [0.9, 0.2]],
        &["missing.obj"],
    );
    refused(
        "touching",
        square_at(0.451, 0.1, 0.4),
        &["touching.obj", "touch at row", "--resolution"],
    );
    // The same two squares with room between them.
    fs::write(
        folder.path().join("fine.obj"),
        squares([left, square_at(0.55, 0.1, 0.4)]),
    )
    .unwrap();
    succeed(folder.path(), &onto("fine.obj"));
}

#[test]
fn atlases_whose_files_do_not_fit_are_refused_by_file() {
    let folder = prepared();
    synth(folder.path(), "a.atlas", &["--method", "coherent"]);
    write_png(&folder.path().join("small.png"), 3, 2, &[9; 6]).unwrap();
    type Change<'a> = &'a dyn Fn(&Path);
    let describe = |from: &'static str, to: &'static str| {
        move |atlas: &Path| {
            let path = atlas.join("atlas.json");
            let text = fs::read_to_string(&path).unwrap();
            assert!(text.contains(from), "{text}");
            fs::write(path, text.replacen(from, to, 1)).unwrap();
        }
    };
    let cases: [(Change<'_>, &[&str]); 7] = [
        (
            &|atlas| fs::remove_file(atlas.join("alpha.png")).unwrap(),
            &["alpha.png", "cannot read"],
        ),
        (
            &|atlas| fs::remove_file(atlas.join("coords.npy")).unwrap(),
            &["coords.npy", "cannot read"],
        ),
        (
            &|atlas| fs::remove_file(atlas.join("surface.npz")).unwrap(),
            &["surface.npz", "cannot read"],
        ),
        (
            &|atlas| {
                let small = atlas.join("../small.png");
                fs::copy(small, atlas.join("alpha.png")).unwrap();
            },
            &["alpha.png: size: 3×2", "64×64"],
        ),
        (
            &|atlas| fs::write(atlas.join("alpha.png"), "x").unwrap(),
            &["alpha.png"],
        ),
        // A size that the other files do not have is told before memory is asked for.
        (
            &describe("\"width\": 64", "\"width\": 8192"),
            &["coords.npy: shape", "[64, 8192, 2]"],
        ),
        (
            &describe("\"kind\": \"alpha\"", "\"kind\": \"opacity\""),
            &["atlas.json", "channels[2]: kind", "`opacity`", "alpha"],
        ),
    ];
    for (change, said) in cases {
        let copy = copy_of(folder.path());
        let atlas = copy.path().join("a.atlas");
        change(&atlas);
        for line in [
            "render a.sample a.atlas -o o --size 16x16",
            "bake-maps a.sample a.atlas -o o",
        ] {
            let words: Vec<&str> = line.split(' ').collect();
            let text = refuse(copy.path(), &words, 1);
            assert!(
                said.iter().all(|said| text.contains(said)),
                "{line}: {text}"
            );
            assert!(!copy.path().join("o").exists());
        }
    }
}
