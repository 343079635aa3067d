//! Random streams keyed by what they are for, never by thread: same seed, same bytes.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// The generator every stage uses.
pub type Stream = Xoshiro256PlusPlus;

/// The stream of one purpose (`"kmeans++"`), one level and one item under one user seed.
///
/// Streams of different keys are independent; the same key gives the same stream on every
/// machine and at any thread count.
pub fn stream(seed: u64, purpose: &str, level: u32, id: u64) -> Stream {
    let mut key = blake3::Hasher::new();
    key.update(&seed.to_le_bytes());
    key.update(&level.to_le_bytes());
    key.update(&id.to_le_bytes());
    key.update(purpose.as_bytes());
    Stream::from_seed(*key.finalize().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngCore;

    #[test]
    fn every_part_of_the_key_counts() {
        let first = |seed, purpose, level, id| stream(seed, purpose, level, id).next_u64();
        let base = first(1, "a", 0, 0);
        assert_eq!(base, first(1, "a", 0, 0));
        for other in [
            first(2, "a", 0, 0),
            first(1, "b", 0, 0),
            first(1, "a", 1, 0),
            first(1, "a", 0, 1),
        ] {
            assert_ne!(base, other);
        }
    }
}
