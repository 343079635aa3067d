//! Rows become columns.
//!
//! In: rows of numbers. Out: their transpose, each number passed through a function on its way.
//! Small tiles are turned whole, so that a line of memory is fetched once.

use std::array;

/// Sides of a tile.
const TILE: usize = 8;

/// The first columns of `from` become rows of `to`, as many as it has; each has rows of the given
/// width, which in `to` may be more than `from` fills.
pub fn transpose<A: Copy, B: Copy>(
    from: &[A],
    from_width: usize,
    to: &mut [B],
    to_width: usize,
    convert: impl Fn(A) -> B + Copy,
) {
    let (rows, columns) = (from.len() / from_width, to.len().div_ceil(to_width));
    for row in (0..rows).step_by(TILE) {
        for column in (0..columns).step_by(TILE) {
            if row + TILE <= rows && column + TILE <= columns {
                let from = &from[row * from_width + column..];
                let to = &mut to[column * to_width + row..];
                transpose_tile(from, from_width, to, to_width, convert);
                continue;
            }
            for column in column..columns.min(column + TILE) {
                for row in row..rows.min(row + TILE) {
                    to[column * to_width + row] = convert(from[row * from_width + column]);
                }
            }
        }
    }
}

/// Turns the whole tile with which `from` and `to` begin.
fn transpose_tile<A: Copy, B: Copy>(
    from: &[A],
    from_width: usize,
    to: &mut [B],
    to_width: usize,
    convert: impl Fn(A) -> B + Copy,
) {
    let lines: [&[A]; TILE] = array::from_fn(|row| &from[row * from_width..][..TILE]);
    for column in 0..TILE {
        let turned: [B; TILE] = array::from_fn(|row| convert(lines[row][column]));
        to[column * to_width..][..TILE].copy_from_slice(&turned);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_columns_whatever_the_sides() {
        for (rows, columns, taken) in [(8, 16, 16), (9, 17, 11), (3, 2, 1), (16, 8, 8)] {
            let from: Vec<u32> = (0..rows * columns).map(|at| at as u32).collect();
            let width = rows + 2;
            let mut to = vec![-1.0; taken * width];
            transpose(&from, columns, &mut to[1..], width, f64::from);
            for (at, &found) in to.iter().enumerate() {
                let (column, row) = (at / width, at % width);
                let filled = (1..=rows).contains(&row);
                let expected = match filled {
                    true => ((row - 1) * columns + column) as f64,
                    false => -1.0,
                };
                assert_eq!(found, expected);
            }
        }
    }
}
