//! Headers in text before the bytes of a fit: words separated by blanks and line ends, in lines of any length.

use std::str::FromStr;

use crate::error::{Error, Result};

/// The longest word or line of a header.
const LONGEST: usize = 256;
/// The most texels a fit may have: 16384 × 16384, as images.
const MOST_TEXELS: u64 = 1 << 28;

/// A header being read.
#[derive(Debug)]
pub(super) struct Header<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Header<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The rest of the line, without blanks around it, and passes its end. `None` where nothing is left.
    pub(super) fn line(&mut self, what: &str) -> Result<&'a str> {
        let rest = &self.bytes[self.at..];
        let shown = &rest[..rest.len().min(LONGEST)];
        let end = shown.iter().position(|&byte| byte == b'\n');
        let line = end.and_then(|end| std::str::from_utf8(&shown[..end]).ok());
        let (Some(end), Some(line)) = (end, line) else {
            return Err(Error::data(what, "no line of text").expected("a header in text"));
        };
        self.at += end + 1;
        Ok(line.trim())
    }

    /// Whether the next line begins with `#`.
    pub(super) fn is_at_comment(&self) -> bool {
        self.bytes.get(self.at) == Some(&b'#')
    }

    /// The next word, read as a number.
    pub(super) fn number<T: FromStr>(&mut self, what: &str, expected: &str) -> Result<T> {
        let is_blank = |byte: &&u8| byte.is_ascii_whitespace();
        let rest = &self.bytes[self.at..];
        let skipped = rest.iter().take(LONGEST).take_while(is_blank).count();
        let rest = &rest[skipped..];
        let length = rest
            .iter()
            .take(LONGEST)
            .take_while(|byte| !is_blank(byte))
            .count();
        let word = String::from_utf8_lossy(&rest[..length]);
        self.at += skipped + length;
        word.parse()
            .map_err(|_| Error::data(what, format!("`{}`", word.escape_debug())).expected(expected))
    }

    /// A finite number.
    pub(super) fn float(&mut self, what: &str) -> Result<f32> {
        let number: f32 = self.number(what, "a number")?;
        match number.is_finite() {
            true => Ok(number),
            false => Err(Error::data(what, number.to_string()).expected("a finite number")),
        }
    }

    /// Columns and rows.
    pub(super) fn sides(&mut self) -> Result<(u32, u32)> {
        let width: u32 = self.number("width", "columns")?;
        let height: u32 = self.number("height", "rows")?;
        match u64::from(width) * u64::from(height) {
            1..=MOST_TEXELS => Ok((width, height)),
            _ => Err(Error::data("size", format!("{width} × {height}"))
                .expected(format!("1 to {MOST_TEXELS} texels"))),
        }
    }

    /// The bytes behind the header: blanks and one line end are passed.
    pub(super) fn end(self) -> Result<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let blanks = rest
            .iter()
            .take(LONGEST)
            .take_while(|byte| b" \t\r".contains(byte))
            .count();
        match rest.get(blanks) {
            Some(b'\n') => Ok(&rest[blanks + 1..]),
            _ => Err(Error::data("header", "more on its last line").expected("the line's end")),
        }
    }
}

/// Takes the first `count` bytes; says how many there are where that is fewer.
pub(super) fn take<'a>(bytes: &mut &'a [u8], count: u64, what: &str) -> Result<&'a [u8]> {
    let taken = usize::try_from(count)
        .ok()
        .and_then(|count| bytes.split_at_checked(count));
    let Some((taken, rest)) = taken else {
        return Err(Error::data(what, format!("{} bytes", bytes.len()))
            .expected(format!("{count} bytes, by the header"))
            .advice("the file is truncated, or its header states another size"));
    };
    *bytes = rest;
    Ok(taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_may_stand_on_one_line_or_several() {
        for text in [
            "A \r\n3 2\n1.5 -2 \nxyz",
            "A\n3\n2\n1.5\t-2\nxyz",
            "A\n3 2 1.5 -2 \r\nxyz",
        ] {
            let mut header = Header::new(text.as_bytes());
            assert_eq!(header.line("first").unwrap(), "A");
            assert_eq!(header.sides().unwrap(), (3, 2));
            assert_eq!(header.float("a").unwrap(), 1.5);
            assert_eq!(header.number::<i32>("b", "").unwrap(), -2);
            assert_eq!(header.end().unwrap(), b"xyz");
        }
    }

    #[test]
    fn broken_headers_are_refused_by_field() {
        let sides = |text: &str| {
            Header::new(text.as_bytes())
                .sides()
                .unwrap_err()
                .to_string()
        };
        assert!(sides("x 3\n").contains("width: `x`"));
        assert!(sides("3").contains("height"));
        assert!(sides("0 3\n").contains("0 × 3"));
        assert!(sides("4000000000 4000000000\n").contains("texels"));
        assert!(Header::new(b"\xff\xfe\n").line("format").is_err());
        assert!(Header::new(b"nan ").float("scale").is_err());
        assert!(Header::new(b" 3\n").end().is_err());
        let mut bytes = &b"abc"[..];
        assert_eq!(take(&mut bytes, 2, "x").unwrap(), b"ab");
        assert!(
            take(&mut bytes, 2, "x")
                .unwrap_err()
                .to_string()
                .contains("1 bytes")
        );
    }
}
