//! Whole files in memory, gzip or not, with a limit on what they expand to.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;

use crate::error::{Error, Result};
use crate::format::guard::guarded;

/// A compressed file may expand to this many times its size, beside [`EXPANSION_BASE`].
const EXPANSION_FACTOR: u64 = 64;
/// What any compressed file may expand to, in bytes.
const EXPANSION_BASE: u64 = 4 << 20;
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Reads a file; a gzip file is expanded.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let file = File::open(path).map_err(Error::io(path, "read"))?;
    let length = file.metadata().map_err(Error::io(path, "read"))?.len();
    let mut bytes = Vec::new();
    (&file)
        .read_to_end(&mut bytes)
        .map_err(Error::io(path, "read"))?;
    if !bytes.starts_with(&GZIP_MAGIC) {
        return Ok(bytes);
    }
    let limit = length
        .saturating_mul(EXPANSION_FACTOR)
        .saturating_add(EXPANSION_BASE);
    guarded(path, || expand(&bytes, limit))
}

fn expand(packed: &[u8], limit: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    MultiGzDecoder::new(packed)
        .take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| {
            Error::data("gzip", error.to_string()).advice("the file is truncated or damaged")
        })?;
    if bytes.len() as u64 > limit {
        return Err(Error::data("gzip", format!("expands beyond {limit} bytes"))
            .expected("a mesh whose size fits the file's"));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn gzip_is_expanded_and_bombs_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj.gz");
        std::fs::write(&path, packed(b"v 0 0 0\n")).unwrap();
        assert_eq!(read(&path).unwrap(), b"v 0 0 0\n");
        let bomb = packed(&vec![0; 1 << 20]);
        assert!(
            expand(&bomb, 1 << 16)
                .unwrap_err()
                .to_string()
                .contains("beyond")
        );
        let cut = expand(&bomb[..bomb.len() / 2], 1 << 21).unwrap_err();
        assert!(cut.to_string().contains("gzip"));
    }
}
