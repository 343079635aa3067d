//! Meshes with vertex colours that show how a surface was prepared: field and singularities,
//! levels, distortion of patches.

use std::path::Path;

use glam::{DVec2, DVec3, Vec3};
use rand::Rng;

use crate::error::Result;
use crate::mesh::colored_vertices::{self, ColoredVertices};
use crate::mesh::field::Field;
use crate::mesh::field::singularities::Singularity;
use crate::mesh::rings::Rings;
use crate::mesh::shapes;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::random;

/// A mesh and an 8-bit sRGB colour for each vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexColoredMesh {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// One colour per vertex.
    pub colors: Vec<[u8; 3]>,
}

/// Arrows drawn on a surface, at most.
const MOST_ARROWS: usize = 4000;
const SURFACE: [u8; 3] = [205, 205, 205];
const ARROW: [u8; 3] = [20, 60, 140];
const SOURCE: [u8; 3] = [220, 40, 30];
const SADDLE: [u8; 3] = [40, 90, 230];

impl VertexColoredMesh {
    /// Adds a mesh in one colour.
    pub fn add(&mut self, mesh: &TriangleMesh, color: [u8; 3]) {
        let base = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(&mesh.positions);
        self.mesh
            .triangles
            .extend(mesh.triangles.iter().map(|t| t.map(|v| v + base)));
        self.colors.resize(self.mesh.positions.len(), color);
    }

    /// Writes it; positions count from `origin`.
    pub fn write(&self, path: &Path, origin: DVec3) -> Result<()> {
        let vertices = ColoredVertices {
            srgb: &self.colors,
            ..ColoredVertices::default()
        };
        colored_vertices::write(path, (&self.mesh, origin), vertices)
    }
}

/// The field as arrows along s, its singularities as balls: red turns with the walk round them,
/// blue against it.
pub fn field(
    mesh: &TriangleMesh,
    rings: &Rings,
    field: &Field,
    singular: &[Singularity],
) -> VertexColoredMesh {
    // Draw the surface.
    let mut picture = VertexColoredMesh::default();
    picture.add(mesh, SURFACE);
    // Draw arrows, as many as can be told apart.
    let step = mesh.positions.len().div_ceil(MOST_ARROWS);
    let area = mesh.area() as f32;
    let length = 0.6 * (area * step as f32 / mesh.positions.len() as f32).sqrt();
    let mut arrows = TriangleMesh::default();
    for vertex in (0..mesh.positions.len()).step_by(step) {
        if !rings.edges.row(vertex).is_empty() {
            add_arrow(
                &mut arrows,
                mesh,
                rings,
                field.vectors[vertex],
                vertex,
                length,
            );
        }
    }
    picture.add(&arrows, ARROW);
    // Draw a ball at each singularity.
    for singularity in singular {
        let [a, b, c] = mesh.corners(singularity.triangle as usize);
        let centre = (a + b + c) / 3.0;
        let mut ball = shapes::icosphere(2);
        ball.positions
            .iter_mut()
            .for_each(|p| *p = centre + *p * (1.2 * length));
        picture.add(
            &ball,
            if singularity.index > 0 {
                SOURCE
            } else {
                SADDLE
            },
        );
    }
    picture
}

/// A slender triangle that points along the field, a little above the surface.
fn add_arrow(
    arrows: &mut TriangleMesh,
    mesh: &TriangleMesh,
    rings: &Rings,
    vector: DVec2,
    vertex: usize,
    length: f32,
) {
    let s = rings.direction(vertex, vector.to_angle());
    let n = rings.normals[vertex];
    let side = n.cross(s) * (0.16 * length);
    let tail = mesh.positions[vertex] + n * (0.08 * length) - s * (0.5 * length);
    let base = arrows.positions.len() as u32;
    arrows
        .positions
        .extend([tail + side, tail - side, tail + s * length]);
    arrows.triangles.push([base, base + 1, base + 2]);
}

/// A level of the pyramid: every vertex in a colour of its own, so that its cell is seen.
pub fn level(mesh: &TriangleMesh) -> VertexColoredMesh {
    let color = |vertex: usize| {
        let mut random = random::stream(0, "level picture", 0, vertex as u64);
        std::array::from_fn(|_| random.gen_range(90..=255u8))
    };
    VertexColoredMesh {
        mesh: mesh.clone(),
        colors: (0..mesh.positions.len()).map(color).collect(),
    }
}

/// Values from 0 (blue) over half of `most` (green) to `most` and more (red).
pub fn heat(mesh: &TriangleMesh, values: &[f32], most: f32) -> VertexColoredMesh {
    let color = |value: &f32| {
        let x = (value / most).clamp(0.0, 1.0);
        let ramp = |centre: f32| ((1.0 - 2.0 * (x - centre).abs()).clamp(0.0, 1.0) * 255.0) as u8;
        [ramp(1.0), ramp(0.5), ramp(0.0)]
    };
    VertexColoredMesh {
        mesh: mesh.clone(),
        colors: values.iter().map(color).collect(),
    }
}

/// A triangle's centroid.
pub fn centroid(mesh: &TriangleMesh, triangle: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle);
    (a + b + c) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::field::{FieldConstraints, orientation_field, singularities::singularities};
    use crate::mesh::topology::Topology;
    use crate::progress::Progress;

    #[test]
    fn the_field_picture_has_an_arrow_a_vertex_and_a_ball_a_singularity() {
        let mesh = shapes::icosphere(2);
        let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
        let smooth = orientation_field(
            &mesh,
            &rings,
            &FieldConstraints::default(),
            0,
            Progress::silent(),
        )
        .unwrap();
        let singular = singularities(&mesh, &rings, &smooth.vectors);
        let picture = field(&mesh, &rings, &smooth, &singular);
        let ball = shapes::icosphere(2).positions.len();
        let vertices = mesh.positions.len() * 4 + singular.len() * ball;
        assert_eq!(picture.colors.len(), vertices);
        assert!(picture.colors.contains(&SOURCE) && !picture.colors.contains(&SADDLE));
    }

    #[test]
    fn heat_runs_from_blue_to_red() {
        let mesh = shapes::grid(1, 1, 1.0);
        let colors = heat(&mesh, &[0.0, 0.5, 1.0, 7.0], 1.0).colors;
        assert_eq!(colors, [[0, 0, 255], [0, 255, 0], [255, 0, 0], [255, 0, 0]]);
    }
}
