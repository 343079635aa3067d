//! Ids: the first 128 bits of a BLAKE3 hash, as 32 hex digits.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Bytes of a file that are hashed at once.
const HASHED: usize = 4 << 20;

/// The id of a file or of an array's content.
#[derive(Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ContentId([u8; 16]);

impl ContentId {
    /// The id of a finished hash.
    pub fn of_hash(hash: &blake3::Hash) -> Self {
        let mut id = [0; 16];
        id.copy_from_slice(&hash.as_bytes()[..16]);
        Self(id)
    }

    /// The id of bytes in memory.
    pub fn of_bytes(bytes: &[u8]) -> Self {
        Self::of_hash(&blake3::Hasher::new().update_rayon(bytes).finalize())
    }

    /// The id of a file's bytes.
    pub fn of_file(path: &Path) -> Result<Self> {
        let mut hasher = blake3::Hasher::new();
        hash_file(&mut hasher, path)?;
        Ok(Self::of_hash(&hasher.finalize()))
    }

    /// Parses 32 hex digits.
    pub fn parse(text: &str) -> Option<Self> {
        if text.len() != 32 || !text.is_ascii() {
            return None;
        }
        let mut id = [0; 16];
        for (byte, pair) in id.iter_mut().zip(text.as_bytes().chunks(2)) {
            let pair = std::str::from_utf8(pair).ok()?;
            *byte = u8::from_str_radix(pair, 16).ok()?;
        }
        Some(Self(id))
    }
}

impl fmt::Display for ContentId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for ContentId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl TryFrom<String> for ContentId {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        Self::parse(&text).ok_or_else(|| format!("id `{text}` is not 32 hex digits"))
    }
}

impl From<ContentId> for String {
    fn from(id: ContentId) -> Self {
        id.to_string()
    }
}

/// Adds a file's bytes to a hash: one part is hashed on all threads while the next is read.
///
/// A file that is shorter at the end than it was at the start is refused.
pub fn hash_file(hasher: &mut blake3::Hasher, path: &Path) -> Result<()> {
    let mut file = File::open(path).map_err(Error::io(path, "read"))?;
    let length = file.metadata().map_err(Error::io(path, "read"))?.len();
    let part = length.saturating_add(1).clamp(1 << 16, HASHED as u64) as usize;
    let (mut held, mut next) = (Vec::with_capacity(part), Vec::new());
    let mut read = |bytes: &mut Vec<u8>| {
        bytes.clear();
        (&mut file).take(part as u64).read_to_end(bytes)
    };
    let mut total = read(&mut held).map_err(Error::io(path, "read"))? as u64;
    while held.len() == part {
        let (count, ()) = rayon::join(
            || read(&mut next),
            || {
                hasher.update_rayon(&held);
            },
        );
        total += count.map_err(Error::io(path, "read"))? as u64;
        std::mem::swap(&mut held, &mut next);
    }
    hasher.update_rayon(&held);
    if total < length {
        return Err(Error::data("length", format!("{total} bytes"))
            .expected(format!("{length}, as it was when it was opened"))
            .advice("the file shrank while it was read; make it again")
            .in_file(path));
    }
    Ok(())
}

/// Refuses `found` when it is not the id that `wanted` asks for, unless `force`.
///
/// `place` says where `found` stands, as `sample id`.
pub fn check_same(place: &str, found: &ContentId, wanted: &ContentId, force: bool) -> Result<()> {
    if found == wanted || force {
        return Ok(());
    }
    Err(Error::data(place, found.to_string())
        .expected(wanted.to_string())
        .advice("the files come from different runs; make them again in order, or give --force"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_every_length_are_hashed_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        for length in [
            0,
            1,
            HASHED - 1,
            HASHED,
            HASHED + 1,
            2 * HASHED,
            2 * HASHED + 5,
        ] {
            let bytes: Vec<u8> = (0..length).map(|at| (at % 251) as u8).collect();
            std::fs::write(&path, &bytes).unwrap();
            let id = ContentId::of_file(&path).unwrap();
            assert_eq!(id, ContentId::of_bytes(&bytes), "{length}");
        }
    }

    #[test]
    fn ids_round_trip_as_text() {
        let id = ContentId::of_bytes(b"texel");
        assert_eq!(ContentId::parse(&id.to_string()), Some(id.clone()));
        assert_eq!(id.to_string(), blake3::hash(b"texel").to_hex()[..32]);
        assert_eq!(ContentId::parse("12"), None);
        assert_eq!(ContentId::parse(&"z".repeat(32)), None);
    }
}
