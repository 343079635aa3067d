//! The keyword and the counts that an OFF file begins with.

use crate::error::{Error, Result};
use crate::format::off::values::Values;

/// What an OFF file says of itself.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Header {
    /// Whether it begins with a keyword, as it should.
    pub has_keyword: bool,
    /// Whether positions have a fourth number, which divides the others (4OFF).
    pub is_homogeneous: bool,
    has_normals: bool,
    has_colours: bool,
    has_texture: bool,
    /// Vertices.
    pub vertices: usize,
    /// Faces.
    pub faces: usize,
}

impl Header {
    /// Reads a header up to the count of edges, which may be missing; hands back what follows. Counts may
    /// follow the keyword on its line, even without space.
    pub fn read(mut values: Values<'_>) -> Result<(Self, Values<'_>)> {
        values.check_left(|| "an OFF file".into())?;
        // A small n before a large OFF stands for a dimension, not for normals.
        let has_dimension = values.peek().is_some_and(|word| word.contains("nOFF"));
        let mut header = Self::of_keyword(&mut values)?;
        if has_dimension {
            header.has_normals = false;
            check_dimension(&mut values)?;
        }
        header.vertices = values.number(true)?;
        header.faces = values.number(true)?;
        Ok((header, values))
    }

    /// Numbers of a position.
    pub fn position_numbers(&self) -> usize {
        3 + usize::from(self.is_homogeneous)
    }

    /// Numbers that a vertex may have: colours have four or three.
    pub fn numbers_per_vertex(&self) -> Vec<usize> {
        let numbers = self.position_numbers()
            + 3 * usize::from(self.has_normals)
            + 2 * usize::from(self.has_texture);
        match self.has_colours {
            true => vec![numbers + 4, numbers + 3],
            false => vec![numbers],
        }
    }

    fn of_keyword(values: &mut Values<'_>) -> Result<Self> {
        let first = values.peek().unwrap_or_default();
        let place = values.place();
        let refuse = |found: &str| {
            Err(Error::data(place, format!("`{found}`"))
                .expected("a text file that begins with OFF (or NOFF, COFF, STOFF …)"))
        };
        let upper = first.to_ascii_uppercase();
        let plain = Self {
            has_keyword: false,
            is_homogeneous: false,
            has_normals: false,
            has_colours: false,
            has_texture: false,
            vertices: 0,
            faces: 0,
        };
        // A file without keyword begins with its counts.
        let Some(end) = upper.find("OFF") else {
            return match first.bytes().all(|byte| byte.is_ascii_digit()) {
                true => Ok(plain),
                false => refuse(first),
            };
        };
        // The letters before OFF say what vertices have.
        let prefix = upper[..end].replace("ST", "T");
        if !prefix.bytes().all(|letter| b"NCT4".contains(&letter)) {
            return refuse(first);
        }
        values.take(end + 3);
        // Refuse the binary form.
        if let Some(word) = values
            .peek()
            .filter(|word| word.eq_ignore_ascii_case("binary"))
        {
            return Err(Error::data(values.place(), format!("`{first} {word}`"))
                .expected("a text file")
                .advice("binary OFF is not read: save it as text, or as PLY"));
        }
        Ok(Self {
            has_keyword: true,
            is_homogeneous: prefix.contains('4'),
            has_normals: prefix.contains('N'),
            has_colours: prefix.contains('C'),
            has_texture: prefix.contains('T'),
            ..plain
        })
    }
}

fn check_dimension(values: &mut Values<'_>) -> Result<()> {
    match values.number::<usize>(true)? {
        3 => Ok(()),
        found => Err(Error::data(values.place(), format!("dimension {found}"))
            .expected("positions of three numbers")),
    }
}
