//! Texture maps as a user makes them: `transfer` onto atlases and vertices, `bake-maps`, and what is refused.

mod program;

use std::fs;
use std::path::Path;

use image::{GrayImage, Luma, Rgb, RgbImage};
use mesotex::exemplar::ChannelKind;
use mesotex::format::exr::{ExrImage, Numbers};
use mesotex::format::image::{Precision, ReadOptions, decode_srgb, read, read_with};
use mesotex::format::{ContentId, exr};
use mesotex::grid::TexCoord;
use mesotex::index::TextonLabel;
use mesotex::maps::{AtlasMap, MapHeader};
use mesotex::mesh::atlas::{Atlas, TexelPoints};
use mesotex::mesh::shapes::icosphere;
use mesotex::mesh::{reading, vertex_normals};
use mesotex::progress::Progress;
use mesotex::textures::{Canvas, ModelOptions, SampleChannel, write_atlas};
use program::{copy_of, files, mesotex, refuse, succeed};
use serde_json::Value;

const SIDE: u32 = 96;
const SAMPLE: u32 = 16;

/// A ball whose texels take s from their longitude and t from their height.
fn ball() -> AtlasMap {
    let mesh = icosphere(3);
    let quiet = Progress::silent();
    let atlas = Atlas::unwrapped(&mesh, SIDE, quiet).unwrap();
    let points = TexelPoints::new(&mesh, &atlas, SIDE, SIDE).unwrap();
    let texels = 0..points.triangle.len();
    let position = texels.clone().map(|texel| match points.is_inside(texel) {
        true => points.surface_point(&mesh, texel).position,
        false => glam::Vec3::ZERO,
    });
    let position: Vec<glam::Vec3> = position.collect();
    let normal: Vec<glam::Vec3> = position.iter().map(|p| p.normalize_or_zero()).collect();
    let east = |n: &glam::Vec3| match *n == glam::Vec3::ZERO {
        true => *n,
        false => glam::Vec3::Y
            .cross(*n)
            .try_normalize()
            .unwrap_or(glam::Vec3::X),
    };
    let side = SAMPLE as f32;
    let coord = |n: &glam::Vec3| {
        let s = (n.x.atan2(n.z) / std::f32::consts::TAU + 0.5) * side;
        let t = (0.5 + 0.49 * n.y) * side;
        (*n != glam::Vec3::ZERO).then_some(TexCoord {
            s: s.min(side.next_down()),
            t,
        })
    };
    let id = ContentId::of_bytes(b"ball");
    AtlasMap {
        vertex_normals: vertex_normals(&mesh),
        corner_uvs: atlas.corner_uvs.clone(),
        chart_of: atlas.chart_of.clone(),
        width: SIDE,
        height: SIDE,
        chart: texels
            .map(|t| points.chart(&atlas, t).map_or(-1, |chart| chart as i32))
            .collect(),
        orientation: normal.iter().map(east).collect(),
        coords: normal.iter().map(coord).collect(),
        textons: vec![TextonLabel::NONE; position.len()],
        position,
        normal,
        scale: None,
        tileable: true,
        mesh,
        header: MapHeader {
            origin: glam::DVec3::ZERO,
            exemplar: [SAMPLE; 2],
            texel: std::f64::consts::TAU / f64::from(SAMPLE),
            seed: 3,
            method: "coherent".into(),
            polish: 0,
            sample: id.clone(),
            space: id,
        },
    }
}

/// `ball.atlas`; of the sample's size `color.png`, `height.png`, `rough.png`, `holes.png`, `none.png`,
/// `normal.png`; `fine.png` twice as large, `odd.png` of another size.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write_atlas(
        &at("ball.atlas"),
        &ball(),
        &[],
        &ModelOptions::default(),
        Progress::silent(),
    )
    .unwrap();
    let color = |x: u32, y: u32| Rgb([15 * x as u8, 15 * y as u8, 200]);
    RgbImage::from_fn(SAMPLE, SAMPLE, color)
        .save(at("color.png"))
        .unwrap();
    let normal = |_, _| Rgb([128, 128, 255]);
    RgbImage::from_fn(SAMPLE, SAMPLE, normal)
        .save(at("normal.png"))
        .unwrap();
    let grey = |name: &str, side: u32, of: &dyn Fn(u32, u32) -> u8| {
        GrayImage::from_fn(side, side, |x, y| Luma([of(x, y)]))
            .save(at(name))
            .unwrap();
    };
    grey("height.png", SAMPLE, &|_, y| 15 * y as u8);
    grey("rough.png", SAMPLE, &|x, _| 10 * x as u8);
    grey("holes.png", SAMPLE, &|x, y| {
        if (x / 4 + y / 4) % 2 == 0 { 255 } else { 0 }
    });
    grey("none.png", SAMPLE, &|_, _| 0);
    grey("fine.png", 2 * SAMPLE, &|x, _| {
        if x % 2 == 0 { 0 } else { 200 }
    });
    grey("odd.png", SAMPLE + 1, &|_, _| 9);
    folder
}

const ALL: &str = "transfer ball.atlas --maps color.png height.png mask:rough.png alpha:holes.png normal.png \
    -o ball.textures --displace 0.1";

fn run(folder: &Path, line: &str) -> String {
    succeed(folder, &line.split_whitespace().collect::<Vec<_>>())
}

#[test]
fn maps_become_texture_maps_and_a_model() {
    let folder = folder();
    run(folder.path(), ALL);
    let out = folder.path().join("ball.textures");
    let told: Value =
        serde_json::from_slice(&fs::read(out.join("textures.json")).unwrap()).unwrap();
    assert_eq!(
        (&told["width"], &told["format"]),
        (&SIDE.into(), &"mesotex-textures".into())
    );
    let kinds: Vec<&str> = told["channels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["kind"].as_str().unwrap())
        .collect();
    assert_eq!(kinds, ["color", "height", "mask", "alpha", "normal"]);
    // At every texel the image's value at the texel's coordinate, colours mixed in linear light.
    let map = AtlasMap::read(&folder.path().join("ball.atlas")).unwrap();
    let color = read(&out.join("color.png")).unwrap();
    let rough = read_with(&out.join("rough.png"), &ReadOptions::data())
        .unwrap()
        .image;
    let height = read_with(&out.join("height.png"), &ReadOptions::data())
        .unwrap()
        .image;
    assert_eq!(
        (rough.precision, height.precision),
        (Precision::Bits8, Precision::Bits16)
    );
    for (texel, coord) in map.coords.iter().enumerate() {
        let Some(coord) = coord else { continue };
        let row = f32::from(SAMPLE as u8) - coord.t - 0.5;
        let (above, share) = (row.floor().clamp(0.0, 15.0), row - row.floor());
        let below = (row.floor() + 1.0).clamp(0.0, 15.0);
        // Beyond the first and the last row the image goes on with the other end.
        if row > 0.0 && row < 15.0 {
            let green = |row: f32| decode_srgb(15.0 * row / 255.0);
            let wanted = green(above) * (1.0 - share) + green(below) * share;
            assert!((decode_srgb(color.data[3 * texel + 1]) - wanted).abs() < 0.01);
            assert!((height.data[texel] - 15.0 * row / 255.0).abs() < 1e-4);
        }
    }
    // Flat normals lie along the surface's: blue in tangent space, but for the facets of the mesh.
    let normal = read_with(&out.join("normal.png"), &ReadOptions::data())
        .unwrap()
        .image;
    let is_inside = |texel: &usize| map.chart[*texel] >= 0;
    for texel in (0..map.len()).filter(is_inside) {
        assert!(
            normal.data[3 * texel + 2] > 0.98,
            "{:?}",
            &normal.data[3 * texel..][..3]
        );
    }
    let model = reading::read(&out.join("surface.glb"), Progress::silent()).unwrap();
    assert!(model.mesh.triangles.len() > 2 * map.mesh.triangles.len());
    let lengths = model.mesh.positions.iter().map(|p| p.length());
    assert!(lengths.clone().fold(0.0, f32::max) > 1.05);
    assert!(lengths.fold(9.0, f32::min) > 0.97);
    let bytes = fs::read(out.join("surface.glb")).unwrap();
    let text = String::from_utf8_lossy(&bytes[..4000]).into_owned();
    for part in [
        "\"alphaMode\":\"MASK\"",
        "\"doubleSided\":true",
        "\"TANGENT\"",
        "normalTexture",
        "image/png",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn the_same_bytes_at_any_number_of_threads() {
    let folder = folder();
    let made = |threads: &str| {
        run(folder.path(), &format!("{ALL} --threads {threads}"));
        files(&folder.path().join("ball.textures"))
    };
    assert_eq!(made("1"), made("3"));
}

#[test]
fn larger_maps_are_reduced() {
    let folder = folder();
    run(
        folder.path(),
        "transfer ball.atlas --maps mask:fine.png -o a",
    );
    let map = AtlasMap::read(&folder.path().join("ball.atlas")).unwrap();
    let fine = read_with(&folder.path().join("a/fine.png"), &ReadOptions::data())
        .unwrap()
        .image;
    for texel in (0..map.len()).filter(|texel| map.chart[*texel] >= 0) {
        assert!((fine.data[texel] - 100.0 / 255.0).abs() < 0.003);
    }
}

#[test]
fn larger_maps_keep_their_detail_on_finer_textures() {
    let folder = folder();
    run(
        folder.path(),
        "transfer ball.atlas --maps mask:fine.png --finer 2 -o a",
    );
    let fine = read_with(&folder.path().join("a/fine.png"), &ReadOptions::data())
        .unwrap()
        .image;
    assert_eq!((fine.width, fine.height), (2 * SIDE, 2 * SIDE));
    let share = |of: &dyn Fn(f32) -> bool| {
        fine.data.iter().filter(|v| of(**v)).count() as f32 / fine.data.len() as f32
    };
    // Stripes of 0 and 200, where the reduced map is 100 everywhere.
    assert!(share(&|v| v < 0.2) > 0.1 && share(&|v| v > 0.6) > 0.1);
}

#[test]
fn what_cannot_be_carried_is_refused() {
    let folder = folder();
    let refused = |line: &str, code: i32| {
        let before = files(folder.path());
        let line = format!("transfer {line} -o out");
        let said = refuse(
            folder.path(),
            &line.split_whitespace().collect::<Vec<_>>(),
            code,
        );
        let after = files(folder.path());
        let changed = after.keys().filter(|path| !before.contains_key(*path));
        let changed: Vec<_> = changed
            .filter(|path| !path.to_string_lossy().contains(".lock"))
            .collect();
        assert!(changed.is_empty(), "{line}: {changed:?}");
        said
    };
    let said = refused("ball.atlas --maps odd.png", 1);
    assert!(
        said.contains("odd.png: size: 17×17; expected 16×16"),
        "{said}"
    );
    assert!(refused("ball.atlas --maps alpha:none.png", 1).contains("0 at every texel"));
    assert!(refused("ball.atlas --maps color.png --displace 1", 2).contains("--displace"));
    assert!(refused("ball.atlas --maps height.png --displace nan", 2).contains("--displace"));
    assert!(refused("ball.atlas --maps height.png --tile", 2).contains("--tile"));
    assert!(refused("ball.atlas --maps height.png --finer 0", 2).contains("--finer"));
    assert!(refused("ball.atlas --maps height.png --finer 86", 2).contains("1 to 85:"));
    assert!(refused("ball.atlas --maps normal:height.png", 1).contains("red, green and blue"));
    assert!(refused("ball.atlas --maps color.png color.png", 2).contains("twice"));
    assert!(refused("ball.atlas --maps missing.png", 1).contains("missing.png"));
    assert!(refused(". --maps color.png", 1).contains("atlas.json"));
    assert!(refused("color.png --maps color.png", 1).contains("color.png"));
}

#[test]
fn folders_of_others_are_kept() {
    let folder = folder();
    let photos = folder.path().join("photos");
    fs::create_dir(&photos).unwrap();
    fs::write(photos.join("a.jpg"), "mine").unwrap();
    let to = |out: &str| {
        [
            "transfer",
            "ball.atlas",
            "--maps",
            "mask:rough.png",
            "-o",
            out,
        ]
        .map(String::from)
    };
    let words = |out: &str| to(out);
    let refused = |out: &str| {
        let words = words(out);
        refuse(folder.path(), &words.each_ref().map(String::as_str), 2)
    };
    assert!(refused("photos").contains("`a.jpg`"));
    assert!(refused("ball.atlas").contains("--output"));
    // A second run replaces the first; not so where an image was painted over.
    for _ in 0..2 {
        succeed(folder.path(), &words("out").each_ref().map(String::as_str));
    }
    fs::write(folder.path().join("out/rough.png"), b"\x89PNG painted").unwrap();
    assert!(refused("out").contains("`rough.png`"));
}

#[test]
fn damaged_atlases_are_refused_by_file() {
    let folder = folder();
    for name in ["atlas.json", "coords.npy", "surface.npz"] {
        let copy = copy_of(folder.path());
        let path = copy.path().join("ball.atlas").join(name);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let words = [
            "transfer",
            "ball.atlas",
            "--maps",
            "mask:rough.png",
            "-o",
            "out",
        ];
        assert!(refuse(copy.path(), &words, 1).contains(name));
        fs::remove_file(&path).unwrap();
        refuse(copy.path(), &words, 1);
    }
}

/// `flat.map.ply` of a grey exemplar of constant colour, 188 of 255, and its sample `x.sample`.
fn flat() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    RgbImage::from_pixel(16, 16, Rgb([188, 188, 0]))
        .save(at("c.png"))
        .unwrap();
    RgbImage::from_fn(16, 16, |x, _| Rgb([16 * x as u8, 0, 0]))
        .save(at("ramp.png"))
        .unwrap();
    GrayImage::from_fn(16, 16, |_, y| Luma([17 * y as u8]))
        .save(at("rough.png"))
        .unwrap();
    run(
        folder.path(),
        "exemplar c.png -o x --tile --levels 2 --k 2 --neighborhood 3",
    );
    run(
        folder.path(),
        "synth x.space.npz x.knn.npz --grid 12x12 -o flat.map.ply --levels 2",
    );
    folder
}

#[test]
fn vertices_take_the_maps_at_their_texels() {
    let folder = flat();
    run(
        folder.path(),
        "transfer flat.map.ply --maps ramp.png mask:rough.png -o out.ply",
    );
    let map = mesotex::maps::SurfaceTextonMap::read(&folder.path().join("flat.map.ply")).unwrap();
    let out = mesotex::format::ply::read(&folder.path().join("out.ply")).unwrap();
    let column = |name: &str| out.column(name).unwrap();
    for (vertex, coord) in map.coords.iter().enumerate() {
        assert_eq!(
            column("red")[vertex],
            f64::from(16 * coord.s.floor() as u32)
        );
        assert_eq!(
            (column("green")[vertex], column("blue")[vertex]),
            (0.0, 0.0)
        );
        let row = 15.0 - (coord.t - 0.5);
        assert!((column("rough")[vertex] - f64::from(17.0 * row / 255.0)).abs() < 1e-5);
    }
    assert_eq!(out.faces.iter().count(), map.mesh.triangles.len());
}

#[test]
fn a_lambertian_plane_is_baked_as_bright_as_it_is_lit() {
    let folder = flat();
    let linear = decode_srgb(188.0 / 255.0);
    // The plane faces +z, where camera and light stand at elevation 0.
    for (elevation, cosine) in [(0.0, 1.0), (60.0, 0.5)] {
        run(
            folder.path(),
            &format!(
                "bake-maps x.sample flat.map.ply --unwrap -o baked --resolution 32 --camera-elevation 0 \
                 --light-azimuth 0 --light-elevation {elevation}"
            ),
        );
        let options = ReadOptions::data();
        let radiance = folder.path().join("baked/radiance.exr");
        let radiance = read_with(&radiance, &options).unwrap().image;
        for texel in radiance.data.chunks_exact(3) {
            assert!((texel[0] - cosine * linear).abs() < 2e-3, "{texel:?}");
            assert!(texel[2].abs() < 1e-6);
        }
        let color = read(&folder.path().join("baked/color.png")).unwrap();
        assert!(
            color
                .data
                .chunks_exact(3)
                .all(|c| (decode_srgb(c[0]) - cosine * linear).abs() < 6e-3)
        );
    }
    let bytes = fs::read(folder.path().join("baked/surface.glb")).unwrap();
    assert!(String::from_utf8_lossy(&bytes[..3000]).contains("KHR_materials_unlit"));
}

#[test]
fn another_mesh_of_the_same_surface_takes_the_bake() {
    let folder = flat();
    let map = mesotex::maps::SurfaceTextonMap::read(&folder.path().join("flat.map.ply")).unwrap();
    let (low, high) = map.mesh.bounds();
    let quad = |shift: f32, uv: f32| {
        let mut text = String::new();
        for (x, y) in [
            (low.x, low.y),
            (high.x, low.y),
            (high.x, high.y),
            (low.x, high.y),
        ] {
            text += &format!("v {x} {y} {shift}\n");
        }
        text + &format!("vt 0 0\nvt {uv} 0\nvt {uv} 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n")
    };
    fs::write(folder.path().join("quad.obj"), quad(0.0, 1.0)).unwrap();
    fs::write(folder.path().join("far.obj"), quad(high.x, 1.0)).unwrap();
    fs::write(folder.path().join("wide.obj"), quad(0.0, 1.5)).unwrap();
    let line = |mesh: &str| {
        format!(
            "bake-maps x.sample flat.map.ply --mesh {mesh} -o baked --resolution 16 --camera-elevation 0"
        )
    };
    run(folder.path(), &line("quad.obj"));
    let color = read(&folder.path().join("baked/color.png")).unwrap();
    assert!(
        color
            .data
            .chunks_exact(3)
            .all(|c| c[0] > 0.3 && c[2] == 0.0)
    );
    let refused = |line: &str, code| {
        refuse(
            folder.path(),
            &line.split_whitespace().collect::<Vec<_>>(),
            code,
        )
    };
    assert!(refused(&line("far.obj"), 1).contains("from the map's surface"));
    assert!(refused(&line("wide.obj"), 1).contains("wide.obj"));
    let bare = "bake-maps x.sample flat.map.ply -o b";
    assert!(refused(bare, 2).contains("--unwrap"));
    assert!(refused(&format!("{bare} --unwrap --resolution 8"), 2).contains("--resolution"));
    assert!(refused(&format!("{bare} --unwrap --frames 3"), 2).contains("--frames"));
    let output = mesotex(folder.path(), &["bake-maps", "--help"]);
    let help = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        help.contains("--light-azimuth") && !help.contains("--sweep "),
        "{help}"
    );
}

/// `relief.atlas`: the ball with the channels of `height.png` and `holes.png`, and `x.sample` beside it.
fn with_channels() -> tempfile::TempDir {
    let folder = folder();
    let map = ball();
    let channel = |name: &str, kind| {
        let image = read_with(&folder.path().join(name), &ReadOptions::data())
            .unwrap()
            .image;
        SampleChannel::of_image(name.into(), kind, image, map.grid(), 1).unwrap()
    };
    let channels = [
        channel("height.png", ChannelKind::Height),
        channel("holes.png", ChannelKind::Alpha),
    ];
    let quiet = Progress::silent();
    let textures = Canvas::new(&map, 1)
        .unwrap()
        .carry_all(&channels, quiet)
        .unwrap();
    let target = folder.path().join("relief.atlas");
    write_atlas(&target, &map, &textures, &ModelOptions::default(), quiet).unwrap();
    run(
        folder.path(),
        "exemplar color.png -o x --tile --levels 2 --k 2 --neighborhood 3",
    );
    folder
}

/// The alpha of a frame: 1 where the surface covers a pixel.
fn coverage(frame: &Path) -> f32 {
    let options = ReadOptions {
        layer: Some("A".into()),
        ..ReadOptions::data()
    };
    let alpha = read_with(frame, &options).unwrap().image.data;
    alpha.iter().sum::<f32>() / alpha.len() as f32
}

#[test]
fn atlases_are_rendered_with_relief_and_holes() {
    let folder = with_channels();
    let camera = "--size 64x64 --force --camera-position 0,0,6";
    let drawn = |atlas: &str, more: &str| {
        run(
            folder.path(),
            &format!("render x.sample {atlas} -o f {camera} {more}"),
        );
        coverage(&folder.path().join("f/frame.0001.exr"))
    };
    let whole = drawn("ball.atlas", "");
    let holed = drawn("relief.atlas", "");
    let raised = drawn("relief.atlas", "--displace 0.5");
    // Through holes of the front those of the back are seen through, here and there.
    assert!(
        holed < 0.95 * whole && holed > 0.3 * whole,
        "{holed} of {whole}"
    );
    assert!(raised > 1.1 * holed, "{raised} after {holed}");
    // Frames of another relief are made anew.
    let kept = |more: &str| {
        let line =
            format!("render x.sample relief.atlas -o f {camera} --skip-existing --json {more}");
        let told: Value = serde_json::from_str(&run(folder.path(), &line)).unwrap();
        told["kept"].as_u64().unwrap()
    };
    assert_eq!([kept("--displace 0.5"), kept("--displace 0.4")], [1, 0]);
    let refused = |line: &str, code| {
        refuse(
            folder.path(),
            &line.split_whitespace().collect::<Vec<_>>(),
            code,
        )
    };
    let line = format!("render x.sample ball.atlas -o g {camera} --displace 0.5");
    assert!(refused(&line, 2).contains("no channel of heights"));
    fs::write(folder.path().join("relief.atlas/holes-png.png"), "damaged").unwrap();
    assert!(refused(&line.replace("ball", "relief"), 1).contains("holes-png.png"));
}

#[test]
fn synthesis_writes_an_atlas_that_everything_reads() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let color = |x: u32, y: u32| {
        Rgb([
            if (x / 4 + y / 4).is_multiple_of(2) {
                220
            } else {
                40
            },
            90,
            8 * x as u8,
        ])
    };
    RgbImage::from_fn(SAMPLE, SAMPLE, color)
        .save(at.join("c.png"))
        .unwrap();
    let height = |x: u32, _| Luma([(16 * x) as u8]);
    GrayImage::from_fn(SAMPLE, SAMPLE, height)
        .save(at.join("height.png"))
        .unwrap();
    let torus = mesotex::mesh::shapes::torus(24, 12, 1.0, 0.4);
    mesotex::mesh::write_mesh(&at.join("torus.obj"), &torus).unwrap();
    run(
        at,
        "exemplar c.png height.png -o x --tile --levels 2 --k 3 --neighborhood 3",
    );
    let synth = "synth x.space.npz x.knn.npz torus.obj --levels 2";
    let onto = "--onto atlas --resolution 64 --unwrap -o t.atlas";
    run(at, &format!("{synth} {onto} --displace 0.05"));
    let map = AtlasMap::read(&at.join("t.atlas")).unwrap();
    assert_eq!(
        (map.width, map.header.exemplar, map.tileable),
        (64, [SAMPLE; 2], true)
    );
    // Each texel shows the sample's texel that its coordinate names.
    let image = read(&at.join("t.atlas/color.png")).unwrap();
    let height = read_with(&at.join("t.atlas/height.png"), &ReadOptions::data())
        .unwrap()
        .image;
    let sample = read(&at.join("c.png")).unwrap();
    for (texel, coord) in map.coords.iter().enumerate() {
        let Some(coord) = coord else { continue };
        let from = map.grid().texel_nearest(*coord);
        let (row, col) = map.grid().row_col(from);
        for channel in 0..3 {
            let (found, wanted) = (
                image.data[3 * texel + channel],
                sample.get(row, col, channel as u32),
            );
            assert!((found - wanted).abs() < 1.5 / 255.0, "{found} {wanted}");
        }
        assert!((height.data[texel] - 16.0 * col as f32 / 255.0).abs() < 1e-3);
    }
    let told: Value = serde_json::from_str(&run(at, "info t.atlas --json")).unwrap();
    assert_eq!(
        (&told["kind"], &told["width"]),
        (&"atlas".into(), &64.into())
    );
    run(
        at,
        "render x.sample t.atlas -o f --size 64x48 --displace 0.05",
    );
    run(at, "transfer t.atlas --maps c.png --finer 2 -o t.textures");
    assert_eq!(read(&at.join("t.textures/c.png")).unwrap().width, 128);
    let refused = |line: &str, code| refuse(at, &line.split_whitespace().collect::<Vec<_>>(), code);
    assert!(refused(&format!("{synth} -o t.atlas"), 2).contains("--onto atlas"));
    assert!(refused(&format!("{synth} -o t.map.ply --displace 1"), 2).contains("--displace"));
    run(
        at,
        "exemplar c.png -o y --tile --levels 2 --k 3 --neighborhood 3",
    );
    let flat = synth.replace("x.", "y.");
    assert!(refused(&format!("{flat} {onto} --displace 1"), 2).contains("no channel is a height"));
    fs::write(at.join("t.atlas/thesis.tex"), "mine").unwrap();
    assert!(refused(&format!("{synth} {onto}"), 2).contains("thesis.tex"));
}

/// The mean of a channel of a frame over the pixels that the surface covers.
fn mean_of(frame: &Path, channel: &str) -> f32 {
    let options = ReadOptions {
        layer: Some(channel.into()),
        ..ReadOptions::data()
    };
    let values = read_with(frame, &options).unwrap().image.data;
    values.iter().sum::<f32>() / values.len() as f32 / coverage(frame)
}

#[test]
fn a_plain_colour_shows_in_place_of_holes() {
    let folder = with_channels();
    let at = |name: &str| folder.path().join(name);
    let green = "--surface-color 0,255,0";
    // In the model: opaque, red over green where the image is transparent.
    RgbImage::from_pixel(SAMPLE, SAMPLE, Rgb([255, 0, 0]))
        .save(at("red.png"))
        .unwrap();
    run(
        folder.path(),
        &format!("transfer ball.atlas --maps color:red.png alpha:holes.png -o g {green}"),
    );
    let model = fs::read(at("g/surface.glb")).unwrap();
    let text = String::from_utf8_lossy(&model[..4000]).into_owned();
    assert!(
        !text.contains("alphaMode") && !text.contains("doubleSided"),
        "{text}"
    );
    let image = embedded_png(&model);
    let holes = read_with(&at("g/holes.png"), &ReadOptions::data())
        .unwrap()
        .image;
    let map = AtlasMap::read(&at("ball.atlas")).unwrap();
    for texel in (0..map.len()).filter(|texel| map.chart[*texel] >= 0) {
        let [red, share] = [decode_srgb(image.data[3 * texel]), holes.data[texel]];
        assert!((red - share).abs() < 0.01, "{red} {share}");
        assert!((decode_srgb(image.data[3 * texel + 1]) - (1.0 - share)).abs() < 0.01);
    }
    // In frames, with every way of shading: the whole ball is there, and greener.
    let camera =
        "--size 48x48 --force --camera-position 0,0,6 --light-azimuth 0 --light-elevation 0";
    for shading in [
        "--shading vertex",
        "--shading pixel",
        "--shading vertex --shadows pixel",
    ] {
        let drawn = |atlas: &str, more: &str| {
            let line = format!("render x.sample {atlas} -o f {camera} {shading} {more}");
            run(folder.path(), &line);
            let frame = at("f/frame.0001.exr");
            (
                coverage(&frame),
                ["R", "G", "B"].map(|name| mean_of(&frame, name)),
            )
        };
        let (whole, plain) = drawn("ball.atlas", "");
        let (covered, mixed) = drawn("relief.atlas", green);
        assert!((covered - whole).abs() < 1e-3, "{covered} of {whole}");
        // About half of the sample is transparent there: blue is halved, and green comes near that of a matte ball.
        assert!(
            (mixed[2] / plain[2] - 0.5).abs() < 0.1,
            "{mixed:?} {plain:?}"
        );
        assert!(mixed[1] > plain[1], "{mixed:?} {plain:?}");
    }
    // Frames of another colour are made anew.
    let kept = |color: &str| {
        let line = format!("render x.sample relief.atlas -o f {camera} --skip-existing --json");
        let line = format!("{line} --shading vertex --shadows pixel --surface-color {color}");
        let told: Value = serde_json::from_str(&run(folder.path(), &line)).unwrap();
        told["kept"].as_u64().unwrap()
    };
    assert_eq!([kept("#00ff00"), kept("#00fe00")], [1, 0]);
}

/// The first PNG in a GLB.
fn embedded_png(model: &[u8]) -> mesotex::format::image::FloatImage {
    let start = model
        .windows(4)
        .position(|bytes| bytes == b"\x89PNG")
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.png");
    fs::write(&path, &model[start..]).unwrap();
    read(&path).unwrap()
}

#[test]
fn a_plain_colour_that_nothing_shows_is_refused() {
    let folder = with_channels();
    GrayImage::from_pixel(SAMPLE, SAMPLE, Luma([255]))
        .save(folder.path().join("white.png"))
        .unwrap();
    let refused = |line: &str| {
        refuse(
            folder.path(),
            &line.split_whitespace().collect::<Vec<_>>(),
            2,
        )
    };
    let blue = "--surface-color 0,0,255";
    for (line, says) in [
        (
            "transfer ball.atlas --maps color.png -o o",
            "no channel is alpha",
        ),
        (
            "transfer ball.atlas --maps color.png alpha:white.png -o o",
            "channel `white` is 1 at every texel",
        ),
        (
            "transfer ball.atlas --maps alpha:holes.png -o o --transparency blend",
            "beside --transparency blend",
        ),
        ("render x.sample ball.atlas -o o", "has no channel of alpha"),
        (
            "render x.sample ball.map.ply -o o",
            "given for ball.map.ply",
        ),
        (
            "bake-maps x.sample ball.atlas -o o",
            "has no channel of alpha",
        ),
        (
            "bake-maps x.sample ball.map.ply --unwrap -o o",
            "given for ball.map.ply",
        ),
        (
            "transfer ball.map.ply --maps color.png -o o.ply",
            "given for ball.map.ply",
        ),
    ] {
        let said = refused(&format!("{line} {blue}"));
        assert!(
            said.contains("surface-color") && said.contains(says),
            "{line}: {said}"
        );
    }
    let said = refused("render x.sample relief.atlas -o o --surface-color 0.1,0.5,0.2");
    assert!(said.contains("0 to 255"), "{said}");
}

#[test]
fn maps_of_other_depths_keep_what_they_hold() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let deep = |x: u32, y: u32| Luma([(257 * x + 16 * y) as u16]);
    image::ImageBuffer::from_fn(SAMPLE, SAMPLE, deep)
        .save(at("deep.png"))
        .unwrap();
    let texels = || (0..SAMPLE * SAMPLE).map(|texel| (texel % SAMPLE, texel / SAMPLE));
    let wide = |name: &str, of: &dyn Fn((u32, u32)) -> f32| {
        let numbers: Vec<f32> = texels().map(of).collect();
        (name.to_owned(), Numbers::Float(numbers.into()))
    };
    let image = ExrImage {
        size: [SAMPLE; 2],
        channels: [
            wide("R", &|(x, _)| x as f32 / 4.0),
            wide("G", &|(_, y)| y as f32 / 16.0),
            wide("B", &|_| 2.5),
        ]
        .into(),
        attributes: Default::default(),
    };
    let encoded = exr::encode(&image, exr::Compression::default()).unwrap();
    exr::write(&at("wide.exr"), &encoded).unwrap();
    let grey = |x: u32, _| Luma([16 * x as u8]);
    GrayImage::from_fn(SAMPLE, SAMPLE, grey)
        .save(at("grey.png"))
        .unwrap();
    run(
        folder.path(),
        "transfer ball.atlas --maps mask:deep.png color:wide.exr -o a",
    );
    let map = AtlasMap::read(&at("ball.atlas")).unwrap();
    let channel = |name: &str, kind, data: bool| {
        let options = match data {
            true => ReadOptions::data(),
            false => ReadOptions::default(),
        };
        let image = read_with(&at(name), &options).unwrap().image;
        SampleChannel::of_image("x".into(), kind, image, map.grid(), 1).unwrap()
    };
    let (deep, wide) = (
        channel("deep.png", ChannelKind::Mask, true),
        channel("wide.exr", ChannelKind::Color, false),
    );
    let stored = |name: &str| read_with(&at(name), &ReadOptions::data()).unwrap().image;
    let (deep_map, wide_map) = (stored("a/deep.png"), stored("a/wide.exr"));
    assert_eq!(
        [deep_map.precision, wide_map.precision],
        [Precision::Bits16, Precision::Float]
    );
    for texel in (0..map.len()).filter(|texel| map.chart[*texel] >= 0) {
        let coord = map.coords[texel].unwrap();
        // Half a step of 16 bits.
        assert!((deep_map.data[texel] - deep.at(coord)[0]).abs() < 0.6 / 65535.0);
        for (number, wanted) in wide_map.data[3 * texel..].iter().zip(wide.at(coord)) {
            assert!((number - wanted).abs() < 1e-5);
        }
    }
    // Grey colours stay grey in their image, and are all three in the model.
    run(
        folder.path(),
        "transfer ball.atlas --maps color:grey.png -o b",
    );
    assert_eq!(stored("b/grey.png").channels, 1);
    let model = embedded_png(&fs::read(at("b/surface.glb")).unwrap());
    assert_eq!(model.channels, 3);
    assert!(
        model
            .data
            .chunks_exact(3)
            .all(|c| c[0] == c[1] && c[1] == c[2])
    );
    // Of one number per texel there are no normals; of three no masks.
    let refused = |line: &str| refuse(folder.path(), &line.split(' ').collect::<Vec<_>>(), 1);
    let said = refused("transfer ball.atlas --maps mask:wide.exr -o c");
    assert!(said.contains("wide.exr"), "{said}");
    let said = refused("transfer ball.atlas --maps normal:deep.png -o c");
    assert!(said.contains("deep.png"), "{said}");
}
