//! One pass that makes a manifold mesh of what a file holds, and says what it changed.
//!
//! Steps, in order: polygons to triangles; vertices at the same place made one; triangles without
//! area or said twice dropped; specks dropped; triangles turned to face one way; edges and vertices
//! where more than one surface meets split. Not done: filling holes, mending crossings.

mod manifold;
mod orientation;
mod welding;

use serde::{Deserialize, Serialize};

use crate::mesh::topology::{component_diagonals, components};
use crate::mesh::triangle_mesh::TriangleMesh;

pub use manifold::{Split, split_non_manifold};
pub use welding::weld;

/// What cleaning changed, in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct RepairReport {
    /// Vertices at the place of an earlier one, made one with it.
    pub welded_vertices: usize,
    /// Polygons of four and more corners cut into triangles (no repair: the surface is the same).
    pub cut_polygons: usize,
    /// Triangles without area, dropped.
    pub empty_triangles: usize,
    /// Triangles with the same corners as an earlier one, dropped.
    pub repeated_triangles: usize,
    /// Components smaller than asked, dropped.
    pub specks: usize,
    /// Triangles turned over to face as their neighbours do.
    pub turned_triangles: usize,
    /// Edges cut because three and more triangles met there.
    pub cut_edges: usize,
    /// Edges cut because the surface has but one side (a Möbius strip).
    pub one_sided_edges: usize,
    /// Vertices added where surfaces met in a point or cut edge.
    pub split_vertices: usize,
    /// Vertices in no triangle, kept in their place.
    pub unused_vertices: usize,
    /// The first thing that was wrong, by its place in the file.
    pub first: Option<String>,
    /// The components that were turned, whole or in part.
    pub turned_components: Vec<TurnedComponent>,
    /// Faces that the reader left out.
    pub notes: Vec<String>,
    /// What the file holds beside the surface and could not be used: no repair.
    pub unused: Vec<String>,
}

/// A component of which triangles were turned to face one way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct TurnedComponent {
    /// Its triangles.
    pub triangles: usize,
    /// Those that were turned.
    pub turned: usize,
    /// The middle of its box, in the file's coordinates.
    pub centre: [f64; 3],
}

impl TurnedComponent {
    fn line(&self) -> String {
        let [x, y, z] = self.centre;
        format!(
            "component round ({x:.6}, {y:.6}, {z:.6}): {} of {} triangles turned",
            self.turned, self.triangles
        )
    }
}

/// Turned components that are named one by one.
const NAMED: usize = 8;

impl RepairReport {
    /// Whether the file was sound as it was: nothing left out, cut, turned or split. Vertices a
    /// format must repeat, polygons and unused vertices are no fault.
    pub fn is_sound(&self) -> bool {
        self.empty_triangles == 0
            && self.repeated_triangles == 0
            && self.specks == 0
            && self.turned_triangles == 0
            && self.cut_edges == 0
            && self.one_sided_edges == 0
            && self.split_vertices == 0
            && self.notes.is_empty()
    }

    /// One line for every kind of change.
    pub fn lines(&self) -> Vec<String> {
        let counts = [
            (
                self.welded_vertices,
                "vertices made one with another at the same place",
            ),
            (self.cut_polygons, "polygons cut into triangles"),
            (self.empty_triangles, "triangles without area dropped"),
            (self.repeated_triangles, "repeated triangles dropped"),
            (self.specks, "specks dropped"),
            (
                self.turned_triangles,
                "triangles turned to face as their neighbours",
            ),
            (self.cut_edges, "edges of three and more triangles cut"),
            (
                self.one_sided_edges,
                "edges cut to give the surface two sides",
            ),
            (
                self.split_vertices,
                "vertices added where surfaces met in a point or cut edge",
            ),
            (self.unused_vertices, "vertices in no triangle kept"),
        ];
        let told = counts.iter().filter(|(count, _)| *count > 0);
        let mut lines: Vec<String> = told
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        let named = self.turned_components.iter().take(NAMED);
        lines.extend(named.map(TurnedComponent::line));
        if let Some(more @ 1..) = self.turned_components.len().checked_sub(NAMED) {
            lines.push(format!("{more} more components turned"));
        }
        lines.extend(self.notes.iter().cloned());
        lines
    }

    fn say_first(&mut self, what: impl FnOnce() -> String) {
        if self.first.is_none() {
            self.first = Some(what());
        }
    }
}

/// Keeps the triangles of a list that say so, and what belongs to them.
pub(crate) fn retain_triangles<T>(
    mesh: &mut TriangleMesh,
    attached: Option<&mut Vec<T>>,
    keep: &[bool],
) {
    let mut flags = keep.iter();
    mesh.triangles
        .retain(|_| flags.next().copied().unwrap_or(false));
    if let Some(attached) = attached {
        let mut flags = keep.iter();
        attached.retain(|_| flags.next().copied().unwrap_or(false));
    }
}

/// Which triangles to keep: those with an area that no earlier one has the corners of.
pub fn useful_triangles(mesh: &TriangleMesh, report: &mut RepairReport) -> Vec<bool> {
    let mut order: Vec<([u32; 3], u32)> = (0..mesh.triangles.len() as u32)
        .map(|t| {
            let mut corners = mesh.triangles[t as usize];
            corners.sort_unstable();
            (corners, t)
        })
        .collect();
    order.sort_unstable();
    let mut keep = vec![true; mesh.triangles.len()];
    for pair in order.windows(2) {
        if pair[0].0 == pair[1].0 {
            keep[pair[1].1 as usize] = false;
            report.repeated_triangles += 1;
        }
    }
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
