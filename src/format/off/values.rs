//! The words of an OFF file, without comments, with the lines they stand on.

use crate::error::{Error, Result};

/// What is left of a file.
#[derive(Clone)]
pub(super) struct Values<'a> {
    rest: &'a str,
    /// The line that `rest` begins in.
    line: usize,
    /// The line of the word taken last.
    last: usize,
    /// The line that numbers are kept to.
    kept_to: Option<usize>,
}

impl<'a> Values<'a> {
    pub fn new(text: &'a str) -> Self {
        Self {
            rest: text,
            line: 1,
            last: 1,
            kept_to: None,
        }
    }

    /// Goes to the next word: past white space, line ends and comments.
    fn seek(&mut self) {
        let bytes = self.rest.as_bytes();
        let mut at = 0;
        while let Some(&byte) = bytes.get(at) {
            match byte {
                b'#' => {
                    let comment = bytes[at..].iter();
                    at += comment.take_while(|b| !matches!(b, b'\n' | b'\r')).count();
                    continue;
                }
                b'\r' if bytes.get(at + 1) == Some(&b'\n') => {}
                b'\n' | b'\r' => self.line += 1,
                _ if byte.is_ascii_whitespace() => {}
                _ => break,
            }
            at += 1;
        }
        self.rest = &self.rest[at..];
    }

    /// The next word, not taken.
    pub fn peek(&mut self) -> Option<&'a str> {
        self.seek();
        let ends = |byte: u8| byte == b'#' || byte.is_ascii_whitespace();
        let end = self.rest.bytes().position(ends).unwrap_or(self.rest.len());
        Some(&self.rest[..end]).filter(|word| !word.is_empty())
    }

    /// Takes the first `length` bytes of the next word.
    pub fn take(&mut self, length: usize) {
        self.last = self.line;
        self.rest = &self.rest[length..];
    }

    /// The line of the word taken last.
    pub fn place(&self) -> String {
        format!("line {}", self.last)
    }

    /// Takes a number. One that does not wrap stands on the line where the item began.
    pub fn number<T: std::str::FromStr>(&mut self, wraps: bool) -> Result<T> {
        let word = self.peek();
        let line = *self.kept_to.get_or_insert(self.line);
        let Some(word) = word.filter(|_| wraps || line == self.line) else {
            return Err(Error::data(self.place(), "the line ends early").expected("a number"));
        };
        self.take(word.len());
        word.parse()
            .map_err(|_| Error::data(self.place(), format!("`{word}`")).expected("a number"))
    }

    /// Ends an item, and passes over the rest of its last line.
    pub fn end_line(&mut self) {
        while self.peek().is_some() && self.line == self.last {
            let length = self.peek().map_or(0, str::len);
            self.take(length);
        }
        self.kept_to = None;
    }

    /// Refuses the end of the file.
    pub fn check_left(&mut self, expected: impl FnOnce() -> String) -> Result<()> {
        match self.peek() {
            Some(_) => Ok(()),
            None => Err(Error::data("end of file", "the file is truncated").expected(expected())),
        }
    }

    /// Refuses anything that is left.
    pub fn check_end(&mut self) -> Result<()> {
        match self.peek() {
            None => Ok(()),
            Some(word) => Err(
                Error::data(format!("line {}", self.line), format!("`{word}`"))
                    .expected("the end of the file"),
            ),
        }
    }
}
