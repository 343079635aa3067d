//! Sweeps and camera paths from files: a row or entry for each frame, any field left out keeps
//! what the options say.
//!
//! CSV: a header row, then numbers. JSON: a list of objects. Fields: `light_azimuth`,
//! `light_elevation` (degrees), `light_x/y/z` (a point light's position); `camera_azimuth`,
//! `camera_elevation` (degrees), `camera_x/y/z`, `target_x/y/z`, `up_x/y/z`, `fov` (degrees),
//! `view_height` (mesh units). JSON may give positions as `camera`, `target`, `up`, `light` lists.

use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::text;

/// What a file says of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Of the first light, in degrees.
    pub light_azimuth: Option<f64>,
    /// Of the first light, in degrees.
    pub light_elevation: Option<f64>,
    /// Position of the first light, which becomes a point light.
    pub light: Option<[f64; 3]>,
    /// In degrees.
    pub camera_azimuth: Option<f64>,
    /// In degrees.
    pub camera_elevation: Option<f64>,
    /// Viewpoint.
    pub camera: Option<[f64; 3]>,
    /// Point in the picture's middle.
    pub target: Option<[f64; 3]>,
    /// What is up in the picture.
    pub up: Option<[f64; 3]>,
    /// Vertical field of view in degrees.
    pub fov: Option<f64>,
    /// Height of an orthographic picture, in mesh units.
    pub view_height: Option<f64>,
}

impl Row {
    /// The row's camera, as `over` says where it says something.
    #[must_use]
    pub fn overlaid(self, over: Self) -> Self {
        Self {
            light_azimuth: over.light_azimuth.or(self.light_azimuth),
            light_elevation: over.light_elevation.or(self.light_elevation),
            light: over.light.or(self.light),
            camera_azimuth: over.camera_azimuth.or(self.camera_azimuth),
            camera_elevation: over.camera_elevation.or(self.camera_elevation),
            camera: over.camera.or(self.camera),
            target: over.target.or(self.target),
            up: over.up.or(self.up),
            fov: over.fov.or(self.fov),
            view_height: over.view_height.or(self.view_height),
        }
    }

    /// Whether it says anything of the camera.
    pub fn moves_camera(&self) -> bool {
        let numbers = [
            self.camera_azimuth,
            self.camera_elevation,
            self.fov,
            self.view_height,
        ];
        let points = [self.camera, self.target, self.up];
        numbers.iter().any(Option::is_some) || points.iter().any(Option::is_some)
    }

    /// Sets a field by name; `None` when there is no such field.
    fn set(&mut self, field: &str, value: f64) -> Option<()> {
        let single = match field {
            "light_azimuth" => &mut self.light_azimuth,
            "light_elevation" => &mut self.light_elevation,
            "camera_azimuth" => &mut self.camera_azimuth,
            "camera_elevation" => &mut self.camera_elevation,
            "fov" => &mut self.fov,
            "view_height" => &mut self.view_height,
            _ => {
                let (name, axis) = field.rsplit_once('_')?;
                let axis = ["x", "y", "z"].iter().position(|known| *known == axis)?;
                self.vector(name)?.get_or_insert([f64::NAN; 3])[axis] = value;
                return Some(());
            }
        };
        *single = Some(value);
        Some(())
    }

    fn vector(&mut self, name: &str) -> Option<&mut Option<[f64; 3]>> {
        match name {
            "light" => Some(&mut self.light),
            "camera" => Some(&mut self.camera),
            "target" => Some(&mut self.target),
            "up" => Some(&mut self.up),
            _ => None,
        }
    }

    fn check(&self, place: &str) -> Result<()> {
        let vectors = [
            ("light", self.light),
            ("camera", self.camera),
            ("target", self.target),
            ("up", self.up),
        ];
        for (name, vector) in vectors {
            let Some(vector) = vector else { continue };
            if vector.iter().any(|value| !value.is_finite()) {
                return Err(
                    Error::data(format!("{place}, {name}"), format!("{vector:?}"))
                        .expected("three finite numbers x, y, z"),
                );
            }
        }
        Ok(())
    }
}

/// The largest file read, in bytes.
const LIMIT: u64 = 64 << 20;

/// Reads the rows of a CSV or (by its name) JSON file.
pub fn read(path: &Path) -> Result<Vec<Row>> {
    let text = text::read(path, LIMIT)?.text;
    let is_json = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
    let rows = guarded(path, || match is_json {
        true => parse_json(&text),
        false => parse_csv(&text),
    })?;
    if rows.is_empty() {
        return Err(Error::data("rows", "none")
            .expected("one per frame")
            .in_file(path));
    }
    Ok(rows)
}

fn unknown(place: &str, field: &str) -> Error {
    Error::data(place, format!("field `{field}`")).expected(
        "light_azimuth, light_elevation, light_x/y/z, camera_azimuth, camera_elevation, \
         camera_x/y/z, target_x/y/z, up_x/y/z, fov or view_height",
    )
}

fn parse_csv(text: &str) -> Result<Vec<Row>> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let fields = reader.headers().map_err(malformed)?.clone();
    if fields.is_empty() {
        return Err(Error::data("header", "missing").expected("a row of field names"));
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(malformed)?;
        let line = line_of(record.position());
        let mut row = Row::default();
        for (field, cell) in fields.iter().zip(&record) {
            let value = cell.parse().ok().filter(|value: &f64| value.is_finite());
            let value = value.ok_or_else(|| {
                Error::data(format!("{line}, {field}"), format!("`{cell}`"))
                    .expected("a finite number")
            })?;
            if field != "frame" {
                row.set(field, value)
                    .ok_or_else(|| unknown("header", field))?;
            }
        }
        row.check(&line)?;
        rows.push(row);
    }
    Ok(rows)
}

fn malformed(error: csv::Error) -> Error {
    let expected = "as many cells in each row as in the header";
    Error::data(line_of(error.position()), error.to_string()).expected(expected)
}

fn line_of(position: Option<&csv::Position>) -> String {
    format!("line {}", position.map_or(1, csv::Position::line))
}

fn parse_json(text: &str) -> Result<Vec<Row>> {
    let entries: Vec<serde_json::Map<String, Value>> = crate::format::json::parse(text.as_bytes())?;
    let parse = |(index, entry): (usize, serde_json::Map<String, Value>)| {
        let place = format!("entry {index}");
        let mut row = Row::default();
        for (field, value) in entry {
            set_from_json(&mut row, &place, &field, &value)?;
        }
        row.check(&place)?;
        Ok(row)
    };
    entries.into_iter().enumerate().map(parse).collect()
}

fn set_from_json(row: &mut Row, place: &str, field: &str, value: &Value) -> Result<()> {
    let not_numbers = || {
        Error::data(format!("{place}, {field}"), value.to_string())
            .expected("a number, or three in a list for a position")
    };
    if field == "frame" {
        return Ok(());
    }
    if let Value::Array(values) = value {
        let numbers: Option<Vec<f64>> = values.iter().map(Value::as_f64).collect();
        let numbers: Option<[f64; 3]> = numbers.and_then(|list| list.try_into().ok());
        let slot = row.vector(field).ok_or_else(|| unknown(place, field))?;
        *slot = Some(numbers.ok_or_else(not_numbers)?);
        return Ok(());
    }
    let number = value.as_f64().ok_or_else(not_numbers)?;
    row.set(field, number).ok_or_else(|| unknown(place, field))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_and_json_say_the_same() {
        let csv =
            "frame,light_azimuth, camera_x,camera_y,camera_z,fov\n1,30,0,1,5,40\n\n2,60,1,1,5,41\n";
        let json = r#"[{"light_azimuth": 30, "camera": [0, 1, 5], "fov": 40},
                       {"light_azimuth": 60, "camera": [1, 1, 5], "fov": 41}]"#;
        let rows = parse_csv(csv).unwrap();
        assert_eq!(rows, parse_json(json).unwrap());
        assert_eq!(rows[1].camera, Some([1.0, 1.0, 5.0]));
        assert_eq!(rows[0].light_elevation, None);
    }

    #[test]
    fn faults_are_named_by_place() {
        let csv = |text: &str| parse_csv(text).unwrap_err().to_string();
        assert!(csv("camera_x,camera_y,camera_z\n0,NaN,1\n").contains("line 2, camera_y"));
        assert!(csv("fov\n1,2\n").contains("line 2"));
        assert!(csv("").contains("header"));
        assert!(csv("fox\n1\n").contains("`fox`"));
        assert!(csv("camera_x\n1\n").contains("line 2, camera"));
        let json = |text: &str| parse_json(text).unwrap_err().to_string();
        assert!(json(r#"[{"camera": [1, 2]}]"#).contains("entry 0, camera"));
        assert!(json(r#"[{"fov": "x"}]"#).contains("entry 0, fov"));
    }
}
