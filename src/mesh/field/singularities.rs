//! Where a field has no direction: triangles round which it turns (Knöppel 2013 §6). On a closed
//! surface the indices sum to the Euler characteristic (Poincaré-Hopf).

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;

use crate::mesh::rings::Rings;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A triangle round which the field turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Singularity {
    /// The triangle.
    pub triangle: u32,
    /// How often the field turns, counter-clockwise.
    pub index: i32,
}

/// Finds the singular triangles of a field given by its vectors in the rings' tangent planes.
pub fn singularities(mesh: &TriangleMesh, rings: &Rings, vectors: &[DVec2]) -> Vec<Singularity> {
    (0..mesh.triangles.len())
        .into_par_iter()
        .filter_map(|triangle| {
            let index = index(rings, vectors, mesh.triangles[triangle]);
            (index != 0).then_some(Singularity {
                triangle: triangle as u32,
                index,
            })
        })
        .collect()
}

fn index(rings: &Rings, vectors: &[DVec2], [i, j, k]: [u32; 3]) -> i32 {
    let (mut turned, mut carried) = (0.0, 0.0);
    for (from, to) in [(i, j), (j, k), (k, i)] {
        // Both triangles at an edge must use the same rotation, so it is always measured in one direction.
        let (low, high) = (from.min(to), from.max(to));
        let turn = turn(rings, vectors, low, high);
        turned += if from == low { turn } else { -turn };
        carried += transport(rings, from, to);
    }
    ((turned - wrap(carried)) / TAU).round() as i32
}

fn transport(rings: &Rings, from: u32, to: u32) -> f64 {
    let range = rings.edges.range(from as usize);
    let place = rings
        .edges
        .row(from as usize)
        .iter()
        .position(|edge| edge.target == to);
    place.map_or(0.0, |place| rings.transport(range.start + place))
}

/// The angle from one vertex's vector to the next one's, carried to it.
fn turn(rings: &Rings, vectors: &[DVec2], from: u32, to: u32) -> f64 {
    let there = vectors[to as usize].to_angle() + transport(rings, from, to);
    wrap(there - vectors[from as usize].to_angle())
}

/// An angle brought into −π … π.
fn wrap(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::field::tests::free_field;
    use crate::mesh::field::{FieldConstraints, orientation_field};
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;
    use crate::progress::Progress;
    use crate::random;
    use rand::Rng;

    #[test]
    fn indices_sum_to_the_euler_characteristic_whatever_the_field() {
        for (mesh, euler) in [
            (shapes::icosphere(2), 2),
            (shapes::torus(20, 10, 1.0, 0.4), 0),
        ] {
            let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
            let mut random = random::stream(5, "singularities test", 0, 0);
            let mut noise = || DVec2::from_angle(random.gen_range(0.0..TAU));
            let noisy: Vec<DVec2> = mesh.positions.iter().map(|_| noise()).collect();
            let smooth = orientation_field(
                &mesh,
                &rings,
                &FieldConstraints::default(),
                0,
                Progress::silent(),
            )
            .unwrap()
            .vectors;
            for vectors in [noisy, smooth] {
                let found = singularities(&mesh, &rings, &vectors);
                assert_eq!(found.iter().map(|s| s.index).sum::<i32>(), euler);
            }
        }
    }

    #[test]
    fn a_smooth_field_on_a_sphere_turns_twice() {
        let mesh = shapes::icosphere(3);
        let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
        let field = free_field(&mesh, &rings, 0);
        let found = singularities(&mesh, &rings, &field.vectors);
        assert_eq!(found.iter().map(|s| s.index).collect::<Vec<_>>(), [1, 1]);
    }
}
