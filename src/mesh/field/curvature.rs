//! Principal curvature directions at the vertices, from how normals turn along edges (Taubin 1995,
//! by least squares).

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::mesh::rings::Rings;
use crate::mesh::triangle_mesh::TriangleMesh;

/// Curvature at a vertex: its direction counts up to sign.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Principal {
    /// The direction along which the surface bends most (by magnitude), unit, from the vertex's
    /// axis.
    pub direction: DVec2,
    /// Difference of the two principal curvatures' magnitudes, one over mesh units: how sure the
    /// direction is.
    pub certainty: f64,
}

/// Principal directions of all vertices.
pub fn principal_directions(mesh: &TriangleMesh, rings: &Rings) -> Vec<Principal> {
    (0..mesh.positions.len())
        .into_par_iter()
        .map(|vertex| {
            let shape = shape_operator(mesh, rings, vertex);
            shape.map_or_else(Principal::default, |[a, b, c]| principal(a, b, c))
        })
        .collect()
}

/// The larger principal curvature of every vertex, by magnitude, in one over mesh units; 0 where it cannot
/// be told.
pub fn largest_curvatures(mesh: &TriangleMesh, rings: &Rings) -> Vec<f64> {
    (0..mesh.positions.len())
        .into_par_iter()
        .map(|vertex| {
            let shape = shape_operator(mesh, rings, vertex);
            shape.map_or(0.0, |[a, b, c]| {
                let mean = f64::midpoint(a, c);
                mean.abs() + f64::midpoint(a, -c).hypot(b)
            })
        })
        .collect()
}

/// Fits the symmetric shape operator (a, b; b, c) to the turn of the normal along each edge.
fn shape_operator(mesh: &TriangleMesh, rings: &Rings, vertex: usize) -> Option<[f64; 3]> {
    let normal = rings.normals[vertex].as_dvec3();
    let axis = rings.axes[vertex].as_dvec3();
    let across = normal.cross(axis);
    let origin = mesh.positions[vertex].as_dvec3();
    let flat = |v: DVec3| DVec2::new(v.dot(axis), v.dot(across));
    let mut normal_equations = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for edge in rings.edges.row(vertex) {
        let far = edge.target as usize;
        let arm = flat(mesh.positions[far].as_dvec3() - origin);
        let turn = flat(rings.normals[far].as_dvec3() - normal);
        let rows = [
            (nalgebra::Vector3::new(arm.x, arm.y, 0.0), turn.x),
            (nalgebra::Vector3::new(0.0, arm.x, arm.y), turn.y),
        ];
        for (row, value) in rows {
            normal_equations += row * row.transpose();
            right += row * value;
        }
    }
    let shape = normal_equations.cholesky()?.solve(&right);
    Some([shape[0], shape[1], shape[2]])
}

fn principal(a: f64, b: f64, c: f64) -> Principal {
    let (mean, half) = ((a + c) / 2.0, ((a - c) / 2.0).hypot(b));
    let angle = 0.5 * b.atan2((a - c) / 2.0);
    // `angle` belongs to the larger of mean ± half; the larger by magnitude may be the other.
    let along = DVec2::from_angle(if mean >= 0.0 {
        angle
    } else {
        angle + std::f64::consts::FRAC_PI_2
    });
    Principal {
        direction: along,
        certainty: (mean + half).abs().max((mean - half).abs())
            - (mean + half).abs().min((mean - half).abs()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;
    use glam::Vec3;

    #[test]
    fn a_cylinder_bends_round_and_not_along() {
        let mesh = shapes::cylinder(48, 12, 2.0, 0.25);
        let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
        let all = principal_directions(&mesh, &rings);
        let inner = 48 * 6 + 5;
        let along = rings.direction(inner, all[inner].direction.to_angle());
        assert!(along.dot(Vec3::Z).abs() < 1e-3);
        assert!((all[inner].certainty - 0.5).abs() < 0.01);
    }
}
