//! A `.btf` file on its way out: little-endian numbers into a file that appears when all is written.

use std::io::Write;
use std::path::Path;

use crate::btf::bonn::matrix::MatrixRows;
use crate::btf::bonn::scalar::Scalar;
use crate::error::{Error, Result};
use crate::format::atomic;

/// Numbers converted at a time.
const BLOCK: usize = 1 << 20;

/// Where the numbers go.
pub struct Output<'a> {
    path: &'a Path,
    sink: &'a mut dyn Write,
}

/// Writes `path` through `fill`; on any failure the target stays as it was.
pub(super) fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut Output<'_>) -> Result<()>,
) -> Result<()> {
    let mut failed = None;
    let written = atomic::write_file(path, |sink| {
        fill(&mut Output { path, sink }).map_err(|error| {
            failed = Some(error);
            std::io::Error::other("stopped")
        })
    });
    match failed {
        Some(error) => Err(error),
        None => written,
    }
}

impl Output<'_> {
    pub(super) fn bytes(&mut self, bytes: &[u8]) -> Result<()> {
        self.sink
            .write_all(bytes)
            .map_err(Error::io(self.path, "write"))
    }

    pub(super) fn u8(&mut self, number: u8) -> Result<()> {
        self.bytes(&[number])
    }

    /// A count or a size.
    pub(super) fn u32(&mut self, number: usize) -> Result<()> {
        let number = u32::try_from(number).map_err(|_| {
            Error::data("size", number.to_string())
                .expected("less than 2^32, as the format counts")
                .in_file(self.path)
        })?;
        self.bytes(&number.to_le_bytes())
    }

    pub(super) fn floats(&mut self, numbers: &[f32]) -> Result<()> {
        numbers
            .iter()
            .try_for_each(|number| self.bytes(&number.to_le_bytes()))
    }

    /// Numbers of a type; `place` is what an error calls them.
    pub(super) fn scalars(&mut self, scalar: Scalar, place: &str, numbers: &[f32]) -> Result<()> {
        let mut bytes = Vec::with_capacity(numbers.len() * scalar.size());
        scalar.encode(place, numbers, &mut bytes)?;
        self.bytes(&bytes)
    }

    /// A matrix, row by row.
    pub(super) fn matrix(
        &mut self,
        scalar: Scalar,
        place: &str,
        matrix: &dyn MatrixRows,
    ) -> Result<()> {
        let columns = matrix.columns();
        let each = (BLOCK / columns.max(1)).max(1);
        let mut numbers = Vec::new();
        for start in (0..matrix.rows()).step_by(each) {
            let rows = start..matrix.rows().min(start + each);
            numbers.resize(rows.len() * columns, 0.0);
            matrix.read(rows, &mut numbers)?;
            self.scalars(scalar, place, &numbers)?;
        }
        Ok(())
    }
}
