//! The numbers of a `.btf` file in their order, little endian; sizes are accepted only if the rest of the file can
//! hold them.

use std::path::Path;

use crate::error::{Error, Result};
use crate::format::positioned::PositionedFile;

/// A file and how far it is read.
#[derive(Debug)]
pub(super) struct Fields {
    file: PositionedFile,
    at: u64,
}

impl Fields {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = PositionedFile::open(path)?;
        Ok(Self { file, at: 0 })
    }

    pub(super) fn file(&self) -> &PositionedFile {
        &self.file
    }

    /// The place of the next byte.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// Goes on at another place.
    pub(super) fn go_to(&mut self, at: u64) {
        self.at = at;
    }

    /// Bytes that are left.
    pub(super) fn left(&self) -> u64 {
        self.file.length().saturating_sub(self.at)
    }

    /// Passes over `count` numbers of `size` bytes; returns where they begin. `None`: more than can be counted.
    pub(super) fn pass(&mut self, field: &str, count: Option<u64>, size: u64) -> Result<u64> {
        let bytes = count.and_then(|count| count.checked_mul(size));
        let start = self.at;
        match bytes {
            Some(bytes) if bytes <= self.left() => {
                self.at += bytes;
                Ok(start)
            }
            _ => Err(
                Error::data(field, format!("{} bytes are left of the file", self.left()))
                    .expected(bytes.map_or("fewer than 2^64 bytes".into(), |bytes| {
                        format!("{bytes} bytes")
                    }))
                    .advice("the file is truncated, or its header states another size"),
            ),
        }
    }

    /// Bytes, after it is known that the file has them.
    pub(super) fn bytes(&mut self, field: &str, length: u64) -> Result<Vec<u8>> {
        let start = self.pass(field, Some(length), 1)?;
        let mut bytes = vec![0; length as usize];
        self.file.read_at(start, &mut bytes)?;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self, field: &str) -> Result<[u8; N]> {
        let start = self.pass(field, Some(N as u64), 1)?;
        let mut bytes = [0; N];
        self.file.read_at(start, &mut bytes)?;
        Ok(bytes)
    }

    pub(super) fn u8(&mut self, field: &str) -> Result<u8> {
        self.array::<1>(field).map(|[byte]| byte)
    }

    pub(super) fn u32(&mut self, field: &str) -> Result<u32> {
        self.array(field).map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self, field: &str) -> Result<i32> {
        self.array(field).map(i32::from_le_bytes)
    }

    /// Floats that are finite.
    pub(super) fn floats(&mut self, field: &str, count: u64) -> Result<Vec<f32>> {
        let bytes = self.bytes(field, count.saturating_mul(4))?;
        let (words, _) = bytes.as_chunks::<4>();
        let floats: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
        match floats.iter().position(|value| !value.is_finite()) {
            None => Ok(floats),
            Some(at) => Err(
                Error::data(format!("{field}, number {at}"), floats[at].to_string())
                    .expected("a finite number"),
            ),
        }
    }

    /// The same, as many as the array has.
    pub(super) fn float_array<const N: usize>(&mut self, field: &str) -> Result<[f32; N]> {
        let floats = self.floats(field, N as u64)?;
        Ok(std::array::from_fn(|at| floats[at]))
    }

    /// Refuses bytes behind the last field.
    pub(super) fn end(&self) -> Result<()> {
        match self.left() {
            0 => Ok(()),
            left => Err(
                Error::data("end", format!("{left} bytes follow the last number"))
                    .expected("none")
                    .advice(
                        "the file's sizes do not fit its length; was it written or copied whole?",
                    ),
            ),
        }
    }
}
