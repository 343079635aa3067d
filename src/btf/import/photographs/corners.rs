//! A table of the patch's corners in each photograph.

use std::collections::BTreeMap;
use std::path::Path;

use crate::btf::table::{Row, Table};
use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::text;

/// The largest table read, in bytes.
const LARGEST: u64 = 64 << 20;
/// Photographs without corners that an error names.
const NAMED: usize = 5;
/// Names of the columns.
const COLUMNS: [&[&str]; 9] = [
    &["file", "filename", "file_name", "image"],
    &["x1"],
    &["y1"],
    &["x2"],
    &["y2"],
    &["x3"],
    &["y3"],
    &["x4"],
    &["y4"],
];

/// Corners by the last part of the photographs' names: top left, top right, bottom right, bottom left.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Corners(BTreeMap<String, [[f64; 2]; 4]>);

impl Corners {
    /// Reads a table.
    pub(super) fn read(path: &Path) -> Result<Self> {
        guarded(path, || Self::parse(&text::read(path, LARGEST)?.text))
    }

    fn parse(text: &str) -> Result<Self> {
        let table = Table::parse(text)?;
        let columns = table.find_all(COLUMNS)?;
        let mut corners = BTreeMap::new();
        for row in &table.rows {
            let name = base_name(table.text(row, columns[0])).to_owned();
            let place = format!("line {}", row.line);
            if name.is_empty() {
                return Err(Error::data(place, "no file").expected("the name of a photograph"));
            }
            let points = points(&table, row, &columns)?;
            if corners.insert(name.clone(), points).is_some() {
                return Err(Error::data(place, format!("`{name}` again"))
                    .expected("each photograph once, identified by the last part of its name"));
            }
        }
        match corners.is_empty() {
            true => Err(Error::data("rows", "none").expected("one photograph per row")),
            false => Ok(Self(corners)),
        }
    }

    /// The corners of a photograph.
    pub(super) fn of(&self, path: &Path) -> Result<[[f64; 2]; 4]> {
        let name = path.to_string_lossy();
        self.0.get(base_name(&name)).copied().ok_or_else(|| {
            Error::data("corners", "the table has none of this photograph")
                .expected("a row with its name")
                .in_file(path)
        })
    }

    /// Refuses photographs without corners, named together.
    pub(super) fn check(&self, images: &[&Path]) -> Result<()> {
        let missing: Vec<String> = images
            .iter()
            .filter(|image| self.of(image).is_err())
            .map(|image| base_name(&image.to_string_lossy()).to_owned())
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        let named = missing[..missing.len().min(NAMED)].join(", ");
        Err(Error::data(
            "corners",
            format!(
                "none of {} of {} photographs: {named}",
                missing.len(),
                images.len()
            ),
        )
        .expected("a row for each"))
    }

    /// Columns and rows as the longest upper or lower side and the longest left or right side have pixels.
    pub(super) fn longest_sides(&self, most: u32) -> (u32, u32) {
        let longest = |pairs: [[usize; 2]; 2]| {
            let sides = self.0.values().flat_map(|corners| {
                pairs.map(|[a, b]| {
                    let [dx, dy] = [0, 1].map(|axis| corners[b][axis] - corners[a][axis]);
                    dx.hypot(dy)
                })
            });
            (sides.fold(1.0, f64::max).round() as u32).min(most)
        };
        (longest([[0, 1], [3, 2]]), longest([[0, 3], [1, 2]]))
    }
}

fn points(table: &Table, row: &Row, columns: &[usize; 9]) -> Result<[[f64; 2]; 4]> {
    let mut points = [[0.0; 2]; 4];
    for (place, column) in points.as_flattened_mut().iter_mut().zip(&columns[1..]) {
        *place = table.number(row, *column)?;
    }
    Ok(points)
}

/// The last part of a path of any system.
fn base_name(named: &str) -> &str {
    named.rsplit(['/', '\\']).next().unwrap_or(named)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "file,x1,y1,x2,y2,x3,y3,x4,y4\n";

    #[test]
    fn photographs_are_told_by_the_last_part_of_their_names() {
        let corners = Corners::parse(&format!("{HEADER}raw\\a.jpg,1,2,30,4,31,60,0,80\n")).unwrap();
        let found = corners.of(Path::new("elsewhere/a.jpg")).unwrap();
        assert_eq!(found, [[1.0, 2.0], [30.0, 4.0], [31.0, 60.0], [0.0, 80.0]]);
        assert_eq!(corners.longest_sides(99), (37, 78));
        assert_eq!(corners.longest_sides(50), (37, 50));
        let missing = corners.check(&[Path::new("a.jpg"), Path::new("x/b.jpg")]);
        let missing = missing.unwrap_err().to_string();
        assert!(missing.contains("1 of 2 photographs: b.jpg"), "{missing}");
    }

    #[test]
    fn broken_tables_are_refused_by_line() {
        let refused = |text: &str| Corners::parse(text).unwrap_err().to_string();
        assert!(refused("file,x1\na,1\n").contains("y1"));
        assert!(refused(HEADER).contains("none"));
        let row = "a.jpg,1,2,3,4,5,6,7,8\n";
        assert!(refused(&format!("{HEADER}{row}b/{row}")).contains("line 3: `a.jpg` again"));
        assert!(refused(&format!("{HEADER}a.jpg,1,2,x,4,5,6,7,8\n")).contains("line 2: x2"));
        assert!(refused(&format!("{HEADER},1,2,3,4,5,6,7,8\n")).contains("no file"));
    }
}
