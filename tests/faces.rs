//! Synthesis onto faces: the files that come of it, their frames, and what is refused.

mod program;

use std::fs;
use std::path::Path;

use mesotex::exemplar::Space;
use mesotex::format::image::{
    Alpha, FloatImage, ReadOptions, decode_srgb, encode_srgb8, read_with, write_png,
};
use mesotex::format::{npz, ply};
use mesotex::maps::FaceMap;
use mesotex::mesh::{TriangleMesh, shapes, write_mesh};
use mesotex::synthesis::faces::at_centers;
use mesotex::textures::SampleChannel;
use ndarray::{Ix2, Ix3};
use program::{files, mesotex, refuse, succeed, with_other};
use serde_json::Value;

/// A picture of blots and its heights, of any size.
fn write_pictures(folder: &Path, [width, height]: [u32; 2]) {
    let (mut colors, mut heights) = (Vec::new(), Vec::new());
    for (row, col) in (0..height).flat_map(|row| (0..width).map(move |col| (row, col))) {
        let wave = |a: u32, b: u32| (f64::from(a * row + b * col) * 0.35).sin();
        let blot = (wave(2, 1) + wave(1, 3) + wave(3, 2)) / 3.0;
        let value = |low: f64, high: f64| (low + (high - low) * (0.5 + 0.5 * blot)) as u8;
        colors.extend([value(40.0, 220.0), value(90.0, 60.0), (5 * (row % 7)) as u8]);
        heights.extend([value(10.0, 200.0); 3]);
    }
    write_png(&folder.join("color.png"), width, height, &colors).unwrap();
    write_png(&folder.join("height.png"), width, height, &heights).unwrap();
}

/// A folder with an exemplar of colour and height, 16 × 16 texels, and a torus of 1,024 triangles in two colours.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_pictures(folder.path(), [16, 16]);
    write_mesh(
        &folder.path().join("torus.obj"),
        &shapes::torus(16, 8, 1.0, 0.4),
    )
    .unwrap();
    exemplar(folder.path());
    folder
}

fn exemplar(folder: &Path) {
    let words = [
        "exemplar",
        "color.png",
        "height.png",
        "-o",
        "a",
        "--levels",
        "2",
        "--k",
        "4",
    ];
    succeed(folder, &words);
}

const SYNTH: [&str; 8] = [
    "synth",
    "a.space.npz",
    "torus.obj",
    "-o",
    "a.faces.ply",
    "--method=choosy",
    "--onto=faces",
    "--base-faces=256",
];

fn synth(folder: &Path, more: &[&str]) -> Value {
    let told = succeed(folder, &[&SYNTH[..], &["--json"], more].concat());
    serde_json::from_str(&told).unwrap()
}

#[test]
fn threads_change_no_byte_of_any_product() {
    let on = |threads: &str| {
        let folder = prepared();
        let products = [
            "--glb=a.glb",
            "--vertex-colors=a.colors.ply",
            "--levels-out=a.levels.npz",
            "--report=a.json",
            "--iterations=2,1",
            "--seed=5",
            "--threads",
            threads,
        ];
        synth(folder.path(), &products);
        let mut made = files(folder.path());
        made.retain(|path, _| !path.to_string_lossy().contains(".sample"));
        made
    };
    let one = on("1");
    assert!(one.contains_key(Path::new("a.glb")) && one.contains_key(Path::new("a.levels.npz")));
    for threads in ["2", "8"] {
        for (path, bytes) in on(threads) {
            assert!(one[&path] == bytes, "{threads} threads: {}", path.display());
        }
    }
}

#[test]
fn faces_keep_the_histograms_of_their_sample() {
    let folder = tempfile::tempdir().unwrap();
    write_pictures(folder.path(), [32, 32]);
    let torus = shapes::torus(32, 16, 1.0, 0.4);
    write_mesh(&folder.path().join("torus.obj"), &torus).unwrap();
    let words = ["exemplar", "color.png", "-o", "a", "--levels=3", "--k=4"];
    succeed(folder.path(), &words);
    let words = [
        &SYNTH[..7],
        &["--base-faces=1024", "--subdivisions=2", "--json"],
    ];
    let told: Value = serde_json::from_str(&succeed(folder.path(), &words.concat())).unwrap();
    assert_eq!(told["faces"], 16_384, "{told}");
    let distance = told["histogram_l1"].as_f64().unwrap();
    assert!(distance <= 0.05, "{distance}");
}

#[test]
fn faces_have_the_colours_and_channels_of_their_sources() {
    let folder = prepared();
    let told = synth(folder.path(), &[]);
    assert_eq!(told["level_faces"], serde_json::json!([256, 1024]));
    assert_eq!(
        (&told["base_mesh"], &told["levels"]),
        (&"given".into(), &2.into())
    );
    assert_eq!(told["eigenvalues"].as_array().unwrap().len(), 2);
    assert_eq!(told["eigenvalues"][0].as_array().unwrap().len(), 4 * 36);
    assert_eq!(told["histograms"][1]["channel"], "height");
    assert!(told["histogram_l1"].as_f64().unwrap() < 0.7, "{told}");
    assert!(told["seconds"]["synthesis"].is_f64() && told["histogram_chi2"].is_null());
    let path = folder.path().join("a.faces.ply");
    let head = fs::read(&path).unwrap();
    let head = String::from_utf8_lossy(&head[..900]).into_owned();
    let properties = "property list uchar int vertex_indices\nproperty float r\nproperty float g\nproperty float b\n\
                      property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uint source\n\
                      property uchar phase\nproperty float height\nend_header\n";
    for part in [
        "comment mesotex 1\n",
        "comment square 0 0 16\n",
        "comment method choosy\n",
        properties,
    ] {
        assert!(head.contains(part), "{part}: {head}");
    }
    let map = FaceMap::read(&path).unwrap();
    let space = Space::read(&folder.path().join("a.space.npz")).unwrap();
    let channels = SampleChannel::of_space(&space);
    let centers = at_centers(&map).unwrap();
    let colors = map.colors.as_ref().unwrap();
    for (face, &at) in centers.coords.iter().enumerate() {
        assert_eq!(colors[face], channels[0].at(at));
        assert_eq!(map.channels[0].numbers[face], channels[1].at(at)[0]);
    }
    let file = ply::read(&path).unwrap();
    let red = file.face_column("red").unwrap();
    assert!((0..1024).all(|face| f64::from(encode_srgb8(colors[face][0])) == red[face]));
    // All phases and both grids are used.
    let finest = 2 * told["sample_faces"][1].as_u64().unwrap() as u32;
    assert!((0..3).all(|phase| map.phases.contains(&phase)));
    assert!(map.sources.iter().any(|&source| source < finest / 2));
    assert!(map.sources.iter().any(|&source| source >= finest / 2));
    let info = succeed(
        folder.path(),
        &["info", "a.faces.ply", "--against", "a.space.npz"],
    );
    assert!(
        info.contains("1024 faces, 2 levels") && info.contains("colours and height"),
        "{info}"
    );
    succeed(
        folder.path(),
        &["info", "a.faces.ply", "--against", "a.sample"],
    );
}

#[test]
fn levels_are_the_pyramids_of_sample_and_surface() {
    let folder = prepared();
    synth(folder.path(), &["--levels-out=a.levels.npz"]);
    let mut file = npz::Reader::open(&folder.path().join("a.levels.npz")).unwrap();
    let sample = file.array::<f32, Ix3>("sample/L0/gaussian").unwrap();
    let surface = file.array::<f32, Ix2>("surface/L0/gaussian").unwrap();
    assert_eq!((surface.dim(), sample.dim()), ((1024, 4), (2, 416, 4)));
    let known: std::collections::BTreeSet<Vec<u32>> = (0..2)
        .flat_map(|grid| (0..416).map(move |face| (grid, face)))
        .map(|(grid, face)| {
            (0..4)
                .map(|at| sample[[grid, face, at]].to_bits())
                .collect()
        })
        .collect();
    for row in surface.rows() {
        let row: Vec<u32> = row.iter().map(|number| number.to_bits()).collect();
        assert!(known.contains(&row));
    }
    for (name, wanted) in [("sample/L1/gaussian", 104), ("sample/L0/laplacian", 416)] {
        assert_eq!(file.array::<f32, Ix3>(name).unwrap().dim(), (2, wanted, 4));
    }
    assert!(!file.has("sample/L1/laplacian") && file.has("surface/L0/laplacian"));
    assert_eq!(
        file.array::<u32, Ix2>("surface/L1/triangles")
            .unwrap()
            .dim(),
        (256, 3)
    );
    let told = succeed(folder.path(), &["info", "a.levels.npz"]);
    assert!(
        told.contains("level 0: 1024 faces of 4 numbers, 416 triangles"),
        "{told}"
    );
}

#[test]
fn models_and_vertex_colours_show_the_faces() {
    let folder = prepared();
    synth(
        folder.path(),
        &["--glb=a.glb", "--vertex-colors=a.colors.ply"],
    );
    let map = FaceMap::read(&folder.path().join("a.faces.ply")).unwrap();
    let bytes = fs::read(folder.path().join("a.glb")).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let told: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let at = told["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]
        .as_u64()
        .unwrap();
    let view = &told["bufferViews"][told["accessors"][at as usize]["bufferView"]
        .as_u64()
        .unwrap() as usize];
    let first = 28 + length + view["byteOffset"].as_u64().unwrap() as usize;
    let colors: &[u8] = &bytes[first..first + 1024 * 36];
    let number = |at: usize| f32::from_le_bytes(colors[4 * at..4 * at + 4].try_into().unwrap());
    for (face, color) in map.colors.as_ref().unwrap().iter().enumerate() {
        assert!((0..9).all(|at| number(9 * face + at) == color[at % 3]));
    }
    let file = ply::read(&folder.path().join("a.colors.ply")).unwrap();
    assert_eq!((file.vertex_count, file.faces.sizes.len()), (512, 1024));
    let mean = |numbers: &mut dyn Iterator<Item = f32>| numbers.sum::<f32>();
    let of_vertices = file.column("red").unwrap();
    let of_vertices = mean(
        &mut of_vertices
            .iter()
            .map(|&byte| decode_srgb(byte as f32 / 255.0)),
    ) / 512.0;
    let of_faces = mean(&mut map.colors.unwrap().iter().map(|color| color[0])) / 1024.0;
    assert!(
        (of_vertices / of_faces - 1.0).abs() < 0.1,
        "{of_vertices} {of_faces}"
    );
}

#[test]
fn frames_show_the_colours_of_faces_under_their_lights() {
    let folder = tempfile::tempdir().unwrap();
    write_pictures(folder.path(), [16, 16]);
    write_mesh(&folder.path().join("torus.obj"), &shapes::grid(16, 8, 1.0)).unwrap();
    exemplar(folder.path());
    synth(folder.path(), &[]);
    let shown = |more: &[&str]| {
        let words = "render a.sample a.faces.ply -o frames --frames 1 --size 80x80 --texels bilinear --shadows none \
                     --camera-azimuth 0 --camera-elevation 0 --light-azimuth 0 --projection orthographic --samples 1 --weights inverse-angle";
        let words: Vec<&str> = words.split_whitespace().collect();
        succeed(folder.path(), &[&words[..], more].concat());
        let options = ReadOptions {
            alpha: Alpha::Ignore,
            ..ReadOptions::default()
        };
        let frame = folder.path().join("frames/frame.0001.exr");
        read_with(&frame, &options).unwrap().image
    };
    // Seen and lit from the front, the plane z = 0 shows its colours as they are.
    let map = FaceMap::read(&folder.path().join("a.faces.ply")).unwrap();
    let colors = map.colors.as_ref().unwrap();
    let frame = shown(&["--light-elevation", "0"]);
    let pixels: Vec<[f32; 3]> = frame
        .data
        .chunks_exact(frame.channels as usize)
        .map(|pixel| [pixel[0], pixel[1], pixel[2]])
        .filter(|pixel| pixel.iter().any(|&value| value > 0.0))
        .collect();
    assert!(pixels.len() > 1000, "{}", pixels.len());
    let is_known = |pixel: &[f32; 3]| {
        colors
            .iter()
            .any(|color| (0..3).all(|at| (pixel[at] - color[at]).abs() < 2e-3))
    };
    let known = pixels.iter().filter(|pixel| is_known(pixel)).count();
    assert!(
        known * 100 >= pixels.len() * 99,
        "{known} of {}",
        pixels.len()
    );
    // Inside a face the sample shows only with pixel shading.
    let inside = shown(&["--light-elevation", "0", "--shading", "pixel"]);
    assert!(inside.data != frame.data);
    let grazing = shown(&["--light-elevation", "60"]);
    let sum = |image: &FloatImage| image.data.iter().sum::<f32>();
    assert!(sum(&grazing) < 0.75 * sum(&frame));
    let refused = refuse(
        folder.path(),
        &program::words("render a.sample a.faces.ply -o x --displace 1"),
        2,
    );
    assert!(
        refused.contains("--displace") && refused.contains("an atlas"),
        "{refused}"
    );
}

#[test]
fn a_table_may_stand_between_and_must_belong() {
    let folder = prepared();
    synth(folder.path(), &[]);
    let alone = fs::read(folder.path().join("a.faces.ply")).unwrap();
    let words =
        "synth a.space.npz a.knn.npz torus.obj -o b.faces.ply --method choosy --base-faces 256";
    let words: Vec<&str> = words.split(' ').collect();
    succeed(folder.path(), &words);
    assert_eq!(fs::read(folder.path().join("b.faces.ply")).unwrap(), alone);
    succeed(
        folder.path(),
        &[
            "exemplar",
            "height.png",
            "-o",
            "b",
            "--levels",
            "2",
            "--k",
            "4",
        ],
    );
    let other = with_other(&words, "a.knn.npz", "b.knn.npz");
    let text = refuse(folder.path(), &other, 1);
    assert!(text.contains("space id"), "{text}");
    succeed(folder.path(), &[&other[..], &["--force"]].concat());
}

#[test]
fn samples_are_cropped_and_meshes_without_two_colours_subdivided_and_both_are_said() {
    let folder = tempfile::tempdir().unwrap();
    write_pictures(folder.path(), [23, 18]);
    // Every edge is a crease, which no chain of splits crosses, and twelve vertices have five edges.
    let facets = shapes::icosphere(1);
    write_mesh(&folder.path().join("torus.obj"), &facets).unwrap();
    exemplar(folder.path());
    let told = synth(folder.path(), &["--subdivisions=1", "--crease=5"]);
    assert_eq!(told["square"], serde_json::json!([2, 0, 18]));
    assert_eq!(told["base_mesh"], "barycentric");
    let warnings = told["warnings"].to_string();
    assert!(
        warnings.contains("23 × 18 texels; its middle 18 × 18"),
        "{warnings}"
    );
    assert!(warnings.contains("barycentrically"), "{warnings}");
    let again = ["--subdivisions=1", "--crease=5"];
    let text = succeed(folder.path(), &[&SYNTH[..], &again].concat());
    assert!(
        text.contains("because no two colours were found") && text.contains("next: mesotex render"),
        "{text}"
    );
    assert!(text.contains("histogram distance"), "{text}");
}

#[test]
fn holes_specks_and_edges_of_three_triangles_are_textured() {
    let folder = prepared();
    // A hole of one triangle and a triangle apart: boundaries shorter than a neighbourhood.
    let mut mesh = shapes::torus(16, 8, 1.0, 0.4);
    mesh.triangles.remove(40);
    let first = mesh.positions.len() as u32;
    let speck = [[3.0, 0.0, 0.0], [3.2, 0.0, 0.0], [3.0, 0.2, 0.0]];
    mesh.positions.extend(speck.map(glam::Vec3::from_array));
    mesh.triangles.push([first, first + 1, first + 2]);
    write_mesh(&folder.path().join("torus.obj"), &mesh).unwrap();
    let told = synth(folder.path(), &[]);
    assert_eq!(told["faces"], 1024);
    assert_eq!(told["warnings"].as_array().unwrap().len(), 0);
    // A fin on an edge of the torus.
    let [a, b, _] = mesh.triangles[3];
    mesh.triangles.push([a, b, first]);
    write_mesh(&folder.path().join("torus.obj"), &mesh).unwrap();
    let told = synth(folder.path(), &[]);
    let warnings = told["warnings"].to_string();
    assert!(
        warnings.contains("more than two triangles meet"),
        "{warnings}"
    );
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let folder = prepared();
    let refused = |more: &str, code: i32, said: &str| {
        let words = ["synth", "a.space.npz", "torus.obj", "-o", "x.faces.ply"];
        let more: Vec<&str> = more.split_whitespace().collect();
        let text = refuse(folder.path(), &[&words[..], &more].concat(), code);
        assert!(text.contains(said), "{more:?}: {text}");
    };
    let choosy = "--method choosy --onto faces";
    for (more, said) in [
        ("", "SPACE TABLE MESH"),
        ("--onto faces", "--onto: faces with --method k-coherence"),
        (
            "--method choosy --onto atlas",
            "--onto: other sites than faces",
        ),
        (
            "--method coherent --base-faces 300",
            "--base-faces: given for",
        ),
        (
            "--method coherent --iterations 2",
            "--iterations: given with --method coherent",
        ),
        (
            "--method coherent --glb x.glb",
            "--glb: given for sites that are not faces",
        ),
    ] {
        refused(more, 2, said);
    }
    for (more, said) in [
        ("--base-faces 100", "at least the 104 triangles"),
        (
            "--base-faces 300 --texel 0.1",
            "--texel: 0.1 beside --base-faces",
        ),
        ("--texel 3", "the surface would be smaller than the sample"),
        (
            "--subdivisions 3",
            "--subdivisions: 3 with a sample of 16 texels",
        ),
        ("--levels 2", "this one has --subdivisions"),
        ("--passes 2", "this one has --iterations"),
        ("--metric gram", "--metric"),
        ("--k 5", "--k: given with --method choosy"),
        ("--window 5", "--window: given with --method choosy"),
        ("--direction 0,1,0", "faces have no orientation"),
        ("--unwrap", "--unwrap"),
        ("--resume", "--resume"),
        ("--force", "--force"),
        ("--pictures p", "--pictures"),
        ("--displace 1", "--displace"),
        ("--iterations 0", "--iterations"),
        ("--dimensions 0", "--dimensions"),
        ("--sample a.sample", "the space has colours of its own"),
        (
            "--subdivisions 1 --base-faces 16777216",
            "67108864 faces of 4 numbers",
        ),
    ] {
        refused(&format!("{choosy} {more}"), 2, said);
    }
    let grid = [
        "synth",
        "a.space.npz",
        "a.knn.npz",
        "--grid",
        "8x8",
        "-o",
        "x.ply",
        "--method",
        "choosy",
    ];
    let text = refuse(folder.path(), &grid, 2);
    assert!(text.contains("--grid"), "{text}");
    let atlas = [
        "synth",
        "a.space.npz",
        "torus.obj",
        "-o",
        "x.atlas",
        "--method",
        "choosy",
    ];
    assert!(refuse(folder.path(), &atlas, 2).contains("--output"));
    let empty = TriangleMesh::default();
    write_mesh(&folder.path().join("empty.obj"), &empty).unwrap();
    let none = [
        "synth",
        "a.space.npz",
        "empty.obj",
        "-o",
        "x.faces.ply",
        "--method",
        "choosy",
    ];
    let output = mesotex(folder.path(), &none);
    assert_eq!(output.status.code(), Some(1));
    assert!(!folder.path().join("x.faces.ply").exists());
}

#[test]
fn textons_have_isotropic_maps_too() {
    let folder = prepared();
    let run = |words: &str| succeed(folder.path(), &words.split_whitespace().collect::<Vec<_>>());
    run(
        "bake --preset weave --size 32 --views fibonacci:5 --lights fibonacci:5 --samples 1 -o w.sample",
    );
    run("textons w.sample -o w.textons.npz --textons 20 --levels 2");
    run("gram w.textons.npz -o w.space.npz");
    let told = run("synth w.space.npz torus.obj -o w.faces.ply --method choosy --json");
    let told: Value = serde_json::from_str(&told).unwrap();
    assert!(told["histogram_chi2"].is_f64() && told["histogram_l1"].is_null());
    assert!(told["spectrum_kept"].as_f64().unwrap() > 0.9);
    assert!(
        FaceMap::read(&folder.path().join("w.faces.ply"))
            .unwrap()
            .colors
            .is_none()
    );
    let before = fs::read(folder.path().join("w.faces.ply")).unwrap();
    let words = "synth w.space.npz torus.obj -o w.faces.ply --method choosy --glb w.glb";
    let words: Vec<&str> = words.split(' ').collect();
    assert!(refuse(folder.path(), &words, 2).contains("--sample X.sample"));
    succeed(
        folder.path(),
        &[&words[..], &["--sample", "w.sample"]].concat(),
    );
    assert!(
        FaceMap::read(&folder.path().join("w.faces.ply"))
            .unwrap()
            .colors
            .is_some()
    );
    assert!(fs::read(folder.path().join("w.faces.ply")).unwrap() != before);
    for shading in ["vertex", "pixel"] {
        run(&format!(
            "render w.sample w.faces.ply -o w.{shading} --size 48x48 --shading {shading}"
        ));
    }
}

#[test]
fn face_maps_are_refused_where_other_maps_are_wanted() {
    let folder = prepared();
    synth(folder.path(), &[]);
    for command in [
        "transfer a.faces.ply --maps color.png -o t.ply",
        "bake-maps a.sample a.faces.ply -o t.maps --unwrap",
    ] {
        let words: Vec<&str> = command.split(' ').collect();
        let error = refuse(folder.path(), &words, 1);
        assert!(
            error.contains("a map of faces") && error.contains("--glb"),
            "{error}"
        );
    }
}

#[test]
fn scenes_make_face_maps() {
    let folder = prepared();
    let scene = "name = \"s\"\nsurface = \"torus.obj\"\n[exemplar]\nimages = [\"color.png\"]\nlevels = 2\nk = 4\n\
                 [synth]\nmethod = \"choosy\"\nbase-faces = 256\n[[render]]\nsize = \"32x32\"\n";
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    succeed(folder.path(), &["run", "scene.toml"]);
    assert!(FaceMap::read(&folder.path().join("s.faces.ply")).is_ok());
    assert!(folder.path().join("s.frames/frame.0001.exr").exists());
}
