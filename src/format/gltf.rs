//! glTF 2.0, binary (.glb) or text (.gltf): the triangles of all nodes of the scene, in world
//! space.
//!
//! Not handled: compressed primitives (Draco, meshopt), sparse accessors, skins and morph targets
//! (the rest pose is read).

pub mod companions;

use std::fs;
use std::io::Write;
use std::path::Path;

use glam::{Mat3, Mat4, Vec3};
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::{Mode, Primitive, Semantic};
use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::format::polygon_mesh::PolygonMesh;
use crate::format::{atomic, json};

/// Parses a glTF file's bytes; buffers outside lie beside `path`.
pub fn parse(bytes: &[u8], path: &Path) -> Result<PolygonMesh> {
    check_description(bytes)?;
    let file = gltf::Gltf::from_slice(bytes).map_err(|error| {
        Error::data("glTF", error.to_string())
            .advice("the file is damaged, or asks for an extension we do not read")
    })?;
    let buffers = buffers(&file, path)?;
    let mut reading = Reading {
        buffers,
        mesh: PolygonMesh {
            splits_vertices: true,
            corner_uvs: Some(Vec::new()),
            normals: Some(Vec::new()),
            ..PolygonMesh::default()
        },
        visited: vec![false; file.nodes().count()],
        skipped: 0,
    };
    match file.default_scene().or_else(|| file.scenes().next()) {
        Some(scene) => scene
            .nodes()
            .try_for_each(|node| reading.take_node(&node, Mat4::IDENTITY))?,
        None => file
            .meshes()
            .try_for_each(|mesh| reading.take_mesh(&mesh, Mat4::IDENTITY))?,
    }
    Ok(reading.finish())
}

/// What the gltf crate takes for granted: a binary header that covers itself, positions that stand
/// in the list of accessors.
fn check_description(bytes: &[u8]) -> Result<()> {
    let text = match bytes.strip_prefix(b"glTF") {
        Some(rest) => binary_description(bytes, rest)?,
        None => bytes,
    };
    let description: Value = json::parse(text)?;
    let list = |value: &Value, name: &str| value[name].as_array().cloned().unwrap_or_default();
    let accessors = list(&description, "accessors").len() as u64;
    for mesh in list(&description, "meshes") {
        for primitive in list(&mesh, "primitives") {
            let position = primitive["attributes"]["POSITION"].as_u64();
            if let Some(index) = position.filter(|&index| index >= accessors) {
                return Err(Error::data("POSITION", format!("accessor {index}"))
                    .expected(format!("below {accessors} accessors")));
            }
        }
    }
    Ok(())
}

/// The JSON chunk of a binary file.
fn binary_description<'a>(bytes: &'a [u8], rest: &[u8]) -> Result<&'a [u8]> {
    let fault =
        |found: String| Error::data("GLB header", found).expected("lengths inside the file");
    let number = |at: usize| {
        let four = rest.get(at..at + 4).and_then(|four| four.try_into().ok());
        four.map(|four| u32::from_le_bytes(four) as usize)
            .ok_or_else(|| fault(format!("{} bytes", bytes.len())))
    };
    let (length, chunk) = (number(4)?, number(8)?);
    if length < GLB_HEADER || length > bytes.len() {
        return Err(fault(format!("length {length} of {} bytes", bytes.len())));
    }
    let end = chunk.checked_add(GLB_HEADER);
    end.and_then(|end| bytes.get(GLB_HEADER..end))
        .ok_or_else(|| fault(format!("a description of {chunk} bytes")))
}

/// Bytes before the JSON of a binary file: its own header and the chunk's.
const GLB_HEADER: usize = 20;

fn buffers(file: &gltf::Gltf, path: &Path) -> Result<Vec<Vec<u8>>> {
    let read = |buffer: gltf::Buffer<'_>| {
        let place = format!("buffer {}", buffer.index());
        let bytes = match buffer.source() {
            Source::Bin => file.blob.clone().unwrap_or_default(),
            Source::Uri(uri) => uri_bytes(uri, path)?,
        };
        if bytes.len() < buffer.length() {
            return Err(Error::data(place, format!("{} bytes", bytes.len()))
                .expected(format!("{}", buffer.length())));
        }
        Ok(bytes)
    };
    file.buffers().map(read).collect()
}

/// The bytes of a `data:` address, or of a file beside the glTF.
fn uri_bytes(uri: &str, path: &Path) -> Result<Vec<u8>> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data
            .split_once("base64,")
            .map_or("", |(_, encoded)| encoded);
        return decode_base64(encoded)
            .ok_or_else(|| Error::data("buffer", "a data address").expected("base64"));
    }
    let beside = atomic::parent(path).join(uri);
    if uri.contains("://")
        || Path::new(uri).is_absolute()
        || uri.split('/').any(|part| part == "..")
    {
        return Err(Error::data("buffer", format!("address `{uri}`"))
            .expected("a file beside the glTF, or a data address"));
    }
    fs::read(&beside).map_err(Error::io(&beside, "read"))
}

fn decode_base64(encoded: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(encoded.len() / 4 * 3);
    let (mut held, mut bits) = (0u32, 0);
    for symbol in encoded
        .bytes()
        .filter(|b| !b.is_ascii_whitespace() && *b != b'=')
    {
        let value = match symbol {
            b'A'..=b'Z' => symbol - b'A',
            b'a'..=b'z' => symbol - b'a' + 26,
            b'0'..=b'9' => symbol - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        held = held << 6 | u32::from(value);
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((held >> bits) as u8);
            held &= (1 << bits) - 1;
        }
    }
    Some(bytes)
}

struct Reading {
    buffers: Vec<Vec<u8>>,
    mesh: PolygonMesh,
    visited: Vec<bool>,
    skipped: usize,
}

impl Reading {
    fn take_node(&mut self, node: &gltf::Node<'_>, parent: Mat4) -> Result<()> {
        // Depth first without recursion: a damaged file may nest without end.
        let mut waiting = vec![(node.clone(), parent)];
        while let Some((node, parent)) = waiting.pop() {
            let visited = self.visited.get_mut(node.index());
            if visited.is_none_or(|visited| std::mem::replace(visited, true)) {
                return Err(Error::data(
                    format!("node {}", node.index()),
                    "stands in the tree twice",
                )
                .expected("a tree of nodes"));
            }
            let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
            if let Some(mesh) = node.mesh() {
                self.take_mesh(&mesh, world)?;
            }
            let children: Vec<_> = node.children().collect();
            waiting.extend(children.into_iter().rev().map(|child| (child, world)));
        }
        Ok(())
    }

    fn take_mesh(&mut self, mesh: &gltf::Mesh<'_>, world: Mat4) -> Result<()> {
        for primitive in mesh.primitives() {
            let place = format!("mesh {} primitive {}", mesh.index(), primitive.index());
            self.take_primitive(&primitive, world)
                .map_err(|error| match error {
                    Error::Data(mut fault) => {
                        fault.place = format!("{place} {}", fault.place);
                        Error::Data(fault)
                    }
                    other => other,
                })?;
        }
        Ok(())
    }

    fn take_primitive(&mut self, primitive: &Primitive<'_>, world: Mat4) -> Result<()> {
        let mode = primitive.mode();
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            self.skipped += 1;
            return Ok(());
        }
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            self.skipped += 1;
            return Ok(());
        };
        let positions = self.floats::<3>(&accessor)?;
        let count = positions.len();
        let uvs =
            self.optional::<2>(primitive.get(&Semantic::TexCoords(0)), count, [f32::NAN; 2])?;
        let normals = self.optional::<3>(primitive.get(&Semantic::Normals), count, [0.0; 3])?;
        let indices = match primitive.indices() {
            Some(accessor) => self.indices(&accessor, count)?,
            None => (0..count as u32).collect(),
        };
        let base = self.mesh.positions.len() as u32;
        let turned = Mat3::from_mat4(world).inverse().transpose();
        let moved = |p: &[f32; 3]| world.transform_point3(Vec3::from_array(*p)).to_array();
        self.mesh.positions.extend(positions.iter().map(moved));
        if let Some(all) = &mut self.mesh.normals {
            all.extend(
                normals
                    .iter()
                    .map(|&n| (turned * Vec3::from_array(n)).to_array()),
            );
        }
        let mirrored = world.determinant() < 0.0;
        for corners in triangles(mode, &indices) {
            let corners = if mirrored {
                [corners[0], corners[2], corners[1]]
            } else {
                corners
            };
            self.mesh.faces.push(&corners.map(|v| base + v));
            if let Some(all) = &mut self.mesh.corner_uvs {
                // glTF's v runs down the image, ours up.
                all.extend(corners.map(|v| [uvs[v as usize][0], 1.0 - uvs[v as usize][1]]));
            }
        }
        Ok(())
    }

    fn optional<const N: usize>(
        &self,
        accessor: Option<Accessor<'_>>,
        count: usize,
        missing: [f32; N],
    ) -> Result<Vec<[f32; N]>> {
        match accessor {
            Some(accessor) if accessor.data_type() == DataType::F32 => {
                let values = self.floats::<N>(&accessor)?;
                if values.len() != count {
                    return Err(Error::data("attribute", format!("{} values", values.len()))
                        .expected(format!("{count}, one a vertex")));
                }
                Ok(values)
            }
            _ => Ok(vec![missing; count]),
        }
    }

    fn floats<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; N]>> {
        let right = match N {
            2 => Dimensions::Vec2,
            _ => Dimensions::Vec3,
        };
        if accessor.data_type() != DataType::F32 || accessor.dimensions() != right {
            return Err(Error::data(
                "attribute",
                format!("{:?} of {:?}", accessor.dimensions(), accessor.data_type()),
            )
            .expected(format!("{right:?} of F32")));
        }
        let number = |bytes: &[u8]| {
            std::array::from_fn(|k| {
                f32::from_le_bytes([
                    bytes[4 * k],
                    bytes[4 * k + 1],
                    bytes[4 * k + 2],
                    bytes[4 * k + 3],
                ])
            })
        };
        Ok(self.items(accessor, 4 * N)?.map(number).collect())
    }

    fn indices(&self, accessor: &Accessor<'_>, vertices: usize) -> Result<Vec<u32>> {
        let number: fn(&[u8]) -> u32 = match accessor.data_type() {
            DataType::U8 => |b| u32::from(b[0]),
            DataType::U16 => |b| u32::from(u16::from_le_bytes([b[0], b[1]])),
            DataType::U32 => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            other => {
                return Err(
                    Error::data("indices", format!("{other:?}")).expected("unsigned integers")
                );
            }
        };
        let indices: Vec<u32> = self
            .items(accessor, accessor.data_type().size())?
            .map(number)
            .collect();
        match indices.iter().find(|&&index| index as usize >= vertices) {
            Some(index) => Err(Error::data("indices", format!("vertex index {index}"))
                .expected(format!("below {vertices} vertices"))),
            None => Ok(indices),
        }
    }

    /// The bytes of each item of an accessor, checked against the buffer first.
    fn items<'a>(
        &'a self,
        accessor: &Accessor<'_>,
        size: usize,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>> {
        let fault = |found: &str| Error::data(format!("accessor {}", accessor.index()), found);
        if accessor.sparse().is_some() {
            return Err(fault("sparse").expected("plain values"));
        }
        let view = accessor.view().ok_or_else(|| {
            fault("no buffer view")
                .advice("compressed meshes are not read; export without compression")
        })?;
        let stride = view.stride().unwrap_or(size).max(1);
        let whole = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        let bytes = end
            .and_then(|end| whole.get(view.offset()..end))
            .and_then(|b| b.get(accessor.offset()..));
        let needed = match accessor.count() {
            0 => Some(0),
            count => stride
                .checked_mul(count - 1)
                .and_then(|n| n.checked_add(size)),
        };
        match (bytes, needed) {
            (Some(bytes), Some(needed)) if needed <= bytes.len() => {
                let count = accessor.count();
                Ok((0..count).map(move |item| &bytes[item * stride..item * stride + size]))
            }
            _ => Err(fault("reaches beyond its buffer").expected("values inside the buffer")),
        }
    }

    fn finish(mut self) -> PolygonMesh {
        if self.skipped > 0 {
            let note = format!(
                "{} primitives without triangles or positions left out",
                self.skipped
            );
            self.mesh.notes.push(note);
        }
        let has_uvs = self
            .mesh
            .corner_uvs
            .iter()
            .flatten()
            .any(|uv| !uv[0].is_nan());
        let has_normals = self.mesh.normals.iter().flatten().any(|n| *n != [0.0; 3]);
        self.mesh.corner_uvs = self.mesh.corner_uvs.filter(|_| has_uvs);
        self.mesh.normals = self.mesh.normals.filter(|_| has_normals);
        self.mesh
    }
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(k, w)| {
                if k % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[1], w[0], w[2]]
                }
            })
            .collect(),
        Mode::TriangleFan => {
            let pairs = indices.get(1..).unwrap_or_default().windows(2);
            pairs.map(|pair| [indices[0], pair[0], pair[1]]).collect()
        }
        _ => indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
    }
}

/// What a GLB file is written from; lists are per vertex.
#[derive(Clone, Copy, Debug)]
pub struct GltfMesh<'a> {
    /// Vertex positions.
    pub positions: &'a [[f32; 3]],
    /// Unit vertex normals.
    pub normals: &'a [[f32; 3]],
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
}

/// Writes a binary glTF file of one mesh.
pub fn write(path: &Path, mesh: &GltfMesh<'_>) -> Result<()> {
    let (low, high) = bounds(mesh.positions);
    let points = mesh.positions.len() * 12;
    let corners = mesh.triangles.len() * 12;
    let total = 2 * points + corners;
    let description = json!({
        "asset": { "version": "2.0", "generator": "mesotex" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3", "min": low, "max": high },
            { "bufferView": 1, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3" },
            { "bufferView": 2, "componentType": 5125, "count": mesh.triangles.len() * 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": points, "target": 34962 },
            { "buffer": 0, "byteOffset": points, "byteLength": points, "target": 34962 },
            { "buffer": 0, "byteOffset": 2 * points, "byteLength": corners, "target": 34963 }
        ],
        "buffers": [{ "byteLength": total }]
    });
    let mut text = description.to_string().into_bytes();
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
        sink.write_all(bytemuck::cast_slice(mesh.positions))?;
        sink.write_all(bytemuck::cast_slice(mesh.normals))?;
        sink.write_all(bytemuck::cast_slice(mesh.triangles))
    })
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let mut points = positions.iter().map(|&p| Vec3::from_array(p));
    let first = points.next().unwrap_or_default();
    let (low, high) = points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    (low.to_array(), high.to_array())
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

    fn square() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let mesh = GltfMesh {
            positions: &POSITIONS,
            normals: &[[0., 0., 1.]; 4],
            triangles: &[[0, 1, 2], [0, 2, 3]],
        };
        write(&path, &mesh).unwrap();
        fs::read(&path).unwrap()
    }

    #[test]
    fn written_files_read_back() {
        let mesh = parse(&square(), Path::new("a.glb")).unwrap();
        assert_eq!(mesh.positions, POSITIONS);
        assert_eq!(mesh.faces.corners, [0, 1, 2, 0, 2, 3]);
        assert_eq!(mesh.normals.unwrap()[3], [0., 0., 1.]);
    }

    #[test]
    fn damage_is_refused() {
        let whole = square();
        assert!(parse(&whole[..whole.len() - 8], Path::new("a.glb")).is_err());
        let key = b"\"count\":6";
        let at = whole
            .windows(key.len())
            .position(|bytes| bytes == key)
            .unwrap();
        let mut more = whole.clone();
        more[at + 8] = b'9';
        let error = parse(&more, Path::new("a.glb")).unwrap_err().to_string();
        assert!(error.contains("beyond its buffer"), "{error}");
        let mut far = whole;
        let last = far.len() - 4;
        far[last] = 200;
        let error = parse(&far, Path::new("a.glb")).unwrap_err().to_string();
        assert!(error.contains("vertex index 200"), "{error}");
    }

    #[test]
    fn base64_decodes() {
        assert_eq!(decode_base64("bWVzaA==").unwrap(), b"mesh");
        assert_eq!(decode_base64("bW*z"), None);
    }

    #[test]
    fn strips_and_fans_alternate() {
        let indices = [0, 1, 2, 3];
        assert_eq!(
            triangles(Mode::TriangleStrip, &indices),
            [[0, 1, 2], [2, 1, 3]]
        );
        assert_eq!(
            triangles(Mode::TriangleFan, &indices),
            [[0, 1, 2], [0, 2, 3]]
        );
    }
}
