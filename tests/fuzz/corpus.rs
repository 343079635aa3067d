//! Small sound files of every kind, made by code.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use glam::Vec3;
use half::f16;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};
use mesotex::btf::factored::{FactoredWriter, Factorization};
use mesotex::btf::fits::hsh::Lists;
use mesotex::btf::fits::{Basis, Colors, Fit, hsh, ptm};
use mesotex::btf::{DType, Description, Direction, Layout, SampleWriter};
use mesotex::exemplar::neighbor_table::NeighborTable;
use mesotex::exemplar::{
    ChannelImage, ChannelKind, Controls, Features, KnnOptions, Space, SpaceLevel, neighbor_table,
    space_of_images,
};
use mesotex::format::exr::{Attribute, Compression, ExrImage, Numbers};
use mesotex::format::image::{Encoding, FloatImage, Precision};
use mesotex::format::{ContentId, exr, npy, npz};
use mesotex::grid::{TexCoord, TexelGrid};
use mesotex::index::TextonLabel;
use mesotex::maps::{AtlasMap, FaceChannel, FaceMap, MapHeader, Square, SurfaceTextonMap};
use mesotex::mesh::TriangleMesh;
use mesotex::progress::Progress;
use ndarray::{Array, Array2};
use serde_json::json;

/// Columns and rows of the pictures.
const SIDES: (u32, u32) = (13, 9);

/// The bytes that `write` puts into a file of this name.
pub fn file_bytes(name: &str, write: impl FnOnce(&Path)) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write(&path);
    fs::read(&path).unwrap()
}

fn color(x: u32, y: u32) -> Rgb<u8> {
    Rgb([(x * 19) as u8, (y * 27) as u8, (x * y) as u8])
}

fn pictures() -> Vec<DynamicImage> {
    let (width, height) = SIDES;
    let gray = ImageBuffer::from_fn(width, height, |x, y| Luma([(x * y * 3) as u8]));
    let rgba = ImageBuffer::from_fn(width, height, |x, y| {
        let [r, g, b] = color(x, y).0;
        Rgba([r, g, b, (x * 17) as u8])
    });
    let deep = ImageBuffer::from_fn(width, height, |x, y| Rgb([x as u16 * 5000, y as u16, 7]));
    vec![
        DynamicImage::ImageRgb8(ImageBuffer::from_fn(width, height, color)),
        DynamicImage::ImageLuma8(gray),
        DynamicImage::ImageRgba8(rgba),
        DynamicImage::ImageRgb16(deep),
    ]
}

fn encoded(picture: &DynamicImage, format: ImageFormat) -> Option<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).ok()?;
    Some(bytes.into_inner())
}

/// The pictures in a format, as many as it can hold.
pub fn images(format: ImageFormat) -> Vec<Vec<u8>> {
    let pictures = pictures();
    let files = pictures
        .iter()
        .filter_map(|picture| encoded(picture, format));
    files.collect()
}

/// PNG files, one with a palette.
pub fn pngs() -> Vec<Vec<u8>> {
    let chunk = |kind: &[u8; 4], content: &[u8]| {
        let mut crc = flate2::Crc::new();
        crc.update(kind);
        crc.update(content);
        let length = (content.len() as u32).to_be_bytes();
        [&length, &kind[..], content, &crc.sum().to_be_bytes()].concat()
    };
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), Default::default());
    packed.write_all(&[0, 0x1b, 0, 0xe4, 0, 0x1b]).unwrap();
    let palette = [
        b"\x89PNG\r\n\x1a\n".to_vec(),
        chunk(b"IHDR", b"\0\0\0\x04\0\0\0\x03\x02\x03\0\0\0"),
        chunk(b"PLTE", &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]),
        chunk(b"tRNS", &[0, 128]),
        chunk(b"IDAT", &packed.finish().unwrap()),
        chunk(b"IEND", b""),
    ];
    let mut files = images(ImageFormat::Png);
    files.push(palette.concat());
    files
}

/// A Radiance picture.
pub fn hdr() -> Vec<u8> {
    let picture = ImageBuffer::from_fn(SIDES.0, SIDES.1, |x, y| {
        Rgb([x as f32 * 0.3, y as f32, 1e-3])
    });
    encoded(&DynamicImage::ImageRgb32F(picture), ImageFormat::Hdr).unwrap()
}

/// TIFF files of each compression, integers and floats.
pub fn tiffs() -> Vec<Vec<u8>> {
    use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype};
    let numbers: Vec<f32> = (0..SIDES.0 * SIDES.1).map(|k| k as f32 * 0.01).collect();
    let compressions = [
        Compression::Uncompressed,
        Compression::Lzw,
        Compression::Deflate(DeflateLevel::default()),
        Compression::Packbits,
    ];
    let floats = compressions.map(|compression| {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut bytes)
            .unwrap()
            .with_compression(compression);
        encoder
            .write_image::<colortype::Gray32Float>(SIDES.0, SIDES.1, &numbers)
            .unwrap();
        bytes.into_inner()
    });
    let mut files = images(ImageFormat::Tiff);
    files.extend(floats);
    files
}

/// OpenEXR files of each compression.
pub fn exrs() -> Vec<Vec<u8>> {
    let count = (SIDES.0 * SIDES.1) as usize;
    let halfs = |factor: f32| -> Numbers<'static> {
        let numbers: Vec<f16> = (0..count)
            .map(|k| f16::from_f32(k as f32 * factor))
            .collect();
        Numbers::Half(numbers.into())
    };
    let depths: Vec<f32> = (0..count).map(|k| (k as f32).sqrt()).collect();
    let channels = BTreeMap::from([
        ("R".to_owned(), halfs(0.1)),
        ("G".to_owned(), halfs(0.2)),
        ("B".to_owned(), halfs(0.0)),
        ("Z".to_owned(), Numbers::Float(depths.into())),
    ]);
    let attributes = BTreeMap::from([
        ("worldToCamera".to_owned(), Attribute::Matrix([0.5; 16])),
        ("mesotex:options".to_owned(), Attribute::Text("{}".into())),
    ]);
    let picture = ExrImage {
        size: [SIDES.0, SIDES.1],
        channels,
        attributes,
    };
    let compressions = [
        Compression::None,
        Compression::Rle,
        Compression::Zips,
        Compression::Zip,
        Compression::Piz,
        Compression::Pxr24,
    ];
    let mut files: Vec<Vec<u8>> = compressions
        .iter()
        .map(|&compression| exr::encode(&picture, compression).unwrap())
        .collect();
    files.push(file_bytes("a.exr", |path| {
        ::exr::prelude::write_rgb_file(path, 20, 10, |x, y| (x as f32, y as f32, 0.5)).unwrap();
    }));
    files
}

/// An array file.
pub fn array() -> Vec<u8> {
    let mut bytes = Vec::new();
    let array = Array2::from_shape_fn((5, 4), |(r, c)| (r * c) as f32);
    npy::encode(&mut bytes, array.view().into_dyn()).unwrap();
    bytes
}

/// The `height.npy` of a sample of 4 × 3 texels.
pub fn heights() -> Vec<u8> {
    let mut bytes = Vec::new();
    let array = Array2::from_shape_fn((3, 4), |(r, c)| r as f32 - 0.5 * c as f32);
    npy::encode(&mut bytes, array.view().into_dyn()).unwrap();
    bytes
}

fn grid(side: u32) -> TexelGrid {
    TexelGrid {
        width: side,
        height: side,
        tileable: true,
    }
}

/// An array of two views and two lights.
pub fn measured_array() -> Vec<u8> {
    let mut bytes = Vec::new();
    let array = Array::from_shape_fn((2, 2, 3, 4, 3), |(v, l, h, w, c)| {
        (v + l + h + w + c) as f32
    });
    npy::encode(&mut bytes, array.view().into_dyn()).unwrap();
    bytes
}

/// Polynomial texture maps of both kinds.
pub fn ptms() -> Vec<Vec<u8>> {
    let of = |colors| {
        let per_texel = if colors == Colors::Rgb { 18 } else { 6 };
        let fit = fit(Basis::Polynomial, colors, per_texel);
        file_bytes("a.ptm", |path| ptm::write(path, &fit).unwrap())
    };
    [Colors::Lrgb, Colors::Rgb].map(of).into()
}

/// Hemispherical harmonics with lists of both kinds.
pub fn harmonics() -> Vec<Vec<u8>> {
    let fit = fit(Basis::Hemispherical(4), Colors::Rgb, 12);
    let of = |lists| file_bytes("a.rti", |path| hsh::write(path, &fit, lists).unwrap());
    [Lists::ScaleOffset, Lists::MinimumMaximum].map(of).into()
}

fn fit(basis: Basis, colors: Colors, per_texel: usize) -> Fit {
    let texels = (SIDES.0 * SIDES.1) as usize;
    Fit {
        width: SIDES.0,
        height: SIDES.1,
        basis,
        colors,
        scale: vec![0.5; basis.terms()],
        offset: vec![-32.0; basis.terms()],
        coefficients: (0..texels * per_texel).map(|k| (k * 7) as u8).collect(),
        texel_colors: match colors {
            Colors::Lrgb => (0..3 * texels).map(|k| (k * 5) as u8).collect(),
            Colors::Rgb => Vec::new(),
        },
        white: if basis == Basis::Polynomial {
            255.0
        } else {
            1.0
        },
    }
}

/// A texton vocabulary of two levels and tiny filters.
pub fn vocabulary(of_factors: bool) -> Vec<u8> {
    let mut meta = json!({
        "format": "mesotex-textons", "version": 1, "tileable": true, "channels": 3,
        "options": {}, "seed": 0, "inertia": [1.5, 0.5], "iterations": [3, 2],
        "sample": ContentId::of_bytes(b"sample").to_string()
    });
    if of_factors {
        meta["factor_basis"] = json!({"rank": 2, "sets": 3});
    }
    let labels = |side: usize| Array2::from_shape_fn((side, side), |(r, c)| ((r + c) % 2) as u16);
    file_bytes("a.textons.npz", |path| {
        npz::write(path, meta.as_object().unwrap().clone(), |file| {
            for (at, side) in [4, 2].into_iter().enumerate() {
                let half = (side * side / 2) as u32;
                let centroids = Array2::from_shape_fn((2, 12), |(r, c)| (r + c) as f32);
                file.array(&format!("L{at}/labels"), labels(side).view())?;
                file.array(&format!("L{at}/centroids"), centroids.view())?;
                file.array(&format!("L{at}/counts"), ndarray::aview1(&[half, half]))?;
            }
            file.array("representatives", ndarray::aview1(&[0_u32, 3]))?;
            if of_factors {
                file.array("factor_basis", Array2::<f32>::eye(6).view())?;
            }
            file.array("filters", Array::from_elem((2, 3, 3), 0.1_f32).view())
        })
        .unwrap();
    })
}

/// A part of a texton analysis.
pub fn texton_part() -> Vec<u8> {
    let meta = json!({
        "format": "mesotex-textons-part", "version": 1, "shard": "1/3", "program": "0.1.0",
        "sample": ContentId::of_bytes(b"sample").to_string(), "holds": "image-vectors",
        "sketched_levels": 0, "image_vectors": "exact", "options": {"textons": 8}
    });
    file_bytes("p.npz", |path| {
        npz::write(path, meta.as_object().unwrap().clone(), |file| {
            file.array("image_vectors", Array2::<f32>::eye(6).view())
        })
        .unwrap();
    })
}

/// A space of textons.
pub fn space() -> Space {
    let level = |side: u32| SpaceLevel {
        grid: grid(side),
        features: Features::Textons {
            labels: (0..side * side).map(|k| (k * k % 5) as u16).collect(),
            gram: Array2::from_shape_fn((6, 6), |(r, c)| if r == c { 2.0 } else { 0.25 }),
        },
    };
    Space {
        levels: vec![level(8), level(4)],
        channels: mesotex::exemplar::Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(b"space"),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    }
}

/// A space of features.
pub fn features() -> Space {
    let level = |side: u32| SpaceLevel {
        grid: grid(side),
        features: Features::Plain(Array::from_shape_fn(
            (side as usize, side as usize, 3),
            |(r, c, k)| (r * 3 + c + k) as f32 * 0.1,
        )),
    };
    Space {
        levels: vec![level(4), level(2)],
        ..space()
    }
}

/// A space of weighted channels with every control.
pub fn channels() -> Space {
    let image = |kind: ChannelKind, channels: u32| ChannelImage {
        name: kind.name().into(),
        kind,
        weight: 0.5,
        image: FloatImage {
            width: 4,
            height: 4,
            channels,
            data: (0..16 * channels).map(|k| k as f32 / 64.0).collect(),
            encoding: Encoding::Data,
            precision: Precision::Bits8,
        },
    };
    let images = [
        image(ChannelKind::Color, 3),
        image(ChannelKind::Height, 1),
        image(ChannelKind::Normal, 3),
    ];
    let controls = Controls {
        mask: Some(Array::from_shape_fn((4, 4), |(r, c)| ((r + c) % 4) as u8)),
        transition: Some(Array::from_elem((4, 4), 0.5)),
        orientation: Some(Array::from_shape_fn((4, 4, 2), |(_, _, k)| k as f32)),
    };
    let id = ContentId::of_bytes(b"sample");
    space_of_images(&images, controls, 2, true, &id).unwrap()
}

/// The bytes of a space.
pub fn space_bytes(mut space: Space) -> Vec<u8> {
    file_bytes("a.space.npz", |path| space.write(path, None).unwrap())
}

/// The neighbour table of [`space`] and its bytes.
pub fn table() -> (NeighborTable, Vec<u8>) {
    let options = KnnOptions {
        k: 3,
        neighborhood: 3,
        coarse_neighborhood: 3,
        ..KnnOptions::default()
    };
    let mut table = neighbor_table::build(&space(), &options, Progress::silent()).unwrap();
    let bytes = file_bytes("a.knn.npz", |path| table.write(path, &options).unwrap());
    (table, bytes)
}

/// A sample's `btf.json` and `radiance.npy`.
pub fn sample(dtype: DType, layout: Layout) -> (Vec<u8>, Vec<u8>) {
    let lights = [0.0, 0.5, 1.0].map(|theta| Direction::from_angles(theta, 2.0 * theta));
    let description = Description {
        dtype,
        texel_mm: Some(0.1),
        layout,
        pairs: (layout == Layout::Pairs).then(|| vec![[0, 2], [0, 0]]),
        tileable: true,
        source: json!({ "kind": "test" }),
        ..Description::product(
            "weave",
            [4, 3],
            vec![Direction::from_angles(0.0, 0.0)],
            lights.to_vec(),
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sample");
    let images = description.image_count();
    let mut writer = SampleWriter::create(&path, description).unwrap();
    for image in 0..images {
        writer.push(&[0.1 * image as f32; 36]).unwrap();
    }
    writer.finish().unwrap();
    let read = |name: &str| fs::read(path.join(name)).unwrap();
    (read("btf.json"), read("radiance.npy"))
}

/// A factored sample's `btf.json`, `directions.npy` and `eigentextures.npy`.
pub fn factored_sample() -> [Vec<u8>; 3] {
    let (described, _) = sample(DType::F4, Layout::Product);
    let factors = Factorization {
        color_mean: [0.1, 0.0, 0.2],
        ..Factorization::of_rank(2)
    };
    let description = Description {
        layout: Layout::Factored(factors),
        ..serde_json::from_slice(&described).unwrap()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sample");
    let mut writer = FactoredWriter::create(&path, description).unwrap();
    writer.push_directions(&[0.5; 3 * 3 * 2]).unwrap();
    writer.push_eigentextures(&[0.25; 3 * 12 * 2]).unwrap();
    writer.finish().unwrap();
    ["btf.json", "directions.npy", "eigentextures.npy"]
        .map(|name| fs::read(path.join(name)).unwrap())
}

/// A face map.
pub fn face_map() -> Vec<u8> {
    let id = ContentId::of_bytes(b"x");
    let map = FaceMap {
        mesh: TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE],
            triangles: vec![[0, 1, 2], [1, 3, 2]],
        },
        colors: Some(vec![[0.5, 0.25, 0.125], [1.0, 0.0, 0.5]]),
        channels: vec![FaceChannel {
            name: "height".into(),
            numbers: vec![0.5, -1.0],
        }],
        sources: vec![3, 70],
        phases: vec![2, 0],
        square: Square {
            left: 1,
            top: 0,
            side: 8,
        },
        subdivisions: 1,
        header: MapHeader {
            exemplar: [9, 8],
            texel: 0.25,
            origin: glam::DVec3::new(4_485_513.5, 0.25, -7.0),
            seed: 7,
            method: "choosy".into(),
            polish: 0,
            sample: id.clone(),
            space: id,
        },
    };
    file_bytes("a.faces.ply", |path| map.write(path).unwrap())
}

/// A surface texton map.
pub fn map() -> Vec<u8> {
    let id = ContentId::of_bytes(b"x");
    let map = SurfaceTextonMap {
        mesh: TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE],
            triangles: vec![[0, 1, 2], [1, 3, 2]],
        },
        normals: vec![Vec3::Z; 4],
        orientations: vec![Vec3::X; 4],
        scale: Some(vec![1.0, 0.5, 2.0, 1.0]),
        coords: vec![TexCoord { s: 0.5, t: 0.5 }; 4],
        transition: Some(vec![0.5; 4]),
        mask: Some(vec![1; 4]),
        textons: vec![
            TextonLabel(1),
            TextonLabel(2),
            TextonLabel(0),
            TextonLabel::NONE,
        ],
        header: MapHeader {
            origin: glam::DVec3::new(4_485_513.5, 0.25, -7.0),
            exemplar: [8, 8],
            texel: 0.25,
            seed: 7,
            method: "k-coherence".into(),
            polish: 0,
            sample: id.clone(),
            space: id,
        },
    };
    file_bytes("a.map.ply", |path| map.write(path).unwrap())
}

/// The files of an atlas of 2 × 2 texels, three of them in its one chart.
pub fn atlas() -> [(&'static str, Vec<u8>); 4] {
    let id = ContentId::of_bytes(b"x");
    let inside = |texel: usize| texel != 1;
    let vectors = |vector: Vec3| {
        (0..4)
            .map(|at| if inside(at) { vector } else { Vec3::ZERO })
            .collect()
    };
    let coord = TexCoord { s: 1.5, t: 0.5 };
    let map = AtlasMap {
        mesh: TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
        },
        vertex_normals: vec![Vec3::Z; 3],
        corner_uvs: vec![[glam::Vec2::ZERO, glam::Vec2::X, glam::Vec2::Y]],
        chart_of: vec![0],
        width: 2,
        height: 2,
        chart: vec![0, -1, 0, 0],
        position: vectors(Vec3::X),
        normal: vectors(Vec3::Z),
        orientation: vectors(Vec3::X),
        coords: (0..4).map(|texel| inside(texel).then_some(coord)).collect(),
        textons: vec![
            TextonLabel(3),
            TextonLabel::NONE,
            TextonLabel(1),
            TextonLabel(0),
        ],
        scale: None,
        tileable: false,
        header: MapHeader {
            origin: glam::DVec3::ZERO,
            exemplar: [8, 8],
            texel: 0.5,
            seed: 7,
            method: "coherent".into(),
            polish: 0,
            sample: id.clone(),
            space: id,
        },
    };
    let folder = tempfile::tempdir().unwrap();
    map.write_into(folder.path(), Vec::new()).unwrap();
    ["atlas.json", "coords.npy", "texton.npy", "surface.npz"]
        .map(|name| (name, fs::read(folder.path().join(name)).unwrap()))
}
