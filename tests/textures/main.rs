//! Texture maps as a user makes them: `transfer` onto atlases and vertices, `bake-maps`, and what is refused.

#[path = "../program/mod.rs"]
mod program;

mod atlases;
mod baked;
mod surface_color;
mod transferred;

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
