//! The front of a mesh: the horizontal side that a camera at azimuth 0 sees.

use std::fmt;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::render::azimuth::{Axis, front_of};

/// Triangles summed by one task; fixed, so that sums do not depend on the thread count.
const CHUNK: usize = 1 << 12;
/// An open surface faces a side when its normals sum up to this share of its area, or more, in horizontal directions.
const FACING: f64 = 0.3;
/// A side is the broad one when it is this many times as broad as the usual front.
const BROADER: f64 = 1.15;

/// The front, and why it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Front {
    /// The side; horizontal.
    pub axis: Axis,
    /// What it was chosen by.
    pub reason: Reason,
}

/// What a front is chosen by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// The user says so.
    Given,
    /// The surface is open, and its outside faces this way.
    Faces,
    /// So many times as much of the surface is seen from there as from the usual front.
    Broad(f64),
    /// No other side is much broader.
    Usual,
}

impl Front {
    /// The front that is `given`, or the likely one: the side that an open surface faces, else the broad side of the
    /// mesh, else the usual front of the up axis. Refuses one that points up or down.
    pub fn of(mesh: &TriangleMesh, up: Axis, given: Option<Axis>) -> Result<Self> {
        match given {
            None => Ok(Self::guess(mesh, up)),
            Some(axis) if axis.vector().dot(up.vector()) == 0.0 => Ok(Self {
                axis,
                reason: Reason::Given,
            }),
            Some(axis) => {
                let sides: Vec<String> = sides(up).iter().map(Axis::to_string).collect();
                Err(Error::option(
                    "front",
                    format!("{axis}, which is up or down with --up {up}"),
                    format!("a horizontal side: {}", sides.join(", ")),
                ))
            }
        }
    }

    fn guess(mesh: &TriangleMesh, up: Axis) -> Self {
        let Facing { sum, sizes, area } = Facing::of(mesh);
        let usual = front_of(up);
        let sides = sides(up);
        let towards = |side: &Axis| side.vector().dot(sum);
        let faced = sides
            .iter()
            .max_by(|a, b| towards(a).total_cmp(&towards(b)));
        if let Some(axis) = faced.filter(|side| towards(side) > FACING * area) {
            return Self {
                axis: *axis,
                reason: Reason::Faces,
            };
        }
        let breadth = |side: Axis| sizes.dot(side.vector().abs());
        let other = sides.into_iter().find(|side| breadth_axis(*side, usual));
        let ratio = |side: Axis| breadth(side) / breadth(usual).max(f64::MIN_POSITIVE);
        match other.filter(|side| breadth(*side) > BROADER * breadth(usual)) {
            Some(axis) => Self {
                axis,
                reason: Reason::Broad(ratio(axis)),
            },
            None => Self {
                axis: usual,
                reason: Reason::Usual,
            },
        }
    }

    /// The front in a sentence.
    pub fn describe(&self) -> String {
        let why = match self.reason {
            Reason::Given => return format!("front: {}", self.axis),
            Reason::Faces => "the side that the surface faces".to_owned(),
            Reason::Broad(ratio) if ratio < 100.0 => {
                format!("the broad side, {ratio:.1} times the usual front")
            }
            Reason::Broad(_) => "the broad side".to_owned(),
            Reason::Usual => "the usual side; no other is much broader".to_owned(),
        };
        format!("front: {} ({why}; --front chooses another)", self.axis)
    }
}

/// The positive side along the other horizontal axis than that of the usual front.
fn breadth_axis(side: Axis, usual: Axis) -> bool {
    let along = side.vector();
    along.dot(usual.vector()) == 0.0 && along.element_sum() > 0.0
}

/// The horizontal sides.
fn sides(up: Axis) -> Vec<Axis> {
    let horizontal = |side: &Axis| side.vector().dot(up.vector()) == 0.0;
    Axis::ALL.into_iter().filter(horizontal).collect()
}

/// Sums over all triangles, of twice the area times the normal.
#[derive(Clone, Copy, Default)]
struct Facing {
    sum: DVec3,
    /// Of the parts along each axis, without their signs.
    sizes: DVec3,
    /// Of the lengths.
    area: f64,
}

impl Facing {
    fn of(mesh: &TriangleMesh) -> Self {
        let all: Vec<usize> = (0..mesh.triangles.len()).step_by(CHUNK).collect();
        let parts: Vec<Self> = all
            .into_par_iter()
            .map(|first| {
                let last = mesh.triangles.len().min(first + CHUNK);
                let normals = (first..last).map(|triangle| mesh.area_normal_f64(triangle));
                normals.fold(Self::default(), |sums, normal| Self {
                    sum: sums.sum + normal,
                    sizes: sums.sizes + normal.abs(),
                    area: sums.area + normal.length(),
                })
            })
            .collect();
        parts.iter().fold(Self::default(), |sums, part| Self {
            sum: sums.sum + part.sum,
            sizes: sums.sizes + part.sizes,
            area: sums.area + part.area,
        })
    }
}

impl fmt::Display for Front {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.axis.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::builtin::kettlebell;
    use crate::mesh::shapes;
    use glam::Vec3;

    fn stretched(by: Vec3) -> TriangleMesh {
        let mut mesh = shapes::icosphere(2);
        mesh.positions.iter_mut().for_each(|p| *p *= by);
        mesh
    }

    fn front(mesh: &TriangleMesh, up: Axis) -> Front {
        Front::of(mesh, up, None).unwrap()
    }

    #[test]
    fn closed_meshes_show_their_broad_side() {
        let long_in_z = stretched(Vec3::new(1.0, 1.0, 2.0));
        assert_eq!(front(&long_in_z, Axis::Y).axis, Axis::X);
        let long_in_x = stretched(Vec3::new(2.0, 1.0, 1.0));
        assert_eq!(front(&long_in_x, Axis::Y).axis, Axis::Z);
        assert_eq!(front(&long_in_x, Axis::Z).axis, Axis::MinusY);
        let long_in_y = stretched(Vec3::new(1.0, 2.0, 1.0));
        assert_eq!(front(&long_in_y, Axis::Z).axis, Axis::X);
        let ball = front(&stretched(Vec3::ONE), Axis::Y);
        assert_eq!((ball.axis, ball.reason), (Axis::Z, Reason::Usual));
        assert_eq!(front(&kettlebell(2000), Axis::Y).axis, Axis::Z);
    }

    #[test]
    fn open_surfaces_show_the_side_they_face() {
        let grid = shapes::grid(3, 3, 1.0);
        let found = front(&grid, Axis::Y);
        assert_eq!((found.axis, found.reason), (Axis::Z, Reason::Faces));
        let mut turned = grid.clone();
        turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        assert_eq!(front(&turned, Axis::Y).axis, Axis::MinusZ);
        // A floor faces up: no side.
        assert_eq!(front(&grid, Axis::Z).axis, Axis::MinusY);
    }

    #[test]
    fn a_front_that_is_up_or_down_is_refused() {
        let grid = shapes::grid(1, 1, 1.0);
        let given = |axis| Front::of(&grid, Axis::Y, Some(axis));
        assert_eq!(given(Axis::MinusX).unwrap().axis, Axis::MinusX);
        let error = given(Axis::MinusY).unwrap_err().to_string();
        assert!(error.starts_with("--front: -y"), "{error}");
        assert!(error.contains("x, z, -x, -z"), "{error}");
    }
}
