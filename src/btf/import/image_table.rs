//! A folder of rectified images with a table of angles (CSV).
//!
//! Format: a header with the columns `file`, `view_theta_deg`, `view_phi_deg`, `light_theta_deg` and
//! `light_phi_deg` (in any order and case, others are ignored), one image per row; files are relative to
//! the table; θ from the surface normal, φ counter-clockwise from image right, both in degrees. Columns
//! may be parted by commas, semicolons or tabs; where no comma parts them, decimals may have one.

use crate::btf::direction::Direction;
use crate::btf::import::listed::Listed;
use crate::btf::table::{Row, Table};
use crate::error::{Error, Result};

/// Names of the columns, the first the one we write.
pub(super) const COLUMNS: [&[&str]; 5] = [
    &["file", "filename", "file_name", "image"],
    &["view_theta_deg"],
    &["view_phi_deg"],
    &["light_theta_deg"],
    &["light_phi_deg"],
];

/// Reads the text of a table of angles.
pub(super) fn parse(text: &str) -> Result<Vec<Listed>> {
    let table = Table::parse(text)?;
    let [file, view_theta, view_phi, light_theta, light_phi] = table.find_all(COLUMNS)?;
    let read = |row: &Row| {
        let angles = |theta, phi| Ok((table.number(row, theta)?, table.number(row, phi)?));
        Ok(Listed {
            line: row.line,
            file: table.text(row, file).to_owned(),
            view: direction(row.line, "view", angles(view_theta, view_phi)?)?,
            light: direction(row.line, "light", angles(light_theta, light_phi)?)?,
        })
    };
    let listed: Vec<Listed> = table.rows.iter().map(read).collect::<Result<_>>()?;
    if listed.is_empty() {
        return Err(Error::data("rows", "none").expected("one image per row"));
    }
    Ok(listed)
}

fn direction(line: u64, kind: &str, (theta, phi): (f64, f64)) -> Result<Direction> {
    if !(0.0..=90.0).contains(&theta) {
        let below = if theta > 90.0 {
            ", below the horizon"
        } else {
            ""
        };
        return Err(Error::data(
            format!("line {line}, {kind}"),
            format!("theta {theta}{below}"),
        )
        .expected("degrees from the surface normal, 0 to 90"));
    }
    Ok(Direction::from_angles(theta.to_radians(), phi.to_radians()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\n";

    #[test]
    fn rows_become_images() {
        for text in [
            format!("{HEADER}a.png, 0, 0, 60.5, 90\n"),
            "\u{feff}File;View_Theta_Deg;View_Phi_Deg;Light_Theta_Deg;Light_Phi_Deg\r\na.png;0;0;60,5;90,0\r\n".into(),
        ] {
            let images = parse(&text).unwrap();
            assert_eq!(images[0].file, "a.png");
            assert!((images[0].light.theta().to_degrees() - 60.5).abs() < 1e-12);
            assert!((images[0].light.phi().to_degrees() - 90.0).abs() < 1e-12);
        }
    }

    #[test]
    fn broken_tables_are_refused_by_line() {
        let refused = |text: &str| parse(text).unwrap_err().to_string();
        assert!(refused("file,theta\na,1\n").contains("view_theta_deg"));
        assert!(refused(HEADER).contains("none"));
        let below = refused(&format!("{HEADER}a,0,0,91,0\n"));
        assert!(
            below.contains("line 2, light") && below.contains("below the horizon"),
            "{below}"
        );
        assert!(refused(&format!("{HEADER}a,NaN,0,0,0\n")).contains("line 2: view_theta_deg"));
        assert!(refused(&format!("{HEADER}a,0,0,0,0\nb,0,0,x,0\n")).contains("line 3"));
    }
}
