//! Files of the Unix program `compress`, ending `.Z`: LZW with codes of 9 to 16 bits.
//!
//! Codes are packed from the lowest bit on, in groups of eight. When codes grow longer, and after the code
//! that clears the table, the rest of a group is filler. Written after the format's public description
//! (the manual and the behaviour of `compress` and `gzip`).

use crate::error::{Error, Result};

/// What a file begins with.
pub const SIGNATURE: [u8; 2] = [0x1f, 0x9d];

/// Bits of the first codes.
const SHORTEST: u32 = 9;
/// Bits of the longest codes of a file. What `compress -b 9` writes, no program expands.
const LONGEST: std::ops::RangeInclusive<u32> = 10..=16;
/// The code that clears the table, where the file has one.
const CLEAR: u32 = 256;
/// Expanded bytes allowed for each byte of the file, beside [`EXPANSION_BASE`].
const EXPANSION_FACTOR: usize = 256;
/// Expanded bytes allowed in any case.
const EXPANSION_BASE: usize = 32 << 20;

/// Whether bytes begin as a compressed file.
pub fn is_compressed(bytes: &[u8]) -> bool {
    bytes.starts_with(&SIGNATURE)
}

/// Expands a whole file.
pub fn expand(bytes: &[u8]) -> Result<Vec<u8>> {
    let [_, _, flags, codes @ ..] = bytes else {
        return Err(Error::data("header", "the end of the file").expected("3 bytes"));
    };
    let longest = u32::from(flags & 0x1f);
    if !is_compressed(bytes) || !LONGEST.contains(&longest) || flags & 0x60 != 0 {
        return Err(Error::data("header", format!("flags {flags:#04x}"))
            .expected("codes of at most 10 to 16 bits, as `compress` writes"));
    }
    let most = bytes.len() * EXPANSION_FACTOR + EXPANSION_BASE;
    let mut table = Table::new(longest, flags & 0x80 != 0);
    let mut reader = Codes::new(codes);
    let mut out = Vec::new();
    while let Some(code) = reader.next(&mut table) {
        if table.clears && code == CLEAR {
            table.clear();
            reader.end_group(SHORTEST);
            continue;
        }
        table.put(code, &mut out)?;
        if out.len() > most {
            return Err(Error::data("file", "it expands too far").expected(format!(
                "at most {EXPANSION_FACTOR} bytes per byte of the file"
            )));
        }
    }
    Ok(out)
}

/// The codes of a file.
struct Codes<'a> {
    bytes: &'a [u8],
    /// The next bit, and the bit at which codes took their present length.
    at: usize,
    since: usize,
    bits: u32,
}

impl<'a> Codes<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            since: 0,
            bits: SHORTEST,
        }
    }

    /// The next code, of the length that the table asks for; `None` at the end.
    fn next(&mut self, table: &mut Table) -> Option<u32> {
        if table.needs_more_than(self.bits) {
            self.end_group(self.bits + 1);
        }
        let end = self.at + self.bits as usize;
        if end > self.bytes.len() * 8 {
            return None;
        }
        let window = &self.bytes[self.at / 8..end.div_ceil(8)];
        let held = window
            .iter()
            .rev()
            .fold(0_u32, |held, &byte| held << 8 | u32::from(byte));
        let code = held >> (self.at % 8) & ((1 << self.bits) - 1);
        self.at = end;
        Some(code)
    }

    /// Passes what is left of a group of eight codes; the next ones have `bits` bits.
    fn end_group(&mut self, bits: u32) {
        let group = self.bits as usize * 8;
        self.at = self.since + (self.at - self.since).next_multiple_of(group);
        self.since = self.at;
        self.bits = bits;
    }
}

/// The strings that codes stand for: each is another one and a byte.
struct Table {
    prefixes: Vec<u16>,
    suffixes: Vec<u8>,
    longest: u32,
    clears: bool,
    /// The code before, and the first byte of its string.
    last: Option<(u32, u8)>,
    /// The string under way, from its end.
    string: Vec<u8>,
}

impl Table {
    fn new(longest: u32, clears: bool) -> Self {
        let first = if clears { 257 } else { 256 };
        Self {
            prefixes: vec![0; first],
            suffixes: (0..first).map(|code| code as u8).collect(),
            longest,
            clears,
            last: None,
            string: Vec::new(),
        }
    }

    /// The code that the next string gets.
    fn next(&self) -> u32 {
        self.prefixes.len() as u32
    }

    fn needs_more_than(&self, bits: u32) -> bool {
        bits < self.longest && self.next() >= 1 << bits
    }

    /// Forgets all strings of more than a byte. The next code's string takes the place of the clearing
    /// code, where nothing refers to it.
    fn clear(&mut self) {
        self.prefixes.truncate(CLEAR as usize);
        self.suffixes.truncate(CLEAR as usize);
    }

    /// Appends the string of a code, and learns a new one.
    fn put(&mut self, code: u32, out: &mut Vec<u8>) -> Result<()> {
        let fault = || {
            Error::data(
                "codes",
                format!("code {code} where {} are known", self.next()),
            )
            .expected("a sound file")
        };
        let Some((last, last_first)) = self.last else {
            let byte = u8::try_from(code).map_err(|_| fault())?;
            out.push(byte);
            self.last = Some((code, byte));
            return Ok(());
        };
        if code > self.next() {
            return Err(fault());
        }
        self.string.clear();
        let mut rest = code;
        if code == self.next() {
            self.string.push(last_first);
            rest = last;
        }
        while rest >= CLEAR {
            self.string.push(self.suffixes[rest as usize]);
            rest = u32::from(self.prefixes[rest as usize]);
        }
        let first = rest as u8;
        out.push(first);
        out.extend(self.string.iter().rev());
        if self.next() < 1 << self.longest {
            self.prefixes.push(last as u16);
            self.suffixes.push(first);
        }
        self.last = Some((code, first));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Packs codes as `compress` does, each with the number of bits it is written in; a change of length
    /// ends a group.
    fn packed(flags: u8, codes: &[(u32, usize)]) -> Vec<u8> {
        let (mut bits, mut since, mut length): (Vec<bool>, usize, usize) = (Vec::new(), 0, 9);
        let fill = |bits: &mut Vec<bool>, since: usize, length: usize| {
            let group = length * 8;
            let whole = since + (bits.len() - since).next_multiple_of(group);
            bits.resize(whole, false);
        };
        for &(code, wanted) in codes {
            if wanted != length {
                fill(&mut bits, since, length);
                (since, length) = (bits.len(), wanted);
            }
            bits.extend((0..length).map(|bit| code >> bit & 1 == 1));
            if code == CLEAR {
                fill(&mut bits, since, length);
                since = bits.len();
            }
        }
        let byte = |bits: &[bool]| {
            bits.iter()
                .rev()
                .fold(0, |held, &bit| held << 1 | u8::from(bit))
        };
        let mut bytes = vec![0x1f, 0x9d, flags];
        bytes.extend(bits.chunks(8).map(byte));
        bytes
    }

    /// Compresses without ever finding a string of more than a byte: every byte is its own code.
    fn literal(text: &[u8], longest: u32) -> Vec<u8> {
        let length = |at: usize| {
            let known = 257 + at.saturating_sub(1) as u32;
            (SHORTEST..longest)
                .find(|&bits| known < 1 << bits)
                .unwrap_or(longest) as usize
        };
        let codes: Vec<(u32, usize)> = text
            .iter()
            .enumerate()
            .map(|(at, &byte)| (u32::from(byte), length(at)))
            .collect();
        packed(0x80 | longest as u8, &codes)
    }

    #[test]
    fn a_file_of_compress_is_expanded() {
        // What `compress` 4.2.4 makes of twenty letters: a, aa, aaa … each the code before and a byte.
        let bytes = b"\x1f\x9d\x90\x61\x02\x0a\x1c\x48\x90\x20";
        assert_eq!(expand(bytes).unwrap(), [b'a'; 20]);
    }

    #[test]
    fn codes_grow_and_tables_are_cleared() {
        let text: Vec<u8> = (0..3000_u32).map(|k| (k * k % 251) as u8).collect();
        for longest in [10, 12, 16] {
            assert_eq!(expand(&literal(&text, longest)).unwrap(), text, "{longest}");
        }
        let bytes = packed(
            0x90,
            &[(97, 9), (98, 9), (256, 9), (99, 9), (100, 9), (257, 9)],
        );
        assert_eq!(expand(&bytes).unwrap(), b"abcdcd");
    }

    #[test]
    fn broken_files_are_refused() {
        let refused = |bytes: &[u8]| expand(bytes).unwrap_err().to_string();
        assert!(refused(b"\x1f\x9d").contains("end of the file"));
        assert!(refused(b"\x1f\x9d\x91\0").contains("0x91"));
        assert!(refused(b"\x1f\x8b\x90\0").contains("10 to 16 bits"));
        let unknown = packed(0x90, &[(97, 9), (300, 9)]);
        assert!(refused(&unknown).contains("code 300"));
        let first = packed(0x90, &[(300, 9)]);
        assert!(refused(&first).contains("code 300"));
    }
}
