//! A hierarchy of ever smaller matrices that approximates the inverse of the finest: algebraic multigrid by plain
//! aggregation. A vertex and its neighbours become one coarse unknown, transported to each of them by the
//! connection's rotation; coarse matrices are the Galerkin products.
//!
//! Plain aggregates correct too little; a W-cycle compensates for it.
//!
//! An unknown with neighbours always ends in an aggregate of two or more. Only unknowns without any
//! keep a level from shrinking: they are divided by the diagonal and leave the hierarchy. So what is
//! left to factor is never larger than [`SMALLEST`], and all levels together have at most ten times the
//! unknowns of the first.

use glam::DVec2;
use nalgebra::{Complex, DMatrix, DVector};

use crate::mesh::compressed_rows::Rows;
use crate::mesh::field::hermitian::{Entry, Hermitian, times_conjugate};
use crate::mesh::topology::NONE;

/// At so few unknowns the matrix is factored.
const SMALLEST: usize = 96;
/// Relaxations before and after the coarse correction.
const SMOOTHING: usize = 2;

/// How the unknowns of a level are connected on the next.
struct Aggregates {
    /// The coarse unknown of each.
    parent: Vec<u32>,
    /// What it is times that: a rotation.
    factor: Vec<DVec2>,
    /// Coarse unknowns.
    count: usize,
    /// The unknowns that left the hierarchy, whose parent is [`NONE`].
    untied: Vec<u32>,
}

/// One level of the hierarchy.
struct MultigridLevel {
    matrix: Hermitian,
    aggregates: Option<Aggregates>,
}

/// The hierarchy over a positive definite Hermitian matrix.
pub struct Multigrid {
    levels: Vec<MultigridLevel>,
    coarsest: nalgebra::Cholesky<Complex<f64>, nalgebra::Dyn>,
}

impl Multigrid {
    /// Builds the hierarchy; `None` when the matrix is not positive definite.
    pub fn new(matrix: Hermitian) -> Option<Self> {
        let mut levels = Vec::new();
        let mut matrix = matrix;
        while matrix.len() > SMALLEST {
            let mut aggregates = aggregate(&matrix);
            if aggregates.count * 10 > matrix.len() * 9 {
                aggregates.drop_untied(&matrix);
            }
            let definite = |&unknown: &u32| matrix.diagonal[unknown as usize] > 0.0;
            if !aggregates.untied.iter().all(definite) {
                return None;
            }
            let coarse = galerkin(&matrix, &aggregates);
            levels.push(MultigridLevel {
                matrix,
                aggregates: Some(aggregates),
            });
            matrix = coarse;
        }
        let coarsest = nalgebra::Cholesky::new(dense(&matrix))?;
        levels.push(MultigridLevel {
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
        for &unknown in &aggregates.untied {
            let unknown = unknown as usize;
            x[unknown] = b[unknown] / matrix.diagonal[unknown];
        }
        // The finest levels cost most: they are visited once, the coarse ones twice (a W-cycle).
        for _ in 0..if number == 0 { 1 } else { 2 } {
            matrix.apply(&x, &mut spare);
            spare.iter_mut().zip(b).for_each(|(ax, b)| *ax = *b - *ax);
            let correction = self.cycle(number + 1, &restrict(aggregates, &spare));
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
    Aggregates {
        parent,
        factor,
        count: count as usize,
        untied: Vec::new(),
    }
}

impl Aggregates {
    /// The unknowns that stay in the hierarchy, each with its coarse one.
    fn tied(&self) -> impl Iterator<Item = (usize, u32)> {
        let parents = self.parent.iter().copied().enumerate();
        parents.filter(|&(_, parent)| parent != NONE)
    }

    /// Takes unknowns without neighbours out of the hierarchy, and numbers the rest anew.
    fn drop_untied(&mut self, matrix: &Hermitian) {
        let is_untied = |unknown: &u32| matrix.rows.row(*unknown as usize).is_empty();
        self.untied = (0..matrix.len() as u32).filter(is_untied).collect();
        let mut numbers = vec![0; self.count];
        for &unknown in &self.untied {
            numbers[self.parent[unknown as usize] as usize] = NONE;
        }
        let mut count = 0;
        for number in numbers.iter_mut().filter(|number| **number != NONE) {
            *number = count;
            count += 1;
        }
        for parent in &mut self.parent {
            *parent = numbers[*parent as usize];
        }
        self.count = count as usize;
    }
}

/// The rotation from a row's unknown to an entry's column that costs least: −conj(value), unit.
fn towards(value: DVec2) -> DVec2 {
    DVec2::new(-value.x, value.y).normalize_or(DVec2::X)
}

fn galerkin(matrix: &Hermitian, aggregates: &Aggregates) -> Hermitian {
    let count = aggregates.count;
    let members = members(aggregates);
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
    for (fine, parent) in aggregates.tied() {
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

fn members(aggregates: &Aggregates) -> Rows<u32> {
    let count = aggregates.count;
    let mut starts = vec![0u32; count + 1];
    for (_, parent) in aggregates.tied() {
        starts[parent as usize + 1] += 1;
    }
    for k in 0..count {
        starts[k + 1] += starts[k];
    }
    let mut next = starts.clone();
    let mut entries = vec![0; aggregates.parent.len() - aggregates.untied.len()];
    for (fine, parent) in aggregates.tied() {
        entries[next[parent as usize] as usize] = fine as u32;
        next[parent as usize] += 1;
    }
    Rows { starts, entries }
}

fn restrict(aggregates: &Aggregates, fine: &[DVec2]) -> Vec<DVec2> {
    let mut coarse = vec![DVec2::ZERO; aggregates.count];
    for (unknown, parent) in aggregates.tied() {
        coarse[parent as usize] += times_conjugate(fine[unknown], aggregates.factor[unknown]);
    }
    coarse
}

fn prolong_onto(aggregates: &Aggregates, coarse: &[DVec2], fine: &mut [DVec2]) {
    for (unknown, parent) in aggregates.tied() {
        fine[unknown] += aggregates.factor[unknown].rotate(coarse[parent as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::field::solvers::solve;
    use crate::progress::Progress;
    use crate::random;
    use rand::Rng;

    /// A matrix of its diagonal and the entries (row, column, value) above it.
    fn hermitian(diagonal: Vec<f64>, above: &[(u32, u32, DVec2)]) -> Hermitian {
        let mut entries: Vec<(u32, Entry)> = Vec::new();
        for &(row, column, value) in above {
            let mirrored = DVec2::new(value.x, -value.y);
            entries.push((row, Entry { column, value }));
            entries.push((
                column,
                Entry {
                    column: row,
                    value: mirrored,
                },
            ));
        }
        entries.sort_by_key(|(row, entry)| (*row, entry.column));
        let mut starts = vec![0; diagonal.len() + 1];
        for (row, _) in &entries {
            starts[*row as usize + 1] += 1;
        }
        for row in 0..diagonal.len() {
            starts[row + 1] += starts[row];
        }
        let entries = entries.into_iter().map(|(_, entry)| entry).collect();
        Hermitian::new(diagonal, Rows { starts, entries })
    }

    fn right_hand_side(count: usize) -> Vec<DVec2> {
        let mut stream = random::stream(1, "right-hand side", 0, 0);
        let mut number = || stream.gen_range(-1.0..1.0);
        (0..count).map(|_| DVec2::new(number(), number())).collect()
    }

    /// What the hierarchy keeps: a small matrix to factor, and few unknowns in all.
    fn assert_bounded(multigrid: &Multigrid) {
        assert!(multigrid.coarsest.l_dirty().nrows() <= SMALLEST);
        let all: usize = multigrid
            .levels
            .iter()
            .map(|level| level.matrix.len())
            .sum();
        assert!(all <= 10 * multigrid.matrix().len(), "{all}");
    }

    #[test]
    fn scattered_unknowns_are_divided_by_the_diagonal() {
        let diagonal: Vec<f64> = (0..20_000).map(|k| 0.5 + f64::from(k % 17)).collect();
        let multigrid = Multigrid::new(hermitian(diagonal.clone(), &[])).unwrap();
        assert_bounded(&multigrid);
        let b = right_hand_side(diagonal.len());
        for ((x, b), diagonal) in multigrid.precondition(&b).iter().zip(&b).zip(diagonal) {
            assert!((*x - *b / diagonal).length() < 1e-12);
        }
    }

    /// Pairs [[2, v], [v̄, 3]] with |v| = 1 have the inverse [[3, −v], [−v̄, 2]] / 5.
    #[test]
    fn tiny_components_are_solved_apart() {
        let pairs = 10_000u32;
        let tie = |pair: u32| DVec2::from_angle(f64::from(pair));
        let above: Vec<_> = (0..pairs).map(|p| (p, pairs + p, tie(p))).collect();
        let diagonal = [vec![2.0; pairs as usize], vec![3.0; pairs as usize]].concat();
        let multigrid = Multigrid::new(hermitian(diagonal, &above)).unwrap();
        assert_bounded(&multigrid);
        let b = right_hand_side(2 * pairs as usize);
        let mut x = multigrid.precondition(&b);
        solve(&multigrid, &b, &mut x, 1e-12, Progress::silent()).unwrap();
        for pair in 0..pairs as usize {
            let (v, other) = (tie(pair as u32), pairs as usize + pair);
            let first = (3.0 * b[pair] - v.rotate(b[other])) / 5.0;
            let second = (2.0 * b[other] - times_conjugate(b[pair], v)) / 5.0;
            assert!((x[pair] - first).length() < 1e-10);
            assert!((x[other] - second).length() < 1e-10);
        }
    }

    #[test]
    fn a_long_chain_among_scattered_unknowns_is_still_coarsened() {
        let (chain, alone) = (3_000u32, 40_000);
        let tie = |k: u32| -DVec2::from_angle(0.1 * f64::from(k));
        let above: Vec<_> = (1..chain).map(|k| (k - 1, k, tie(k))).collect();
        let matrix = hermitian(vec![2.001; chain as usize + alone], &above);
        let wanted = right_hand_side(matrix.len());
        let mut b = wanted.clone();
        matrix.apply(&wanted, &mut b);
        let multigrid = Multigrid::new(matrix).unwrap();
        assert_bounded(&multigrid);
        assert!(multigrid.levels.len() > 4);
        let mut x = multigrid.precondition(&b);
        solve(&multigrid, &b, &mut x, 1e-12, Progress::silent()).unwrap();
        let off = x
            .iter()
            .zip(&wanted)
            .map(|(x, wanted)| (*x - *wanted).length());
        assert!(off.fold(0.0, f64::max) < 1e-7);
    }

    #[test]
    fn a_scattered_unknown_of_no_or_negative_weight_is_not_definite() {
        for wrong in [0.0, -1.0, f64::NAN] {
            let mut diagonal = vec![1.0; 1_000];
            diagonal[700] = wrong;
            assert!(Multigrid::new(hermitian(diagonal, &[])).is_none());
        }
    }
}
