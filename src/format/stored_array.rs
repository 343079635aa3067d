//! An array that stays in the file it came from, read in parts: no copy of the whole is made. It may
//! lie anywhere in the file, as arrays do in archives.

use std::marker::PhantomData;
use std::ops::Range;

use ndarray::{ArrayD, IxDyn};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::format::npy::{Element, parse_header};
use crate::format::positioned::{PIECE, PositionedFile};

/// Bytes in which a header is looked for.
const HEADER: u64 = 1 << 16;

/// Where an array's bytes are.
#[derive(Clone, Debug)]
pub enum Bytes {
    /// A part of a file, which had it all when it was opened.
    InFile(PositionedFile, Range<u64>),
    /// Expanded in memory.
    Expanded(Vec<u8>),
}

impl Bytes {
    fn len(&self) -> u64 {
        match self {
            Self::InFile(_, range) => range.end - range.start,
            Self::Expanded(bytes) => bytes.len() as u64,
        }
    }

    /// Fills `out` from byte `at` on.
    fn read(&self, at: u64, out: &mut [u8]) -> Result<()> {
        match self {
            Self::InFile(file, range) => file.read_at(range.start + at, out),
            Self::Expanded(bytes) => {
                out.copy_from_slice(&bytes[at as usize..][..out.len()]);
                Ok(())
            }
        }
    }
}

/// An array of `T` in C order.
#[derive(Clone, Debug)]
pub struct StoredArray<T> {
    bytes: Bytes,
    data_offset: usize,
    shape: Vec<usize>,
    element: PhantomData<T>,
}

impl<T: Element> StoredArray<T> {
    /// The array in `bytes`, a whole `.npy` file.
    pub fn new(bytes: Bytes) -> Result<Self> {
        let mut start = vec![0; HEADER.min(bytes.len()) as usize];
        bytes.read(0, &mut start)?;
        let header = parse_header(&start, bytes.len())?;
        header.expect::<T>()?;
        Ok(Self {
            bytes,
            data_offset: header.data_offset,
            shape: header.shape,
            element: PhantomData,
        })
    }

    /// Sides of the array, slowest first.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// How many numbers it holds.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Fills `numbers` from number `first` on, in C order.
    pub fn read(&self, first: usize, numbers: &mut [T]) -> Result<()> {
        let at = self.data_offset + first * size_of::<T>();
        self.bytes
            .read(at as u64, bytemuck::cast_slice_mut(numbers))
    }

    /// A copy in memory.
    pub fn to_array(&self) -> Result<ArrayD<T>> {
        let mut numbers = vec![T::zeroed(); self.len()];
        let each = PIECE / size_of::<T>();
        numbers
            .par_chunks_mut(each)
            .enumerate()
            .try_for_each(|(piece, numbers)| self.read(piece * each, numbers))?;
        ArrayD::from_shape_vec(IxDyn(&self.shape), numbers)
            .map_err(|error| Error::data("shape", error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::npy;
    use ndarray::Array2;

    #[test]
    fn numbers_are_read_where_they_lie_aligned_or_not() {
        let array = Array2::from_shape_fn((3, 4), |(r, c)| (r * 4 + c) as f32);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for padding in 0..4 {
            let mut bytes = vec![7; padding];
            npy::encode(&mut bytes, array.view().into_dyn()).unwrap();
            std::fs::write(&path, &bytes).unwrap();
            let file = PositionedFile::open(&path).unwrap();
            let part = Bytes::InFile(file, padding as u64..bytes.len() as u64);
            let stored = StoredArray::<f32>::new(part).unwrap();
            assert_eq!((stored.shape(), stored.len()), (&[3, 4][..], 12));
            let mut numbers = [0.0; 3];
            stored.read(5, &mut numbers).unwrap();
            assert_eq!(numbers, [5.0, 6.0, 7.0]);
            assert_eq!(stored.to_array().unwrap(), array.clone().into_dyn());
        }
        let other = Bytes::Expanded(std::fs::read(&path).unwrap()[3..].to_vec());
        assert!(StoredArray::<u32>::new(other).is_err());
    }
}
