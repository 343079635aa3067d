//! Channels of a sample on the faces of a map.

use glam::Vec3;

use crate::exemplar::channels::ChannelKind;
use crate::maps::face_map::{FaceChannel, FaceMap};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::textures::channel::SampleChannel;
use crate::textures::properties::property_names;
use crate::textures::transfer::onto_vertices;

/// Gives every face of a map what the channels have at the centre of its source: the first colour becomes its colour,
/// all other channels become properties of their names. Vertices of `centers` are the faces.
pub fn carry_onto_faces(map: &mut FaceMap, centers: &SurfaceTextonMap, channels: &[SampleChannel]) {
    for channel in channels {
        let values = onto_vertices(channel, centers);
        if channel.kind == ChannelKind::Color && map.colors.is_none() {
            // Grey has one number for all three.
            let color = |value: &[f32; 3]| [0, 1, 2].map(|at| value[at % channel.count]);
            map.colors = Some(values.iter().map(color).collect());
            continue;
        }
        let named = property_names(channel).into_iter().enumerate();
        map.channels.extend(named.map(|(at, name)| FaceChannel {
            name,
            numbers: values.iter().map(|value| value[at]).collect(),
        }));
    }
}

/// Linear colours of vertices: the means of the faces round them, by area. Black for vertices in no face.
pub fn vertex_colors(map: &FaceMap, colors: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![(Vec3::ZERO, 0.0f32); map.mesh.positions.len()];
    for (face, (corners, color)) in map.mesh.triangles.iter().zip(colors).enumerate() {
        let area = map.mesh.area_normal(face).length();
        for &vertex in corners {
            let (sum, areas) = &mut sums[vertex as usize];
            *sum += area * Vec3::from_array(*color);
            *areas += area;
        }
    }
    let mean = |(sum, areas): (Vec3, f32)| (sum / areas.max(f32::MIN_POSITIVE)).to_array();
    sums.into_iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::channels::ChannelKind;
    use crate::format::image::{Encoding, FloatImage, Precision};
    use crate::grid::{TexCoord, TexelGrid};
    use crate::index::TextonLabel;
    use crate::maps::face_map::tests::pair;
    use crate::mesh::triangle_mesh::TriangleMesh;

    fn channel(name: &str, kind: ChannelKind, channels: u32) -> SampleChannel {
        let grid = TexelGrid {
            width: 24,
            height: 16,
            tileable: false,
        };
        let count = 24 * 16 * channels;
        let image = FloatImage {
            width: 24,
            height: 16,
            channels,
            data: (0..count).map(|at| at as f32 / count as f32).collect(),
            encoding: Encoding::Data,
            precision: Precision::Float,
        };
        SampleChannel::of_image(name.into(), kind, image, grid, 1).unwrap()
    }

    fn centers(map: &FaceMap) -> SurfaceTextonMap {
        SurfaceTextonMap {
            mesh: TriangleMesh {
                positions: vec![Vec3::ZERO; 2],
                triangles: Vec::new(),
            },
            normals: vec![Vec3::Z; 2],
            orientations: vec![Vec3::X; 2],
            scale: None,
            coords: vec![TexCoord { s: 0.5, t: 15.5 }, TexCoord { s: 23.5, t: 0.5 }],
            textons: vec![TextonLabel::NONE; 2],
            transition: None,
            mask: None,
            header: map.header.clone(),
        }
    }

    #[test]
    fn the_first_colour_is_the_colour_and_others_are_named() {
        let mut map = pair();
        (map.colors, map.channels) = (None, Vec::new());
        let channels = [
            channel("grey", ChannelKind::Color, 1),
            channel("other", ChannelKind::Color, 3),
            channel("b", ChannelKind::Height, 1),
        ];
        let points = centers(&map);
        carry_onto_faces(&mut map, &points, &channels);
        let colors = map.colors.as_ref().unwrap();
        assert_eq!(colors[0], [0.0; 3]);
        assert!(colors[1][0] > 0.99 && colors[1][0] == colors[1][2]);
        let names: Vec<&str> = map.channels.iter().map(|of| of.name.as_str()).collect();
        assert_eq!(names, ["other_red", "other_green", "other_blue", "map_b"]);
        assert_eq!(map.channels[3].numbers[0], 0.0);
    }

    #[test]
    fn vertices_have_the_means_of_their_faces() {
        let map = pair();
        let colors = vertex_colors(&map, &[[1.0, 0.0, 0.5], [0.0, 1.0, 0.5]]);
        assert_eq!(colors[1], [1.0, 0.0, 0.5]);
        assert_eq!(colors[0], [0.5; 3]);
    }
}
