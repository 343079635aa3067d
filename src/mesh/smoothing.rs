//! A surface without its finest detail, for paths that should not follow every bump (Ying 2001 §4.1).
//!
//! Positions diffuse along the surface with mean-value weights (Floater 2003): they are positive, and a
//! vertex amid neighbours in a plane stays where it is.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::mesh::compressed_rows::Rows;
use crate::mesh::rings::{RingEdge, Rings};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// Steps of diffusion at most: on meshes much denser than the distance the finest detail is gone by then.
const MOST_STEPS: u32 = 64;

/// The mesh with detail smaller than `distance` (mesh units) smoothed away. Boundaries stay.
pub fn smoothed(
    mesh: &TriangleMesh,
    rings: &Rings,
    distance: f32,
    progress: Progress<'_>,
) -> Result<TriangleMesh> {
    let weights = mean_value_weights(rings);
    let mut positions = mesh.positions.clone();
    for _ in 0..steps(rings, distance) {
        progress.check()?;
        positions = (0..positions.len())
            .into_par_iter()
            .map(|vertex| {
                let edges = rings.edges.row(vertex).iter();
                let around = edges.zip(weights.row(vertex));
                let own = positions[vertex];
                let towards: Vec3 = around
                    .map(|(edge, &weight)| (positions[edge.target as usize] - own) * weight)
                    .sum();
                own + 0.5 * towards
            })
            .collect();
    }
    Ok(TriangleMesh {
        positions,
        triangles: mesh.triangles.clone(),
    })
}

/// Half steps to the neighbours until the diffusion has gone as far as `distance` along each axis.
fn steps(rings: &Rings, distance: f32) -> u32 {
    let edges = &rings.edges.entries;
    let squares = edges.iter().map(|edge| f64::from(edge.length).powi(2));
    let mean = squares.sum::<f64>() / edges.len().max(1) as f64;
    let wanted = 4.0 * f64::from(distance).powi(2) / mean.max(f64::MIN_POSITIVE);
    (wanted.round() as u32).min(MOST_STEPS)
}

/// Per vertex the weights of its edges, which sum to 1; zeros on a boundary.
fn mean_value_weights(rings: &Rings) -> Rows<f32> {
    Rows::collect(
        rings.edges.len(),
        || (),
        |(), vertex, out| {
            let edges = rings.edges.row(vertex);
            if rings.boundary[vertex] {
                out.extend(edges.iter().map(|_| 0.0));
                return;
            }
            let begin = out.len();
            out.extend((0..edges.len()).map(|place| weight(edges, place)));
            let sum: f32 = out[begin..].iter().sum();
            let share = if sum > 0.0 { sum.recip() } else { 0.0 };
            out[begin..].iter_mut().for_each(|weight| *weight *= share);
        },
    )
}

/// The mean of the tangents of half the angles on both sides of an edge, over its length.
fn weight(edges: &[RingEdge], place: usize) -> f32 {
    let count = edges.len();
    let angle = |place: usize| {
        let (here, next) = (edges[place].angle, edges[(place + 1) % count].angle);
        (next - here).rem_euclid(std::f64::consts::TAU)
    };
    let half = |angle: f64| (0.5 * angle.min(MOST_ANGLE)).tan();
    let both = half(angle(place)) + half(angle((place + count - 1) % count));
    (both / f64::from(edges[place].length).max(f64::MIN_POSITIVE)) as f32
}

/// Wider angles count as this one, in radians: beyond π the tangent of the half is negative.
const MOST_ANGLE: f64 = 3.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;

    fn smooth(mesh: &TriangleMesh, distance: f32) -> TriangleMesh {
        let rings = Rings::new(mesh, &Topology::new(&mesh.triangles));
        smoothed(mesh, &rings, distance, Progress::silent()).unwrap()
    }

    #[test]
    fn a_plane_stays_and_a_bump_on_it_goes() {
        let mut mesh = shapes::grid(20, 20, 1.0);
        // Irregular, but flat.
        for (number, position) in mesh.positions.iter_mut().enumerate() {
            if (0.5..19.5).contains(&position.x) && (0.5..19.5).contains(&position.y) {
                let turn = number as f32 * 2.4;
                *position += Vec3::new(turn.sin(), turn.cos(), 0.0) * 0.2;
            }
        }
        let flat = smooth(&mesh, 2.0);
        for (before, after) in mesh.positions.iter().zip(&flat.positions) {
            assert!(before.distance(*after) < 1e-3, "{before} {after}");
        }
        let bump = 10 * 21 + 10;
        mesh.positions[bump].z = 1.0;
        assert!(smooth(&mesh, 2.0).positions[bump].z < 0.1);
        assert_eq!(smooth(&mesh, 0.0), mesh);
    }

    #[test]
    fn a_ball_shrinks_by_little() {
        let ball = smooth(&shapes::icosphere(4), 0.1);
        for position in &ball.positions {
            // σ² / R² of the radius.
            assert!(
                (position.length() - 0.99).abs() < 0.004,
                "{}",
                position.length()
            );
        }
    }
}
