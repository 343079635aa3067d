//! ZIP blocks: the numbers' bytes split into low and high ones, each byte as the difference to the
//! one before, deflated.
//!
//! The `exr` crate deflates at one level that takes longer than rendering does; the level here
//! costs a third of that, for files that are 3 % larger (docs/performance/render.md).

use std::io::Write;
use std::ops::Range;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::{ExrImage, Numbers};

/// How hard deflating tries, of 9.
const LEVEL: u32 = 2;

/// The compressed pixels of some rows; `None` where they would be no shorter than the raw ones.
pub(super) fn compress(image: &ExrImage, rows: Range<usize>) -> std::io::Result<Option<Vec<u8>>> {
    let differences = differences(&split_bytes(image, rows));
    let room = Vec::with_capacity(differences.len() / 2);
    let mut encoder = ZlibEncoder::new(room, Compression::new(LEVEL));
    encoder.write_all(&differences)?;
    let compressed = encoder.finish()?;
    Ok((compressed.len() < differences.len()).then_some(compressed))
}

/// All bytes at even places (little-endian), then all at odd ones; every number has an even count.
fn split_bytes(image: &ExrImage, rows: Range<usize>) -> Vec<u8> {
    let width = image.size[0] as usize;
    let bytes_a_pixel: usize = image.channels.values().map(Numbers::bytes_each).sum();
    let mut bytes = vec![0; rows.len() * width * bytes_a_pixel];
    let (mut even, mut odd) = bytes.split_at_mut(rows.len() * width * bytes_a_pixel / 2);
    for row in rows {
        for numbers in image.channels.values() {
            let taken = width * numbers.bytes_each() / 2;
            let (even_part, odd_part);
            (even_part, even) = even.split_at_mut(taken);
            (odd_part, odd) = odd.split_at_mut(taken);
            split_numbers(numbers, row * width..(row + 1) * width, even_part, odd_part);
        }
    }
    bytes
}

fn split_numbers(numbers: &Numbers, range: Range<usize>, even: &mut [u8], odd: &mut [u8]) {
    match numbers {
        Numbers::Half(numbers) => {
            let places = even.iter_mut().zip(odd);
            for (number, (even, odd)) in numbers[range].iter().zip(places) {
                [*even, *odd] = number.to_bits().to_le_bytes();
            }
        }
        Numbers::Float(numbers) => {
            split_words(
                numbers[range].iter().map(|number| number.to_bits()),
                even,
                odd,
            );
        }
        Numbers::Uint(numbers) => split_words(numbers[range].iter().copied(), even, odd),
    }
}

fn split_words(words: impl Iterator<Item = u32>, even: &mut [u8], odd: &mut [u8]) {
    let (even, odd) = (even.as_chunks_mut::<2>().0, odd.as_chunks_mut::<2>().0);
    let places = even.iter_mut().zip(odd);
    for (word, (even, odd)) in words.zip(places) {
        [even[0], odd[0], even[1], odd[1]] = word.to_le_bytes();
    }
}

/// The first byte, then each byte less the one before, plus 128.
fn differences(bytes: &[u8]) -> Vec<u8> {
    let difference = |(&next, &last): (&u8, &u8)| next.wrapping_sub(last).wrapping_add(128);
    let pairs = bytes.iter().skip(1).zip(bytes);
    bytes
        .iter()
        .take(1)
        .copied()
        .chain(pairs.map(difference))
        .collect()
}
