//! A file that is read in pieces, each at a stated place.
//!
//! Files that lie under a name are never mapped: when another program shortens a mapped file, touching
//! what is gone ends the process (SIGBUS). Here a piece that is gone is an error that names the file.
//! Threads share one open file, since a piece is read without moving a position.
//!
//! This costs one copy from the system's cache, about 0.1 s per gigabyte and thread.

use std::fs::File;
use std::io::{self, ErrorKind};
#[cfg(target_os = "linux")]
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{Error, Result};

/// Bytes read by one task where a long piece is read on all threads.
pub const PIECE: usize = 1 << 20;

/// An open file and the length it had when it was opened.
#[derive(Clone, Debug)]
pub struct PositionedFile(Arc<Opened>);

#[derive(Debug)]
struct Opened {
    path: PathBuf,
    file: File,
    length: u64,
}

impl PositionedFile {
    /// Opens a file.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(Error::io(path, "read"))?;
        let length = file.metadata().map_err(Error::io(path, "read"))?.len();
        Ok(Self(Arc::new(Opened {
            path: path.to_path_buf(),
            file,
            length,
        })))
    }

    /// The file's name.
    pub fn path(&self) -> &Path {
        &self.0.path
    }

    /// Bytes it held when it was opened.
    pub fn length(&self) -> u64 {
        self.0.length
    }

    /// The open file, for readers that move its position.
    pub fn file(&self) -> &File {
        &self.0.file
    }

    /// Fills `bytes` from the place `at` on.
    pub fn read_at(&self, at: u64, bytes: &mut [u8]) -> Result<()> {
        read_exact_at(&self.0.file, at, bytes).map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => self.shrunk(at + bytes.len() as u64),
            _ => Error::io(&self.0.path, "read")(error),
        })
    }

    /// Tells the system that `length` bytes from the place `at` on will be read soon: it fetches them meanwhile, many
    /// such pieces at once. Nothing but time depends on it.
    pub fn announce(&self, at: u64, length: u64) {
        announce(&self.0.file, at, length);
    }

    /// Says that the file no longer holds its bytes up to `end`.
    fn shrunk(&self, end: u64) -> Error {
        let found = match self.0.file.metadata() {
            Ok(now) => format!("{} bytes", now.len()),
            Err(_) => "fewer bytes".into(),
        };
        Error::data("length", found)
            .expected(format!("at least {end}"))
            .advice("the file shrank while it was read; make it again")
            .in_file(&self.0.path)
    }
}

#[cfg(target_os = "linux")]
fn announce(file: &File, at: u64, length: u64) {
    // A file system that cannot fetch ahead reads when it is asked to.
    let length = NonZeroU64::new(length);
    let _ = rustix::fs::fadvise(file, at, length, rustix::fs::Advice::WillNeed);
}

#[cfg(not(target_os = "linux"))]
fn announce(_file: &File, _at: u64, _length: u64) {}

#[cfg(unix)]
fn read_exact_at(file: &File, at: u64, bytes: &mut [u8]) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, at)
}

#[cfg(windows)]
fn read_exact_at(file: &File, mut at: u64, mut bytes: &mut [u8]) -> io::Result<()> {
    use std::os::windows::fs::FileExt;
    while !bytes.is_empty() {
        match file.seek_read(bytes, at)? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            read => {
                bytes = &mut bytes[read..];
                at += read as u64;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_shrinks_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        std::fs::write(&path, [7; 100]).unwrap();
        let file = PositionedFile::open(&path).unwrap();
        let mut bytes = [0; 10];
        file.read_at(90, &mut bytes).unwrap();
        assert_eq!((bytes, file.length()), ([7; 10], 100));
        File::options()
            .write(true)
            .open(&path)
            .unwrap()
            .set_len(95)
            .unwrap();
        let error = file.read_at(90, &mut bytes).unwrap_err().to_string();
        assert!(
            error.contains("a.bin") && error.contains("shrank"),
            "{error}"
        );
    }
}
