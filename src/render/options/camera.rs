//! Where frames are seen from.

use std::path::PathBuf;

use glam::DVec3;
use serde::Serialize;

use crate::error::Error;
use crate::error::Result;
use crate::render::azimuth::{Axis, is_along};
use crate::render::option_values::{Point, ProjectionKind};
use crate::render::options::ranges::{ANGLES, FARTHEST, Plain, check_numbers};

/// Where frames are seen from.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
#[command(next_help_heading = "Camera")]
pub struct CameraOptions {
    /// The axis of the mesh that points up.
    #[arg(long, value_enum, default_value_t, allow_hyphen_values = true)]
    pub up: Axis,
    /// The side of the mesh that is its front, which the camera sees at azimuth 0. [default: the side that an open mesh
    /// faces, otherwise the broad side]
    #[arg(long, value_enum, value_name = "AXIS", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub front: Option<Axis>,
    /// Azimuth of the camera in degrees, counter-clockwise seen from above; 0 is in front.
    #[arg(long, value_name = "DEGREES", default_value_t = CameraOptions::default().camera_azimuth, allow_negative_numbers = true)]
    pub camera_azimuth: f64,
    /// Elevation of the camera in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = CameraOptions::default().camera_elevation, allow_negative_numbers = true)]
    pub camera_elevation: f64,
    /// Position of the camera, in place of one fitted to the mesh.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera_position: Option<Point>,
    /// Point in the middle of the image. [default: the middle of what is visible; the centre of the mesh's bounding box
    /// if the camera moves or its position is given]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera_target: Option<Point>,
    /// How the camera projects.
    #[arg(long, value_enum, default_value_t)]
    pub projection: ProjectionKind,
    /// Magnification of the middle of the image. At 1 a fitted camera sees the whole mesh.
    #[arg(long, value_name = "X", default_value_t = CameraOptions::default().zoom)]
    pub zoom: f64,
    /// Vertical field of view in degrees, at zoom 1.
    #[arg(long, value_name = "DEGREES", default_value_t = CameraOptions::default().fov)]
    pub fov: f64,
    /// Focal length in mm for an image 24 mm high, in place of --fov.
    #[arg(long, value_name = "MM", conflicts_with = "fov")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_length: Option<f64>,
    /// Height of an orthographic image in mesh units. [default: fitted to the mesh]
    #[arg(long, value_name = "UNITS")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_height: Option<f64>,
    /// Cameras from a JSON or CSV file, one for each frame (fields: see docs/rendering.md).
    #[arg(long, value_name = "FILE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera_path: Option<PathBuf>,
}

impl Default for CameraOptions {
    fn default() -> Self {
        Self {
            up: Axis::default(),
            front: None,
            camera_azimuth: 0.0,
            camera_elevation: 15.0,
            camera_position: None,
            camera_target: None,
            projection: ProjectionKind::default(),
            zoom: 1.0,
            fov: 30.0,
            focal_length: None,
            view_height: None,
            camera_path: None,
        }
    }
}

impl CameraOptions {
    /// The vertical field of view in radians.
    pub fn vertical_fov(&self) -> f64 {
        match self.focal_length {
            Some(mm) => 2.0 * (12.0 / mm).atan(),
            None => self.fov.to_radians(),
        }
    }

    /// Whether a camera at the stated position looks straight up or down at `target`: what is up in its image then
    /// depends on the front.
    pub fn looks_along_up(&self, target: [f64; 3]) -> bool {
        self.camera_position.is_some_and(|position| {
            let towards = DVec3::from_array(position.0) - DVec3::from_array(target);
            is_along(self.up.vector(), towards)
        })
    }

    /// Refuses values that no camera can have.
    pub(super) fn validate(&self) -> Result<()> {
        check_numbers(&[
            ("zoom", Some(self.zoom), [1e-3, 1e6]),
            ("fov", Some(self.fov), [0.001, 179.999]),
            ("camera-azimuth", Some(self.camera_azimuth), ANGLES),
            ("camera-elevation", Some(self.camera_elevation), ANGLES),
            ("focal-length", self.focal_length, [0.01, 1e6]),
            ("view-height", self.view_height, [1.0 / FARTHEST, FARTHEST]),
        ])?;
        for (option, point) in [
            ("camera-position", self.camera_position),
            ("camera-target", self.camera_target),
        ] {
            let far = point.is_some_and(|point| point.0.iter().any(|at| at.abs() > FARTHEST));
            if let Some(point) = point.filter(|_| far) {
                let expected = format!("coordinates up to {}", Plain(FARTHEST));
                return Err(Error::option(option, point.to_string(), expected));
            }
        }
        Ok(())
    }
}
