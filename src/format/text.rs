//! Text files as other programs write them: UTF-8, UTF-16 or Latin-1, with or without a byte order mark,
//! lines ended by line feeds, carriage returns or both.

use std::borrow::Cow;
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
pub struct Text<'a> {
    /// The text, without a byte order mark.
    pub text: Cow<'a, str>,
    /// How it was stored.
    pub encoding: TextEncoding,
}

/// Reads a text file of at most `limit` bytes; its lines are ended by `\n` alone.
pub fn read(path: &Path, limit: u64) -> Result<Text<'static>> {
    let size = fs::metadata(path).map_err(Error::io(path, "read"))?.len();
    if size > limit {
        return Err(Error::data("size", format!("{size} bytes of text"))
            .expected(format!("at most {limit}"))
            .in_file(path));
    }
    let bytes = fs::read(path).map_err(Error::io(path, "read"))?;
    of_bytes(&bytes).map_err(|error| error.in_file(path))
}

/// The text of a file that is in memory; its lines are ended by `\n` alone.
pub fn of_bytes(bytes: &[u8]) -> Result<Text<'static>> {
    let Text { text, encoding } = decode(bytes)?;
    let text = match text.contains('\r') {
        true => text.replace("\r\n", "\n").replace('\r', "\n"),
        false => text.into_owned(),
    };
    Ok(Text {
        text: text.into(),
        encoding,
    })
}

/// The text that bytes stand for. A byte order mark decides; without one, zero bytes show UTF-16, and
/// what is no UTF-8 is Latin-1.
pub fn decode(bytes: &[u8]) -> Result<Text<'_>> {
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => one_byte(rest),
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [0, _, ..] if has_no_odd_zero(bytes, 1) => utf16(bytes, u16::from_be_bytes),
        [_, 0, ..] if has_no_odd_zero(bytes, 0) => utf16(bytes, u16::from_le_bytes),
        _ => one_byte(bytes),
    }
}

/// Bytes without zeros as UTF-8, or else as Latin-1: a name or comment in it costs no number.
pub fn utf8_or_latin1(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// The lines of a text, each with its number, counted from 1.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let text = rest.filter(|text| !text.is_empty())?;
        let end = text.bytes().position(|byte| matches!(byte, b'\n' | b'\r'));
        let (line, after) = match end {
            None => (text, None),
            Some(end) => {
                let pair = text.as_bytes()[end..].starts_with(b"\r\n");
                (&text[..end], Some(&text[end + 1 + usize::from(pair)..]))
            }
        };
        rest = after;
        Some(line)
    })
    .zip(1..)
    .map(|(line, number)| (number, line))
}

/// Whether none of the first bytes at places of this parity is zero, as in UTF-16 of Latin letters.
fn has_no_odd_zero(bytes: &[u8], parity: usize) -> bool {
    let mut start = bytes.iter().take(64).skip(parity).step_by(2);
    start.all(|&byte| byte != 0)
}

fn one_byte(bytes: &[u8]) -> Result<Text<'_>> {
    if bytes.contains(&0) {
        return Err(Error::data("text", "zero bytes").expected("text in UTF-8, UTF-16 or Latin-1"));
    }
    let text = utf8_or_latin1(bytes);
    let encoding = match text {
        Cow::Borrowed(_) => TextEncoding::Utf8,
        Cow::Owned(_) => TextEncoding::Latin1,
    };
    Ok(Text { text, encoding })
}

fn utf16(bytes: &[u8], number: impl Fn([u8; 2]) -> u16) -> Result<Text<'_>> {
    let pairs = bytes.chunks_exact(2);
    let is_cut = !pairs.remainder().is_empty();
    let units: Vec<u16> = pairs.map(|pair| number([pair[0], pair[1]])).collect();
    match String::from_utf16(&units) {
        Ok(text) if !is_cut => Ok(Text {
            text: text.into(),
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
        let stored = "6\r\nMünze 1.jpg 0 0 1\n";
        let marked = format!("\u{feff}{stored}");
        let latin: Vec<u8> = stored.chars().map(|c| c as u8).collect();
        for (bytes, encoding) in [
            (stored.as_bytes().to_vec(), TextEncoding::Utf8),
            (marked.as_bytes().to_vec(), TextEncoding::Utf8),
            (utf16_bytes(&marked, u16::to_le_bytes), TextEncoding::Utf16),
            (utf16_bytes(&marked, u16::to_be_bytes), TextEncoding::Utf16),
            (utf16_bytes(stored, u16::to_le_bytes), TextEncoding::Utf16),
            (utf16_bytes(stored, u16::to_be_bytes), TextEncoding::Utf16),
            (latin, TextEncoding::Latin1),
        ] {
            let found = decode(&bytes).unwrap();
            assert_eq!((&*found.text, found.encoding), (stored, encoding));
        }
    }

    #[test]
    fn what_is_no_text_is_refused() {
        assert!(decode(b"a.png\0\0\0 0 0 1").is_err());
        assert!(decode(b"\xff\xfea").is_err());
        assert_eq!(decode(b"").unwrap().text, "");
    }

    #[test]
    fn lines_end_in_any_way() {
        let text = "a\nb\r\nc\rd\n\ne";
        let found: Vec<_> = lines(text).collect();
        let expected = [(1, "a"), (2, "b"), (3, "c"), (4, "d"), (5, ""), (6, "e")];
        assert_eq!(found, expected);
        assert_eq!(lines("").count(), 0);
        assert_eq!(lines("a\n").count(), 1);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, text).unwrap();
        assert_eq!(read(&path, 100).unwrap().text, "a\nb\nc\nd\n\ne");
        assert!(read(&path, 3).is_err());
    }
}
