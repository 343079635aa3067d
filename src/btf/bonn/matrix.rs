//! Matrices that are read by rows: in memory, or where they lie in a file.

use std::ops::Range;
use std::sync::Arc;

use ndarray::{Array2, s};

use crate::btf::bonn::fields::Fields;
use crate::btf::bonn::scalar::Scalar;
use crate::error::{Error, Result};
use crate::format::positioned::PositionedFile;

/// A matrix, row-major.
pub trait MatrixRows: Send + Sync {
    /// How many rows.
    fn rows(&self) -> usize;
    /// How many columns.
    fn columns(&self) -> usize;
    /// Fills `out` with some rows.
    fn read(&self, rows: Range<usize>, out: &mut [f32]) -> Result<()>;
}

impl MatrixRows for Array2<f32> {
    fn rows(&self) -> usize {
        self.nrows()
    }

    fn columns(&self) -> usize {
        self.ncols()
    }

    fn read(&self, rows: Range<usize>, out: &mut [f32]) -> Result<()> {
        let part = self.slice(s![rows, ..]);
        let pairs = out.iter_mut().zip(part.iter());
        pairs.for_each(|(out, &number)| *out = number);
        Ok(())
    }
}

/// A copy of all rows in memory.
pub(super) fn to_array(matrix: &dyn MatrixRows) -> Result<Array2<f32>> {
    let mut array = Array2::zeros((matrix.rows(), matrix.columns()));
    if let Some(numbers) = array.as_slice_mut() {
        matrix.read(0..matrix.rows(), numbers)?;
    }
    Ok(array)
}

/// A matrix in a file.
#[derive(Debug)]
pub(super) struct StoredMatrix {
    /// What errors call it.
    name: String,
    file: PositionedFile,
    start: u64,
    rows: usize,
    /// Numbers of a stored row.
    stored: usize,
    /// Those of them that count.
    columns: usize,
    scalar: Scalar,
}

/// The sides of a matrix in a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sides {
    pub(super) rows: u32,
    /// Numbers of a stored row.
    pub(super) stored: u32,
    /// Those of them that count.
    pub(super) columns: u32,
    pub(super) scalar: Scalar,
}

impl StoredMatrix {
    /// The matrix that comes next; the file is known to hold all of it.
    pub(super) fn next(fields: &mut Fields, name: String, sides: Sides) -> Result<Self> {
        let count = u64::from(sides.rows).checked_mul(u64::from(sides.stored));
        let start = fields.pass(&name, count, sides.scalar.size() as u64)?;
        Ok(Self {
            name,
            file: fields.file().clone(),
            start,
            rows: sides.rows as usize,
            stored: sides.stored as usize,
            columns: sides.columns as usize,
            scalar: sides.scalar,
        })
    }

    fn check(&self, first_row: usize, numbers: &[f32]) -> Result<()> {
        let Some(at) = numbers.iter().position(|number| !number.is_finite()) else {
            return Ok(());
        };
        let (row, column) = (first_row + at / self.columns, at % self.columns);
        Err(Error::data(
            format!("{}: row {row}, component {column}", self.name),
            numbers[at].to_string(),
        )
        .expected("a finite number within the range of 32-bit floats")
        .in_file(self.file.path()))
    }
}

impl MatrixRows for StoredMatrix {
    fn rows(&self) -> usize {
        self.rows
    }

    fn columns(&self) -> usize {
        self.columns
    }

    fn read(&self, rows: Range<usize>, out: &mut [f32]) -> Result<()> {
        let row = self.stored * self.scalar.size();
        let mut bytes = vec![0; rows.len() * row];
        let start = self.start + (rows.start * row) as u64;
        self.file.read_at(start, &mut bytes)?;
        if self.stored == self.columns {
            self.scalar.decode(&bytes, out);
        } else {
            let used = self.columns * self.scalar.size();
            let pairs = bytes.chunks(row).zip(out.chunks_mut(self.columns));
            pairs.for_each(|(bytes, out)| self.scalar.decode(&bytes[..used], out));
        }
        self.check(rows.start, out)
    }
}

/// Every `step`-th row of a matrix from row `first` on.
pub(super) struct EveryNth {
    pub(super) matrix: Arc<StoredMatrix>,
    pub(super) step: usize,
    pub(super) first: usize,
}

impl MatrixRows for EveryNth {
    fn rows(&self) -> usize {
        self.matrix.rows / self.step
    }

    fn columns(&self) -> usize {
        self.matrix.columns
    }

    fn read(&self, rows: Range<usize>, out: &mut [f32]) -> Result<()> {
        let columns = self.columns();
        let stored = rows.start * self.step..rows.end * self.step;
        let mut all = vec![0.0; stored.len() * columns];
        self.matrix.read(stored, &mut all)?;
        let wanted = all.chunks(columns).skip(self.first).step_by(self.step);
        let pairs = out.chunks_mut(columns).zip(wanted);
        pairs.for_each(|(out, row)| out.copy_from_slice(row));
        Ok(())
    }
}
