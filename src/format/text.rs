//! Text files as other programs write them: UTF-8, UTF-16 or Latin-1, with or without a byte order mark.

use std::fs;
use std::path::Path;

use crate::error::{Error, Result};

/// How the bytes of a text stand for characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextEncoding {
    /// UTF-8.
    Utf8,
    /// UTF-16 of either byte order.
    Utf16,
    /// One byte per character: what is no UTF-8 is taken as this.
    Latin1,
}

/// A text with the encoding it was stored in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text {
    /// The text, without a byte order mark, lines ended by `\n` alone.
    pub text: String,
    /// How it was stored.
    pub encoding: TextEncoding,
}

/// Reads a text file of at most `limit` bytes.
pub fn read(path: &Path, limit: u64) -> Result<Text> {
    let size = fs::metadata(path).map_err(Error::io(path, "read"))?.len();
    if size > limit {
        return Err(Error::data("size", format!("{size} bytes of text"))
            .expected(format!("at most {limit}"))
            .in_file(path));
    }
    let bytes = fs::read(path).map_err(Error::io(path, "read"))?;
    decode(&bytes).map_err(|error| error.in_file(path))
}

/// The text that bytes stand for. A byte order mark decides; without one, zero bytes show UTF-16, and
/// what is no UTF-8 is Latin-1.
pub fn decode(bytes: &[u8]) -> Result<Text> {
    let mut decoded = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => utf8(rest),
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [0, _, ..] if has_no_odd_zero(bytes, 1) => utf16(bytes, u16::from_be_bytes),
        [_, 0, ..] if has_no_odd_zero(bytes, 0) => utf16(bytes, u16::from_le_bytes),
        _ => utf8(bytes),
    }?;
    if decoded.text.contains('\r') {
        decoded.text = decoded.text.replace("\r\n", "\n").replace('\r', "\n");
    }
    Ok(decoded)
}

/// Whether none of the first bytes at places of this parity is zero, as in UTF-16 of Latin letters.
fn has_no_odd_zero(bytes: &[u8], parity: usize) -> bool {
    let mut start = bytes.iter().take(64).skip(parity).step_by(2);
    start.all(|&byte| byte != 0)
}

fn utf8(bytes: &[u8]) -> Result<Text> {
    if bytes.contains(&0) {
        return Err(Error::data("text", "zero bytes").expected("text in UTF-8, UTF-16 or Latin-1"));
    }
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => Text {
            text: text.to_owned(),
            encoding: TextEncoding::Utf8,
        },
        Err(_) => Text {
            text: bytes.iter().map(|&byte| char::from(byte)).collect(),
            encoding: TextEncoding::Latin1,
        },
    })
}

fn utf16(bytes: &[u8], number: impl Fn([u8; 2]) -> u16) -> Result<Text> {
    let pairs = bytes.chunks_exact(2);
    let is_cut = !pairs.remainder().is_empty();
    let units: Vec<u16> = pairs.map(|pair| number([pair[0], pair[1]])).collect();
    match String::from_utf16(&units) {
        Ok(text) if !is_cut => Ok(Text {
            text,
            encoding: TextEncoding::Utf16,
        }),
        _ => Err(Error::data("text", "broken UTF-16").expected("text in UTF-8, UTF-16 or Latin-1")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16_bytes(text: &str, bytes: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let wanted = "6\nMünze 1.jpg 0 0 1\n";
        let stored = wanted.replacen('\n', "\r\n", 1);
        let marked = format!("\u{feff}{stored}");
        let latin: Vec<u8> = stored.chars().map(|c| c as u8).collect();
        for (bytes, encoding) in [
            (stored.as_bytes().to_vec(), TextEncoding::Utf8),
            (marked.as_bytes().to_vec(), TextEncoding::Utf8),
            (utf16_bytes(&marked, u16::to_le_bytes), TextEncoding::Utf16),
            (utf16_bytes(&marked, u16::to_be_bytes), TextEncoding::Utf16),
            (utf16_bytes(&stored, u16::to_le_bytes), TextEncoding::Utf16),
            (utf16_bytes(&stored, u16::to_be_bytes), TextEncoding::Utf16),
            (latin, TextEncoding::Latin1),
        ] {
            let found = decode(&bytes).unwrap();
            assert_eq!((found.text.as_str(), found.encoding), (wanted, encoding));
        }
    }

    #[test]
    fn what_is_no_text_is_refused() {
        assert!(decode(b"a.png\0\0\0 0 0 1").is_err());
        assert!(decode(b"\xff\xfea").is_err());
        assert_eq!(decode(b"").unwrap().text, "");
    }
}
