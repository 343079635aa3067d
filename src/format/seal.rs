//! Seals of files that a run keeps for itself: a hash over all that the file states.
//!
//! A checksum of an archive's members tells that the disk gave back what was written. A seal also tells
//! that no value was changed since, that lists were not exchanged between files, and that this version of
//! the program wrote it. It protects against damage and mistakes, not against a forger: it has no secret.

use bytemuck::Pod;

use crate::format::id::ContentId;

/// The version of the program whose numbers a file holds.
pub const ENGINE: &str = env!("CARGO_PKG_VERSION");

/// A seal in the making.
pub struct Seal(blake3::Hasher);

impl Seal {
    /// The seal of a file of one format and version, made for `run`.
    pub fn new(format: &str, version: u32, run: &ContentId) -> Self {
        let mut seal = Self(blake3::Hasher::new());
        seal.text("format", format);
        seal.text("version", &version.to_string());
        seal.text("engine", ENGINE);
        seal.text("run", &run.to_string());
        seal
    }

    /// Adds a text.
    pub fn text(&mut self, name: &str, text: &str) {
        self.part(name, text.as_bytes());
    }

    /// Adds a list of numbers.
    pub fn list<T: Pod>(&mut self, name: &str, list: &[T]) {
        self.part(name, bytemuck::cast_slice(list));
    }

    /// Name and length go before the bytes, so that no part can be taken for the beginning of the next.
    fn part(&mut self, name: &str, bytes: &[u8]) {
        for text in [name.as_bytes(), &(bytes.len() as u64).to_le_bytes()] {
            self.0.update(&(text.len() as u64).to_le_bytes());
            self.0.update(text);
        }
        self.0.update_rayon(bytes);
    }

    /// The seal as it stands in the file.
    pub fn finish(self) -> ContentId {
        ContentId::of_hash(&self.0.finalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_and_its_place_count() {
        let run = ContentId::of_bytes(b"run");
        let of = |format: &str, version, parts: &[(&str, &[u8])]| {
            let mut seal = Seal::new(format, version, &run);
            parts.iter().for_each(|(name, list)| seal.list(name, list));
            seal.finish()
        };
        let all = [
            of("a", 1, &[("x", &[1, 2]), ("y", &[3])]),
            of("b", 1, &[("x", &[1, 2]), ("y", &[3])]),
            of("a", 2, &[("x", &[1, 2]), ("y", &[3])]),
            of("a", 1, &[("x", &[1]), ("y", &[2, 3])]),
            of("a", 1, &[("y", &[1, 2]), ("x", &[3])]),
            of("a", 1, &[("x", &[1, 2, 3])]),
        ];
        let distinct: std::collections::HashSet<_> = all.iter().collect();
        assert_eq!(distinct.len(), all.len());
        assert_eq!(all[0], of("a", 1, &[("x", &[1, 2]), ("y", &[3])]));
    }
}
