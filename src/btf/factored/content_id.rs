//! The id of a factored sample: BLAKE3 over `directions.npy`, then `eigentextures.npy`, then, where there
//! is a colour step, its twelve numbers (transform, mean) as little-endian `f64`.

use std::path::Path;

use crate::btf::factored::factorization::Factorization;
use crate::error::Result;
use crate::format::id::{ContentId, hash_file};

/// The id of the factors in two files.
pub fn of_files(
    directions: &Path,
    eigentextures: &Path,
    factors: &Factorization,
) -> Result<ContentId> {
    let mut hasher = blake3::Hasher::new();
    hash_file(&mut hasher, directions)?;
    hash_file(&mut hasher, eigentextures)?;
    if !factors.is_plain_color() {
        let numbers = factors.color_transform.iter().chain(&factors.color_mean);
        for number in numbers {
            hasher.update(&number.to_le_bytes());
        }
    }
    Ok(ContentId::of_hash(&hasher.finalize()))
}
