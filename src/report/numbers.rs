//! Numbers as a page carries them: bytes planes that compress well, gzip, base64. `web/numbers.js` and
//! `web/surface.js` read them.

use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

/// Bytes compressed.
pub fn gzip(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// Bytes as the text of a script element.
pub fn base64(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

/// Characters that base64 makes of this many bytes.
pub fn base64_length(bytes: usize) -> usize {
    4 * bytes.div_ceil(3)
}

/// A whole number with its sign in the lowest bit: small ones of either sign stay small.
pub fn fold(number: i16) -> u16 {
    ((number << 1) ^ (number >> 15)) as u16
}

/// Appends numbers byte by byte: all lowest bytes first.
pub fn append_planes(bytes: &mut Vec<u8>, numbers: &[u16]) {
    for byte in 0..2 {
        bytes.extend(numbers.iter().map(|number| number.to_le_bytes()[byte]));
    }
}

/// Appends a column of 16-bit numbers as differences to the number before.
pub fn append_column(bytes: &mut Vec<u8>, numbers: impl Iterator<Item = u16>) {
    let mut last = 0u16;
    let differences: Vec<u16> = numbers
        .map(|number| {
            let difference = number.wrapping_sub(last) as i16;
            last = number;
            fold(difference)
        })
        .collect();
    append_planes(bytes, &differences);
}

/// Appends a column of 32-bit numbers as differences to the number before.
pub fn append_indices(bytes: &mut Vec<u8>, numbers: impl Iterator<Item = u32>) {
    let mut last = 0u32;
    let differences: Vec<u32> = numbers
        .map(|number| {
            let difference = number.wrapping_sub(last) as i32;
            last = number;
            ((difference << 1) ^ (difference >> 31)) as u32
        })
        .collect();
    for byte in 0..4 {
        bytes.extend(differences.iter().map(|number| number.to_le_bytes()[byte]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What `web/surface.js` does.
    fn unfold(folded: u32) -> i32 {
        (folded >> 1) as i32 ^ -((folded & 1) as i32)
    }

    #[test]
    fn folded_numbers_unfold() {
        for number in [0, 1, -1, 2, -2, 1000, i16::MAX, i16::MIN] {
            assert_eq!(unfold(u32::from(fold(number))) as i16, number);
        }
        assert_eq!([0, -1, 1, -2].map(fold), [0, 1, 2, 3]);
    }

    #[test]
    fn columns_add_up_again() {
        let numbers = [5u16, 5, 65535, 0, 40000];
        let mut bytes = Vec::new();
        append_column(&mut bytes, numbers.into_iter());
        let mut last = 0u16;
        let found: Vec<u16> = (0..5)
            .map(|at| {
                let folded = u16::from_le_bytes([bytes[at], bytes[5 + at]]);
                last = last.wrapping_add(unfold(u32::from(folded)) as u16);
                last
            })
            .collect();
        assert_eq!(found, numbers);
    }

    #[test]
    fn base64_has_the_length_it_is_said_to_have() {
        for length in 0..7 {
            assert_eq!(base64(&vec![1; length]).len(), base64_length(length));
        }
    }
}
