//! RTI captures: a `.lp` file names one image per light, all taken from directly above.
//!
//! Format: a first line with the number of images, which may be missing, then `file x y z` per line: the light's
//! position on a dome, x to the image's right, y up, z towards the camera; positions are normalised. Numbers are
//! separated by any white space, or by commas or semicolons; names may hold spaces and stand in quotes. Empty lines
//! and lines that begin with `#` are left out, and so is what follows ` #` after the position. In the list of a
//! calibrated dome, lines may be `x y z` alone.

use glam::DVec3;

use crate::btf::direction::Direction;
use crate::btf::import::listed::Listed;
use crate::btf::table::number_with_comma;
use crate::error::{Error, Result};

/// Lengths further than this from 1 are positions, not directions.
const UNIT: f64 = 0.01;
/// Lights below the horizon that an error names.
const NAMED: usize = 5;

/// What a `.lp` file says.
#[derive(Debug)]
pub(super) struct Lights {
    pub(super) listed: Vec<Listed>,
    /// What the user should know.
    pub(super) notes: Vec<String>,
}

/// A line of the list.
struct Entry<'a> {
    line: u64,
    /// Empty where the line has none.
    file: &'a str,
    position: DVec3,
}

/// Reads the text of a `.lp` file.
pub(super) fn parse(text: &str) -> Result<Lights> {
    // Read the lines, the announced count first.
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index as u64 + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .peekable();
    let announced = lines.next_if(|(_, line)| count(line).is_some());
    let entries: Vec<Entry> = lines
        .map(|(line, text)| entry(line, text))
        .collect::<Result<_>>()?;
    if entries.is_empty() {
        return Err(Error::data("list", "no image").expected("a line `file x y z` per image"));
    }
    // Check the count and the lights.
    if let Some((line, text)) = announced {
        let number = count(text).unwrap_or(0);
        if number != entries.len() as u64 {
            return Err(
                Error::data(format!("line {line}"), format!("{number} images announced"))
                    .expected(format!("{}, as many as lines follow", entries.len()))
                    .advice("correct the number, or delete the line"),
            );
        }
    }
    check_horizon(&entries)?;
    Ok(Lights {
        notes: note_on_lengths(&entries).into_iter().collect(),
        listed: entries.iter().map(listed).collect(),
    })
}

/// The lights of the text of a `.lp` file, in its order.
pub(in crate::btf) fn directions(text: &str) -> Result<Vec<Direction>> {
    Ok(parse(text)?
        .listed
        .iter()
        .map(|listed| listed.light)
        .collect())
}

/// The number of images, where a line holds nothing else.
fn count(line: &str) -> Option<u64> {
    line.trim_end_matches([',', ';']).parse().ok()
}

fn entry(line: u64, text: &str) -> Result<Entry<'_>> {
    let without_comment = text.rsplit_once(" #").map(|(before, _)| before);
    let found = split(text).or_else(|| split(without_comment?));
    let Some((file, position)) = found else {
        return Err(Error::data(format!("line {line}"), format!("`{text}`"))
            .expected("file x y z: a name and three numbers"));
    };
    if position.try_normalize().is_none() {
        return Err(
            Error::data(format!("line {line}"), format!("position {position}"))
                .expected("a position of the light"),
        );
    }
    Ok(Entry {
        line,
        file,
        position,
    })
}

/// The name and the position of a line: the last three words are numbers.
fn split(line: &str) -> Option<(&str, DVec3)> {
    split_at(line, char::is_whitespace).or_else(|| split_at(line, |c| c == ',' || c == ';'))
}

fn split_at(line: &str, is_between: impl Fn(char) -> bool + Copy) -> Option<(&str, DVec3)> {
    let mut rest = line;
    let mut numbers = [0.0; 3];
    for number in numbers.iter_mut().rev() {
        rest = rest.trim_end_matches(|c: char| is_between(c) || c.is_whitespace());
        let start = rest.rfind(is_between).map_or(0, |at| {
            at + rest[at..].chars().next().map_or(1, char::len_utf8)
        });
        let word = rest[start..].trim().trim_end_matches([',', ';']);
        *number = number_with_comma(word).filter(|number: &f64| number.is_finite())?;
        rest = &rest[..start];
    }
    let name = rest.trim_matches(|c: char| is_between(c) || c.is_whitespace());
    let name = name.trim_end_matches([',', ';']);
    let name = name
        .strip_prefix('"')
        .and_then(|name| name.strip_suffix('"'))
        .unwrap_or(name);
    Some((name, DVec3::from_array(numbers)))
}

fn listed(entry: &Entry) -> Listed {
    Listed {
        line: entry.line,
        file: entry.file.to_owned(),
        view: Direction(DVec3::Z),
        light: Direction(entry.position.normalize()),
    }
}

/// Refuses lights below the horizon, by name.
fn check_horizon(entries: &[Entry]) -> Result<()> {
    let below: Vec<&Entry> = entries
        .iter()
        .filter(|entry| entry.position.z < 0.0)
        .collect();
    let Some(first) = below.first() else {
        return Ok(());
    };
    let told = below.iter().take(NAMED).map(|entry| {
        let depth = -entry.position.normalize().z.asin().to_degrees();
        format!("{} ({depth:.1}° below, line {})", entry.file, entry.line)
    });
    let told: Vec<String> = told.collect();
    let more = match below.len() - told.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    Err(Error::data(
        format!("line {}", first.line),
        format!(
            "{} of {} lights lie below the horizon: {}{more}",
            below.len(),
            entries.len(),
            told.join(", ")
        ),
    )
    .expected("lights above it, z >= 0")
    .advice("if z points away from the camera, change the sign of the last column"))
}

/// Says when positions are far from unit length, as millimetres are.
fn note_on_lengths(entries: &[Entry]) -> Option<String> {
    let lengths = || entries.iter().map(|entry| entry.position.length());
    let off = lengths()
        .filter(|length| (length - 1.0).abs() > UNIT)
        .count();
    let least = lengths().fold(f64::INFINITY, f64::min);
    let most = lengths().fold(0.0, f64::max);
    (off > 0).then(|| {
        format!(
            "{off} of {} light positions are not unit vectors (lengths {least:.3} to {most:.3}); they are \
             taken as directions to distant lights",
            entries.len()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_become_directions() {
        let list = parse("2\na b.jpg 0 0 2\nb.jpg 3 0 4\n").unwrap();
        assert_eq!(list.listed[0].file, "a b.jpg");
        assert_eq!(list.listed[0].light.0, DVec3::Z);
        assert!((list.listed[1].light.0 - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
        assert!(
            list.notes[0].contains("lengths 2.000 to 5.000"),
            "{:?}",
            list.notes
        );
    }

    #[test]
    fn every_way_to_part_columns_is_read() {
        for text in [
            "1\na.jpg  0.6   0.0  0.8\n",
            "a.jpg\t0.6\t0\t0.8",
            "\u{feff}1\r\na.jpg 0.6 0 0.8\r\n",
            "# dome\n1\n\n# lights\na.jpg 0.6 0 0.8 # first\n",
            "1\n\"a.jpg\" 0.6 0 0.8\n",
            "1\na.jpg,0.6,0,0.8\n",
            "1;\na.jpg; 0,6; 0; 0,8\n",
            "a.jpg 0,6 0,0 0,8\n",
            "a.jpg, 0.6, 0.0, 0.8\n",
        ] {
            let list = parse(text).unwrap();
            assert_eq!(list.listed[0].file, "a.jpg", "{text:?}");
            let light = list.listed[0].light.0;
            assert!(
                (light - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-12,
                "{text:?}"
            );
            assert_eq!(list.notes, Vec::<String>::new());
        }
        let named = parse("my photo #3.jpg 0 0 1\n0.6 0 0.8\n").unwrap().listed;
        assert_eq!(
            (named[0].file.as_str(), named[1].file.as_str()),
            ("my photo #3.jpg", "")
        );
    }

    #[test]
    fn broken_lists_are_refused_by_line() {
        let refused = |text: &str| parse(text).unwrap_err().to_string();
        let count = refused("2\na.jpg 0 0 1\n");
        assert!(
            count.contains("2 images announced") && count.contains("expected 1,"),
            "{count}"
        );
        assert!(refused("1\na.jpg 0 0\n").contains("line 2"));
        assert!(refused("1\na.jpg 0 x 1\n").contains("three numbers"));
        let below = refused("a.jpg 0 0 1\nb.jpg 0 1 -1\nc.jpg 0 0 -1\n");
        assert!(
            below.contains("line 2: 2 of 3") && below.contains("b.jpg (45.0° below"),
            "{below}"
        );
        assert!(refused("1\na.jpg 0 NaN 1\n").contains("line 2"));
        assert!(refused("1\na.jpg 0 0 0\n").contains("position"));
        assert!(refused("0\n").contains("no image"));
    }
}
