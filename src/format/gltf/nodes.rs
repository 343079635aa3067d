//! The positions of the meshes of a scene: the tree of nodes, in double precision, with instances.

use glam::{DMat4, DQuat, DVec3, Vec3};
use gltf::{Gltf, Mesh, Node, Scene};
use serde_json::Value;

use crate::error::{Error, Result};
use crate::format::gltf::accessors::Accessors;
use crate::format::gltf::description::list;

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// A mesh and where it stands.
pub(super) struct Placed<'a> {
    /// What stands there.
    pub mesh: Mesh<'a>,
    /// From the mesh's coordinates to the scene's.
    pub world: DMat4,
}

/// The nodes of a file.
pub(super) struct Nodes<'a> {
    /// Their descriptions: the `gltf` crate has single precision alone.
    described: &'a [Value],
}

impl<'a> Nodes<'a> {
    pub fn new(description: &'a Value) -> Self {
        Self {
            described: list(description, "nodes"),
        }
    }

    /// All meshes of a scene, in the order of the tree.
    pub fn placed<'b>(
        &self,
        scene: &Scene<'b>,
        file: &'b Gltf,
        accessors: &Accessors<'_>,
    ) -> Result<Vec<Placed<'b>>> {
        let mut placed = Vec::new();
        let mut visited = vec![false; self.described.len()];
        // Depth first without recursion: a damaged file may nest without end.
        let mut waiting: Vec<(Node<'b>, DMat4)> = Vec::new();
        let roots: Vec<_> = scene.nodes().collect();
        waiting.extend(roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)));
        while let Some((node, parent)) = waiting.pop() {
            let visited = visited.get_mut(node.index());
            if visited.is_none_or(|visited| std::mem::replace(visited, true)) {
                return Err(
                    Error::data(format!("node {}", node.index()), "is in the tree twice")
                        .expected("a tree of nodes"),
                );
            }
            let described = &self.described[node.index()];
            let world = parent * transform(described);
            if let Some(mesh) = node.mesh() {
                let instances = instances(described, file, accessors).map_err(|error| {
                    Error::data(format!("node {}", node.index()), error.to_string())
                })?;
                let at = |local| Placed {
                    mesh: mesh.clone(),
                    world: world * local,
                };
                placed.extend(instances.into_iter().map(at));
            }
            let children: Vec<_> = node.children().collect();
            waiting.extend(children.into_iter().rev().map(|child| (child, world)));
        }
        Ok(placed)
    }
}

/// A node's transform: a matrix, or translation, rotation and scale.
fn transform(node: &Value) -> DMat4 {
    if let Some(matrix) = numbers::<16>(&node["matrix"]) {
        return DMat4::from_cols_array(&matrix);
    }
    let translation = numbers(&node["translation"]).unwrap_or_default();
    let rotation = numbers(&node["rotation"]).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = numbers(&node["scale"]).unwrap_or([1.0; 3]);
    DMat4::from_scale_rotation_translation(
        DVec3::from_array(scale),
        DQuat::from_array(rotation),
        DVec3::from_array(translation),
    )
}

fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let list = value.as_array()?;
    let numbers: Option<Vec<f64>> = list.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}

/// The transforms of a node's instances; of a node without instancing, one that moves nothing.
fn instances(node: &Value, file: &Gltf, accessors: &Accessors<'_>) -> Result<Vec<DMat4>> {
    let attributes = &node["extensions"][INSTANCING]["attributes"];
    if attributes.is_null() {
        return Ok(vec![DMat4::IDENTITY]);
    }
    // Find the accessors of the three parts.
    let accessor = |name: &str| {
        let Some(index) = attributes[name].as_u64() else {
            return Ok(None);
        };
        let found = file.accessors().nth(index as usize);
        found.map(Some).ok_or_else(|| {
            Error::data(format!("{INSTANCING} {name}"), format!("accessor {index}"))
                .expected(format!("below {} accessors", file.accessors().count()))
        })
    };
    let (moves, turns, sizes) = (
        accessor("TRANSLATION")?,
        accessor("ROTATION")?,
        accessor("SCALE")?,
    );
    // Read their values.
    let moves = moves
        .map(|found| accessors.numbers::<3>(&found))
        .transpose()?;
    let turns = turns
        .map(|found| accessors.numbers::<4>(&found))
        .transpose()?;
    let sizes = sizes
        .map(|found| accessors.numbers::<3>(&found))
        .transpose()?;
    // Check that all parts have as many.
    let counts = [
        moves.as_ref().map(Vec::len),
        turns.as_ref().map(Vec::len),
        sizes.as_ref().map(Vec::len),
    ];
    let count = counts.into_iter().flatten().min().unwrap_or(0);
    if counts.into_iter().flatten().any(|found| found != count) {
        return Err(
            Error::data(INSTANCING, format!("{counts:?} values")).expected("as many of each")
        );
    }
    // Compose a transform per instance.
    let vector = |list: &Option<Vec<[f32; 3]>>, instance: usize, missing: f32| {
        let found = list.as_ref().map_or([missing; 3], |list| list[instance]);
        Vec3::from_array(found).as_dvec3()
    };
    let turn = |instance: usize| {
        let found = turns
            .as_ref()
            .map_or([0.0, 0.0, 0.0, 1.0], |list| list[instance]);
        DQuat::from_array(found.map(f64::from)).normalize()
    };
    Ok((0..count)
        .map(|instance| {
            DMat4::from_scale_rotation_translation(
                vector(&sizes, instance, 1.0),
                turn(instance),
                vector(&moves, instance, 0.0),
            )
        })
        .collect())
}
