//! The two ways to the smoothest field: the eigenvector of the smallest eigenvalue (Knöppel 2013
//! §3, for a field free everywhere), and the solution of a linear system (given directions).

use glam::DVec2;
use nalgebra::{Matrix3, SymmetricEigen};

use crate::error::{Error, Result};
use crate::mesh::field::hermitian::{Hermitian, add_scaled, dot};
use crate::mesh::field::multigrid::Multigrid;
use crate::progress::Progress;

/// Solves A x = b by conjugate gradients with the multigrid cycle, from x, until the residual is
/// `tolerance` of b.
pub fn solve(
    multigrid: &Multigrid,
    b: &[DVec2],
    x: &mut [DVec2],
    tolerance: f64,
    progress: Progress<'_>,
) -> Result<()> {
    // Begin with the residual of the first guess.
    let matrix = multigrid.matrix();
    let mut applied = vec![DVec2::ZERO; b.len()];
    matrix.apply(x, &mut applied);
    let mut residual: Vec<DVec2> = b.iter().zip(&applied).map(|(b, ax)| *b - *ax).collect();
    let goal = tolerance * dot(b, b).sqrt();
    let mut direction: Vec<DVec2> = Vec::new();
    let mut before = 0.0;
    for _ in 0..MOST_ITERATIONS {
        progress.check()?;
        if dot(&residual, &residual).sqrt() <= goal {
            return Ok(());
        }
        // Find the next direction, conjugate to those before.
        let corrected = multigrid.precondition(&residual);
        let now = dot(&residual, &corrected);
        if direction.is_empty() {
            direction.clone_from(&corrected);
        } else {
            let keep = now / before;
            direction
                .iter_mut()
                .zip(&corrected)
                .for_each(|(d, z)| *d = *z + keep * *d);
        }
        before = now;
        // Step along it.
        matrix.apply(&direction, &mut applied);
        let bent = dot(&direction, &applied);
        if !(bent > 0.0 && now > 0.0) {
            break;
        }
        let step = now / bent;
        add_scaled(x, step, &direction);
        add_scaled(&mut residual, -step, &applied);
    }
    Err(
        Error::data("orientation field", "the solver did not converge").advice(
            "the mesh has triangles too thin to measure; retile it with mesotex mesh --vertices N",
        ),
    )
}

const MOST_ITERATIONS: usize = 1000;

/// A vector with its products.
struct Tracked {
    x: Vec<DVec2>,
    /// A x.
    ax: Vec<DVec2>,
    /// M x.
    mx: Vec<DVec2>,
}

impl Tracked {
    fn new(x: Vec<DVec2>, matrix: &Hermitian, mass: &[f64]) -> Self {
        let mut ax = vec![DVec2::ZERO; x.len()];
        matrix.apply(&x, &mut ax);
        let mx = x.iter().zip(mass).map(|(x, m)| *x * *m).collect();
        Self { x, ax, mx }
    }

    fn combine(parts: &[(&Self, f64)]) -> Self {
        let sum = |pick: fn(&Self) -> &[DVec2]| {
            let mut out = vec![DVec2::ZERO; parts[0].0.x.len()];
            parts
                .iter()
                .for_each(|(part, factor)| add_scaled(&mut out, *factor, pick(part)));
            out
        };
        Self {
            x: sum(|t| &t.x),
            ax: sum(|t| &t.ax),
            mx: sum(|t| &t.mx),
        }
    }

    fn scale_to_unit(&mut self) {
        let factor = dot(&self.x, &self.mx).sqrt().recip();
        for list in [&mut self.x, &mut self.ax, &mut self.mx] {
            list.iter_mut().for_each(|v| *v *= factor);
        }
    }
}

/// The smallest eigenvalue λ of A x = λ M x and its vector of unit M-norm, from a first guess, by
/// the locally optimal method (LOBPCG, Knyazev 2001) with the multigrid cycle. Stops when λ no
/// longer falls by a ten-thousandth. `mass` is the diagonal of M; `A` is the multigrid's matrix.
pub fn smallest_eigenvector(
    multigrid: &Multigrid,
    mass: &[f64],
    guess: Vec<DVec2>,
    progress: Progress<'_>,
) -> Result<(f64, Vec<DVec2>)> {
    let matrix = multigrid.matrix();
    // Begin with the guess.
    let mut now = Tracked::new(guess, matrix, mass);
    now.scale_to_unit();
    let mut momentum: Option<Tracked> = None;
    let mut value = dot(&now.x, &now.ax);
    let mut calm = 0;
    for _ in 0..MOST_EIGEN_ITERATIONS {
        progress.check()?;
        // Precondition the residual, and keep it apart from the vector.
        let residual: Vec<DVec2> = now
            .ax
            .iter()
            .zip(&now.mx)
            .map(|(a, m)| *a - value * *m)
            .collect();
        let mut step = Tracked::new(multigrid.precondition(&residual), matrix, mass);
        remove(&mut step, &now);
        if dot(&step.x, &step.mx) <= 1e-300 {
            break;
        }
        step.scale_to_unit();
        // Find the best combination of vector, residual and momentum (Rayleigh–Ritz).
        let mut basis = vec![&now, &step];
        basis.extend(momentum.as_ref());
        let weights = rayleigh_ritz(&basis);
        let parts: Vec<(&Tracked, f64)> =
            basis.iter().copied().zip(weights.iter().copied()).collect();
        let mut next = Tracked::combine(&parts);
        let mut travelled = Tracked::combine(&parts[1..]);
        next.scale_to_unit();
        remove(&mut travelled, &next);
        // Keep the move as the next momentum.
        let moved = dot(&travelled.x, &travelled.mx);
        momentum = (moved > 1e-24).then(|| {
            travelled.scale_to_unit();
            travelled
        });
        now = next;
        // Stop when the value stands still twice.
        let before = std::mem::replace(&mut value, dot(&now.x, &now.ax));
        calm = if before - value <= 1e-4 * value.abs() {
            calm + 1
        } else {
            0
        };
        if calm == 2 {
            break;
        }
    }
    Ok((value, now.x))
}

const MOST_EIGEN_ITERATIONS: usize = 60;

/// Makes a vector M-orthogonal to another of unit M-norm.
fn remove(from: &mut Tracked, unit: &Tracked) {
    let along = dot(&from.x, &unit.mx);
    add_scaled(&mut from.x, -along, &unit.x);
    add_scaled(&mut from.ax, -along, &unit.ax);
    add_scaled(&mut from.mx, -along, &unit.mx);
}

/// The weights of the best vector in the span of two or three: the small problem is whitened and
/// solved densely.
fn rayleigh_ritz(basis: &[&Tracked]) -> [f64; 3] {
    let mut stiffness = Matrix3::from_diagonal_element(f64::MAX.sqrt());
    let mut gram = Matrix3::identity();
    for i in 0..basis.len() {
        for j in 0..basis.len() {
            stiffness[(i, j)] = dot(&basis[i].x, &basis[j].ax);
            gram[(i, j)] = dot(&basis[i].x, &basis[j].mx);
        }
    }
    let symmetric = |m: Matrix3<f64>| (m + m.transpose()) * 0.5;
    let Some(factor) = nalgebra::Cholesky::new(symmetric(gram)) else {
        return [1.0, 0.0, 0.0];
    };
    let Some(inverse) = factor.l().try_inverse() else {
        return [1.0, 0.0, 0.0];
    };
    let small = symmetric(inverse * symmetric(stiffness) * inverse.transpose());
    let eigen = SymmetricEigen::new(small.view((0, 0), (basis.len(), basis.len())).into_owned());
    let least = eigen.eigenvalues.imin();
    let mut vector = nalgebra::Vector3::zeros();
    for k in 0..basis.len() {
        vector[k] = eigen.eigenvectors[(k, least)];
    }
    let weights = inverse.transpose() * vector;
    let sign = if weights[0] < 0.0 { -1.0 } else { 1.0 };
    [weights[0] * sign, weights[1] * sign, weights[2] * sign]
}
