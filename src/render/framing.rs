//! Framing: how far off a camera stands so that the surface fills its picture.
//!
//! A still camera is fitted to the silhouette it sees, an orbiting one to the silhouettes of its whole orbit, any other
//! to a bounding sphere. A sweep has one fit, so the surface keeps its size from frame to frame. All fits are closed
//! forms: each point of the surface gives a least distance of the camera.

use glam::DVec3;

use crate::render::camera::{Camera, Projection};

/// How much larger the picture is than what it is fitted to.
const MARGIN: f64 = 1.05;
/// The least distance from a perspective camera to the surface, over the surface's radius: nearer, a point that is
/// turned to the camera would cover all behind it.
const CLEARANCE: f64 = 0.25;

/// A camera that is yet to be fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The point looked at.
    pub target: DVec3,
    /// The unit direction from there to the camera.
    pub towards: DVec3,
    /// What is up in the picture; not along `towards`.
    pub up: DVec3,
    /// How points fall on the picture.
    pub projection: FittedProjection,
    /// The picture's width over its height.
    pub aspect: f64,
}

/// The projection of a camera that is yet to be fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FittedProjection {
    /// See [`Projection::Perspective`].
    Perspective {
        /// The angle between the image's top and bottom, in radians.
        vertical_fov: f64,
    },
    /// The height follows from what is to be seen.
    Orthographic,
}

/// Where a fitted camera stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framed {
    /// By how much the target is moved across the line of sight, so that the surface is in the picture's middle.
    pub shift: DVec3,
    /// From the target to the camera, in mesh units.
    pub distance: f64,
    /// The height of the picture at the target, in mesh units.
    pub height: f64,
}

/// The range of a number over all points.
#[derive(Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    const NONE: Self = Self {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    fn add(&mut self, low: f64, high: f64) {
        self.low = self.low.min(low);
        self.high = self.high.max(high);
    }

    /// Half the range about its middle, or about 0; and where that is.
    fn half(self, centred: bool) -> (f64, f64) {
        match centred {
            true => (0.5 * (self.high - self.low), 0.5 * (self.high + self.low)),
            false => (self.high.max(-self.low), 0.0),
        }
    }
}

impl Aim {
    /// The place from which points of a surface fill the picture. `radius` is that of the surface; with `centred` the
    /// target may be moved.
    pub fn still(&self, points: impl Iterator<Item = DVec3>, radius: f64, centred: bool) -> Framed {
        let (right, up) = self.axes();
        let slopes = self.slopes();
        let [mut across, mut upwards] = [Range::NONE; 2];
        let mut nearest = f64::NEG_INFINITY;
        for point in points {
            let offset = point - self.target;
            let (x, y) = (offset.dot(right), offset.dot(up));
            let depth = offset.dot(self.towards);
            let [wide, high] = slopes.map(|slope| slope * depth);
            across.add(x - wide, x + wide);
            upwards.add(y - high, y + high);
            nearest = nearest.max(depth);
        }
        let ((wide, x), (high, y)) = (across.half(centred), upwards.half(centred));
        Framed {
            shift: right * x + up * y,
            ..self.framed([wide, high], nearest, radius)
        }
    }

    /// The place from which the points of a surface stay in the picture while the camera turns about `axis`, a unit
    /// vector.
    pub fn circle(&self, points: impl Iterator<Item = DVec3>, radius: f64, axis: DVec3) -> Framed {
        let (sin, cos) = {
            let sin = self.towards.dot(axis).clamp(-1.0, 1.0);
            (sin, (1.0 - sin * sin).sqrt())
        };
        let [wide, high] = self.slopes();
        let mut halves = [0.0f64; 2];
        let mut nearest = f64::NEG_INFINITY;
        for point in points {
            let offset = point - self.target;
            let along = offset.dot(axis);
            let round = (offset - axis * along).length();
            // On its circle a point is at most as far right, up and down as this, less what its depth adds.
            let right = round * (wide * cos).hypot(1.0) + wide * along * sin;
            let above = round * (high * cos - sin).abs() + along * (high * sin + cos);
            let below = round * (high * cos + sin).abs() + along * (high * sin - cos);
            halves = [halves[0].max(right), halves[1].max(above).max(below)];
            nearest = nearest.max(round * cos + along * sin);
        }
        self.framed(halves, nearest, radius)
    }

    /// The place from which a sphere round the target fills the picture.
    pub fn sphere(&self, radius: f64) -> Framed {
        let halves = self.slopes().map(|slope| radius * slope.hypot(1.0));
        self.framed(halves, radius, radius)
    }

    /// The camera at a place.
    pub fn camera(&self, framed: &Framed) -> Camera {
        let target = self.target + framed.shift;
        Camera {
            position: target + self.towards * framed.distance,
            target,
            up: self.up,
            projection: match self.projection {
                FittedProjection::Perspective { vertical_fov } => {
                    Projection::Perspective { vertical_fov }
                }
                FittedProjection::Orthographic => Projection::Orthographic {
                    height: framed.height,
                },
            },
        }
    }

    /// The place from which the half width and height fit the picture. Both are what a perspective picture would need
    /// at the camera's place: how far a point is off the line of sight, and by how much its nearness enlarges it.
    fn framed(&self, [wide, high]: [f64; 2], nearest: f64, radius: f64) -> Framed {
        let (distance, height) = match self.projection {
            FittedProjection::Perspective { .. } => {
                let [x, y] = self.slopes();
                let distance = (wide / x).max(high / y);
                let distance = distance.max(nearest + CLEARANCE * radius);
                (distance, 2.0 * y * distance)
            }
            FittedProjection::Orthographic => {
                let height = 2.0 * MARGIN * high.max(wide / self.aspect);
                (2.0 * radius, height.max(f64::MIN_POSITIVE))
            }
        };
        Framed {
            shift: DVec3::ZERO,
            distance,
            height,
        }
    }

    /// How fast the picture widens and heightens with distance, on either side of the line of sight, less the margin.
    fn slopes(&self) -> [f64; 2] {
        match self.projection {
            FittedProjection::Perspective { vertical_fov } => {
                let slope = (0.5 * vertical_fov).tan() / MARGIN;
                [slope * self.aspect, slope]
            }
            FittedProjection::Orthographic => [0.0; 2],
        }
    }

    /// Right and up in the picture.
    fn axes(&self) -> (DVec3, DVec3) {
        let forward = -self.towards;
        let right = forward.cross(self.up).normalize_or(DVec3::X);
        (right, right.cross(forward))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::camera::View;

    const PROJECTIONS: [FittedProjection; 2] = [
        FittedProjection::Perspective { vertical_fov: 0.6 },
        FittedProjection::Orthographic,
    ];

    fn aim(projection: FittedProjection, aspect: f64, elevation: f64) -> Aim {
        let (sin, cos) = elevation.sin_cos();
        Aim {
            target: DVec3::new(1.0, 2.0, 3.0),
            towards: DVec3::new(0.6 * cos, sin, 0.8 * cos),
            up: DVec3::Y,
            projection,
            aspect,
        }
    }

    /// A lump that is no symmetric thing: points on a bent band about the target.
    fn lump() -> Vec<DVec3> {
        (0..400)
            .map(|k| {
                let (sin, cos) = (f64::from(k) * 0.37).sin_cos();
                let lift = f64::from(k % 20) / 20.0;
                DVec3::new(1.0 + 2.0 * cos, 2.3 + lift + 0.4 * sin, 3.2 + 0.7 * sin)
            })
            .collect()
    }

    /// The parts of the picture that points take: from the left and the top edge, the right and the bottom edge.
    fn taken(camera: Camera, aspect: f64, points: &[DVec3]) -> [[f64; 2]; 2] {
        let size = [(1000.0 * aspect) as u32, 1000];
        let view = View::new(camera, size).unwrap();
        let mut taken = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for &point in points {
            let (x, y) = view.pixel_from_camera(view.camera_from_world(point));
            for (range, at) in taken.iter_mut().zip([x / f64::from(size[0]), y / 1000.0]) {
                *range = [range[0].min(at), range[1].max(at)];
            }
        }
        taken
    }

    #[test]
    fn a_still_camera_is_filled_to_the_margin_and_centred() {
        let points = lump();
        for aspect in [0.5, 1.0, 2.0] {
            for projection in PROJECTIONS {
                let aim = aim(projection, aspect, 0.3);
                let framed = aim.still(points.iter().copied(), 2.2, true);
                let taken = taken(aim.camera(&framed), aspect, &points);
                let extents = taken.map(|[from, to]| to - from);
                let widest = extents[0].max(extents[1]);
                assert!((widest - 1.0 / MARGIN).abs() < 0.01, "{taken:?}");
                let tight = usize::from(extents[1] > extents[0]);
                let middle = 0.5 * (taken[tight][0] + taken[tight][1]);
                assert!((middle - 0.5).abs() < 1e-3, "{taken:?}");
                assert!(taken.iter().all(|[from, to]| *from > 0.0 && *to < 1.0));
            }
        }
    }

    #[test]
    fn a_given_target_stays_in_the_middle() {
        let points = lump();
        for projection in PROJECTIONS {
            let aim = aim(projection, 1.3, 0.3);
            let framed = aim.still(points.iter().copied(), 2.2, false);
            assert_eq!(framed.shift, DVec3::ZERO);
            let taken = taken(aim.camera(&framed), 1.3, &points);
            let reach = taken
                .map(|[from, to]| (0.5 - from).max(to - 0.5))
                .into_iter()
                .fold(0.0, f64::max);
            assert!((reach - 0.5 / MARGIN).abs() < 0.005, "{taken:?}");
        }
    }

    #[test]
    fn an_orbit_is_filled_at_its_fullest_and_never_left() {
        let points = lump();
        for aspect in [0.6, 1.5] {
            for projection in PROJECTIONS {
                for elevation in [-0.4, 0.0, 0.9] {
                    let first = aim(projection, aspect, elevation);
                    let framed = first.circle(points.iter().copied(), 2.2, DVec3::Y);
                    let mut fullest = 0.0f64;
                    for turn in 0..720 {
                        let turn = glam::DQuat::from_rotation_y(f64::from(turn) * 0.008_727);
                        let aim = Aim {
                            towards: turn * first.towards,
                            ..first
                        };
                        let taken = taken(aim.camera(&framed), aspect, &points);
                        let reach = taken.map(|[from, to]| (0.5 - from).max(to - 0.5));
                        fullest = fullest.max(reach[0]).max(reach[1]);
                    }
                    assert!((fullest - 0.5 / MARGIN).abs() < 0.005, "{fullest}");
                }
            }
        }
    }

    #[test]
    fn a_sphere_fills_the_narrow_side() {
        let ball: Vec<DVec3> = (0..4000)
            .map(|k| {
                let y = 1.0 - (f64::from(k) + 0.5) / 2000.0;
                let (sin, cos) = (f64::from(k) * 2.4).sin_cos();
                let round = (1.0 - y * y).sqrt();
                DVec3::new(1.0, 2.0, 3.0) + 2.0 * DVec3::new(round * cos, y, round * sin)
            })
            .collect();
        for aspect in [0.5, 2.0] {
            for projection in PROJECTIONS {
                let aim = aim(projection, aspect, 0.5);
                let of_sphere = aim.sphere(2.0);
                let taken = taken(aim.camera(&of_sphere), aspect, &ball);
                let extents = taken.map(|[from, to]| to - from);
                let widest = extents[0].max(extents[1]);
                assert!((widest - 1.0 / MARGIN).abs() < 0.01, "{taken:?}");
                let of_points = aim.still(ball.iter().copied(), 2.0, true);
                assert!((of_points.distance / of_sphere.distance - 1.0).abs() < 0.01);
            }
        }
    }

    #[test]
    fn a_needle_that_points_at_the_camera_is_seen_from_some_way_off() {
        let aim = aim(PROJECTIONS[0], 1.0, 0.0);
        let needle = [-1.0, 1.0].map(|along| aim.target + aim.towards * along);
        let framed = aim.still(needle.into_iter(), 1.0, true);
        assert!((framed.distance - 1.25).abs() < 1e-12);
    }
}
