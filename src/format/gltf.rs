//! glTF 2.0, binary (.glb) or text (.gltf): the triangles of all nodes of the scene, in world
//! space, instances included.
//!
//! A mesh may stand in many nodes, and accessors in many primitives, so a small file can describe a
//! mesh of any size: what is read is bounded by the bytes of the file and its buffers.
//!
//! Compressed primitives (Draco, meshopt) are refused by name. Skins and morph targets are noted: the
//! rest pose is read.

mod accessors;
mod buffers;
mod companions;
mod description;
mod extensions;
mod material;
mod nodes;
mod room;
mod split;
mod writing;

use std::path::Path;

use glam::{DMat3, DMat4, Vec3};
use gltf::accessor::Accessor;
use gltf::mesh::{Mode, Primitive, Semantic};

pub use crate::format::gltf::material::{AlphaMode, GltfMaterial};
pub use crate::format::gltf::writing::{GltfMesh, VertexAttribute, write};

use crate::error::{Error, Result};
use crate::format::gltf::accessors::Accessors;
use crate::format::gltf::buffers::Buffers;
use crate::format::gltf::description::Description;
use crate::format::gltf::nodes::Nodes;
use crate::format::gltf::room::Room;
use crate::format::mesh_format::MeshFormat;
use crate::format::polygon_mesh::PolygonMesh;

/// The format.
pub(crate) const FORMAT: MeshFormat = MeshFormat {
    name: "glTF",
    extensions: &["glb", "gltf"],
    parse,
    splits_vertices: true,
    companions: Some(companions::companions),
};

/// Parses a glTF file's bytes; buffers outside lie beside `path`.
pub fn parse(bytes: &[u8], path: &Path) -> Result<PolygonMesh> {
    // Read the description and the buffers.
    let mut description = Description::read(bytes)?;
    let unneeded = extensions::settle(&mut description.json)?;
    let file = description.file()?;
    let buffers = Buffers::read(&file, path)?;
    // Gather the meshes of the scene, each in its place; without a scene, all meshes.
    let nodes = Nodes::new(&description.json);
    let room = Room::new(bytes.len().saturating_add(buffers.outside));
    let mut reading = Reading {
        accessors: Accessors::new(buffers.contents, room.most),
        room,
        mesh: PolygonMesh {
            corner_uvs: Some(Vec::new()),
            normals: Some(Vec::new()),
            unused: unneeded,
            ..PolygonMesh::default()
        },
        skipped: 0,
        stored: 0.0,
    };
    match file.default_scene().or_else(|| file.scenes().next()) {
        Some(scene) => {
            for placed in nodes.placed(&scene, &file, &reading.accessors)? {
                reading.take_mesh(&placed.mesh, placed.world)?;
            }
        }
        None => file
            .meshes()
            .try_for_each(|mesh| reading.take_mesh(&mesh, DMat4::IDENTITY))?,
    }
    reading.note_poses(&file);
    Ok(reading.finish())
}

struct Reading<'a> {
    accessors: Accessors<'a>,
    room: Room,
    mesh: PolygonMesh,
    skipped: usize,
    /// The largest number that positions are stored as.
    stored: f64,
}

impl Reading<'_> {
    fn take_mesh(&mut self, mesh: &gltf::Mesh<'_>, world: DMat4) -> Result<()> {
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

    fn take_primitive(&mut self, primitive: &Primitive<'_>, world: DMat4) -> Result<()> {
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
        extensions::refuse_draco(primitive, &accessor)?;
        let positions = self.accessors.numbers::<3>(&accessor)?;
        let uvs = primitive.get(&Semantic::TexCoords(0));
        let uvs = self.optional::<2>("texture coordinates", uvs, count, [f32::NAN; 2]);
        let normals = primitive.get(&Semantic::Normals);
        let normals = self.optional::<3>("normals", normals, count, [0.0; 3]);
        let indices = match primitive.indices() {
            Some(accessor) => self.accessors.indices(&accessor, count)?,
            None => (0..count as u32).collect(),
        };
        let base = self.mesh.positions.len() as u32;
        let turned = DMat3::from_mat4(world).inverse().transpose();
        self.place(&positions, world);
        if let Some(all) = &mut self.mesh.normals {
            all.extend(normals.iter().map(|&n| {
                (turned * Vec3::from_array(n).as_dvec3())
                    .as_vec3()
                    .to_array()
            }));
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

    /// Adds positions where a node puts them.
    fn place(&mut self, positions: &[[f32; 3]], world: DMat4) {
        let moved = |p: &[f32; 3]| {
            let stored = Vec3::from_array(*p).as_dvec3();
            (stored.abs().max_element(), world.transform_point3(stored))
        };
        for (stored, position) in positions.iter().map(moved) {
            self.stored = self.stored.max(stored * longest(world));
            self.mesh.positions.push(position.to_array());
        }
    }

    /// An attribute that the surface can do without: what cannot be read is noted.
    fn optional<const N: usize>(
        &mut self,
        what: &str,
        accessor: Option<Accessor<'_>>,
        count: usize,
        missing: [f32; N],
    ) -> Vec<[f32; N]> {
        let Some(accessor) = accessor else {
            return vec![missing; count];
        };
        let values = match accessor.count() {
            found if found == count => self.accessors.numbers::<N>(&accessor),
            found => Err(Error::data(what, format!("{found} values"))
                .expected(format!("{count}, one per vertex"))),
        };
        values.unwrap_or_else(|error| {
            let note = format!("{what} that cannot be used: {error}");
            if !self.mesh.unused.contains(&note) {
                self.mesh.unused.push(note);
            }
            vec![missing; count]
        })
    }

    fn note_poses(&mut self, file: &gltf::Gltf) {
        if file.skins().next().is_some() {
            self.mesh
                .unused
                .push("a skin: the mesh is read in its rest pose".into());
        }
        let mut primitives = file.meshes().flat_map(|mesh| mesh.primitives());
        if primitives.any(|primitive| primitive.morph_targets().next().is_some()) {
            self.mesh
                .unused
                .push("morph targets: the mesh is read without them".into());
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
        let farthest = self.mesh.positions.as_flattened().iter();
        let farthest = farthest.fold(0.0f64, |most, value| most.max(value.abs()));
        // Nodes may move a mesh far off by double precision.
        self.mesh.single_precision = 2.0 * self.stored >= farthest;
        self.mesh.corner_uvs = self.mesh.corner_uvs.filter(|_| has_uvs);
        self.mesh.normals = self.mesh.normals.filter(|_| has_normals);
        self.mesh
    }
}

/// How long a transform makes a unit vector, at most by a factor of √3.
fn longest(world: DMat4) -> f64 {
    let columns = [world.x_axis, world.y_axis, world.z_axis];
    columns
        .map(|column| column.truncate().length())
        .into_iter()
        .fold(0.0, f64::max)
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use std::fs;

    const POSITIONS: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

    fn square_mesh() -> GltfMesh<'static> {
        GltfMesh {
            origin: [0.0; 3],
            positions: &POSITIONS,
            normals: &[[0., 0., 1.]; 4],
            triangles: &[[0, 1, 2], [0, 2, 3]],
            uvs: None,
            ..GltfMesh::default()
        }
    }

    fn square() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        write(&path, &square_mesh()).unwrap();
        fs::read(&path).unwrap()
    }

    #[test]
    fn written_files_read_back() {
        let mesh = parse(&square(), Path::new("a.glb")).unwrap();
        assert_eq!(mesh.positions, POSITIONS.map(|p| p.map(f64::from)));
        assert_eq!(mesh.faces.corners, [0, 1, 2, 0, 2, 3]);
        assert_eq!(mesh.normals.unwrap()[3], [0., 0., 1.]);
    }

    /// The first of some files' JSON.
    fn description_of(bytes: &[u8]) -> serde_json::Value {
        let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
        serde_json::from_slice(&bytes[20..20 + length]).unwrap()
    }

    #[test]
    fn textures_tangents_and_transparency_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        // The two triangles lie mirrored in the texture: their common vertices are repeated.
        let uvs = [
            [[0., 0.], [1., 0.], [1., 1.]],
            [[0., 0.], [1., 1.], [0., 1.]],
        ];
        let tangents = [[[1., 0., 0., 1.]; 3], [[1., 0., 0., -1.]; 3]];
        let material = GltfMaterial {
            base_color: Some(b"first"),
            normal_map: Some(b"second"),
            alpha: AlphaMode::Mask,
            roughness: 0.5,
            is_unlit: true,
        };
        let mesh = GltfMesh {
            uvs: Some(&uvs),
            tangents: Some(&tangents),
            material: Some(material),
            ..square_mesh()
        };
        write(&path, &mesh).unwrap();
        let bytes = fs::read(&path).unwrap();
        let told = description_of(&bytes);
        let material = &told["materials"][0];
        assert_eq!(material["alphaMode"], "MASK");
        assert_eq!(
            (&material["doubleSided"], &material["alphaCutoff"]),
            (&json!(true), &json!(0.5))
        );
        assert_eq!(
            material["pbrMetallicRoughness"]["baseColorTexture"]["index"],
            0
        );
        assert_eq!(material["normalTexture"]["index"], 1);
        assert_eq!(told["extensionsUsed"], json!(["KHR_materials_unlit"]));
        let binary = &bytes[20 + told.to_string().len().next_multiple_of(4) + 8..];
        for (image, content) in [b"first".as_slice(), b"second"].iter().enumerate() {
            let view = &told["bufferViews"]
                [told["images"][image]["bufferView"].as_u64().unwrap() as usize];
            let at = view["byteOffset"].as_u64().unwrap() as usize;
            assert_eq!(at % 4, 0);
            assert_eq!(&binary[at..at + content.len()], *content);
        }
        let read = parse(&bytes, Path::new("a.glb")).unwrap();
        assert_eq!(read.positions.len(), 6);
        assert_eq!(
            read.corner_uvs.unwrap().as_flattened(),
            uvs.as_flattened().as_flattened()
        );
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
