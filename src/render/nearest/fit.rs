//! Weights of a local fit (moving least squares, Lancaster and Salkauskas 1981): a polynomial through
//! the values near the wanted direction, weighted by nearness bᵢ, is read off at the wanted direction.
//!
//! With pᵢ the terms of sample i beside the constant, m = Σ bᵢ pᵢ and M = Σ bᵢ pᵢ pᵢᵀ (Σ bᵢ = 1), what the fit
//! gives is the sum of the values times bᵢ (1 − pᵢ·g), up to a common factor, where (M + λ I) g = m. λ is small and
//! keeps the fit bounded where directions lie on a line or are few.

/// λ over the mean of the diagonal of Σ bᵢ (1, pᵢ)ᵀ(1, pᵢ).
const RIDGE: f64 = 1e-3;

/// g from the means m of the terms and of their products M, of which entries with column ≤ row are read.
#[inline(always)]
pub(super) fn tilt<const N: usize>(mean: [f64; N], mut products: [[f64; N]; N]) -> [f64; N] {
    let trace: f64 = (0..N).map(|k| products[k][k]).sum();
    let ridge = RIDGE * (1.0 + trace) / (N + 1) as f64;
    for (k, row) in products.iter_mut().enumerate() {
        row[k] += ridge;
    }
    solve(products, mean)
}

/// Solves a positive definite system by its factors L D Lᵀ.
#[inline(always)]
fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    let mut inverse = [0.0; N];
    for column in 0..N {
        inverse[column] = 1.0 / matrix[column][column];
        for row in column + 1..N {
            let factor = matrix[row][column] * inverse[column];
            for line in &mut matrix[row..] {
                line[row] -= factor * line[column];
            }
            right[row] -= factor * right[column];
        }
    }
    for column in (0..N).rev() {
        for row in column + 1..N {
            right[column] -= matrix[row][column] * right[row];
        }
        right[column] *= inverse[column];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_solved() {
        // (columns of a Vandermonde matrix) times their transpose: positive definite.
        let columns: [[f64; 4]; 4] = [1.0, 0.5, -0.7, 1.3].map(|x: f64| [1.0, x, x * x, x * x * x]);
        let mut matrix = [[0.0; 4]; 4];
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = columns.iter().map(|column| column[i] * column[j]).sum();
            }
        }
        let wanted = [1.0, -2.0, 3.0, 0.5];
        let right = matrix.map(|row| row.iter().zip(wanted).map(|(a, b)| a * b).sum());
        for (found, wanted) in solve(matrix, right).into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
        }
    }

    #[test]
    fn directions_on_a_line_have_a_finite_tilt() {
        let found = tilt([0.3, 0.0], [[0.2, 0.0], [0.0, 0.0]]);
        assert!((found[0] - 0.3 / (0.2 + 4e-4)).abs() < 1e-12 && found[1] == 0.0);
    }
}
