//! Small sound files of meshes, made by code.

use std::io::Write;
use std::path::Path;

use mesotex::format::gltf;
use mesotex::format::gltf::GltfMesh;
use mesotex::mesh::reading::{CleaningOptions, UserMesh, clean, parse};
use mesotex::progress::Progress;
use serde_json::json;

use crate::corpus::{file_bytes, map};

/// A small patch of surface, read and cleaned.
pub fn user_mesh() -> UserMesh {
    let mut text = String::new();
    for k in 0..16 {
        let (x, y) = (k % 4, k / 4);
        text += &format!("v {x} {y} {}\n", x * y % 3);
    }
    for k in 0..9 {
        let first = 1 + k / 3 * 4 + k % 3;
        text += &format!("f {first} {} {} {}\n", first + 1, first + 5, first + 4);
    }
    let file = parse(text.as_bytes(), Path::new("a.obj")).unwrap();
    clean(file, &CleaningOptions::default(), Progress::silent()).unwrap()
}

const CORNERS: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// A binary glTF file.
pub fn glb() -> Vec<u8> {
    let mesh = GltfMesh {
        origin: [0.0; 3],
        uvs: Some(&[[[0.0, 0.5]; 3]; 4]),
        positions: &CORNERS,
        normals: &[[0., 0., 1.]; 4],
        triangles: &FACES,
        ..GltfMesh::default()
    };
    file_bytes("a.glb", |path| gltf::write(path, &mesh).unwrap())
}

/// glTF in text: two nodes that share a mesh, its buffer in the file; a strip, its buffer beside it.
pub fn gltf_texts() -> Vec<Vec<u8>> {
    let with = |uri: &str, mode: u32| {
        json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0, 1] }],
            "nodes": [{ "mesh": 0, "children": [2] }, { "mesh": 0, "translation": [2, 0, 0] },
                { "mesh": 0, "scale": [1, -1, 1] }],
            "meshes": [{ "primitives": [{ "mode": mode, "indices": 1,
                "attributes": { "POSITION": 0, "TEXCOORD_0": 2 } }] }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                    "min": [0, 0, 0], "max": [1, 1, 1] },
                { "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" },
                { "bufferView": 0, "byteOffset": 4, "componentType": 5126, "count": 4,
                    "type": "VEC2" }
            ],
            "bufferViews": [{ "buffer": 0, "byteLength": 48, "byteStride": 12 },
                { "buffer": 0, "byteOffset": 48, "byteLength": 24 }],
            "buffers": [{ "byteLength": 72, "uri": uri }]
        })
        .to_string()
        .into_bytes()
    };
    let data = format!("data:application/octet-stream;base64,{}", base64(&buffer()));
    vec![with(&data, 4), with("a.bin", 5)]
}

/// The buffer of [`gltf_texts`].
pub fn buffer() -> Vec<u8> {
    let mut bytes: Vec<u8> = bytemuck::cast_slice(&CORNERS).to_vec();
    for corner in FACES.as_flattened() {
        bytes.extend((*corner as u16).to_le_bytes());
    }
    bytes
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |bits: u32| DIGITS[(bits & 63) as usize] as char;
    let groups = bytes.chunks(3).flat_map(|group| {
        let held = group
            .iter()
            .fold(0, |held, &byte| held << 8 | u32::from(byte));
        let held = held << (8 * (3 - group.len()));
        [18, 12, 6, 0].map(|shift| digit(held >> shift))
    });
    groups.collect()
}

/// PLY files: text and binary, both byte orders.
pub fn plys() -> Vec<Vec<u8>> {
    let text = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\n\
        property float y\nproperty float z\nproperty float scale\nelement edge 1\nproperty int a\n\
        element face 3\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 1\n1 0 0 1\n0 1 0 2\n0 0 1 1\n9\n4 0 1 2 3\n3 0 1 3\n3 1 2 3\n";
    let binary = |order: &str, number: fn(f64) -> [u8; 8], index: fn(u32) -> [u8; 4]| {
        let mut bytes = format!(
            "ply\nformat {order} 1.0\nelement vertex 4\nproperty double x\nproperty double y\n\
             property double z\nelement face 4\nproperty list ushort uint vertex_index\nend_header\n"
        )
        .into_bytes();
        for value in CORNERS.as_flattened() {
            bytes.extend(number(f64::from(*value)));
        }
        for face in FACES {
            bytes.extend(if order.contains("little") {
                [3, 0]
            } else {
                [0, 3]
            });
            face.iter().for_each(|&corner| bytes.extend(index(corner)));
        }
        bytes
    };
    vec![
        text.into(),
        binary("binary_little_endian", f64::to_le_bytes, u32::to_le_bytes),
        binary("binary_big_endian", f64::to_be_bytes, u32::to_be_bytes),
        map(),
    ]
}

/// STL files: binary and text.
pub fn stls() -> Vec<Vec<u8>> {
    let (mut text, mut binary) = ("solid a\n".to_owned(), vec![b' '; 80]);
    binary.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        text += "facet normal 0 0 1\nouter loop\n";
        binary.extend([0; 12]);
        for [x, y, z] in face.map(|corner| CORNERS[corner as usize]) {
            text += &format!("vertex {x} {y} {z}\n");
            [x, y, z]
                .iter()
                .for_each(|v| binary.extend(v.to_le_bytes()));
        }
        text += "endloop\nendfacet\n";
        binary.extend([0; 2]);
    }
    text += "endsolid a\n";
    vec![text.into(), binary]
}

/// An OBJ file.
pub const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n\
    f 1/1/1 2/2/1 3/3/1\nf -4 -3 -1\nf 1//1 3//1 4//1\nf 2 3 \\\n 4\n";

/// An OFF file.
pub const OFF: &str =
    "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// A gzip file of text.
pub fn packed(text: &str) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), Default::default());
    packed.write_all(text.as_bytes()).unwrap();
    packed.finish().unwrap()
}
