//! The singular values that a factored file lists: the lengths of the columns of S·V.

use crate::btf::bonn::matrix::MatrixRows;
use crate::error::Result;

/// Rows read at a time.
const BLOCK: usize = 4096;

/// The lengths of a matrix's columns.
pub(super) fn singular_values(matrix: &dyn MatrixRows) -> Result<Vec<f32>> {
    let columns = matrix.columns();
    let mut squares = vec![0.0_f64; columns];
    let mut numbers = Vec::new();
    for start in (0..matrix.rows()).step_by(BLOCK) {
        let rows = start..matrix.rows().min(start + BLOCK);
        numbers.resize(rows.len() * columns, 0.0);
        matrix.read(rows, &mut numbers)?;
        for row in numbers.chunks(columns) {
            let pairs = squares.iter_mut().zip(row);
            pairs.for_each(|(sum, &number)| *sum += f64::from(number) * f64::from(number));
        }
    }
    Ok(squares.iter().map(|sum| sum.sqrt() as f32).collect())
}
