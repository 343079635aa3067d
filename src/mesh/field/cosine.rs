//! The orientation field by cosines of angles (Ying 2001, footnote 2): of all unit fields the one with the
//! greatest Σ cos((θ_i − φ_ij) − (θ_j − φ_ji)) over the edges, where φ_ij is the angle of the edge in the
//! tangent plane of vertex i.
//!
//! In: a field to start from and its constraints. Out: unit vectors. The sum has many local maxima; the
//! one that the start leads to is found.
//!
//! Each step turns one vertex. With all others held, its terms are |S| cos(θ_i − arg S), where S sums the neighbours'
//! vectors carried to it, so that a turn of 0 to 2 times the angle to S never makes them less. Turning by more than 1
//! times that angle (successive overrelaxation) converges faster.

use glam::DVec2;

use crate::error::Result;
use crate::mesh::field::FieldConstraints;
use crate::mesh::rings::Rings;
use crate::progress::Progress;

/// How far a vertex is turned, as a multiple of the angle to the best direction. Below 2.
const OVERRELAXATION: f64 = 1.8;
/// Passes over the mesh end when none of them turns a vertex by more than this, in radians.
const STILL: f64 = 1e-6;
/// The most passes over the mesh.
const MOST_PASSES: usize = 1000;

/// Improves a field, vertex by vertex in ascending order, until it stands still; `areas` are those of the
/// vertices. Vertices with a wanted direction keep it.
///
/// A soft constraint q adds area · (q · u) to the sum. Against edges of weight 1 that is what it weighs in the
/// smoothness energy.
pub fn improved(
    rings: &Rings,
    start: &[DVec2],
    (constraints, areas): (&FieldConstraints, &[f32]),
    progress: Progress<'_>,
) -> Result<Vec<DVec2>> {
    // Hold the vertices with a wanted direction.
    let mut vectors: Vec<DVec2> = start.iter().map(|u| u.normalize_or(DVec2::X)).collect();
    let mut is_fixed = vec![false; vectors.len()];
    for constraint in &constraints.hard {
        is_fixed[constraint.vertex as usize] = true;
    }
    let entries = 0..rings.edges.entries.len();
    let rotations: Vec<DVec2> = entries
        .map(|entry| DVec2::from_angle(rings.transport(entry)))
        .collect();
    // Turn each of the others towards the sum of its neighbours, until none moves.
    for _ in 0..MOST_PASSES {
        progress.check()?;
        let mut largest: f64 = 0.0;
        for vertex in (0..vectors.len()).filter(|&vertex| !is_fixed[vertex]) {
            let range = rings.edges.range(vertex);
            let mut sum = match constraints.soft.get(vertex) {
                Some(pull) => *pull * f64::from(areas[vertex]),
                None => DVec2::ZERO,
            };
            for (edge, rotation) in rings.edges.row(vertex).iter().zip(&rotations[range]) {
                sum += rotation.rotate(vectors[edge.target as usize]);
            }
            let own = vectors[vertex];
            let apart = own.perp_dot(sum).atan2(own.dot(sum));
            vectors[vertex] = own
                .rotate(DVec2::from_angle(OVERRELAXATION * apart))
                .normalize();
            largest = largest.max(apart.abs());
        }
        if largest <= STILL {
            break;
        }
    }
    Ok(vectors)
}

/// The mean of cos((θ_i − φ_ij) − (θ_j − φ_ji)) over all edges: 1 for a parallel field. Only the directions
/// of the vectors count.
pub fn mean_cosine(rings: &Rings, vectors: &[DVec2]) -> f64 {
    let entries = &rings.edges.entries;
    let mut sum = 0.0;
    for vertex in 0..rings.edges.len() {
        let own = vectors[vertex].normalize_or_zero();
        for entry in rings.edges.range(vertex) {
            let other = vectors[entries[entry].target as usize].normalize_or_zero();
            sum += own.dot(DVec2::from_angle(rings.transport(entry)).rotate(other));
        }
    }
    sum / entries.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::field::{Constraint, orientation_field};
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;
    use crate::mesh::triangle_mesh::TriangleMesh;
    use glam::Vec3;
    use std::f64::consts::FRAC_PI_3;

    fn rings(mesh: &TriangleMesh) -> Rings {
        Rings::new(mesh, &Topology::new(&mesh.triangles))
    }

    /// The start and the improved field.
    fn both(mesh: &TriangleMesh, rings: &Rings, constraints: &FieldConstraints) -> [Vec<DVec2>; 2] {
        let start = orientation_field(mesh, rings, constraints, 3, Progress::silent())
            .unwrap()
            .vectors;
        let areas = mesh.vertex_areas();
        let found = improved(rings, &start, (constraints, &areas), Progress::silent()).unwrap();
        [start, found]
    }

    #[test]
    fn a_flat_field_turns_as_evenly_as_its_border() {
        let (columns, rows) = (12, 9);
        let mesh = shapes::grid(columns, rows, 0.1);
        let rings = rings(&mesh);
        let turned = |angle: f64| Vec3::new(angle.cos() as f32, angle.sin() as f32, 0.0);
        // Along the border the direction turns evenly, from x on the left to 60° on the right.
        let step = FRAC_PI_3 / f64::from(columns);
        let mut constraints = FieldConstraints::default();
        for row in 0..=rows {
            for column in 0..=columns {
                if row % rows == 0 || column % columns == 0 {
                    let vertex = row * (columns + 1) + column;
                    let direction = turned(step * f64::from(column));
                    let angle = rings.angle_of(vertex as usize, direction).unwrap();
                    constraints.hard.push(Constraint { vertex, angle });
                }
            }
        }
        let [start, found] = both(&mesh, &rings, &constraints);
        for (vertex, vector) in found.iter().enumerate() {
            let column = vertex as u32 % (columns + 1);
            let s = rings.direction(vertex, vector.to_angle());
            let wanted = turned(step * f64::from(column));
            assert!((s - wanted).length() < 1e-4, "{vertex}: {s}, not {wanted}");
        }
        // Upright edges are parallel; level ones and diagonals turn by a step.
        let upright = f64::from((columns + 1) * rows);
        let turning = f64::from(columns * (rows + 1) + columns * rows);
        let closed = (upright + turning * step.cos()) / (upright + turning);
        let mean = mean_cosine(&rings, &found);
        assert!((mean - closed).abs() < 1e-9, "{mean}, not {closed}");
        assert!(mean_cosine(&rings, &start) <= mean);
    }

    #[test]
    fn every_pass_makes_any_field_better() {
        use rand::Rng;
        let mesh = shapes::icosphere(2);
        let rings = rings(&mesh);
        let mut random = crate::random::stream(1, "cosine test", 0, 0);
        let mut noise = || DVec2::from_angle(random.gen_range(0.0..std::f64::consts::TAU));
        let start: Vec<DVec2> = mesh.positions.iter().map(|_| noise()).collect();
        let constraints = FieldConstraints {
            hard: vec![Constraint {
                vertex: 5,
                angle: 0.3,
            }],
            ..FieldConstraints::default()
        };
        let mut start = start;
        start[5] = DVec2::from_angle(0.3);
        let areas = mesh.vertex_areas();
        let found = improved(&rings, &start, (&constraints, &areas), Progress::silent()).unwrap();
        assert_eq!(found[5], start[5]);
        assert!(mean_cosine(&rings, &found) > 0.9 && mean_cosine(&rings, &start) < 0.5);
        // It stands still: no vertex has a better direction.
        let again = improved(&rings, &found, (&constraints, &areas), Progress::silent()).unwrap();
        for (a, b) in found.iter().zip(&again) {
            assert!(a.distance(*b) < 1e-5);
        }
    }

    #[test]
    fn a_torus_is_no_worse_than_under_the_smoothness_energy() {
        for mesh in [
            shapes::torus(30, 14, 1.0, 0.45),
            shapes::icosphere(3),
            shapes::cylinder(16, 8, 1.0, 0.3),
        ] {
            let rings = rings(&mesh);
            let [start, found] = both(&mesh, &rings, &FieldConstraints::default());
            let [before, after] = [start, found].map(|vectors| mean_cosine(&rings, &vectors));
            assert!(after >= before && after <= 1.0, "{before} → {after}");
        }
    }
}
