//! Cameras: where the viewer stands, how the picture is projected, and the matrices that frames
//! carry in their headers.
//!
//! Camera space is OpenEXR's: left-handed, x right, y up, z ahead. Pixel space has x right and y
//! down, (0, 0) at the upper left corner of the image, pixel (i, j) centred at (i + ½, j + ½).

use glam::DVec3;

use crate::error::{Error, Result};

/// How points in camera space fall on the image plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Lines of sight meet in the camera's position.
    Perspective {
        /// The angle between the image's top and bottom, in radians.
        vertical_fov: f64,
    },
    /// Lines of sight are parallel.
    Orthographic {
        /// The image's height, in mesh units.
        height: f64,
    },
}

/// Where the viewer stands and looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The viewpoint; for an orthographic camera, a point of the plane that Z is measured from.
    pub position: DVec3,
    /// The point in the image's middle.
    pub target: DVec3,
    /// What is up in the image.
    pub up: DVec3,
    /// How points fall on the image.
    pub projection: Projection,
}

impl Camera {
    /// The camera with a picture that shows a part of its own, `zoom` times as large.
    #[must_use]
    pub fn zoomed(self, zoom: f64) -> Self {
        let projection = match self.projection {
            Projection::Perspective { vertical_fov } => Projection::Perspective {
                vertical_fov: 2.0 * ((0.5 * vertical_fov).tan() / zoom).atan(),
            },
            Projection::Orthographic { height } => Projection::Orthographic {
                height: height / zoom,
            },
        };
        Self { projection, ..self }
    }
}

/// A camera with its image: axes, scale and principal point, ready to project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Columns and rows of the image.
    pub size: [u32; 2],
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels a mesh unit spans: at distance 1 (perspective), or anywhere (orthographic).
    pixels_per_unit: f64,
}

impl View {
    /// Refuses cameras that see nothing: NaN, looking at themselves, or along their up vector.
    pub fn new(camera: Camera, size: [u32; 2]) -> Result<Self> {
        let Camera {
            position,
            target,
            up,
            projection,
        } = camera;
        let fault = |place: &str, found: String, expected: &str| {
            Err(Error::data(format!("camera {place}"), found).expected(expected))
        };
        // Check the vectors.
        for (place, vector) in [("position", position), ("target", target), ("up", up)] {
            if !vector.is_finite() {
                return fault(place, format!("{vector}"), "finite numbers");
            }
        }
        let Some(forward) = (target - position).try_normalize() else {
            return fault("target", "is the camera's position".into(), "another point");
        };
        // Set up the axes.
        let right = forward.cross(up);
        if right.length() <= 1e-9 * up.length() {
            return fault(
                "up",
                format!("{up} is the line of sight"),
                "another direction",
            );
        }
        let right = right.normalize();
        // Find the scale.
        let rows = f64::from(size[1]);
        let pixels_per_unit = match projection {
            Projection::Perspective { vertical_fov } => {
                if !(vertical_fov > 0.0 && vertical_fov < std::f64::consts::PI) {
                    return fault(
                        "field of view",
                        format!("{}°", vertical_fov.to_degrees()),
                        "more than 0° and less than 180°",
                    );
                }
                0.5 * rows / (0.5 * vertical_fov).tan()
            }
            Projection::Orthographic { height } => {
                if !(height > 0.0 && height.is_finite()) {
                    return fault("height", height.to_string(), "more than 0");
                }
                rows / height
            }
        };
        Ok(Self {
            camera,
            size,
            right,
            up: right.cross(forward),
            forward,
            pixels_per_unit,
        })
    }

    /// Whether lines of sight meet in the camera's position.
    pub fn is_perspective(&self) -> bool {
        matches!(self.camera.projection, Projection::Perspective { .. })
    }

    /// A world point in camera space: right, up, ahead.
    #[inline]
    pub fn camera_from_world(&self, point: DVec3) -> DVec3 {
        let offset = point - self.camera.position;
        DVec3::new(
            offset.dot(self.right),
            offset.dot(self.up),
            offset.dot(self.forward),
        )
    }

    /// Pixels a mesh unit spans across the line of sight at a depth.
    #[inline]
    pub fn pixels_per_unit_at(&self, depth: f64) -> f64 {
        if self.is_perspective() {
            self.pixels_per_unit / depth
        } else {
            self.pixels_per_unit
        }
    }

    /// The pixel coordinates of a point in camera space; for points ahead of the camera.
    #[inline]
    pub fn pixel_from_camera(&self, point: DVec3) -> (f64, f64) {
        let scale = self.pixels_per_unit_at(point.z);
        (
            0.5 * f64::from(self.size[0]) + scale * point.x,
            0.5 * f64::from(self.size[1]) - scale * point.y,
        )
    }

    /// The unit direction from a surface point to the viewer.
    #[inline]
    pub fn towards_viewer(&self, point: DVec3) -> DVec3 {
        if self.is_perspective() {
            (self.camera.position - point).normalize_or(-self.forward)
        } else {
            -self.forward
        }
    }

    /// The line of sight through a place of the image: where it begins, and a vector along it that is 1 deep.
    #[inline]
    pub fn line_of_sight(&self, [x, y]: [f64; 2]) -> (DVec3, DVec3) {
        let [columns, rows] = self.size.map(f64::from);
        let across = self.right * ((x - 0.5 * columns) / self.pixels_per_unit)
            + self.up * ((0.5 * rows - y) / self.pixels_per_unit);
        match self.is_perspective() {
            true => (self.camera.position, self.forward + across),
            false => (self.camera.position + across, self.forward),
        }
    }

    /// OpenEXR's `worldToCamera`: row-major, for row vectors (p · M), left-handed, +z ahead.
    pub fn world_to_camera(&self) -> [f32; 16] {
        let axes = [self.right, self.up, self.forward];
        let mut matrix = [0.0; 16];
        for (column, axis) in axes.iter().enumerate() {
            for row in 0..3 {
                matrix[row * 4 + column] = axis[row] as f32;
            }
            matrix[12 + column] = -self.camera.position.dot(*axis) as f32;
        }
        matrix[15] = 1.0;
        matrix
    }

    /// OpenEXR's `worldToNDC`: row-major, for row vectors; after the division by w, (0, 0) is the
    /// upper left and (1, 1) the lower right corner of the image. z is 1 − nearest/depth
    /// (perspective, nearest = 1/1000 of the way to the target) or the depth (orthographic).
    pub fn world_to_ndc(&self) -> [f32; 16] {
        let [columns, rows] = self.size.map(f64::from);
        let (x, y) = (self.pixels_per_unit / columns, self.pixels_per_unit / rows);
        let nearest = 1e-3 * (self.camera.target - self.camera.position).length();
        // Each column as an affine function of the point in camera space: (axes, constant).
        let ndc: [(DVec3, f64); 4] = if self.is_perspective() {
            [
                (self.right * x + self.forward * 0.5, 0.0),
                (self.up * -y + self.forward * 0.5, 0.0),
                (self.forward, -nearest),
                (self.forward, 0.0),
            ]
        } else {
            [
                (self.right * x, 0.5),
                (self.up * -y, 0.5),
                (self.forward, 0.0),
                (DVec3::ZERO, 1.0),
            ]
        };
        let mut matrix = [0.0; 16];
        for (column, (axis, constant)) in ndc.iter().enumerate() {
            for row in 0..3 {
                matrix[row * 4 + column] = axis[row] as f32;
            }
            matrix[12 + column] = (constant - self.camera.position.dot(*axis)) as f32;
        }
        matrix
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(projection: Projection) -> View {
        let camera = Camera {
            position: DVec3::new(0.0, 1.0, 5.0),
            target: DVec3::new(0.0, 1.0, 0.0),
            up: DVec3::Y,
            projection,
        };
        View::new(camera, [200, 100]).unwrap()
    }

    fn row_times(point: DVec3, matrix: &[f32; 16]) -> DVec3 {
        let p = [point.x, point.y, point.z, 1.0];
        let at = |column: usize| -> f64 {
            (0..4)
                .map(|row| p[row] * f64::from(matrix[row * 4 + column]))
                .sum()
        };
        DVec3::new(at(0), at(1), at(2)) / at(3)
    }

    #[test]
    fn pictures_are_not_mirrored() {
        let view = view(Projection::Perspective { vertical_fov: 1.0 });
        // Seen from +z with y up, +x is to the right and +y above.
        let at = |x, y| view.pixel_from_camera(view.camera_from_world(DVec3::new(x, y, 0.0)));
        let (middle, right, above) = (at(0.0, 1.0), at(0.5, 1.0), at(0.0, 1.5));
        assert_eq!(middle, (100.0, 50.0));
        assert!(right.0 > 100.0 && (right.1 - 50.0).abs() < 1e-9);
        assert!(above.1 < 50.0 && (above.0 - 100.0).abs() < 1e-9);
        assert_eq!(view.camera_from_world(DVec3::new(0.0, 1.0, 3.0)).z, 2.0);
    }

    #[test]
    fn matrices_agree_with_the_projection() {
        for projection in [
            Projection::Perspective { vertical_fov: 0.7 },
            Projection::Orthographic { height: 3.0 },
        ] {
            let view = view(projection);
            for point in [DVec3::new(0.3, 0.9, 0.2), DVec3::new(-1.0, 1.4, -2.0)] {
                let camera = view.camera_from_world(point);
                let (x, y) = view.pixel_from_camera(camera);
                let (origin, direction) = view.line_of_sight([x, y]);
                assert!((origin + direction * camera.z - point).length() < 1e-9);
                let matrix = row_times(point, &view.world_to_camera());
                assert!((matrix - camera).length() < 1e-5);
                let ndc = row_times(point, &view.world_to_ndc());
                assert!((ndc.x * 200.0 - x).abs() < 1e-3, "{} {x}", ndc.x * 200.0);
                assert!((ndc.y * 100.0 - y).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn zoom_enlarges_about_the_middle() {
        for projection in [
            Projection::Perspective { vertical_fov: 1.2 },
            Projection::Orthographic { height: 3.0 },
        ] {
            let plain = view(projection);
            let zoomed = View::new(plain.camera.zoomed(2.5), plain.size).unwrap();
            let point = DVec3::new(0.3, 1.2, -0.4);
            let at = |view: &View| view.pixel_from_camera(view.camera_from_world(point));
            let ((x, y), (zoomed_x, zoomed_y)) = (at(&plain), at(&zoomed));
            assert!((zoomed_x - 100.0 - 2.5 * (x - 100.0)).abs() < 1e-9);
            assert!((zoomed_y - 50.0 - 2.5 * (y - 50.0)).abs() < 1e-9);
        }
    }

    #[test]
    fn impossible_cameras_are_refused() {
        let good = view(Projection::Orthographic { height: 1.0 }).camera;
        let refused = |camera| View::new(camera, [10, 10]).unwrap_err().to_string();
        let nan = DVec3::new(f64::NAN, 0.0, 0.0);
        assert!(
            refused(Camera {
                position: nan,
                ..good
            })
            .contains("position")
        );
        let itself = Camera {
            target: good.position,
            ..good
        };
        assert!(refused(itself).contains("target"));
        assert!(
            refused(Camera {
                up: DVec3::Z,
                ..good
            })
            .contains("line of sight")
        );
        let flat = Projection::Perspective { vertical_fov: 0.0 };
        assert!(
            refused(Camera {
                projection: flat,
                ..good
            })
            .contains("field of view")
        );
    }
}
