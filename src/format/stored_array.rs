//! An array that stays in the file it came from, mapped: no copy of it is made, and its pages are
//! the system's to take back. Its numbers need not be aligned, as they are not in archives.

use std::fs::File;
use std::marker::PhantomData;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use memmap2::Mmap;
use ndarray::{ArrayD, IxDyn};

use crate::error::{Error, Result};
use crate::format::npy::{Element, parse_header};

/// A file's bytes, mapped.
#[derive(Clone, Debug)]
pub struct MappedFile(Arc<Mmap>);

impl MappedFile {
    /// Maps a file.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(Error::io(path, "read"))?;
        #[allow(
            unsafe_code,
            reason = "mapping a file is the one way to read it in slices without copies; \
            a file changed under a running process is outside every reader's promise"
        )]
        let map = unsafe { Mmap::map(&file) }.map_err(Error::io(path, "map"))?;
        Ok(Self(Arc::new(map)))
    }
}

impl AsRef<[u8]> for MappedFile {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// Where an array's bytes are.
#[derive(Clone, Debug)]
pub enum Bytes {
    /// A part of a file, which has it all.
    InFile(MappedFile, Range<usize>),
    /// Expanded in memory.
    Expanded(Vec<u8>),
}

impl AsRef<[u8]> for Bytes {
    fn as_ref(&self) -> &[u8] {
        match self {
            Self::InFile(file, range) => &file.as_ref()[range.clone()],
            Self::Expanded(bytes) => bytes,
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
        let header = parse_header(bytes.as_ref(), bytes.as_ref().len() as u64)?;
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

    /// Whether it holds no number.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Some of its numbers, in C order.
    pub fn numbers(&self, range: Range<usize>) -> impl ExactSizeIterator<Item = T> + '_ {
        let bytes = &self.bytes.as_ref()[self.data_offset..];
        let bytes = &bytes[range.start * size_of::<T>()..range.end * size_of::<T>()];
        let numbers = bytes.chunks_exact(size_of::<T>());
        numbers.map(bytemuck::pod_read_unaligned)
    }

    /// A copy in memory.
    pub fn to_array(&self) -> Result<ArrayD<T>> {
        let numbers = bytemuck::pod_collect_to_vec(&self.bytes.as_ref()[self.data_offset..]);
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
            let file = MappedFile::open(&path).unwrap();
            let part = Bytes::InFile(file, padding..bytes.len());
            let stored = StoredArray::<f32>::new(part).unwrap();
            assert_eq!((stored.shape(), stored.len()), (&[3, 4][..], 12));
            assert_eq!(stored.numbers(5..8).collect::<Vec<_>>(), [5.0, 6.0, 7.0]);
            assert_eq!(stored.to_array().unwrap(), array.clone().into_dyn());
        }
        let other = Bytes::Expanded(std::fs::read(&path).unwrap()[3..].to_vec());
        assert!(StoredArray::<u32>::new(other).is_err());
    }
}
