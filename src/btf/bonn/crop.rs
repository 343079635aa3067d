//! A part of the texels of a `.btf` file: what lies outside is left out before anything is multiplied or copied.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::btf::bonn::body::Body;
use crate::btf::bonn::factors::{Channel, Factors};
use crate::btf::bonn::matrix::MatrixRows;
use crate::btf::import::Region;
use crate::error::Result;

/// Runs of rows of a matrix, all equally long.
struct RowRuns {
    matrix: Arc<dyn MatrixRows>,
    runs: Vec<Range<usize>>,
}

impl MatrixRows for RowRuns {
    fn rows(&self) -> usize {
        self.runs.iter().map(ExactSizeIterator::len).sum()
    }

    fn columns(&self) -> usize {
        self.matrix.columns()
    }

    fn read(&self, rows: Range<usize>, out: &mut [f32]) -> Result<()> {
        let length = self.runs[0].len();
        let (mut at, mut rest) = (rows.start, out);
        while at < rows.end {
            let (run, inside) = (&self.runs[at / length], at % length);
            let count = (length - inside).min(rows.end - at);
            let (part, later) = rest.split_at_mut(count * self.columns());
            let first = run.start + inside;
            self.matrix.read(first..first + count, part)?;
            (at, rest) = (at + count, later);
        }
        Ok(())
    }
}

/// The factors of a region of images of `width` texels per row.
pub(super) fn factors_of(factors: Factors, region: Region, width: u32) -> Factors {
    let runs: Vec<Range<usize>> = region.rows(width).collect();
    let mut channels: Vec<Channel> = Vec::new();
    for (at, channel) in factors.channels.iter().enumerate() {
        let is_same = |other: &Channel| Arc::ptr_eq(&other.eigentextures, &channel.eigentextures);
        // Shared eigentextures stay shared.
        let earlier = factors.channels[..at].iter().position(is_same);
        let eigentextures = match earlier {
            Some(earlier) => Arc::clone(&channels[earlier].eigentextures),
            None => Arc::new(RowRuns {
                matrix: Arc::clone(&channel.eigentextures),
                runs: runs.clone(),
            }),
        };
        channels.push(Channel {
            directions: Arc::clone(&channel.directions),
            eigentextures,
        });
    }
    Factors {
        channels,
        ..factors
    }
}

/// Images of which a region is read.
pub(super) struct Cropped<B> {
    pub(super) body: B,
    pub(super) region: Region,
    /// Columns and rows of the whole images.
    pub(super) size: [u32; 2],
}

impl<B: Body> Body for Cropped<B> {
    fn read(&self, images: Range<usize>, out: &mut [f32]) -> Result<()> {
        let whole = self
            .size
            .map(|side| side as usize)
            .iter()
            .product::<usize>()
            * 3;
        let part = out.len() / images.len();
        let mut numbers = vec![0.0; images.len() * whole];
        self.body.read(images, &mut numbers)?;
        let pairs = out.par_chunks_mut(part).zip(numbers.par_chunks(whole));
        pairs.for_each(|(out, numbers)| {
            let rows = self.region.rows(self.size[0]);
            for (out, row) in out.chunks_mut(self.region.width as usize * 3).zip(rows) {
                out.copy_from_slice(&numbers[row.start * 3..row.end * 3]);
            }
        });
        Ok(())
    }

    /// So much that the whole images take what the body asks for.
    fn run_bytes(&self) -> usize {
        let [width, height] = self.size.map(u64::from);
        let share = u64::from(self.region.width) * u64::from(self.region.height);
        (self.body.run_bytes() as u64 * share / (width * height)) as usize
    }
}
