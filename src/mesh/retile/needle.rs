//! The thinnest triangle of a mesh: what keeps a mesh with an outlying vertex from being retiled.
//!
//! The long edges of a needle of length L and width w are cut into many pieces while its area asks
//! for few vertices. Each cut leaves thinner needles, so that the pieces grow faster than L.
//! [`Retiler`](super::Retiler) stops cutting in time and names the outlying vertex.

use glam::Vec3;

use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A long, thin triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needle {
    /// The vertex at its tip, opposite the shortest edge.
    pub tip: u32,
    /// Where that is.
    pub position: Vec3,
    /// Its longest edge.
    pub length: f32,
    /// Its height over the longest edge.
    pub width: f32,
}

impl Needle {
    /// The triangle whose longest edge is longest against its height; of equal ones the first.
    pub fn of(mesh: &TriangleMesh) -> Option<Self> {
        let needles = (0..mesh.triangles.len()).map(|triangle| Self::of_triangle(mesh, triangle));
        needles.reduce(
            |thinnest, needle| match needle.slenderness() > thinnest.slenderness() {
                true => needle,
                false => thinnest,
            },
        )
    }

    fn of_triangle(mesh: &TriangleMesh, triangle: usize) -> Self {
        let corners = mesh.corners(triangle);
        let opposite = |k: usize| corners[(k + 1) % 3].distance(corners[(k + 2) % 3]);
        let edges = [0, 1, 2].map(opposite);
        let shortest = (1..3).fold(0, |best, k| if edges[k] < edges[best] { k } else { best });
        let length = edges.into_iter().fold(0.0, f32::max);
        Self {
            tip: mesh.triangles.get(triangle).map_or(NONE, |t| t[shortest]),
            position: corners[shortest],
            length,
            width: mesh.area_normal(triangle).length() / length.max(f32::MIN_POSITIVE),
        }
    }

    fn slenderness(&self) -> f32 {
        self.length / self.width.max(f32::MIN_POSITIVE)
    }

    /// What the user should know of it.
    pub fn note(&self) -> String {
        let Vec3 { x, y, z } = self.position;
        format!(
            "vertex {} at ({x}, {y}, {z}) is far from its neighbours: its triangle is {:.4} long and {:.4} wide, {:.0} to 1; \
             such triangles stay coarser than asked, unless that vertex is corrected or removed",
            self.tip,
            self.length,
            self.width,
            self.slenderness()
        )
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::time::{Duration, Instant};

    use super::*;
    use crate::mesh::retile::retile;
    use crate::mesh::shapes;
    use crate::progress::{Event, Progress};

    /// Retiles to 120 vertices; hands back their number and what was warned of.
    fn retiled(mesh: &TriangleMesh) -> (usize, Vec<String>) {
        let warnings = Mutex::new(Vec::new());
        let listen = |event| {
            if let Event::Warn(text) = event {
                warnings.lock().unwrap().push(text);
            }
        };
        let even = retile(mesh, 120, 0.7, Progress::new(&listen, None)).unwrap();
        (even.positions.len(), warnings.into_inner().unwrap())
    }

    #[test]
    fn an_outlying_vertex_costs_no_time_and_is_named() {
        let mut far = shapes::icosphere(2);
        far.positions[40].x = 65_536.0;
        let mut needle = shapes::icosphere(2);
        let count = needle.positions.len() as u32;
        let tip = Vec3::Y * 65_536.0;
        needle.positions.extend([Vec3::ZERO, Vec3::X * 0.1, tip]);
        needle.triangles.push([count, count + 1, count + 2]);
        let begun = Instant::now();
        for (mesh, vertex) in [(far, 40), (needle, count + 2)] {
            let (_, warnings) = retiled(&mesh);
            let named = format!("vertex {vertex} at");
            assert!(
                warnings.len() == 1
                    && warnings[0].contains(&named)
                    && warnings[0].contains("65536"),
                "{warnings:?}"
            );
        }
        // A fraction of a second each; cut to the end, the needle alone takes minutes.
        assert!(begun.elapsed() < Duration::from_secs(20));
    }

    #[test]
    fn far_clusters_and_unused_far_vertices_are_nothing_odd() {
        let mut clusters = shapes::icosphere(2);
        let (count, triangles) = (clusters.positions.len() as u32, clusters.triangles.clone());
        let moved: Vec<Vec3> = clusters
            .positions
            .iter()
            .map(|p| *p + Vec3::X * 65_536.0)
            .collect();
        clusters.positions.extend(moved);
        clusters
            .triangles
            .extend(triangles.iter().map(|t| t.map(|v| v + count)));
        let mut unused = shapes::icosphere(2);
        unused.positions.push(Vec3::splat(65_536.0));
        for mesh in [clusters, unused] {
            let (count, warnings) = retiled(&mesh);
            assert!(count == 120 && warnings.is_empty(), "{count} {warnings:?}");
        }
    }
}
