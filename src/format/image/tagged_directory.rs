//! The bytes of one short tag in the first directory of a TIFF file, found without decoding anything.

/// Where the number of a tag lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PhotometricEntry {
    at: usize,
    big_endian: bool,
}

/// Tag of the photometric interpretation.
const PHOTOMETRIC: u16 = 262;
/// More entries than this are no directory.
const MOST_ENTRIES: u64 = 4096;

impl PhotometricEntry {
    /// The photometric interpretation, where the directory has one.
    pub(super) fn find(bytes: &[u8]) -> Option<Self> {
        Self::find_tag(bytes, PHOTOMETRIC)
    }

    /// A tag that is a single 16-bit number.
    pub(super) fn find_tag(bytes: &[u8], tag: u16) -> Option<Self> {
        let big_endian = bytes.first() == Some(&b'M');
        let number = |at: usize, length: usize| -> Option<u64> {
            let part = bytes.get(at..at.checked_add(length)?)?;
            let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
            Some(match big_endian {
                true => part.iter().fold(0, join),
                false => part.iter().rev().fold(0, join),
            })
        };
        let is_big = number(2, 2)? == 43;
        let (offset, offset_length) = if is_big { (8, 8) } else { (4, 4) };
        let (count_length, entry_length) = if is_big { (8, 20) } else { (2, 12) };
        let directory = usize::try_from(number(offset, offset_length)?).ok()?;
        let entries = number(directory, count_length)?.min(MOST_ENTRIES) as usize;
        (0..entries).find_map(|index| {
            let entry = directory + count_length + index * entry_length;
            let is_short = number(entry + 2, 2)? == 3;
            (number(entry, 2)? == u64::from(tag) && is_short).then_some(Self {
                at: entry + entry_length - offset_length,
                big_endian,
            })
        })
    }

    /// The number.
    pub(super) fn value(self, bytes: &[u8]) -> u16 {
        let pair = bytes.get(self.at..).and_then(|rest| rest.first_chunk());
        let pair = pair.copied().unwrap_or_default();
        match self.big_endian {
            true => u16::from_be_bytes(pair),
            false => u16::from_le_bytes(pair),
        }
    }

    /// Puts another number in its place.
    pub(super) fn set(self, bytes: &mut [u8], value: u16) {
        let pair = match self.big_endian {
            true => value.to_be_bytes(),
            false => value.to_le_bytes(),
        };
        if let Some(place) = bytes.get_mut(self.at..self.at + 2) {
            place.copy_from_slice(&pair);
        }
    }
}
