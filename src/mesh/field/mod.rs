//! The orientation field: a tangent s at every vertex, as smooth as the surface and the user's
//! directions allow (Knöppel 2013; the relaxation of Wei-Levoy 2001 and Turk 2001, solved exactly).
//!
//! In: rings, wanted directions. Out: a vector at every vertex, of which synthesis takes the
//! direction; its length falls to zero at singularities. A component without wanted directions
//! gets the eigenvector of the smallest eigenvalue of the connection Laplacian; one with them the
//! field of least energy that takes them exactly. [`cosine`] improves it under another energy.

pub(crate) mod cosine;
pub mod curvature;
pub mod guides;
mod hermitian;
mod laplacian;
mod multigrid;
pub(crate) mod singularities;
mod solvers;

use glam::{DVec2, Vec3};
use rand::Rng;

use crate::error::{Error, Result};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::field::hermitian::{Entry, Hermitian, dot};
use crate::mesh::field::laplacian::{Weights, connection_laplacian};
use crate::mesh::field::multigrid::Multigrid;
use crate::mesh::field::solvers::{smallest_eigenvector, solve};
use crate::mesh::rings::Rings;
use crate::mesh::topology::{NONE, components};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::random;

/// A direction that the field must take at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint {
    /// The vertex.
    pub vertex: u32,
    /// The angle from the vertex's axis, in radians.
    pub angle: f64,
}

/// Directions that constrain the field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldConstraints {
    /// Directions taken exactly.
    pub hard: Vec<Constraint>,
    /// Directions that pull at the field, per vertex: their lengths say how much, as a weight for each
    /// unit of area. Empty for none.
    pub soft: Vec<DVec2>,
}

/// An orientation field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// Per vertex a tangent vector, along the vertex's axis and at right angles to it.
    pub vectors: Vec<DVec2>,
    /// Its smoothness energy over its mass: Σ w |u_i − r u_j|² / Σ area |u|², one over an area.
    pub energy: f64,
}

impl Field {
    /// The angle of each vector from its vertex's axis, in radians.
    pub fn angles(&self) -> Vec<f64> {
        self.vectors.iter().map(|u| u.to_angle()).collect()
    }

    /// A field of vectors found elsewhere.
    pub fn of_vectors(mesh: &TriangleMesh, rings: &Rings, vectors: Vec<DVec2>) -> Self {
        let laplacian = connection_laplacian(mesh, rings, Weights::Cotangent);
        Self {
            energy: rayleigh_quotient(&laplacian, &masses(mesh), &vectors),
            vectors,
        }
    }
}

/// The world's up, towards which t of an unguided field points as far as it can.
const UP: Vec3 = Vec3::Y;

/// Solves for the smoothest field under the constraints.
pub fn orientation_field(
    mesh: &TriangleMesh,
    rings: &Rings,
    constraints: &FieldConstraints,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Field> {
    // Set up the equations, and hold the constraints.
    let laplacian = connection_laplacian(mesh, rings, Weights::Cotangent);
    let mass = masses(mesh);
    let mut vectors = vec![DVec2::X; mesh.positions.len()];
    let mut fixed = vec![false; mesh.positions.len()];
    for constraint in &constraints.hard {
        vectors[constraint.vertex as usize] = DVec2::from_angle(constraint.angle);
        fixed[constraint.vertex as usize] = true;
    }
    // Solve component by component.
    let parts = by_component(mesh);
    let mut positive = None;
    for part in 0..parts.len() {
        let problem = |laplacian| Part {
            rings,
            laplacian,
            mass: &mass,
            members: parts.row(part),
            fixed: &fixed,
            soft: &constraints.soft,
            progress,
        };
        progress.check()?;
        let solved = problem(&laplacian).solve(&mut vectors, seed, part as u64);
        if let Err(Error::Interrupted) = solved {
            return Err(Error::Interrupted);
        }
        // Where cotangent weights fail, solve with positive ones.
        if solved.is_err() {
            let positive = positive
                .get_or_insert_with(|| connection_laplacian(mesh, rings, Weights::Positive));
            problem(positive).solve(&mut vectors, seed, part as u64)?;
        }
    }
    let energy = rayleigh_quotient(&laplacian, &mass, &vectors);
    Ok(Field { vectors, energy })
}

/// What each vertex's vector counts in the mass: its area.
fn masses(mesh: &TriangleMesh) -> Vec<f64> {
    mesh.vertex_areas().into_iter().map(f64::from).collect()
}

/// Energy over mass; vertices in no triangle have neither.
pub fn rayleigh_quotient(laplacian: &Hermitian, mass: &[f64], vectors: &[DVec2]) -> f64 {
    let mut applied = vec![DVec2::ZERO; vectors.len()];
    laplacian.apply(vectors, &mut applied);
    let weighted: Vec<DVec2> = vectors.iter().zip(mass).map(|(u, m)| *u * *m).collect();
    dot(vectors, &applied) / dot(vectors, &weighted)
}

/// The vertices of each component.
fn by_component(mesh: &TriangleMesh) -> Rows<u32> {
    let (labels, count) = components(mesh);
    let mut order: Vec<(u32, u32)> = labels
        .iter()
        .enumerate()
        .filter(|&(_, &label)| label != NONE)
        .map(|(vertex, &label)| (label, vertex as u32))
        .collect();
    order.sort_unstable();
    let mut rows = Rows {
        starts: vec![0; count + 1],
        entries: order.iter().map(|&(_, vertex)| vertex).collect(),
    };
    for &(label, _) in &order {
        rows.starts[label as usize + 1] += 1;
    }
    for k in 0..count {
        rows.starts[k + 1] += rows.starts[k];
    }
    rows
}

/// The problem on one component.
struct Part<'a> {
    rings: &'a Rings,
    laplacian: &'a Hermitian,
    mass: &'a [f64],
    members: &'a [u32],
    fixed: &'a [bool],
    soft: &'a [DVec2],
    progress: Progress<'a>,
}

impl Part<'_> {
    fn solve(&self, vectors: &mut [DVec2], seed: u64, part: u64) -> Result<()> {
        let free: Vec<u32> = self
            .members
            .iter()
            .copied()
            .filter(|&v| !self.fixed[v as usize])
            .collect();
        if free.is_empty() {
            return Ok(());
        }
        let leans = |v: &u32| {
            self.soft
                .get(*v as usize)
                .is_some_and(|q| *q != DVec2::ZERO)
        };
        let guided = free.len() < self.members.len() || self.members.iter().any(leans);
        let found = if guided {
            self.least_energy(&free, vectors)?
        } else {
            self.smoothest(&free, seed, part)?
        };
        for (&vertex, vector) in free.iter().zip(found) {
            vectors[vertex as usize] = vector;
        }
        Ok(())
    }

    /// Rows and columns of the free vertices, `added` on the diagonal.
    fn matrix(&self, free: &[u32], added: impl Fn(usize) -> f64) -> Hermitian {
        let mut numbers = vec![NONE; self.mass.len()];
        for (number, &vertex) in free.iter().enumerate() {
            numbers[vertex as usize] = number as u32;
        }
        let rows = Rows::collect(
            free.len(),
            || (),
            |(), row, out| {
                let entries = self.laplacian.rows.row(free[row] as usize).iter();
                out.extend(entries.filter_map(|entry| {
                    let column = numbers[entry.column as usize];
                    (column != NONE).then_some(Entry { column, ..*entry })
                }));
            },
        );
        let diagonal = free
            .iter()
            .map(|&vertex| self.laplacian.diagonal[vertex as usize] + added(vertex as usize))
            .collect();
        Hermitian::new(diagonal, rows)
    }

    /// A shift that keeps the matrix of a flat component definite, far below what matters.
    fn shift(&self, free: &[u32]) -> f64 {
        let sum = |list: &[f64]| free.iter().map(|&v| list[v as usize]).sum::<f64>();
        1e-9 * sum(&self.laplacian.diagonal) / sum(self.mass)
    }

    fn smoothest(&self, free: &[u32], seed: u64, part: u64) -> Result<Vec<DVec2>> {
        let shift = self.shift(free);
        let matrix = self.matrix(free, |v| shift * self.mass[v]);
        let multigrid = Multigrid::new(matrix).ok_or_else(indefinite)?;
        let mass: Vec<f64> = free.iter().map(|&v| self.mass[v as usize]).collect();
        let mut random = random::stream(seed, "orientation field", 0, part);
        let mut guess: Vec<DVec2> = free
            .iter()
            .map(|_| DVec2::from_angle(random.gen_range(0.0..std::f64::consts::TAU)))
            .collect();
        for _ in 0..3 {
            self.progress.check()?;
            guess.iter_mut().zip(&mass).for_each(|(u, m)| *u *= *m);
            guess = multigrid.precondition(&guess);
            let norm = dot(&guess, &guess).sqrt();
            guess.iter_mut().for_each(|u| *u /= norm);
        }
        let (value, mut vectors) = smallest_eigenvector(&multigrid, &mass, guess, self.progress)?;
        if !(value >= 0.0 && vectors.iter().all(|u| u.is_finite())) {
            return Err(indefinite());
        }
        self.turn_upright(free, &mut vectors);
        // Of unit length on average, as wanted directions are.
        let area: f64 = mass.iter().sum();
        Ok(vectors.into_iter().map(|u| u * area.sqrt()).collect())
    }

    /// A smooth field may be turned as a whole without changing its energy: it is turned so that t
    /// points up as far as it can, and a texture stands upright.
    fn turn_upright(&self, free: &[u32], vectors: &mut [DVec2]) {
        let apart: DVec2 = free
            .iter()
            .zip(&*vectors)
            .map(|(&vertex, vector)| {
                let vertex = vertex as usize;
                let rightwards = UP.cross(self.rings.normals[vertex]);
                let angle = self.rings.angle_of(vertex, rightwards).unwrap_or(0.0);
                let wanted = DVec2::from_angle(angle) * f64::from(rightwards.length());
                DVec2::new(vector.x, -vector.y).rotate(wanted) * self.mass[vertex]
            })
            .sum();
        let turn = apart.try_normalize().unwrap_or(DVec2::X);
        vectors
            .iter_mut()
            .for_each(|vector| *vector = turn.rotate(*vector));
    }

    fn least_energy(&self, free: &[u32], vectors: &[DVec2]) -> Result<Vec<DVec2>> {
        let weight = |v: usize| self.soft.get(v).map_or(0.0, |q| q.length() * self.mass[v]);
        let shift = self.shift(free) * 1e-3;
        let matrix = self.matrix(free, |v| weight(v) + shift * self.mass[v]);
        let wanted: Vec<DVec2> = free
            .iter()
            .map(|&vertex| {
                let pull = self.soft.get(vertex as usize).copied().unwrap_or_default();
                let row = self.laplacian.rows.row(vertex as usize).iter();
                let pulls = row
                    .filter(|entry| self.fixed[entry.column as usize])
                    .map(|entry| entry.value.rotate(vectors[entry.column as usize]));
                pull * self.mass[vertex as usize] - pulls.sum::<DVec2>()
            })
            .collect();
        let multigrid = Multigrid::new(matrix).ok_or_else(indefinite)?;
        let mut found = multigrid.precondition(&wanted);
        solve(&multigrid, &wanted, &mut found, 1e-10, self.progress)?;
        Ok(found)
    }
}

fn indefinite() -> Error {
    Error::data(
        "orientation field",
        "the connection Laplacian is not positive definite",
    )
    .advice("the mesh has triangles too thin to measure; retile it with mesotex mesh --vertices N")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;

    fn rings(mesh: &TriangleMesh) -> Rings {
        Rings::new(mesh, &Topology::new(&mesh.triangles))
    }

    fn guided(mesh: &TriangleMesh, vertex: u32, direction: Vec3) -> Vec<Vec3> {
        let rings = rings(mesh);
        let constraints = FieldConstraints {
            hard: vec![Constraint {
                vertex,
                angle: rings.angle_of(vertex as usize, direction).unwrap(),
            }],
            ..FieldConstraints::default()
        };
        let field = orientation_field(mesh, &rings, &constraints, 0, Progress::silent()).unwrap();
        let angles = field.angles();
        assert_eq!(angles[vertex as usize], constraints.hard[0].angle);
        (0..angles.len())
            .map(|v| rings.direction(v, angles[v]))
            .collect()
    }

    #[test]
    fn one_direction_makes_a_flat_field_parallel() {
        let mesh = shapes::grid(40, 30, 0.1);
        let wanted = Vec3::new(0.6, 0.8, 0.0);
        for s in guided(&mesh, 17, wanted) {
            assert!(s.angle_between(wanted) < 1e-3, "{s}");
        }
    }

    #[test]
    fn thousands_of_scattered_vertices_follow_the_directions_round_them() {
        let side = 283;
        let mesh = shapes::grid(side - 1, side - 1, 0.1);
        let rings = rings(&mesh);
        let wanted = Vec3::new(0.6, 0.8, 0.0);
        let is_free = |v: u32| (v % side).is_multiple_of(2) && (v / side).is_multiple_of(2);
        let count = side * side;
        let constraint = |vertex: u32| Constraint {
            vertex,
            angle: rings.angle_of(vertex as usize, wanted).unwrap(),
        };
        let constraints = FieldConstraints {
            hard: (0..count)
                .filter(|v| !is_free(*v))
                .map(constraint)
                .collect(),
            ..FieldConstraints::default()
        };
        assert!(count as usize - constraints.hard.len() > 20_000);
        let field = orientation_field(&mesh, &rings, &constraints, 0, Progress::silent()).unwrap();
        for vertex in (0..count).filter(|v| is_free(*v)) {
            let angle = field.vectors[vertex as usize].to_angle();
            let s = rings.direction(vertex as usize, angle);
            assert!((s - wanted).length() < 1e-5, "{vertex}: {s}");
        }
    }

    #[test]
    fn one_direction_makes_a_cylinders_field_parallel() {
        let mesh = shapes::cylinder(40, 30, 1.0, 0.15);
        for s in guided(&mesh, 600, Vec3::Z) {
            assert!(s.angle_between(Vec3::Z) < 1e-3, "{s}");
        }
    }

    /// The smallest eigenvalue, by dense algebra.
    fn smallest_eigenvalue(mesh: &TriangleMesh, rings: &Rings) -> f64 {
        use nalgebra::{Complex, DMatrix};
        let laplacian = connection_laplacian(mesh, rings, Weights::Cotangent);
        let scale: Vec<f64> = mesh
            .vertex_areas()
            .iter()
            .map(|&m| f64::from(m).sqrt().recip())
            .collect();
        let mut dense: DMatrix<Complex<f64>> = DMatrix::zeros(scale.len(), scale.len());
        for i in 0..scale.len() {
            dense[(i, i)] = Complex::new(laplacian.diagonal[i] * scale[i] * scale[i], 0.0);
            for entry in laplacian.rows.row(i) {
                let j = entry.column as usize;
                dense[(i, j)] = Complex::new(entry.value.x, entry.value.y) * (scale[i] * scale[j]);
            }
        }
        nalgebra::SymmetricEigen::new(dense).eigenvalues.min()
    }

    /// The field that nothing guides.
    pub(super) fn free_field(mesh: &TriangleMesh, rings: &Rings, seed: u64) -> Field {
        let free = FieldConstraints::default();
        orientation_field(mesh, rings, &free, seed, Progress::silent()).unwrap()
    }

    #[test]
    fn a_free_field_stands_upright() {
        let mesh = shapes::grid(9, 7, 0.5);
        let rings = rings(&mesh);
        let field = free_field(&mesh, &rings, 5);
        for (vertex, angle) in field.angles().into_iter().enumerate() {
            let s = rings.direction(vertex, angle);
            assert!((s - Vec3::X).length() < 1e-3, "{s:?}");
        }
    }

    #[test]
    fn a_free_field_has_the_smallest_energy_there_is() {
        for mesh in [shapes::icosphere(2), shapes::torus(24, 12, 1.0, 0.4)] {
            let rings = rings(&mesh);
            let field = free_field(&mesh, &rings, 1);
            let least = smallest_eigenvalue(&mesh, &rings);
            assert!(
                field.energy < 1.001 * least + 1e-9,
                "{} {least}",
                field.energy
            );
        }
    }

    #[test]
    fn every_component_gets_a_field() {
        let mut mesh = shapes::icosphere(1);
        let other = shapes::torus(16, 8, 30.0, 9.0);
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(other.positions);
        mesh.triangles
            .extend(other.triangles.iter().map(|t| t.map(|v| v + base)));
        let field = orientation_field(
            &mesh,
            &rings(&mesh),
            &FieldConstraints::default(),
            1,
            Progress::silent(),
        )
        .unwrap();
        let long = field.vectors.iter().filter(|u| u.length() > 0.3).count();
        assert!(long > field.vectors.len() * 3 / 4);
    }
}
