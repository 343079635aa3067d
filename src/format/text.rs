//! Text files as programs write them: with or without a byte order mark, in any of the usual encodings,
//! lines ended by line feeds, carriage returns or both.

use std::borrow::Cow;

/// The text of a file.
///
/// A byte order mark says UTF-8 or UTF-16 and is left out. Without one, bytes that are no UTF-8 are taken
/// as Latin-1, so that a name or comment in it costs no number.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => String::from_utf8_lossy(rest),
        [0xFF, 0xFE, rest @ ..] => utf16(rest, u16::from_le_bytes).into(),
        [0xFE, 0xFF, rest @ ..] => utf16(rest, u16::from_be_bytes).into(),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => text.into(),
            Err(_) => latin1(bytes).into(),
        },
    }
}

/// Bytes of Latin-1 as text.
pub fn latin1(bytes: &[u8]) -> String {
    bytes.iter().map(|&byte| char::from(byte)).collect()
}

fn utf16(bytes: &[u8], unit: impl Fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units)
        .map(|found| found.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_usual_encoding_is_read() {
        assert_eq!(decode(b"\xEF\xBB\xBFv 1"), "v 1");
        assert_eq!(decode(b"\xFF\xFEv\0 \0"), "v ");
        assert_eq!(decode(b"\xFE\xFF\0v\0 "), "v ");
        assert_eq!(decode(b"# caf\xE9"), "# café");
        assert_eq!(decode("# café".as_bytes()), "# café");
    }

    #[test]
    fn lines_end_in_any_way() {
        let found: Vec<_> = lines("a\nb\r\nc\rd\n\ne").collect();
        let expected = [(1, "a"), (2, "b"), (3, "c"), (4, "d"), (5, ""), (6, "e")];
        assert_eq!(found, expected);
        assert_eq!(lines("").count(), 0);
        assert_eq!(lines("a\n").count(), 1);
    }
}
