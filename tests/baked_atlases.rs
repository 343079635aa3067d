//! `bake-maps` of an atlas: what its texels show is held against closed forms, and a measured material comes from
//! textons to texture maps.

mod program;

use std::fs;
use std::path::Path;

use image::{GrayImage, Luma, Rgb, RgbImage};
use mesotex::exemplar::ChannelKind;
use mesotex::format::image::{FloatImage, ReadOptions, read, read_with};
use mesotex::maps::{AtlasDescription, AtlasMap};
use mesotex::mesh::{shapes, write_mesh};
use mesotex::textures::SampleChannel;
use program::{files, refuse, succeed};
use serde_json::Value;

const SAMPLE: u32 = 16;

fn run(folder: &Path, line: &str) -> String {
    succeed(folder, &line.split_whitespace().collect::<Vec<_>>())
}

/// A torus and a picture with holes; `a.atlas` of both, and `b.atlas` of the picture alone.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let color = |x: u32, y: u32| Rgb([15 * x as u8, 15 * y as u8, 120]);
    RgbImage::from_fn(SAMPLE, SAMPLE, color)
        .save(at("color.png"))
        .unwrap();
    let alpha = |x: u32, y: u32| Luma([if x / 4 == y / 4 { 51 } else { 255 }]);
    GrayImage::from_fn(SAMPLE, SAMPLE, alpha)
        .save(at("alpha.png"))
        .unwrap();
    write_mesh(&at("torus.obj"), &shapes::torus(30, 16, 1.0, 0.4)).unwrap();
    for (name, images) in [("a", "color.png alpha.png"), ("b", "color.png")] {
        let exemplar = "--tile --levels 2 --k 3 --neighborhood 3";
        run(
            folder.path(),
            &format!("exemplar {images} -o {name} {exemplar}"),
        );
        let onto = "torus.obj --onto atlas --resolution 64 --unwrap --method coherent";
        let line = format!("synth {name}.space.npz {name}.knn.npz {onto} -o {name}.atlas");
        run(folder.path(), &line);
    }
    folder
}

/// The light comes along +z.
const LIGHT: &str =
    "--light-azimuth 0 --light-elevation 0 --camera-elevation 0 --shadows none --texels bilinear";

fn radiance(folder: &Path) -> FloatImage {
    let path = folder.join("baked/radiance.exr");
    read_with(&path, &ReadOptions::data()).unwrap().image
}

#[test]
fn texels_show_the_sample_at_their_own_coordinate() {
    let folder = prepared();
    let map = AtlasMap::read(&folder.path().join("a.atlas")).unwrap();
    let channel = |name: &str, kind| {
        let options = match kind {
            ChannelKind::Color => ReadOptions::default(),
            _ => ReadOptions::data(),
        };
        let image = read_with(&folder.path().join(name), &options)
            .unwrap()
            .image;
        SampleChannel::of_image(name.into(), kind, image, map.grid(), 1).unwrap()
    };
    let color = channel("color.png", ChannelKind::Color);
    let alpha = channel("alpha.png", ChannelKind::Alpha);
    let inside: Vec<usize> = (0..map.len()).filter(|t| map.chart[*t] >= 0).collect();
    // White light on a matte surface: the colour times the cosine; below it a plain one, as matte, of albedo 1 in blue.
    for (more, is_covered) in [("", false), ("--surface-color #0000ff", true)] {
        run(
            folder.path(),
            &format!("bake-maps a.sample a.atlas -o baked {LIGHT} {more}"),
        );
        let baked = radiance(folder.path());
        assert_eq!([baked.width, baked.height], [64, 64]);
        let mut seen = 0;
        for &texel in &inside {
            let cosine = map.normal[texel].z;
            let coord = map.coords[texel].unwrap();
            let share = match is_covered {
                true => alpha.at(coord)[0],
                false => 1.0,
            };
            // A light below the horizon of the texel gives nothing.
            let lit = cosine.max(0.0);
            for (at, plain) in [0.0, 0.0, 1.0].into_iter().enumerate() {
                let wanted = lit * (share * color.at(coord)[at] + (1.0 - share) * plain);
                let found = baked.data[3 * texel + at];
                assert!((found - wanted).abs() < 4e-3, "{texel}: {found}, {wanted}");
            }
            seen += usize::from(lit > 0.0);
        }
        assert!(seen > inside.len() / 3);
        let model = fs::read(folder.path().join("baked/surface.glb")).unwrap();
        let text = String::from_utf8_lossy(&model[..4000]).into_owned();
        assert!(text.contains("KHR_materials_unlit"), "{text}");
        assert_eq!(text.contains("\"alphaMode\":\"MASK\""), !is_covered);
        assert_eq!(folder.path().join("baked/alpha.png").exists(), !is_covered);
    }
}

#[test]
fn what_hides_the_light_darkens_texels() {
    let folder = prepared();
    let bake = |shadows: &str| {
        let low = "--light-azimuth 90 --light-elevation 0 --camera-elevation 20 --threads 3";
        let line = format!("bake-maps b.sample b.atlas -o baked {low} --shadows {shadows}");
        run(folder.path(), &line);
        radiance(folder.path()).data
    };
    let (open, hidden) = (bake("none"), bake("vertex"));
    let light: [f32; 2] = [open.iter().sum(), hidden.iter().sum()];
    // The far side of the ring lies in the shadow of the near one.
    assert!(
        light[1] < 0.97 * light[0] && light[1] > 0.5 * light[0],
        "{light:?}"
    );
    assert!(
        open.iter()
            .zip(&hidden)
            .all(|(open, hidden)| *hidden <= open + 1e-5 || *hidden < 0.5)
    );
    assert_eq!(bake("vertex"), bake("pixel"));
    let made = |threads: &str| {
        run(
            folder.path(),
            &format!("bake-maps b.sample b.atlas -o baked --threads {threads}"),
        );
        files(&folder.path().join("baked"))
    };
    assert!(made("1") == made("4"));
}

#[test]
fn textons_come_to_texture_maps_with_one_command() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_mesh(&at.join("torus.obj"), &shapes::torus(30, 16, 1.0, 0.4)).unwrap();
    RgbImage::from_pixel(32, 32, Rgb([9, 200, 9]))
        .save(at.join("albedo.png"))
        .unwrap();
    for line in [
        "bake --preset weave --size 16 --samples 1 --views fibonacci:5 --lights fibonacci:5 -o w.sample",
        "textons w.sample -o w.textons.npz --textons 12 --levels 2",
        "gram w.textons.npz -o w.space.npz",
        "knn w.space.npz -o w.knn.npz --k 3 --neighborhood 3",
    ] {
        run(at, line);
    }
    let synth = "synth w.space.npz w.knn.npz torus.obj --onto atlas --resolution 64 --unwrap";
    let told = run(at, &format!("{synth} -o t.atlas"));
    let next = "next: mesotex bake-maps NAME.sample t.atlas -o t.baked";
    assert!(told.contains(next), "{told}");
    let description = AtlasDescription::read(&at.join("t.atlas")).unwrap();
    assert!(description.channels.is_empty());
    assert!(at.join("t.atlas/texton.npy").is_file());
    run(at, "bake-maps w.sample t.atlas -o t.baked");
    let color = read(&at.join("t.baked/color.png")).unwrap();
    let map = AtlasMap::read(&at.join("t.atlas")).unwrap();
    let lit = (0..map.len()).filter(|t| map.chart[*t] >= 0 && color.data[3 * t] > 0.1);
    let inside = map.chart.iter().filter(|chart| **chart >= 0).count();
    assert!(lit.count() > inside / 4);
    let model = fs::read(at.join("t.baked/surface.glb")).unwrap();
    assert!(model.windows(4).any(|bytes| bytes == b"\x89PNG"));
    run(at, "transfer t.atlas --maps albedo.png -o t.textures");
    let albedo = read(&at.join("t.textures/albedo.png")).unwrap();
    assert!((albedo.data[1] * 255.0 - 200.0).abs() < 1.0);
    run(at, "render w.sample t.atlas -o f --size 32x32");
    // A sample that the atlas was not made from.
    run(
        at,
        "bake --preset weave --size 16 --samples 1 --views fibonacci:4 --lights fibonacci:5 -o v.sample",
    );
    let words = ["bake-maps", "v.sample", "t.atlas", "-o", "x"];
    assert!(refuse(at, &words, 1).contains("--force"));
    let told: Value = serde_json::from_str(&run(at, "info t.atlas --json")).unwrap();
    assert_eq!(told["kind"], "atlas");
}

#[test]
fn options_that_an_atlas_answers_itself_are_refused() {
    let folder = prepared();
    for option in ["--mesh torus.obj", "--unwrap", "--resolution 64"] {
        let line = format!("bake-maps a.sample a.atlas -o o {option}");
        let words: Vec<&str> = line.split_whitespace().collect();
        let said = refuse(folder.path(), &words, 2);
        let name = option.split(' ').next().unwrap();
        assert!(
            said.contains(name) && said.contains("given for a.atlas"),
            "{said}"
        );
    }
    let b = folder.path().join("b.atlas");
    fs::remove_file(b.join("surface.npz")).unwrap();
    let words = ["bake-maps", "b.sample", "b.atlas", "-o", "o"];
    assert!(refuse(folder.path(), &words, 1).contains("surface.npz"));
    assert!(!folder.path().join("o").exists());
}
