//! Numbers that are written come back exactly, bit by bit: random ones, subnormal, huge.

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec3};
use mesotex::btf::{Direction, DirectionSet};
use mesotex::byte_size::ByteSize;
use mesotex::format::gltf::GltfMesh;
use mesotex::format::obj::ObjMesh;
use mesotex::format::ply::Column;
use mesotex::format::{ContentId, gltf, json, npz, obj, ply};
use mesotex::grid::TexCoord;
use mesotex::index::TextonLabel;
use mesotex::maps::{MapHeader, SurfaceTextonMap};
use mesotex::mesh::TriangleMesh;
use mesotex::random;
use mesotex::render::{FileOptions, LightSpec, Point, RenderOptions, SweepOptions};
use ndarray::Array1;
use rand::Rng;
use serde::{Deserialize, Serialize};

const COUNT: usize = 20_000;

fn bits(kind: &str, at: u32) -> impl Iterator<Item = u64> + use<> {
    let mut stream = random::stream(11, kind, at, 0);
    std::iter::from_fn(move || Some(stream.r#gen()))
}

/// Finite numbers of any size, and those at the ends.
fn doubles(count: usize) -> Vec<f64> {
    let ends = [
        0.0,
        -0.0,
        f64::MIN_POSITIVE,
        f64::from_bits(1),
        f64::MAX,
        f64::MIN,
        0.1,
    ];
    let random = bits("double", 0)
        .map(f64::from_bits)
        .filter(|x| x.is_finite());
    // Numbers as descriptions have them: near 1.
    let near = bits("near", 0).map(|bits| f64::from_bits((bits >> 12) | 0x3ff0_0000_0000_0000));
    let most = random.zip(near).flat_map(|(a, b)| [a, b - 1.0]);
    ends.into_iter().chain(most).take(count).collect()
}

fn singles(count: usize) -> Vec<f32> {
    let ends = [
        0.0,
        -0.0,
        f32::MIN_POSITIVE,
        f32::from_bits(1),
        f32::MAX,
        f32::MIN,
        0.1,
    ];
    let random = bits("single", 0)
        .map(|bits| f32::from_bits(bits as u32))
        .filter(|x| x.is_finite());
    ends.into_iter().chain(random).take(count).collect()
}

fn assert_same<T: Copy + std::fmt::Debug, B: PartialEq>(
    what: &str,
    wrote: &[T],
    read: &[T],
    bits: impl Fn(T) -> B,
) {
    assert_eq!(wrote.len(), read.len(), "{what}");
    for (a, b) in wrote.iter().zip(read) {
        assert!(bits(*a) == bits(*b), "{what}: wrote {a:?}, read {b:?}");
    }
}

#[derive(Serialize, Deserialize)]
struct Described {
    doubles: Vec<f64>,
    singles: Vec<f32>,
    directions: Vec<Direction>,
}

#[test]
fn json_gives_numbers_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.json");
    let near = doubles(3 * COUNT);
    let vector = |xyz: &[f64]| Direction(DVec3::new(xyz[0], xyz[1], xyz[2]));
    let wrote = Described {
        directions: near.chunks_exact(3).map(vector).collect(),
        doubles: doubles(COUNT),
        singles: singles(COUNT),
    };
    json::write(&path, &wrote).unwrap();
    let read: Described = json::read(&path).unwrap();
    assert_same("f64", &wrote.doubles, &read.doubles, f64::to_bits);
    assert_same("f32", &wrote.singles, &read.singles, f32::to_bits);
    let bits_of = |direction: Direction| direction.0.to_array().map(f64::to_bits);
    assert_same("directions", &wrote.directions, &read.directions, bits_of);
}

#[test]
fn descriptions_of_archives_give_numbers_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npz");
    let wrote = doubles(COUNT);
    let mut meta = serde_json::Map::new();
    meta.insert("numbers".into(), serde_json::json!(wrote));
    let list = Array1::from(singles(COUNT));
    npz::write(&path, meta, |writer| writer.array("list", list.view())).unwrap();
    #[derive(Deserialize)]
    struct Meta {
        numbers: Vec<f64>,
    }
    let mut reader = npz::Reader::open(&path).unwrap();
    let meta: Meta = reader.meta().unwrap();
    assert_same("meta.json", &wrote, &meta.numbers, f64::to_bits);
    let read: Array1<f32> = reader.array("list").unwrap();
    assert_same("array", &list.to_vec(), &read.to_vec(), f32::to_bits);
}

#[test]
fn map_headers_give_the_texel_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.map.ply");
    let id = ContentId::of_bytes(b"x");
    let mut map = SurfaceTextonMap {
        mesh: TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
        },
        normals: vec![Vec3::Z; 3],
        orientations: vec![Vec3::X; 3],
        scale: None,
        coords: vec![TexCoord { s: 0.5, t: 0.5 }; 3],
        textons: vec![TextonLabel(1); 3],
        transition: None,
        mask: None,
        header: MapHeader {
            exemplar: [8, 4],
            origin: DVec3::ZERO,
            texel: 1.0,
            seed: u64::MAX,
            method: "k-coherence".into(),
            polish: 0,
            sample: id.clone(),
            space: id,
        },
    };
    // The texels that a map may have.
    let random = doubles(500).into_iter().map(f64::abs);
    let texels: Vec<f64> = random
        .filter(|texel| (1e-15..=1e15).contains(texel))
        .collect();
    assert!(texels.len() > 10);
    for texel in texels {
        map.header.texel = texel;
        map.write(&path).unwrap();
        let read = SurfaceTextonMap::read(&path).unwrap();
        assert_eq!(read.header.texel.to_bits(), texel.to_bits());
        assert_eq!(read.header.seed, u64::MAX);
    }
}

/// A strip of triangles over as many corners as there are numbers for.
fn strip(numbers: &[f32]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (positions, _) = numbers.as_chunks::<3>();
    let triangles = (2..positions.len() as u32).map(|at| [at - 2, at - 1, at]);
    (positions.to_vec(), triangles.collect())
}

#[test]
fn mesh_files_give_coordinates_back() {
    let folder = tempfile::tempdir().unwrap();
    let numbers = singles(3 * 4000);
    let (positions, triangles) = strip(&numbers);
    let path = |name: &str| folder.path().join(name);
    let bits_of = |at: [f32; 3]| at.map(f32::to_bits);

    let mesh = ObjMesh {
        origin: [0.0; 3],
        positions: &positions,
        normals: &[],
        uvs: None,
        triangles: &triangles,
    };
    obj::write(&path("a.obj"), &mesh).unwrap();
    let read = obj::parse(&fs::read(path("a.obj")).unwrap()).unwrap();
    let read: Vec<[f32; 3]> = read
        .positions
        .iter()
        .map(|at| at.map(|x| x as f32))
        .collect();
    assert_same("OBJ", &positions, &read, bits_of);

    let mesh = GltfMesh {
        origin: [0.0; 3],
        positions: &positions,
        normals: &positions,
        uvs: None,
        triangles: &triangles,
        ..GltfMesh::default()
    };
    gltf::write(&path("a.glb"), &mesh).unwrap();

    let axes: Vec<Vec<f32>> = (0..3)
        .map(|axis| positions.iter().map(|at| at[axis]).collect())
        .collect();
    let columns: Vec<(&str, Column<'_>)> = ["x", "y", "z"]
        .into_iter()
        .zip(&axes)
        .map(|(name, axis)| (name, Column::Float(axis)))
        .collect();
    ply::write(&path("a.ply"), &[], &columns, &triangles).unwrap();
    let read = ply::read(&path("a.ply")).unwrap();
    for (name, axis) in ["x", "y", "z"].into_iter().zip(&axes) {
        let column: Vec<f32> = read
            .column(name)
            .unwrap()
            .iter()
            .map(|&x| x as f32)
            .collect();
        assert_same("binary PLY", axis, &column, f32::to_bits);
    }

    let text = ascii_ply(&axes[0]);
    fs::write(path("b.ply"), text).unwrap();
    let read = ply::read(&path("b.ply")).unwrap();
    let column: Vec<f32> = read
        .column("x")
        .unwrap()
        .iter()
        .map(|&x| x as f32)
        .collect();
    assert_same("ascii PLY", &axes[0], &column, f32::to_bits);
}

fn ascii_ply(numbers: &[f32]) -> String {
    let lines: String = numbers.iter().map(|number| format!("{number}\n")).collect();
    let count = numbers.len();
    format!("ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nend_header\n{lines}")
}

/// What an option's value becomes as text, and back.
fn through_text<T: std::fmt::Display + std::str::FromStr>(value: &T) -> T {
    let text = value.to_string();
    text.parse().unwrap_or_else(|_| panic!("{text}"))
}

#[test]
fn option_values_give_numbers_back() {
    let numbers = doubles(3000);
    for three in numbers.chunks_exact(3) {
        let [x, y, z] = [three[0], three[1], three[2]];
        let point = Point([x, y, z]);
        assert_eq!(through_text(&point), point);
        for irradiance in [None, Some(x)] {
            for light in [
                LightSpec::Sun {
                    azimuth: y,
                    elevation: z,
                    irradiance,
                },
                LightSpec::Point {
                    position: [x, y, z],
                    irradiance,
                },
            ] {
                assert_eq!(through_text(&light), light);
            }
        }
    }
    for bits in bits("size", 0).take(1000) {
        let size = ByteSize(bits);
        assert_eq!(String::from(size).parse(), Ok(size));
    }
    let angle = |bits: u64| (bits >> 11) as f64 / (1_u64 << 53) as f64 * 90.0;
    for (theta, offset) in bits("ring", 0)
        .map(angle)
        .zip(bits("offset", 0).map(angle))
        .take(300)
    {
        let set: DirectionSet = format!("rings:{theta}:5:{offset}").parse().unwrap();
        assert_eq!(through_text(&set), set);
    }
}

#[test]
fn options_in_descriptions_give_numbers_back() {
    for (a, b) in doubles(400).into_iter().zip(singles(400)) {
        let options = RenderOptions {
            sweep: SweepOptions {
                turns: a,
                ..SweepOptions::default()
            },
            files: FileOptions {
                exposure: b,
                ..FileOptions::default()
            },
            ..RenderOptions::default()
        };
        let value = serde_json::to_value(&options).unwrap();
        let read: serde_json::Value = serde_json::from_str(&value.to_string()).unwrap();
        assert_eq!(read["turns"].as_f64().unwrap().to_bits(), a.to_bits());
        let exposure = read["exposure"].as_f64().unwrap() as f32;
        assert_eq!(exposure.to_bits(), b.to_bits());
    }
}

#[test]
fn directions_of_a_sample_are_those_it_was_baked_with() {
    let folder: &Path = crate::small_files();
    let text = fs::read_to_string(folder.join("s.sample/btf.json")).unwrap();
    let read: serde_json::Value = serde_json::from_str(&text).unwrap();
    let directions: Vec<Direction> = serde_json::from_value(read["views"].clone()).unwrap();
    let set: DirectionSet = "fibonacci:4".parse().unwrap();
    let bits_of = |direction: Direction| direction.0.to_array().map(f64::to_bits);
    assert_same("views", &set.directions().unwrap(), &directions, bits_of);
}
