//! A folder of rectified images with a CSV of angles.
//!
//! Format: a header `file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg` (columns in
//! any order, others are ignored), one image a row; files are relative to the CSV; θ from the
//! surface normal, φ counter-clockwise from image right, both in degrees.

use std::fs::File;
use std::path::Path;

use serde::Deserialize;

use crate::btf::direction::Direction;
use crate::btf::import::{ImageList, MeasuredImage};
use crate::error::{Error, Result};
use crate::format::guard::guarded;

#[derive(Debug, Deserialize)]
struct Row {
    file: String,
    view_theta_deg: f64,
    view_phi_deg: f64,
    light_theta_deg: f64,
    light_phi_deg: f64,
}

/// Reads a CSV of angles.
pub fn read(path: &Path) -> Result<ImageList> {
    let file = File::open(path).map_err(Error::io(path, "read"))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let images = guarded(path, || parse(file, folder))?;
    Ok(ImageList {
        name: path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        path: path.to_path_buf(),
        kind: "images with angles",
        images,
    })
}

fn parse(source: impl std::io::Read, folder: &Path) -> Result<Vec<MeasuredImage>> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(source);
    let mut images = Vec::new();
    for (index, row) in reader.deserialize().enumerate() {
        let place = format!("row {}", index + 1);
        let row: Row = row.map_err(|error| {
            Error::data(&place, error.to_string()).expected(
                "columns file, view_theta_deg, view_phi_deg, light_theta_deg, light_phi_deg",
            )
        })?;
        images.push(MeasuredImage {
            path: folder.join(&row.file),
            view: direction(&place, "view", row.view_theta_deg, row.view_phi_deg)?,
            light: direction(&place, "light", row.light_theta_deg, row.light_phi_deg)?,
        });
    }
    if images.is_empty() {
        return Err(Error::data("rows", "none").expected("one image a row"));
    }
    Ok(images)
}

fn direction(place: &str, kind: &str, theta: f64, phi: f64) -> Result<Direction> {
    if !(0.0..=90.0).contains(&theta) || !phi.is_finite() {
        return Err(Error::data(
            format!("{place}, {kind}"),
            format!("theta {theta}, phi {phi}"),
        )
        .expected("degrees, theta from 0 to 90"));
    }
    Ok(Direction::from_angles(theta.to_radians(), phi.to_radians()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\n";

    #[test]
    fn rows_become_images() {
        let text = format!("{HEADER}a.png, 0, 0, 60, 90\n");
        let images = parse(text.as_bytes(), Path::new("set")).unwrap();
        assert_eq!(images[0].path, Path::new("set/a.png"));
        assert!((images[0].light.theta().to_degrees() - 60.0).abs() < 1e-12);
        assert!((images[0].light.phi().to_degrees() - 90.0).abs() < 1e-12);
    }

    #[test]
    fn broken_tables_are_refused_by_row() {
        let refused = |text: &str| {
            parse(text.as_bytes(), Path::new(""))
                .unwrap_err()
                .to_string()
        };
        assert!(refused("file,theta\na,1\n").contains("view_theta_deg"));
        assert!(refused(HEADER).contains("none"));
        assert!(refused(&format!("{HEADER}a,0,0,91,0\n")).contains("row 1, light"));
        assert!(refused(&format!("{HEADER}a,NaN,0,0,0\n")).contains("row 1, view"));
        assert!(refused(&format!("{HEADER}a,0,0,0,0\nb,0,0,x,0\n")).contains("row 2"));
    }
}
