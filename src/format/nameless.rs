//! Arrays too large for memory, in a temporary file without a name.
//!
//! The file is mapped, which is the fastest way to read scattered numbers of it. No other program can
//! shorten it, since none can open it; it is gone when its owner is, also when that is killed.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::marker::PhantomData;
use std::path::Path;

use memmap2::Mmap;

use crate::format::npy::Element;

/// Numbers on their way into a file without a name.
#[derive(Debug)]
pub struct NamelessWriter(BufWriter<File>);

impl NamelessWriter {
    /// Makes the file; its bytes lie on the disk of `folder`.
    pub fn create_in(folder: &Path) -> io::Result<Self> {
        tempfile::tempfile_in(folder).map(|file| Self(BufWriter::new(file)))
    }

    /// Adds numbers.
    pub fn write<T: Element>(&mut self, numbers: &[T]) -> io::Result<()> {
        self.0.write_all(bytemuck::cast_slice(numbers))
    }

    /// Maps all that was written.
    pub fn finish<T: Element>(self) -> io::Result<Nameless<T>> {
        let file = self
            .0
            .into_inner()
            .map_err(io::IntoInnerError::into_error)?;
        #[allow(
            unsafe_code,
            reason = "sound while no one changes the file: it has no name, and its only handle is \
            dropped here"
        )]
        let map = unsafe { Mmap::map(&file) }?;
        Ok(Nameless {
            map,
            element: PhantomData,
        })
    }
}

/// The numbers of a file without a name.
#[derive(Debug)]
pub struct Nameless<T> {
    map: Mmap,
    element: PhantomData<T>,
}

impl<T: Element> Nameless<T> {
    /// All numbers, in the order they were written.
    #[inline(always)]
    pub fn as_slice(&self) -> &[T] {
        bytemuck::cast_slice(&self.map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_and_no_file_is_seen() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = NamelessWriter::create_in(folder.path()).unwrap();
        writer.write(&[1.5_f32, -2.0]).unwrap();
        writer.write(&[7.0_f32]).unwrap();
        let numbers = writer.finish::<f32>().unwrap();
        assert_eq!(numbers.as_slice(), [1.5, -2.0, 7.0]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
