//! The header of a PLY file as programs write it: lines ended in any way, comments in any encoding.

use std::io::{BufRead, Read};

use crate::error::{Error, Result};
use crate::format::text;

/// The longest header that is read, in bytes.
const LONGEST: u64 = 1 << 20;

/// How a file ends its lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LineEnd {
    /// By a line feed, perhaps behind a carriage return.
    LineFeed,
    /// By a carriage return alone.
    CarriageReturn,
}

impl LineEnd {
    /// The last byte of a line.
    pub fn last_byte(self) -> u8 {
        match self {
            Self::LineFeed => b'\n',
            Self::CarriageReturn => b'\r',
        }
    }
}

/// A header, from `ply` to `end_header`.
pub(super) struct Preamble {
    /// The header, with line feeds and without a byte order mark.
    pub text: String,
    /// How the file ends its lines.
    pub line_end: LineEnd,
}

impl Preamble {
    /// Reads a header and nothing behind it.
    pub fn read(source: &mut impl BufRead) -> Result<Self> {
        let failed = |error: std::io::Error| Error::data("header", error.to_string());
        let (mut line, line_end) = first_line(source).map_err(failed)?;
        let mut text = String::new();
        let mut left = LONGEST;
        loop {
            let found = text::utf8_or_latin1(line.trim_ascii())
                .trim_start_matches('\u{feff}')
                .trim()
                .to_owned();
            text.push_str(&found);
            text.push('\n');
            let is_ply = text.starts_with("ply");
            if found == "end_header" || line.is_empty() || !is_ply {
                return Ok(Self { text, line_end });
            }
            line.clear();
            let read = source
                .by_ref()
                .take(left)
                .read_until(line_end.last_byte(), &mut line)
                .map_err(failed)?;
            left -= read as u64;
            if left == 0 {
                return Err(Error::data("header", format!("more than {LONGEST} bytes"))
                    .expected("end_header before"));
            }
        }
    }
}

/// The first line, whose end tells that of all lines.
fn first_line(source: &mut impl BufRead) -> std::io::Result<(Vec<u8>, LineEnd)> {
    let mut line = Vec::new();
    let mut byte = [0];
    while line.len() < 64 && source.read(&mut byte)? == 1 {
        line.push(byte[0]);
        if byte[0] == b'\n' {
            return Ok((line, LineEnd::LineFeed));
        }
        if byte[0] == b'\r' {
            let follows = source.fill_buf()?.first() == Some(&b'\n');
            source.consume(usize::from(follows));
            let end = match follows {
                true => LineEnd::LineFeed,
                false => LineEnd::CarriageReturn,
            };
            return Ok((line, end));
        }
    }
    Ok((line, LineEnd::LineFeed))
}
