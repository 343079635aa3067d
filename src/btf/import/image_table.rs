//! A folder of rectified images with a table of angles or of positions (CSV).
//!
//! Format: a header with the column `file`, and for the view either `view_theta_deg` and `view_phi_deg` or
//! `camera_x_mm`, `camera_y_mm`, `camera_z_mm`, for the light either `light_theta_deg` and `light_phi_deg` or
//! `light_x_mm`, `light_y_mm`, `light_z_mm` (in any order and case, others are ignored), one image per row. Files are
//! relative to the table; θ from the surface normal, φ counter-clockwise from image right, both in degrees; positions
//! from the patch's centre, x to image right, y up, z along the normal, in millimetres. Columns may be separated by
//! commas, semicolons or tabs; where no comma parts them, decimals may have one.

use glam::DVec3;

use crate::btf::direction::Direction;
use crate::btf::import::listed::Listed;
use crate::btf::table::{Row, Table};
use crate::error::{Error, Result};

/// Names of the column of files, the first the one we write.
const FILE: &[&str] = &["file", "filename", "file_name", "image"];

const VIEW_ANGLES: [&str; 2] = ["view_theta_deg", "view_phi_deg"];
const VIEW_POSITION: [&str; 3] = ["camera_x_mm", "camera_y_mm", "camera_z_mm"];
const LIGHT_ANGLES: [&str; 2] = ["light_theta_deg", "light_phi_deg"];
const LIGHT_POSITION: [&str; 3] = ["light_x_mm", "light_y_mm", "light_z_mm"];

/// What a table says.
#[derive(Debug)]
pub(super) struct ImageTable {
    pub(super) listed: Vec<Listed>,
    /// Where the camera and the light of each image stood, in millimetres, where the table says so.
    pub(super) cameras: Option<Vec<DVec3>>,
    pub(super) lights: Option<Vec<DVec3>>,
}

/// The columns that say where the camera or the light was.
enum Columns {
    Angles([usize; 2]),
    Position([usize; 3]),
}

/// A direction, and the position it was computed from.
type Stood = (Direction, Option<DVec3>);

/// Reads the text of a table.
pub(super) fn parse(text: &str) -> Result<ImageTable> {
    let table = Table::parse(text)?;
    let [file] = table.find_all([FILE])?;
    let view = Columns::find(&table, VIEW_ANGLES, VIEW_POSITION)?;
    let light = Columns::find(&table, LIGHT_ANGLES, LIGHT_POSITION)?;
    rows_of(&table, file, [&view, &light])
}

/// Reads the text of a table whose lights stand with the camera: it has no columns for them.
pub(super) fn parse_collocated(text: &str) -> Result<ImageTable> {
    let table = Table::parse(text)?;
    let [file] = table.find_all([FILE])?;
    refuse_lights(&table)?;
    let both = Columns::find(&table, VIEW_ANGLES, VIEW_POSITION)?;
    rows_of(&table, file, [&both, &both])
}

/// The rows of a table with these columns of files, views and lights.
fn rows_of(table: &Table, file: usize, [view, light]: [&Columns; 2]) -> Result<ImageTable> {
    let mut listed = Vec::new();
    let (mut cameras, mut lights) = (Vec::new(), Vec::new());
    for row in &table.rows {
        let (seen, camera) = view.stood(table, row, "view")?;
        let (lit, lamp) = light.stood(table, row, "light")?;
        cameras.extend(camera);
        lights.extend(lamp);
        listed.push(Listed {
            line: row.line,
            file: table.text(row, file).to_owned(),
            view: seen,
            light: lit,
        });
    }
    if listed.is_empty() {
        return Err(Error::data("rows", "none").expected("one image per row"));
    }
    let stated = |positions: Vec<DVec3>| (!positions.is_empty()).then_some(positions);
    Ok(ImageTable {
        listed,
        cameras: stated(cameras),
        lights: stated(lights),
    })
}

/// Refuses columns of lights where these stand with the camera.
fn refuse_lights(table: &Table) -> Result<()> {
    for name in LIGHT_ANGLES.iter().chain(&LIGHT_POSITION) {
        if table.find(&[name])?.is_some() {
            return Err(Error::data("header", format!("a column {name}"))
                .expected("none with --collocated: the light is where the camera is"));
        }
    }
    Ok(())
}

impl Columns {
    /// The columns of angles, else those of positions.
    fn find(table: &Table, angles: [&str; 2], position: [&str; 3]) -> Result<Self> {
        let has_position = table.find(&[position[0]])?.is_some();
        let has_angles = table.find(&[angles[0]])?.is_some();
        if has_position && has_angles {
            return Err(
                Error::data("header", format!("both {} and {}", angles[0], position[0]))
                    .expected("angles or positions"),
            );
        }
        match has_position {
            true => table
                .find_all(position.each_ref().map(std::slice::from_ref))
                .map(Self::Position),
            false => table
                .find_all(angles.each_ref().map(std::slice::from_ref))
                .map(Self::Angles),
        }
    }

    fn stood(&self, table: &Table, row: &Row, kind: &str) -> Result<Stood> {
        match *self {
            Self::Angles([theta, phi]) => {
                let angles = (table.number(row, theta)?, table.number(row, phi)?);
                Ok((direction(row.line, kind, angles)?, None))
            }
            Self::Position(columns) => {
                let [x, y, z] = columns.map(|column| table.number(row, column));
                let position = DVec3::new(x?, y?, z?);
                let fault = || {
                    Error::data(
                        format!("line {}, {kind}", row.line),
                        format!("position {position} mm"),
                    )
                    .expected("a place above the patch, z > 0, in mm from its centre")
                };
                let unit = position.try_normalize().filter(|unit| unit.z > 0.0);
                Ok((Direction(unit.ok_or_else(fault)?), Some(position)))
            }
        }
    }
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
            let images = parse(&text).unwrap().listed;
            assert_eq!(images[0].file, "a.png");
            assert!((images[0].light.theta().to_degrees() - 60.5).abs() < 1e-12);
            assert!((images[0].light.phi().to_degrees() - 90.0).abs() < 1e-12);
        }
    }

    #[test]
    fn positions_become_directions_at_the_centre() {
        let text =
            "file,view_theta_deg,view_phi_deg,light_x_mm,light_y_mm,light_z_mm\na,30,0,300,0,400\n";
        let table = parse(text).unwrap();
        assert!((table.listed[0].light.0 - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
        assert!((table.listed[0].view.theta().to_degrees() - 30.0).abs() < 1e-12);
        assert_eq!(table.lights, Some(vec![DVec3::new(300.0, 0.0, 400.0)]));
        assert_eq!(table.cameras, None);
    }

    #[test]
    fn collocated_lights_are_where_the_camera_is() {
        let text = "file,camera_x_mm,camera_y_mm,camera_z_mm\na.png,300,0,400\n";
        let table = parse_collocated(text).unwrap();
        assert_eq!(table.listed[0].view, table.listed[0].light);
        assert_eq!(table.cameras, table.lights);
        let both = parse_collocated(&format!("{HEADER}a.png,1,2,3,4\n")).unwrap_err();
        assert!(both.to_string().contains("--collocated"));
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
        let places = "file,camera_x_mm,camera_y_mm,camera_z_mm,light_x_mm,light_y_mm,light_z_mm\n";
        assert!(
            refused(&format!("{places}a,0,0,500,1,2,-3\n")).contains("line 2, light: position")
        );
        assert!(refused(&format!("{places}a,0,0,0,1,2,3\n")).contains("line 2, view"));
        assert!(
            refused("file,camera_x_mm,view_theta_deg\na,1,2\n").contains("both view_theta_deg")
        );
    }
}
