//! The rows of an element, ascii or binary, through `ply-rs-bw`.

use std::io::{self, BufRead};

use ply_rs_bw::parser::{ParseError, Parser};
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult};

use crate::error::{Error, Result};
use crate::format::ply::preamble::LineEnd;

/// A fault in the parser's own words.
pub(super) fn fault(place: impl Into<String>, error: &dyn std::fmt::Display) -> Error {
    Error::data(place, error.to_string()).advice("the file is truncated, or not a valid PLY file")
}

/// Reads the rows of one element, in either encoding.
pub(super) struct Rows<'a> {
    parser: &'a Parser<Record>,
    encoding: Encoding,
    pub element: &'a ElementDef,
    line_end: LineEnd,
    line: Vec<u8>,
}

impl<'a> Rows<'a> {
    pub fn new(
        parser: &'a Parser<Record>,
        encoding: Encoding,
        element: &'a ElementDef,
        line_end: LineEnd,
    ) -> Self {
        Self {
            parser,
            encoding,
            element,
            line_end,
            line: Vec::new(),
        }
    }

    /// The next row, which is number `row`.
    pub fn next(&mut self, row: usize, source: &mut impl BufRead) -> Result<Record> {
        let record = match self.encoding {
            Encoding::Ascii => self.next_line(source),
            Encoding::BinaryLittleEndian => {
                self.parser.read_little_endian_element(source, self.element)
            }
            Encoding::BinaryBigEndian => self.parser.read_big_endian_element(source, self.element),
        };
        record.map_err(|error| fault(format!("{} {row}", self.element.name), &error))
    }

    fn next_line(&mut self, source: &mut impl BufRead) -> std::result::Result<Record, ParseError> {
        self.line.clear();
        while self.line.trim_ascii().is_empty() {
            self.line.clear();
            if source.read_until(self.line_end.last_byte(), &mut self.line)? == 0 {
                return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
            }
        }
        let line = String::from_utf8_lossy(self.line.trim_ascii());
        self.parser.read_ascii_element(&line, self.element)
    }
}

/// One row of any element: its scalars in order, and its lists of vertex indices and texture coordinates.
#[derive(Debug)]
pub(super) struct Record {
    pub scalars: [f64; Self::MOST_SCALARS],
    filled: usize,
    indices: Option<Property>,
    texture: Option<Property>,
}

impl Record {
    /// The vertex indices of a face; `None` where there is no list, or a negative number in it.
    pub fn indices(&self) -> Option<Vec<u32>> {
        self.indices.as_ref()?.to_u32_list()
    }

    /// The vertex indices of strips, which −1 parts.
    pub fn strips(&self) -> Option<Vec<Vec<u32>>> {
        let signed = match self.indices.as_ref()? {
            Property::ListChar(list) => list.iter().map(|&v| i64::from(v)).collect(),
            Property::ListShort(list) => list.iter().map(|&v| i64::from(v)).collect(),
            Property::ListInt(list) => list.iter().map(|&v| i64::from(v)).collect(),
            unsigned => unsigned.to_u32_list()?.into_iter().map(i64::from).collect(),
        };
        let signed: Vec<i64> = signed;
        let strips = signed.split(|&index| index == -1);
        strips
            .map(|strip| {
                strip
                    .iter()
                    .map(|&index| u32::try_from(index).ok())
                    .collect()
            })
            .collect()
    }

    /// Texture coordinates of a face's corners; `None` where there are none, or not two numbers for each.
    pub fn texture_coordinates(&self, corners: usize) -> Option<Vec<[f32; 2]>> {
        let numbers: Vec<f32> = match self.texture.as_ref()? {
            Property::ListFloat(list) => list.clone(),
            Property::ListDouble(list) => list.iter().map(|&v| v as f32).collect(),
            _ => return None,
        };
        (numbers.len() == 2 * corners)
            .then(|| numbers.chunks_exact(2).map(|uv| [uv[0], uv[1]]).collect())
    }

    /// Scalars that a row may have.
    pub const MOST_SCALARS: usize = 64;

    fn push(&mut self, value: f64) -> PropertyAccessResult {
        if let Some(slot) = self.scalars.get_mut(self.filled) {
            *slot = value;
            self.filled += 1;
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Record {
    fn new() -> Self {
        Self {
            scalars: [0.0; Self::MOST_SCALARS],
            filled: 0,
            indices: None,
            texture: None,
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match property {
            Property::Char(v) => self.push(v.into()),
            Property::UChar(v) => self.push(v.into()),
            Property::Short(v) => self.push(v.into()),
            Property::UShort(v) => self.push(v.into()),
            Property::Int(v) => self.push(v.into()),
            Property::UInt(v) => self.push(v.into()),
            Property::Float(v) => self.push(v.into()),
            Property::Double(v) => self.push(v),
            list if matches!(name, "vertex_indices" | "vertex_index") => {
                self.indices = Some(list);
                PropertyAccessResult::Set
            }
            list if name == "texcoord" => {
                self.texture = Some(list);
                PropertyAccessResult::Set
            }
            _ => PropertyAccessResult::Ignored,
        }
    }
}
