//! The cameras of a sweep: where the options and the sweep's files put them.

use std::cell::OnceCell;

use glam::DVec3;

use crate::render::azimuth::{AzimuthFrame, is_along};
use crate::render::bounds::used_points;
use crate::render::camera::{Camera, Projection};
use crate::render::framing::{Aim, FittedProjection, Framed};
use crate::render::option_values::{ProjectionKind, Sweep};
use crate::render::options::RenderOptions;
use crate::render::path_file::Row;
use crate::render::subject::Subject;

/// Finds the camera of each frame.
pub struct CameraPlan<'a> {
    options: &'a RenderOptions,
    subject: &'a Subject<'a>,
    /// Azimuth 0 at the front.
    azimuths: AzimuthFrame,
    course: Course,
    /// The frame of all cameras but those of files.
    framed: OnceCell<Framed>,
}

/// Where a camera goes in the course of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Course {
    /// Nowhere.
    Still,
    /// Round the up axis.
    Circle,
    /// Where a file says.
    Anywhere,
}

impl<'a> CameraPlan<'a> {
    /// The cameras of a sweep with these rows of files.
    pub fn new(options: &'a RenderOptions, subject: &'a Subject<'a>, rows: &[Row]) -> Self {
        let course = if rows.iter().any(Row::moves_camera) {
            Course::Anywhere
        } else if options.sweep.kind == Sweep::ViewOrbit {
            Course::Circle
        } else {
            Course::Still
        };
        Self {
            options,
            subject,
            azimuths: AzimuthFrame::facing(options.camera.up, subject.front.axis),
            course,
            framed: OnceCell::new(),
        }
    }

    /// Azimuth 0 at the front.
    pub fn azimuths(&self) -> &AzimuthFrame {
        &self.azimuths
    }

    /// The camera of a frame of which the sweep says `row`.
    pub fn camera(&self, row: &Row) -> Camera {
        let options = self.options;
        // Find what the frame says, else the options.
        let azimuth = row.camera_azimuth.unwrap_or(options.camera.camera_azimuth);
        let elevation = row
            .camera_elevation
            .unwrap_or(options.camera.camera_elevation);
        let target = self.point(row.target.or(options.camera.camera_target.map(|p| p.0)));
        let middle = target.unwrap_or(self.subject.bounds.centre);
        // Find position and direction.
        let position = match (self.point(row.camera), self.stated_position()) {
            (Some(position), _) => Some(position),
            (None, Some(position)) => Some(self.orbited(position, middle, azimuth)),
            (None, None) => None,
        };
        let towards = match position {
            Some(position) => (position - middle).normalize_or_zero(),
            None => self
                .azimuths
                .direction(azimuth.to_radians(), elevation.to_radians()),
        };
        // Frame the subject unless position or target are given.
        let up = row.up.map(DVec3::from_array);
        let [width, height] = options.image.size.0.map(f64::from);
        let aim = Aim {
            target: middle,
            towards,
            up: up.unwrap_or_else(|| self.upright(towards)),
            projection: self.projection(row),
            aspect: width / height,
        };
        let is_free = position.is_none() && target.is_none();
        let mut camera = aim.camera(&self.framed(&aim, is_free));
        camera.position = position.unwrap_or(camera.position);
        // Apply a stated height and the zoom.
        let stated_height = row.view_height.or(options.camera.view_height);
        if let (Projection::Orthographic { height }, Some(stated)) =
            (&mut camera.projection, stated_height)
        {
            *height = stated;
        }
        match options.camera.zoom == 1.0 {
            true => camera,
            false => camera.zoomed(options.camera.zoom),
        }
    }

    /// What a camera is fitted to: `is_free` where nothing says what is in the picture's middle.
    fn framed(&self, aim: &Aim, is_free: bool) -> Framed {
        let Subject { mesh, bounds, .. } = self.subject;
        let points = || used_points(mesh);
        let radius = bounds.radius + (aim.target - bounds.centre).length();
        let found = || match self.course {
            Course::Still => aim.still(points(), bounds.radius, is_free),
            Course::Circle => aim.circle(points(), bounds.radius, self.azimuths.up()),
            Course::Anywhere => aim.sphere(radius),
        };
        match self.course {
            Course::Anywhere => found(),
            Course::Still | Course::Circle => *self.framed.get_or_init(found),
        }
    }

    fn projection(&self, row: &Row) -> FittedProjection {
        let stated = self.options.camera.vertical_fov();
        match self.options.camera.projection {
            ProjectionKind::Perspective => FittedProjection::Perspective {
                vertical_fov: row.fov.map_or(stated, f64::to_radians),
            },
            ProjectionKind::Orthographic => FittedProjection::Orthographic,
        }
    }

    fn stated_position(&self) -> Option<DVec3> {
        self.point(self.options.camera.camera_position.map(|p| p.0))
    }

    /// A point that options or files name, in the mesh's coordinates.
    fn point(&self, given: Option<[f64; 3]>) -> Option<DVec3> {
        given.map(|point| DVec3::from_array(point) - self.subject.origin)
    }

    /// A given viewpoint, carried round the target by an orbit.
    fn orbited(&self, position: DVec3, target: DVec3, azimuth: f64) -> DVec3 {
        let offset = position - target;
        let (own, elevation) = self.azimuths.angles(offset);
        let turned = own + (azimuth - self.options.camera.camera_azimuth).to_radians();
        if turned == own {
            return position;
        }
        target + self.azimuths.direction(turned, elevation) * offset.length()
    }

    /// The up vector, or the front where the camera looks along it.
    fn upright(&self, towards: DVec3) -> DVec3 {
        let up = self.azimuths.up();
        if is_along(up, towards) {
            // Looking down, the front is at the picture's bottom; looking up, at its top.
            return self.azimuths.zero() * -up.dot(towards).signum();
        }
        up
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::triangle_mesh::TriangleMesh;
    use crate::render::camera::View;
    use crate::render::option_values::{ImageSize, Point};
    use crate::render::options::{CameraOptions, ImageOptions, SweepOptions};

    /// A long ball, off the origin.
    fn mesh() -> TriangleMesh {
        let mut mesh = shapes::icosphere(3);
        for p in &mut mesh.positions {
            *p = glam::Vec3::new(3.0 * p.x + 5.0, p.y, 0.7 * p.z);
        }
        mesh
    }

    fn options() -> RenderOptions {
        RenderOptions {
            image: ImageOptions {
                size: ImageSize([400, 300]),
                ..ImageOptions::default()
            },
            ..RenderOptions::default()
        }
    }

    /// The part of the picture's width that the mesh takes from a camera.
    fn width(camera: Camera) -> f64 {
        let view = View::new(camera, [400, 300]).unwrap();
        let mesh = mesh();
        let across =
            used_points(&mesh).map(|p| view.pixel_from_camera(view.camera_from_world(p)).0);
        let (least, most) = across.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), x| {
            (a.min(x), b.max(x))
        });
        (most - least) / 400.0
    }

    fn camera(options: &RenderOptions, row: &Row) -> Camera {
        let mesh = mesh();
        let subject = Subject::new(&mesh, DVec3::ZERO, options).unwrap();
        CameraPlan::new(options, &subject, &[*row]).camera(row)
    }

    #[test]
    fn surfaces_fill_the_picture() {
        let plain = camera(&options(), &Row::default());
        assert!((width(plain) - 1.0 / 1.05).abs() < 0.01, "{plain:?}");
        // From the narrow side too.
        let side = RenderOptions {
            camera: CameraOptions {
                camera_azimuth: 90.0,
                ..options().camera
            },
            ..options()
        };
        let side = camera(&side, &Row::default());
        assert!((0.4..0.9).contains(&width(side)), "{side:?}");
        assert!(side.position.distance(side.target) < plain.position.distance(plain.target));
        let zoomed = RenderOptions {
            camera: CameraOptions {
                zoom: 0.5,
                ..options().camera
            },
            ..options()
        };
        let zoomed = camera(&zoomed, &Row::default());
        assert!((width(zoomed) - 0.5 / 1.05).abs() < 0.01, "{zoomed:?}");
    }

    #[test]
    fn an_orbit_keeps_its_distance() {
        let orbit = RenderOptions {
            sweep: SweepOptions {
                kind: Sweep::ViewOrbit,
                ..options().sweep
            },
            ..options()
        };
        let at = |azimuth: f64| {
            let row = Row {
                camera_azimuth: Some(azimuth),
                ..Row::default()
            };
            let mesh = mesh();
            let subject = Subject::new(&mesh, DVec3::ZERO, &orbit).unwrap();
            CameraPlan::new(&orbit, &subject, &[]).camera(&row)
        };
        let distances = [0.0, 50.0, 90.0].map(|azimuth| {
            let camera = at(azimuth);
            assert!(width(camera) < 0.96);
            camera.position.distance(camera.target)
        });
        assert!(distances.iter().all(|d| (d - distances[0]).abs() < 1e-9));
    }

    #[test]
    fn files_that_move_the_camera_fit_a_sphere() {
        let row = Row {
            camera_elevation: Some(40.0),
            ..Row::default()
        };
        let camera = camera(&options(), &row);
        let radius = 3.0 * 1.05 / 15f64.to_radians().sin();
        let distance = camera.position.distance(camera.target);
        assert!(
            (distance / radius - 1.0).abs() < 0.05,
            "{distance} {radius}"
        );
    }

    #[test]
    fn given_points_are_kept() {
        let given = RenderOptions {
            camera: CameraOptions {
                camera_target: Some(Point([5.0, 0.5, 0.0])),
                ..options().camera
            },
            ..options()
        };
        let target = camera(&given, &Row::default()).target;
        assert_eq!(target, DVec3::new(5.0, 0.5, 0.0));
        let given = RenderOptions {
            camera: CameraOptions {
                camera_position: Some(Point([5.0, 8.0, 0.0])),
                ..given.camera
            },
            ..given
        };
        let camera = camera(&given, &Row::default());
        assert_eq!(camera.position, DVec3::new(5.0, 8.0, 0.0));
        // Looking down: the front is at the bottom.
        assert_eq!(camera.up, -DVec3::Z);
    }
}
