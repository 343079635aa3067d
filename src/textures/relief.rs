//! The surface moved along its normals by a height channel.
//!
//! Triangles are cut to the length of a texel first, so that the relief has a vertex per texel. A vertex on a
//! border of charts has a height in each: it takes their mean, so that the surface stays closed.

use std::f64::consts::SQRT_2;

use crate::error::Result;
use crate::mesh::rings::vertex_normals;
use crate::mesh::tessellation::{TexturedMesh, affordable_edge, tessellate};
use crate::progress::Progress;
use crate::textures::texture::Texture;

/// The most triangles of a displaced surface: about 150 MB of GLB.
pub(super) const MOST_TRIANGLES: usize = 1 << 21;

/// A surface with about a vertex per texel.
pub(super) struct Cut {
    /// It.
    pub(super) surface: TexturedMesh,
    /// The longest edge that it was cut to, in mesh units.
    pub(super) edge: f64,
}

/// Cuts a surface into edges of at most the diagonal of a texel, whose side is `texel` mesh units, or longer ones
/// where there would be too many triangles.
pub(super) fn cut(surface: TexturedMesh, texel: f64, progress: Progress<'_>) -> Result<Cut> {
    let edge = affordable_edge(&surface.mesh, texel * SQRT_2, MOST_TRIANGLES);
    let surface = tessellate(surface, edge, MOST_TRIANGLES, progress)?;
    Ok(Cut { surface, edge })
}

/// Moves each vertex along its normal by its height times `amount` mesh units; the normals stay those of the
/// smooth surface.
pub(super) fn displace(surface: &mut TexturedMesh, heights: &Texture, amount: f64) {
    let offsets = vertex_means(surface, heights);
    let vertices = surface.mesh.positions.iter_mut().zip(&surface.normals);
    for ((position, normal), height) in vertices.zip(offsets) {
        *position += *normal * (f64::from(height) * amount) as f32;
    }
}

/// The normals of a moved surface's own shape.
pub(super) fn own_normals(surface: &mut TexturedMesh) {
    surface.normals = vertex_normals(&surface.mesh);
}

/// The mean number of each vertex' corners; 0 for a vertex in no triangle.
pub(super) fn vertex_means(surface: &TexturedMesh, texture: &Texture) -> Vec<f32> {
    let mut sums = vec![(0.0_f64, 0_u32); surface.mesh.positions.len()];
    let triangles = surface.mesh.triangles.iter().zip(&surface.corner_uvs);
    for (&vertex, &uv) in triangles.flat_map(|(corners, uvs)| corners.iter().zip(uvs)) {
        let (sum, count) = &mut sums[vertex as usize];
        *sum += f64::from(texture.at_uv(uv));
        *count += 1;
    }
    let mean = |(sum, count): (f64, u32)| (sum / f64::from(count.max(1))) as f32;
    sums.into_iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::channels::ChannelKind;
    use crate::mesh::shapes::icosphere;
    use crate::mesh::topology::Topology;
    use crate::textures::texture::tests::texture;
    use glam::Vec2;

    #[test]
    fn a_ball_of_constant_height_grows() {
        let mesh = icosphere(2);
        let surface = TexturedMesh {
            normals: mesh.positions.clone(),
            corner_uvs: vec![[Vec2::splat(0.5); 3]; mesh.triangles.len()],
            mesh,
        };
        let half = texture(ChannelKind::Height, 1, vec![0.5; 4]);
        let moved = |texel| {
            let cut = cut(surface.clone(), texel, Progress::silent()).unwrap();
            let mut moved = cut.surface;
            displace(&mut moved, &half, 0.3);
            moved.mesh
        };
        let coarse = moved(10.0);
        for position in &coarse.positions {
            assert!((position.length() - 1.15).abs() < 1e-5);
        }
        let fine = moved(0.1);
        assert!(fine.triangles.len() > 4 * coarse.triangles.len());
        let topology = Topology::new(&fine.triangles);
        assert_eq!(topology.boundary_half_edges().count(), 0);
    }

    #[test]
    fn vertices_on_a_border_of_charts_take_the_mean() {
        let mesh = crate::mesh::shapes::grid(2, 1, 1.0);
        // The left cells show the left of the image, the right cells the right.
        let left = |t: usize| mesh.corners(t).iter().all(|p| p.x < 1.5);
        let uv = |t| {
            if left(t) {
                Vec2::new(0.25, 0.5)
            } else {
                Vec2::new(0.75, 0.5)
            }
        };
        let surface = TexturedMesh {
            normals: vertex_normals(&mesh),
            corner_uvs: (0..mesh.triangles.len()).map(|t| [uv(t); 3]).collect(),
            mesh,
        };
        let steps = texture(ChannelKind::Height, 1, vec![0.0, 1.0, 0.0, 1.0]);
        let heights = vertex_means(&surface, &steps);
        for (p, height) in surface.mesh.positions.iter().zip(heights) {
            let wanted = if p.x < 0.5 {
                0.0..=0.0
            } else if p.x < 1.5 {
                0.2..=0.8
            } else {
                1.0..=1.0
            };
            assert!(wanted.contains(&height), "{p}: {height}");
        }
    }
}
