//! A hierarchy of ever smaller matrices that stands in for the inverse of the finest: algebraic
//! multigrid by plain aggregation. A vertex and its neighbours become one coarse unknown, carried
//! to each of them by the connection's own rotation; coarse matrices are the Galerkin products.
//!
//! Plain aggregates correct too little; a W-cycle makes up for it.

use glam::DVec2;
use nalgebra::{Complex, DMatrix, DVector};

use crate::mesh::field::hermitian::{Entry, Hermitian, times_conjugate};
use crate::mesh::rows::Rows;
use crate::mesh::topology::NONE;

/// At so few unknowns the matrix is factored.
const SMALLEST: usize = 96;
/// Relaxations before and after the coarse correction.
const SMOOTHING: usize = 2;

/// How the unknowns of a level hang together on the next.
struct Aggregates {
    /// The coarse unknown of each.
    parent: Vec<u32>,
    /// What it is times that: a rotation.
    factor: Vec<DVec2>,
}

/// One level of the hierarchy.
struct Level {
    matrix: Hermitian,
    aggregates: Option<Aggregates>,
}

/// The hierarchy over a positive definite Hermitian matrix.
pub struct Multigrid {
    levels: Vec<Level>,
    coarsest: nalgebra::Cholesky<Complex<f64>, nalgebra::Dyn>,
}

impl Multigrid {
    /// Builds the hierarchy; `None` when the matrix is not positive definite.
    pub fn new(matrix: Hermitian) -> Option<Self> {
        let mut levels = Vec::new();
        let mut matrix = matrix;
        while matrix.len() > SMALLEST {
            let aggregates = aggregate(&matrix);
            let count = aggregates
                .parent
                .iter()
                .max()
                .map_or(0, |&most| most as usize + 1);
            if count * 10 > matrix.len() * 9 {
                break;
            }
            let coarse = galerkin(&matrix, &aggregates, count);
            levels.push(Level {
                matrix,
                aggregates: Some(aggregates),
            });
            matrix = coarse;
        }
        let coarsest = nalgebra::Cholesky::new(dense(&matrix))?;
        levels.push(Level {
            matrix,
            aggregates: None,
        });
        Some(Self { levels, coarsest })
    }

    /// The matrix itself.
    pub fn matrix(&self) -> &Hermitian {
        &self.levels[0].matrix
    }

    /// About A⁻¹ b.
    pub fn precondition(&self, b: &[DVec2]) -> Vec<DVec2> {
        self.cycle(0, b)
    }

    fn cycle(&self, number: usize, b: &[DVec2]) -> Vec<DVec2> {
        let level = &self.levels[number];
        let Some(aggregates) = &level.aggregates else {
            return self.solve_coarsest(b);
        };
        let matrix = &level.matrix;
        let mut spare = vec![DVec2::ZERO; b.len()];
        let mut x = vec![DVec2::ZERO; b.len()];
        matrix.smooth(&mut x, b, SMOOTHING, &mut spare);
        // The finest levels are dear: they are passed once, the coarse ones twice (a W-cycle).
        for _ in 0..if number == 0 { 1 } else { 2 } {
            matrix.apply(&x, &mut spare);
            spare.iter_mut().zip(b).for_each(|(ax, b)| *ax = *b - *ax);
            let coarse = self.levels[number + 1].matrix.len();
            let correction = self.cycle(number + 1, &restrict(aggregates, &spare, coarse));
            prolong_onto(aggregates, &correction, &mut x);
        }
        matrix.smooth(&mut x, b, SMOOTHING, &mut spare);
        x
    }

    fn solve_coarsest(&self, b: &[DVec2]) -> Vec<DVec2> {
        let b = DVector::from_iterator(b.len(), b.iter().map(|v| Complex::new(v.x, v.y)));
        self.coarsest
            .solve(&b)
            .iter()
            .map(|c| DVec2::new(c.re, c.im))
            .collect()
    }
}

fn dense(matrix: &Hermitian) -> DMatrix<Complex<f64>> {
    let mut dense = DMatrix::zeros(matrix.len(), matrix.len());
    for row in 0..matrix.len() {
        dense[(row, row)] = Complex::new(matrix.diagonal[row], 0.0);
        for entry in matrix.rows.row(row) {
            dense[(row, entry.column as usize)] = Complex::new(entry.value.x, entry.value.y);
        }
    }
    dense
}

/// Groups every unknown with a root it is tied to strongly, in order of number.
fn aggregate(matrix: &Hermitian) -> Aggregates {
    let mut parent = vec![NONE; matrix.len()];
    let mut factor = vec![DVec2::X; matrix.len()];
    let mut count = 0;
    // A root and all its neighbours, where none of them is taken.
    for root in 0..matrix.len() {
        let row = matrix.rows.row(root);
        let free = |entry: &Entry| parent[entry.column as usize] == NONE;
        if parent[root] == NONE && row.iter().all(free) {
            parent[root] = count;
            for entry in row {
                parent[entry.column as usize] = count;
                // Row `column` holds the conjugate: the rotation from the root to the neighbour.
                factor[entry.column as usize] = towards(entry.value);
            }
            count += 1;
        }
    }
    // The rest joins the strongest neighbour that belongs somewhere, or stands alone.
    let settled = parent.clone();
    for unknown in 0..matrix.len() {
        if settled[unknown] != NONE {
            continue;
        }
        let strongest = matrix
            .rows
            .row(unknown)
            .iter()
            .filter(|entry| settled[entry.column as usize] != NONE)
            .fold(None, |best: Option<&Entry>, entry| match best {
                Some(best) if best.value.length_squared() >= entry.value.length_squared() => {
                    Some(best)
                }
                _ => Some(entry),
            });
        match strongest {
            Some(entry) => {
                let at = entry.column as usize;
                parent[unknown] = parent[at];
                let back = towards(entry.value);
                factor[unknown] = DVec2::new(back.x, -back.y).rotate(factor[at]);
            }
            None => {
                parent[unknown] = count;
                count += 1;
            }
        }
    }
    Aggregates { parent, factor }
}

/// The rotation from a row's unknown to an entry's column that costs least: −conj(value), unit.
fn towards(value: DVec2) -> DVec2 {
    DVec2::new(-value.x, value.y).normalize_or(DVec2::X)
}

fn galerkin(matrix: &Hermitian, aggregates: &Aggregates, count: usize) -> Hermitian {
    let members = members(aggregates, count);
    let mut diagonal = vec![0.0; count];
    let rows = Rows::collect(
        count,
        Vec::new,
        |held: &mut Vec<(u32, DVec2)>, coarse, out| {
            held.clear();
            for &fine in members.row(coarse) {
                let own = aggregates.factor[fine as usize];
                for entry in matrix.rows.row(fine as usize) {
                    let column = entry.column as usize;
                    // conj(own) · value · factor of the column.
                    let moved = entry.value.rotate(aggregates.factor[column]);
                    held.push((aggregates.parent[column], times_conjugate(moved, own)));
                }
            }
            held.sort_by_key(|&(column, _)| column);
            for group in held.chunk_by(|a, b| a.0 == b.0) {
                out.push(Entry {
                    column: group[0].0,
                    value: group.iter().map(|&(_, value)| value).sum(),
                });
            }
        },
    );
    for (fine, &parent) in aggregates.parent.iter().enumerate() {
        diagonal[parent as usize] += matrix.diagonal[fine];
    }
    without_diagonal(diagonal, &rows)
}

/// Moves entries on the diagonal to where they belong.
fn without_diagonal(mut diagonal: Vec<f64>, rows: &Rows<Entry>) -> Hermitian {
    for (row, diagonal) in diagonal.iter_mut().enumerate() {
        let own = rows
            .row(row)
            .iter()
            .filter(|entry| entry.column as usize == row);
        *diagonal += own.map(|entry| entry.value.x).sum::<f64>();
    }
    let beside = Rows::collect(
        rows.len(),
        || (),
        |(), row, out| {
            out.extend(
                rows.row(row)
                    .iter()
                    .filter(|entry| entry.column as usize != row),
            );
        },
    );
    Hermitian::new(diagonal, beside)
}

fn members(aggregates: &Aggregates, count: usize) -> Rows<u32> {
    let mut starts = vec![0u32; count + 1];
    for &parent in &aggregates.parent {
        starts[parent as usize + 1] += 1;
    }
    for k in 0..count {
        starts[k + 1] += starts[k];
    }
    let mut next = starts.clone();
    let mut entries = vec![0; aggregates.parent.len()];
    for (fine, &parent) in aggregates.parent.iter().enumerate() {
        entries[next[parent as usize] as usize] = fine as u32;
        next[parent as usize] += 1;
    }
    Rows { starts, entries }
}

fn restrict(aggregates: &Aggregates, fine: &[DVec2], count: usize) -> Vec<DVec2> {
    let mut coarse = vec![DVec2::ZERO; count];
    for ((&value, &parent), &factor) in fine.iter().zip(&aggregates.parent).zip(&aggregates.factor)
    {
        coarse[parent as usize] += times_conjugate(value, factor);
    }
    coarse
}

fn prolong_onto(aggregates: &Aggregates, coarse: &[DVec2], fine: &mut [DVec2]) {
    for ((value, &parent), &factor) in fine
        .iter_mut()
        .zip(&aggregates.parent)
        .zip(&aggregates.factor)
    {
        *value += factor.rotate(coarse[parent as usize]);
    }
}
