//! A mesh into a binary glTF file.

use std::collections::HashMap;
use std::io::Write;
use std::path::Path;

use glam::Vec3;
use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::format::atomic;

/// What a GLB file is written from; lists are per vertex.
#[derive(Clone, Copy, Debug)]
pub struct GltfMesh<'a> {
    /// Where the positions count from: the node's translation.
    pub origin: [f64; 3],
    /// Vertex positions.
    pub positions: &'a [[f32; 3]],
    /// Unit vertex normals.
    pub normals: &'a [[f32; 3]],
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
    /// Texture coordinates of the corners of each triangle, v upwards. A vertex with several is repeated
    /// behind the others; what is not finite is written as 0.
    pub uvs: Option<&'a [[[f32; 2]; 3]]>,
}

/// Writes a binary glTF file of one mesh.
pub fn write(path: &Path, mesh: &GltfMesh<'_>) -> Result<()> {
    let Some(uvs) = mesh.uvs else {
        return write_lists(path, mesh, None);
    };
    let split = Split::new(mesh, uvs);
    let copied = GltfMesh {
        positions: &split.copied(mesh.positions),
        normals: &split.copied(mesh.normals),
        triangles: &split.triangles,
        ..*mesh
    };
    write_lists(path, &copied, Some(&split.uvs))
}

/// Vertices repeated so that each has one texture coordinate.
struct Split {
    /// The vertex that each is a copy of; the first ones are the mesh's own.
    sources: Vec<u32>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Split {
    fn new(mesh: &GltfMesh<'_>, uvs: &[[[f32; 2]; 3]]) -> Self {
        let count = mesh.positions.len();
        let mut split = Self {
            sources: (0..count as u32).collect(),
            uvs: vec![[0.0; 2]; count],
            triangles: mesh.triangles.to_vec(),
        };
        let mut is_taken = vec![false; count];
        let mut known: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        for (triangle, uvs) in split.triangles.iter_mut().zip(uvs) {
            for (corner, uv) in triangle.iter_mut().zip(uvs) {
                let uv = match uv {
                    [u, v] if u.is_finite() && v.is_finite() => [*u, 1.0 - v],
                    _ => [0.0; 2],
                };
                let key = (*corner, uv.map(f32::to_bits));
                let vertex = *corner as usize;
                *corner = *known.entry(key).or_insert_with(|| {
                    if !std::mem::replace(&mut is_taken[vertex], true) {
                        split.uvs[vertex] = uv;
                        return vertex as u32;
                    }
                    split.sources.push(vertex as u32);
                    split.uvs.push(uv);
                    split.sources.len() as u32 - 1
                });
            }
        }
        split
    }

    fn copied(&self, list: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.sources.iter().map(|&v| list[v as usize]).collect()
    }
}

fn write_lists(path: &Path, mesh: &GltfMesh<'_>, uvs: Option<&[[f32; 2]]>) -> Result<()> {
    let uvs = uvs.unwrap_or_default();
    let lists: [&[u8]; 4] = [
        bytemuck::cast_slice(mesh.positions),
        bytemuck::cast_slice(mesh.normals),
        bytemuck::cast_slice(mesh.triangles),
        bytemuck::cast_slice(uvs),
    ];
    let total: usize = lists.iter().map(|list| list.len()).sum();
    let mut text = description(mesh, &lists, total).to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = u32::try_from(12 + 8 + text.len() + 8 + total).map_err(|_| {
        Error::data("mesh", "too large for a GLB file").advice("write a PLY instead")
    })?;
    atomic::write_file(path, |sink| {
        sink.write_all(b"glTF")?;
        sink.write_all(&2u32.to_le_bytes())?;
        sink.write_all(&length.to_le_bytes())?;
        sink.write_all(&(text.len() as u32).to_le_bytes())?;
        sink.write_all(b"JSON")?;
        sink.write_all(&text)?;
        sink.write_all(&(total as u32).to_le_bytes())?;
        sink.write_all(b"BIN\0")?;
        lists.iter().try_for_each(|list| sink.write_all(list))
    })
}

fn description(mesh: &GltfMesh<'_>, lists: &[&[u8]; 4], total: usize) -> Value {
    let (low, high) = bounds(mesh.positions);
    let count = mesh.positions.len();
    let mut node = json!({ "mesh": 0 });
    if mesh.origin != [0.0; 3] {
        node["translation"] = json!(mesh.origin);
    }
    let mut attributes = json!({ "POSITION": 0, "NORMAL": 1 });
    let mut accessors = vec![
        json!({ "bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": low, "max": high }),
        json!({ "bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3" }),
        json!({ "bufferView": 2, "componentType": 5125, "count": mesh.triangles.len() * 3, "type": "SCALAR" }),
    ];
    if !lists[3].is_empty() {
        attributes["TEXCOORD_0"] = json!(3);
        accessors.push(
            json!({ "bufferView": 3, "componentType": 5126, "count": count, "type": "VEC2" }),
        );
    }
    let mut offset = 0;
    let views: Vec<Value> = lists[..accessors.len()]
        .iter()
        .enumerate()
        .map(|(list, bytes)| {
            let target = if list == 2 { 34963 } else { 34962 };
            let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "target": target });
            offset += bytes.len();
            view
        })
        .collect();
    json!({
        "asset": { "version": "2.0", "generator": "mesotex" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [node],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": 2 }] }],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": total }]
    })
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let mut points = positions.iter().map(|&p| Vec3::from_array(p));
    let first = points.next().unwrap_or_default();
    let (low, high) = points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    (low.to_array(), high.to_array())
}
