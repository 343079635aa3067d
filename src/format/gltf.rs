//! glTF 2.0, binary (.glb) or text (.gltf): the triangles of all nodes of the scene, in world
//! space.
//!
//! A mesh may stand in many nodes, and accessors in many primitives, so a small file can describe a
//! mesh of any size: what is read is bounded by the bytes of the file and its buffers.
//!
//! Not handled: compressed primitives (Draco, meshopt), sparse accessors, skins and morph targets
//! (the rest pose is read).

mod buffers;
pub mod companions;

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;
use std::rc::Rc;

use glam::{Mat3, Mat4, Vec3};
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::mesh::{Mode, Primitive, Semantic};
use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::format::gltf::buffers::Buffers;
use crate::format::polygon_mesh::PolygonMesh;
use crate::format::{atomic, json};

/// Vertices, and corners of triangles, that any file may describe.
const MOST_ITEMS: usize = 1 << 20;
/// Vertices, and corners of triangles, for each byte of the file and its buffers, beside [`MOST_ITEMS`].
const ITEMS_PER_BYTE: usize = 4;

/// Parses a glTF file's bytes; buffers outside lie beside `path`.
pub fn parse(bytes: &[u8], path: &Path) -> Result<PolygonMesh> {
    check_description(bytes)?;
    let file = gltf::Gltf::from_slice(bytes).map_err(|error| {
        Error::data("glTF", error.to_string())
            .advice("the file is damaged, or asks for an extension we do not read")
    })?;
    let buffers = Buffers::read(&file, path)?;
    let mut reading = Reading {
        room: Room::new(bytes.len().saturating_add(buffers.outside)),
        buffers: buffers.contents,
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
    let accessors = list(&description, "accessors").len() as u64;
    for mesh in list(&description, "meshes") {
        for primitive in list(mesh, "primitives") {
            let position = primitive["attributes"]["POSITION"].as_u64();
            if let Some(index) = position.filter(|&index| index >= accessors) {
                return Err(Error::data("POSITION", format!("accessor {index}"))
                    .expected(format!("below {accessors} accessors")));
            }
        }
    }
    Ok(())
}

fn list<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value[name].as_array().map_or(&[], Vec::as_slice)
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

/// What a file may still describe.
struct Room {
    most: usize,
    vertices: usize,
    corners: usize,
}

impl Room {
    fn new(bytes: usize) -> Self {
        let most = bytes
            .saturating_mul(ITEMS_PER_BYTE)
            .saturating_add(MOST_ITEMS)
            .min(u32::MAX as usize / 2);
        Self {
            most,
            vertices: most,
            corners: most,
        }
    }

    /// Takes the vertices and corners of a primitive, before they are allocated.
    fn take(&mut self, vertices: usize, corners: usize) -> Result<()> {
        let (vertices, corners) = (
            self.vertices.checked_sub(vertices),
            self.corners.checked_sub(corners),
        );
        let (Some(vertices), Some(corners)) = (vertices, corners) else {
            return Err(Error::data("size", "more than its bytes account for")
                .expected(format!(
                    "at most {} vertices and as many corners in all nodes",
                    self.most
                ))
                .advice("export the mesh once for each place where it stands, or fewer of them"));
        };
        (self.vertices, self.corners) = (vertices, corners);
        Ok(())
    }
}

struct Reading<'a> {
    buffers: Vec<Rc<Cow<'a, [u8]>>>,
    room: Room,
    mesh: PolygonMesh,
    visited: Vec<bool>,
    skipped: usize,
}

impl Reading<'_> {
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
        let count = accessor.count();
        let corners = primitive.indices().map_or(count, |list| list.count());
        let corners = match mode {
            Mode::Triangles => corners,
            _ => corners.saturating_mul(3), // each adds a triangle
        };
        self.room.take(count, corners)?;
        let positions = self.floats::<3>(&accessor)?;
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
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(fault("items that overlap").expected(format!("a stride of {size} or more")));
        }
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
    use std::fs;

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

    /// Nodes that share one mesh of `vertices` positions without indices, all 0.
    fn shared(nodes: usize, vertices: usize) -> Vec<u8> {
        let mut text = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": (0..nodes).collect::<Vec<_>>() }],
            "nodes": vec![json!({ "mesh": 0 }); nodes],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": vertices,
                "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0] }],
            "bufferViews": [{ "buffer": 0, "byteLength": 12 * vertices }],
            "buffers": [{ "byteLength": 12 * vertices }]
        })
        .to_string()
        .into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunk = |kind: &[u8], content: &[u8]| {
            [&(content.len() as u32).to_le_bytes(), kind, content].concat()
        };
        let chunks = [
            chunk(b"JSON", &text),
            chunk(b"BIN\0", &vec![0; 12 * vertices]),
        ]
        .concat();
        let length = (12 + chunks.len()) as u32;
        [b"glTF\x02\0\0\0".as_slice(), &length.to_le_bytes(), &chunks].concat()
    }

    #[test]
    fn what_nodes_share_is_bounded_by_the_file() {
        let few = parse(&shared(3, 30), Path::new("a.glb")).unwrap();
        assert_eq!(few.positions.len(), 90);
        let many = parse(&shared(4000, 4000), Path::new("a.glb")).unwrap_err();
        assert!(many.to_string().contains("in all nodes"), "{many}");
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
