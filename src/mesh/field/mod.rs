//! The orientation field: a unit tangent s at every vertex, as smooth as the surface allows.

use glam::DVec2;
use rayon::prelude::*;

use crate::mesh::rings::Rings;

/// A direction that the field must take at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint {
    /// The vertex.
    pub vertex: u32,
    /// The angle from the vertex's axis, in radians.
    pub angle: f64,
}

/// Relaxes a field (Wei-Levoy 2001 §3.1): every vertex takes the mean of its neighbours' carried
/// directions. Hands back the angle from each vertex's axis.
pub fn orientation_field(rings: &Rings, constraints: &[Constraint]) -> Vec<f64> {
    let count = rings.edges.len();
    let mut fixed = vec![false; count];
    let mut field = vec![DVec2::X; count];
    for constraint in constraints {
        fixed[constraint.vertex as usize] = true;
        field[constraint.vertex as usize] = DVec2::from_angle(constraint.angle);
    }
    for _ in 0..200 {
        field = (0..count)
            .into_par_iter()
            .map(|vertex| {
                if fixed[vertex] {
                    return field[vertex];
                }
                let carried = rings.edges.range(vertex).map(|entry| {
                    let far = rings.edges.entries[entry].target as usize;
                    DVec2::from_angle(rings.transport(entry)).rotate(field[far])
                });
                (carried.sum::<DVec2>() + field[vertex]).normalize_or(field[vertex])
            })
            .collect();
    }
    field.into_iter().map(DVec2::to_angle).collect()
}
