//! One pass that makes a manifold mesh of a file's content, and reports what it changed.
//!
//! Steps, in order: polygons are triangulated; vertices at the same position are merged; triangles without area and
//! repeated triangles are removed; specks are removed; triangles are flipped to face one way; edges and vertices
//! where more than one surface meets are split. Holes are not filled; self-intersections are kept.

mod manifold;
mod orientation;
mod report;
mod welding;

use crate::mesh::topology::{component_diagonals, components};
use crate::mesh::triangle_mesh::TriangleMesh;

pub use manifold::{Split, split_non_manifold};
pub use report::{FlippedComponent, RepairReport};
pub use welding::weld;

/// Keeps the entries of a list per triangle for which `keep` says so.
pub(crate) fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    list.retain(|_| flags.next().copied().unwrap_or(false));
}

/// Which triangles to keep: those with an area that no earlier one has the corners of.
pub fn useful_triangles(mesh: &TriangleMesh, report: &mut RepairReport) -> Vec<bool> {
    // Sort the triangles by their corners, whatever their order.
    let mut order: Vec<([u32; 3], u32)> = (0..mesh.triangles.len() as u32)
        .map(|t| {
            let mut corners = mesh.triangles[t as usize];
            corners.sort_unstable();
            (corners, t)
        })
        .collect();
    order.sort_unstable();
    // Drop all but the first of equal ones.
    let mut keep = vec![true; mesh.triangles.len()];
    for pair in order.windows(2) {
        if pair[0].0 == pair[1].0 {
            keep[pair[1].1 as usize] = false;
            report.repeated_triangles += 1;
        }
    }
    // Drop those without area.
    for (triangle, keep) in keep.iter_mut().enumerate() {
        if has_no_area(mesh, triangle) {
            report.repeated_triangles -= usize::from(!*keep);
            report.empty_triangles += 1;
            *keep = false;
            report.say_first(|| {
                format!(
                    "triangle of vertices {:?} without area",
                    mesh.triangles[triangle]
                )
            });
        } else if !*keep {
            report.say_first(|| {
                format!(
                    "repeated triangle of vertices {:?}",
                    mesh.triangles[triangle]
                )
            });
        }
    }
    keep
}

/// Whether a triangle's height is lost in the rounding of its corners.
fn has_no_area(mesh: &TriangleMesh, triangle: usize) -> bool {
    let [a, b, c] = mesh.triangles[triangle];
    if a == b || b == c || c == a {
        return true;
    }
    let corners = mesh.corners(triangle).map(|corner| corner.as_dvec3());
    let longest = (0..3)
        .map(|k| corners[k].distance_squared(corners[(k + 1) % 3]))
        .fold(0.0, f64::max);
    mesh.area_normal_f64(triangle).length() <= 1e-7 * longest
}

/// Which triangles to keep: those of components whose bounding box's diagonal is at least
/// `fraction` of the whole mesh's.
pub fn without_specks(mesh: &TriangleMesh, fraction: f64, report: &mut RepairReport) -> Vec<bool> {
    let (labels, _) = components(mesh);
    let least = fraction * f64::from(mesh.diagonal());
    let sizes = component_diagonals(mesh);
    let large: Vec<bool> = sizes.iter().map(|&size| f64::from(size) >= least).collect();
    report.specks += large.iter().filter(|&&large| !large).count();
    let label = |triangle: &[u32; 3]| labels[triangle[0] as usize] as usize;
    mesh.triangles
        .iter()
        .map(|triangle| large[label(triangle)])
        .collect()
}
