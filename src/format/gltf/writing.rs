//! A mesh into a binary glTF file.

use std::io::Write;
use std::path::Path;

use glam::Vec3;
use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::gltf::material::GltfMaterial;
use crate::format::gltf::split::{Corners, Split};

/// What a GLB file is written from; lists are per vertex.
#[derive(Clone, Copy, Debug, Default)]
pub struct GltfMesh<'a> {
    /// Where the positions count from: the node's translation.
    pub origin: [f64; 3],
    /// Vertex positions.
    pub positions: &'a [[f32; 3]],
    /// Unit vertex normals.
    pub normals: &'a [[f32; 3]],
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
    /// Linear colours, written where there are no texture coordinates.
    pub colors: Option<&'a [[f32; 3]]>,
    /// Further attributes by their names in glTF, written where there are no texture coordinates of corners.
    pub attributes: &'a [(&'a str, VertexAttribute<'a>)],
    /// Texture coordinates of the corners of each triangle, v upwards. A vertex with several is repeated
    /// behind the others; what is not finite is written as 0.
    pub uvs: Option<&'a [[[f32; 2]; 3]]>,
    /// Tangents of the corners of each triangle, as glTF has them; written beside texture coordinates alone.
    pub tangents: Option<&'a [[[f32; 4]; 3]]>,
    /// How it looks.
    pub material: Option<GltfMaterial<'a>>,
}

/// Numbers per vertex, under a name of glTF or one that begins with an underscore.
#[derive(Clone, Copy, Debug)]
pub enum VertexAttribute<'a> {
    /// One number.
    Scalar(&'a [f32]),
    /// Two numbers.
    Vec2(&'a [[f32; 2]]),
    /// Four numbers.
    Vec4(&'a [[f32; 4]]),
}

impl<'a> VertexAttribute<'a> {
    /// The bytes, how many elements they are, and what glTF calls the kind.
    fn parts(self) -> (&'a [u8], usize, &'static str) {
        match self {
            Self::Scalar(list) => (bytemuck::cast_slice(list), list.len(), "SCALAR"),
            Self::Vec2(list) => (bytemuck::cast_slice(list), list.len(), "VEC2"),
            Self::Vec4(list) => (bytemuck::cast_slice(list), list.len(), "VEC4"),
        }
    }
}

/// Writes a binary glTF file of one mesh.
pub fn write(path: &Path, mesh: &GltfMesh<'_>) -> Result<()> {
    let Some(uvs) = mesh.uvs else {
        return write_lists(path, mesh, &[], &[]);
    };
    let corners = Corners {
        uvs,
        tangents: mesh.tangents,
    };
    let split = Split::new(mesh.positions.len(), mesh.triangles, &corners);
    let copied = GltfMesh {
        positions: &split.copied(mesh.positions),
        normals: &split.copied(mesh.normals),
        triangles: &split.triangles,
        colors: None,
        attributes: &[],
        ..*mesh
    };
    write_lists(path, &copied, &split.uvs, &split.tangents)
}

/// The kinds of buffer views.
#[derive(Clone, Copy)]
enum BufferKind {
    Vertices = 34962,
    Indices = 34963,
}

/// The one buffer of the file, list after list, each at a multiple of four bytes.
#[derive(Default)]
struct Buffer<'a> {
    lists: Vec<&'a [u8]>,
    views: Vec<Value>,
    length: usize,
}

impl<'a> Buffer<'a> {
    /// Adds a list; returns the number of its view.
    fn add(&mut self, bytes: &'a [u8], target: Option<BufferKind>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.length, "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target as u32);
        }
        self.views.push(view);
        self.lists.push(bytes);
        self.length += bytes.len().next_multiple_of(4);
        self.views.len() - 1
    }

    fn write(&self, sink: &mut impl Write) -> std::io::Result<()> {
        self.lists.iter().try_for_each(|list| {
            let gap = list.len().next_multiple_of(4) - list.len();
            sink.write_all(list)?;
            sink.write_all(&[0; 3][..gap])
        })
    }
}

fn write_lists(
    path: &Path,
    mesh: &GltfMesh<'_>,
    uvs: &[[f32; 2]],
    tangents: &[[f32; 4]],
) -> Result<()> {
    let mut buffer = Buffer::default();
    let mut text = description(mesh, uvs, tangents, &mut buffer)
        .to_string()
        .into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = u32::try_from(12 + 8 + text.len() + 8 + buffer.length).map_err(|_| {
        Error::data("mesh", "too large for a GLB file").advice("write a PLY instead")
    })?;
    atomic::write_file(path, |sink| {
        sink.write_all(b"glTF")?;
        sink.write_all(&2u32.to_le_bytes())?;
        sink.write_all(&length.to_le_bytes())?;
        sink.write_all(&(text.len() as u32).to_le_bytes())?;
        sink.write_all(b"JSON")?;
        sink.write_all(&text)?;
        sink.write_all(&(buffer.length as u32).to_le_bytes())?;
        sink.write_all(b"BIN\0")?;
        buffer.write(sink)
    })
}

/// The text of the file; its lists go into the buffer.
fn description<'a>(
    mesh: &GltfMesh<'a>,
    uvs: &'a [[f32; 2]],
    tangents: &'a [[f32; 4]],
    buffer: &mut Buffer<'a>,
) -> Value {
    let mut accessors = Accessors::new(buffer);
    let mut primitive = primitive(mesh, uvs, tangents, &mut accessors);
    let accessors = accessors.with_bounds(mesh.positions);
    let mut file = json!({
        "asset": { "version": "2.0", "generator": "mesotex" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [node(mesh.origin)],
        "accessors": accessors,
    });
    // Add the material and its images.
    if let Some(material) = &mesh.material {
        let textures = material.textures();
        let views: Vec<usize> = textures.map(|png| buffer.add(png, None)).collect();
        material.describe(&mut file, &views);
        primitive["material"] = json!(0);
    }
    // Add what holds them.
    file["meshes"] = json!([{ "primitives": [primitive] }]);
    file["bufferViews"] = json!(buffer.views);
    file["buffers"] = json!([{ "byteLength": buffer.length }]);
    file
}

/// The mesh, placed at its origin.
fn node(origin: [f64; 3]) -> Value {
    let mut node = json!({ "mesh": 0 });
    if origin != [0.0; 3] {
        node["translation"] = json!(origin);
    }
    node
}

/// The attributes of the vertices, and the triangles.
fn primitive<'a>(
    mesh: &GltfMesh<'a>,
    uvs: &'a [[f32; 2]],
    tangents: &'a [[f32; 4]],
    accessors: &mut Accessors<'_, 'a>,
) -> Value {
    // Add the lists that every mesh has.
    let mut attributes = json!({
        "POSITION": accessors.vectors(mesh.positions),
        "NORMAL": accessors.vectors(mesh.normals),
    });
    let indices = accessors.indices(mesh.triangles);
    // Add those that are there.
    if let Some(colors) = mesh.colors {
        attributes["COLOR_0"] = json!(accessors.vectors(colors));
    }
    if !uvs.is_empty() {
        attributes["TEXCOORD_0"] = json!(accessors.attribute(VertexAttribute::Vec2(uvs)));
    }
    if !tangents.is_empty() {
        attributes["TANGENT"] = json!(accessors.attribute(VertexAttribute::Vec4(tangents)));
    }
    for (name, attribute) in mesh.attributes {
        attributes[*name] = json!(accessors.attribute(*attribute));
    }
    json!({ "attributes": attributes, "indices": indices })
}

/// The accessors of the lists in a buffer, that of the positions first.
struct Accessors<'b, 'a> {
    buffer: &'b mut Buffer<'a>,
    all: Vec<Value>,
}

impl<'b, 'a> Accessors<'b, 'a> {
    fn new(buffer: &'b mut Buffer<'a>) -> Self {
        Self {
            buffer,
            all: Vec::new(),
        }
    }

    /// Adds three numbers per vertex; returns the accessor's number, as all of these do.
    fn vectors(&mut self, list: &'a [[f32; 3]]) -> usize {
        let bytes = bytemuck::cast_slice(list);
        self.add(bytes, list.len(), "VEC3", BufferKind::Vertices)
    }

    fn attribute(&mut self, attribute: VertexAttribute<'a>) -> usize {
        let (bytes, count, kind) = attribute.parts();
        self.add(bytes, count, kind, BufferKind::Vertices)
    }

    fn indices(&mut self, triangles: &'a [[u32; 3]]) -> usize {
        let bytes = bytemuck::cast_slice(triangles);
        self.add(bytes, triangles.len() * 3, "SCALAR", BufferKind::Indices)
    }

    fn add(&mut self, bytes: &'a [u8], count: usize, kind: &str, target: BufferKind) -> usize {
        let component = match target {
            BufferKind::Indices => 5125,
            BufferKind::Vertices => 5126,
        };
        let view = self.buffer.add(bytes, Some(target));
        self.all.push(
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }),
        );
        self.all.len() - 1
    }

    /// All of them, with the bounds that the format wants of positions.
    fn with_bounds(mut self, positions: &[[f32; 3]]) -> Vec<Value> {
        let (low, high) = bounds(positions);
        self.all[0]["min"] = json!(low);
        self.all[0]["max"] = json!(high);
        self.all
    }
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let mut points = positions.iter().map(|&p| Vec3::from_array(p));
    let first = points.next().unwrap_or_default();
    let (low, high) = points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    (low.to_array(), high.to_array())
}
