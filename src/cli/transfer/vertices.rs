//! Channels of the sample on the vertices of a map, as a PLY.
//!
//! The first colour becomes `red green blue`, the first alpha `alpha`, bytes as MeshLab and Blender show them.
//! Everything else is floats under the channel's name: a colour's in linear light, a normal's x, y and z in
//! mesh space.

use std::path::Path;

use glam::Vec3;

use crate::error::Result;
use crate::exemplar::channels::ChannelKind;
use crate::format::image::encode_srgb8;
use crate::format::ours::MESH_MARK;
use crate::format::ply::{self, Column};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::origin::origin_comment;
use crate::textures::channel::SampleChannel;
use crate::textures::properties::property_names;
use crate::textures::transfer::onto_vertices;

/// A property of the vertices.
struct Property {
    name: String,
    numbers: Numbers,
}

enum Numbers {
    Float(Vec<f32>),
    Byte(Vec<u8>),
}

/// Writes the map's mesh with the channels; returns the names of their properties.
pub(super) fn write(
    path: &Path,
    map: &SurfaceTextonMap,
    channels: &[SampleChannel],
) -> Result<Vec<String>> {
    // Carry the channels onto the vertices.
    let mut properties = Vec::new();
    for (at, channel) in channels.iter().enumerate() {
        let is_first = !channels[..at]
            .iter()
            .any(|other| other.kind == channel.kind);
        properties.extend(properties_of(
            channel,
            is_first,
            &onto_vertices(channel, map),
        ));
    }
    // Join the columns: the geometry, then the channels.
    let geometry = [["x", "y", "z"], ["nx", "ny", "nz"]]
        .into_iter()
        .zip([&map.mesh.positions, &map.normals])
        .flat_map(|(names, vectors)| names.into_iter().zip(axes(vectors)));
    let geometry: Vec<(&str, Vec<f32>)> = geometry.collect();
    let shape = geometry
        .iter()
        .map(|(name, numbers)| (*name, Column::Float(numbers)));
    let carried = properties
        .iter()
        .map(|Property { name, numbers }| match numbers {
            Numbers::Float(numbers) => (name.as_str(), Column::Float(numbers)),
            Numbers::Byte(numbers) => (name.as_str(), Column::UChar(numbers)),
        });
    let columns: Vec<(&str, Column<'_>)> = shape.chain(carried).collect();
    // Write the file.
    let mut comments: Vec<String> = vec![MESH_MARK.into()];
    comments.extend(origin_comment(map.header.origin));
    ply::write(path, &comments, &columns, &map.mesh.triangles)?;
    Ok(properties
        .into_iter()
        .map(|property| property.name)
        .collect())
}

fn axes(vectors: &[Vec3]) -> [Vec<f32>; 3] {
    [0, 1, 2].map(|axis| vectors.iter().map(|vector| vector[axis]).collect())
}

fn properties_of(channel: &SampleChannel, is_first: bool, values: &[[f32; 3]]) -> Vec<Property> {
    let byte = |name: &str, of: &dyn Fn(&[f32; 3]) -> u8| Property {
        name: name.into(),
        numbers: Numbers::Byte(values.iter().map(of).collect()),
    };
    let float = |name: String, at: usize| Property {
        name,
        numbers: Numbers::Float(values.iter().map(|value| value[at]).collect()),
    };
    match channel.kind {
        ChannelKind::Color if is_first => {
            // Grey has one number for all three.
            let number = |value: &[f32; 3], at: usize| encode_srgb8(value[at % channel.count]);
            vec![
                byte("red", &|value| number(value, 0)),
                byte("green", &|value| number(value, 1)),
                byte("blue", &|value| number(value, 2)),
            ]
        }
        ChannelKind::Alpha if is_first => {
            let alpha = |value: &[f32; 3]| (value[0].clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            vec![byte("alpha", &alpha)]
        }
        _ => {
            let named = property_names(channel).into_iter().enumerate();
            named.map(|(at, name)| float(name, at)).collect()
        }
    }
}
