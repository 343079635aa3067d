//! Tables of numbers with a header, as spreadsheets write them: columns separated by commas, semicolons or tabs,
//! decimal commas where the columns are not separated by them, names in any case.

use crate::error::{Error, Result};

/// What may part columns.
const DELIMITERS: [u8; 3] = [b',', b';', b'\t'];

/// A table in memory.
#[derive(Debug)]
pub(in crate::btf) struct Table {
    /// Names of the columns in lower case, words joined by `_`.
    columns: Vec<String>,
    /// The header as it stands, for errors.
    header: String,
    pub(in crate::btf) rows: Vec<Row>,
    delimiter: u8,
}

/// A row with the line it stands on, counted from 1.
#[derive(Debug)]
pub(in crate::btf) struct Row {
    pub(in crate::btf) line: u64,
    fields: Vec<String>,
}

impl Table {
    /// Reads a table. Empty lines, lines that begin with `#` and a first line `sep=…` are left out.
    pub(in crate::btf) fn parse(text: &str) -> Result<Self> {
        // Find the delimiter.
        let (text, skipped, given) = after_sep_line(text.trim_start_matches('\u{feff}'));
        let is_content = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
        let header = text.lines().find(is_content).unwrap_or_default();
        let delimiter = given.unwrap_or_else(|| likely_delimiter(header));
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .comment(Some(b'#'))
            .flexible(true)
            .trim(csv::Trim::All)
            .has_headers(false)
            .from_reader(text.as_bytes());
        let mut rows = Vec::new();
        let mut lines = Lines::new(text, skipped);
        for record in reader.records() {
            let record = record.map_err(|error| Error::data("table", error.to_string()))?;
            let line = lines.of(record
                .position()
                .map_or(0, |position| position.byte() as usize));
            let fields: Vec<String> = record.iter().map(str::to_owned).collect();
            if fields.iter().any(|field| !field.is_empty()) {
                rows.push(Row { line, fields });
            }
        }
        if rows.is_empty() {
            return Err(
                Error::data("header", "nothing").expected("a line with the names of the columns")
            );
        }
        let columns = rows
            .remove(0)
            .fields
            .iter()
            .map(|name| plain(name))
            .collect();
        Ok(Self {
            columns,
            header: header.trim().to_owned(),
            rows,
            delimiter,
        })
    }

    /// The place of the column that has one of these names; `None` where there is none.
    pub(in crate::btf) fn find(&self, names: &[&str]) -> Result<Option<usize>> {
        let is_named = |place: &usize| names.contains(&self.columns[*place].as_str());
        let mut found = (0..self.columns.len()).filter(is_named);
        match (found.next(), found.next()) {
            (Some(_), Some(_)) => Err(Error::data("header", format!("`{}`", self.header))
                .expected(format!("one column {}", names[0]))),
            (place, _) => Ok(place),
        }
    }

    /// The places of all these columns.
    pub(in crate::btf) fn find_all<const N: usize>(
        &self,
        wanted: [&[&str]; N],
    ) -> Result<[usize; N]> {
        let mut places = [0; N];
        for (place, names) in places.iter_mut().zip(wanted) {
            *place = self.find(names)?.ok_or_else(|| {
                let all: Vec<&str> = wanted.iter().map(|names| names[0]).collect();
                Error::data("header", format!("`{}` has no {}", self.header, names[0]))
                    .expected(format!("the columns {}", all.join(", ")))
            })?;
        }
        Ok(places)
    }

    /// A field of a row; empty where the row ends before it.
    pub(in crate::btf) fn text<'a>(&self, row: &'a Row, column: usize) -> &'a str {
        row.fields.get(column).map_or("", String::as_str)
    }

    /// A finite number of a row.
    pub(in crate::btf) fn number(&self, row: &Row, column: usize) -> Result<f64> {
        let field = self.text(row, column);
        let number: Option<f64> = match self.delimiter {
            b',' => field.parse().ok(),
            _ => number_with_comma(field),
        };
        number.filter(|number| number.is_finite()).ok_or_else(|| {
            let place = format!("line {}: {}", row.line, self.columns[column]);
            Error::data(place, format!("`{field}`")).expected("a number")
        })
    }
}

/// Counts the lines of a text up to places that come in order.
struct Lines<'a> {
    text: &'a str,
    counted: usize,
    lines: u64,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str, before: u64) -> Self {
        Self {
            text,
            counted: 0,
            lines: before,
        }
    }

    /// The line, from 1, of the first content at or after a place: empty lines and comments are passed.
    fn of(&mut self, place: usize) -> u64 {
        let mut rest = self.text.get(place..).unwrap_or_default();
        while let Some((line, after)) = rest.split_once('\n') {
            if !line.trim().is_empty() && !line.starts_with('#') {
                break;
            }
            rest = after;
        }
        let place = self.text.len() - rest.len();
        let passed = self.text.get(self.counted..place).unwrap_or_default();
        self.lines += passed.matches('\n').count() as u64;
        self.counted = place;
        self.lines + 1
    }
}

/// A number that may have a comma before its decimals.
pub(in crate::btf) fn number_with_comma(text: &str) -> Option<f64> {
    match text.contains('.') {
        true => text.parse().ok(),
        false => text.replacen(',', ".", 1).parse().ok(),
    }
}

/// A name in lower case, without a mark at its start, words joined by `_`.
fn plain(name: &str) -> String {
    let name = name.trim_start_matches('\u{feff}').trim().to_lowercase();
    name.replace([' ', '-'], "_")
}

/// The text after the first line `sep=;` of spreadsheets, the lines left out, and the delimiter it names.
fn after_sep_line(text: &str) -> (&str, u64, Option<u8>) {
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    let named = first.trim_end_matches('\r').strip_prefix("sep=");
    match named.map(str::as_bytes) {
        Some([delimiter]) if DELIMITERS.contains(delimiter) => (rest, 1, Some(*delimiter)),
        _ => (text, 0, None),
    }
}

/// What parts the columns of a header: the delimiter it has most of, outside quotes.
fn likely_delimiter(header: &str) -> u8 {
    let outside: String = header.split('"').step_by(2).collect();
    let count = |delimiter: &u8| outside.bytes().filter(|byte| byte == delimiter).count();
    // Of equally frequent ones the first.
    let mut best = DELIMITERS[0];
    for delimiter in DELIMITERS {
        if count(&delimiter) > count(&best) {
            best = delimiter;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str) -> Vec<(u64, f64, f64)> {
        let table = Table::parse(text).unwrap();
        let [a, b] = table.find_all([&["a"], &["b"]]).unwrap();
        let number = |row, column| table.number(row, column).unwrap();
        let rows = table.rows.iter();
        rows.map(|row| (row.line, number(row, a), number(row, b)))
            .collect()
    }

    #[test]
    fn spreadsheets_of_all_lands_are_read() {
        for text in [
            "a,b\n1.5,2\n",
            "\u{feff}\"A\",\"B\"\n1.5,2\n",
            "a;b\n1,5;2\n",
            "B;ignored, with comma;A\n2;x;1,5\n",
            "a\tb\n1.5\t2\n",
            "a\tb\n1,5\t2,0\n",
            " A , b \n 1.5 , 2 \n",
        ] {
            assert_eq!(numbers(text), [(2, 1.5, 2.0)], "{text:?}");
        }
        assert_eq!(numbers("sep=;\na;b\n1,5;2\n"), [(3, 1.5, 2.0)]);
        let spaced = "# made by hand\na,b\n\n1.5,2\n# more\n\n3,4";
        assert_eq!(numbers(spaced), [(4, 1.5, 2.0), (7, 3.0, 4.0)]);
    }

    #[test]
    fn faults_name_the_line_and_the_column() {
        let refused = |text: &str| {
            let table = Table::parse(text).map_err(|error| error.to_string())?;
            let [a, b] = table
                .find_all([&["a"], &["b"]])
                .map_err(|error| error.to_string())?;
            for row in &table.rows {
                table.number(row, a).map_err(|error| error.to_string())?;
                table.number(row, b).map_err(|error| error.to_string())?;
            }
            Ok::<(), String>(())
        };
        for (text, says) in [
            ("", "names of the columns"),
            ("a,c\n1,2\n", "has no b; expected the columns a, b"),
            ("a,b,B\n1,2,3\n", "one column b"),
            ("a,b\n1\n", "line 2: b: ``"),
            ("a,b\n1,2\nx,2\n", "line 3: a: `x`"),
            ("a,b\n1,inf\n", "`inf`"),
        ] {
            let error = refused(text).unwrap_err();
            assert!(error.contains(says), "{text:?}: {error}");
        }
    }
}
