//! A surface without its holes: triangles cut where the alpha channel passes one half.
//!
//! Between the vertices alpha is linear, so a hole's edge is a line in every triangle. Vertices on a border of
//! charts take the mean of what both charts say, so that the edges of holes meet across it.

use std::collections::HashMap;

use glam::Vec2;

use crate::mesh::tessellation::TexturedMesh;
use crate::mesh::triangle_mesh::TriangleMesh;

/// What a texel needs to be drawn.
const OPAQUE: f32 = 0.5;

/// Keeps what is opaque: where `alpha`, a number per vertex, is at least one half.
pub(super) fn cut(surface: TexturedMesh, alpha: &[f32]) -> TexturedMesh {
    let mut cut = Cut {
        alpha,
        kept: TexturedMesh {
            corner_uvs: Vec::with_capacity(surface.corner_uvs.len()),
            mesh: TriangleMesh {
                positions: surface.mesh.positions,
                triangles: Vec::with_capacity(surface.mesh.triangles.len()),
            },
            normals: surface.normals,
        },
        crossings: HashMap::new(),
    };
    for (triangle, uvs) in surface.mesh.triangles.iter().zip(&surface.corner_uvs) {
        cut.triangle([0, 1, 2].map(|at| (triangle[at], uvs[at])));
    }
    cut.kept
}

/// A corner: its vertex and its texture coordinate.
type Corner = (u32, Vec2);

struct Cut<'a> {
    alpha: &'a [f32],
    kept: TexturedMesh,
    /// The vertex at which an edge, smaller vertex first, crosses the border of a hole.
    crossings: HashMap<[u32; 2], u32>,
}

impl Cut<'_> {
    fn is_opaque(&self, (vertex, _): Corner) -> bool {
        self.alpha[vertex as usize] >= OPAQUE
    }

    /// Keeps the opaque part of a triangle: none of it, all, one corner or two.
    fn triangle(&mut self, corners: [Corner; 3]) {
        let opaque = corners.map(|corner| self.is_opaque(corner));
        let count = opaque.iter().filter(|&&opaque| opaque).count();
        // The corner that is unlike the two others comes first.
        let odd = opaque.iter().position(|&is| is == (count == 1));
        let [a, b, c] = match odd {
            Some(first) if count == 1 || count == 2 => {
                [0, 1, 2].map(|at| corners[(first + at) % 3])
            }
            _ => corners,
        };
        match count {
            0 => {}
            1 => {
                let (ab, ac) = (self.crossing(a, b), self.crossing(a, c));
                self.keep([a, ab, ac]);
            }
            2 => {
                let (ab, ac) = (self.crossing(a, b), self.crossing(a, c));
                self.keep([ab, b, c]);
                self.keep([ab, c, ac]);
            }
            _ => self.keep(corners),
        }
    }

    fn keep(&mut self, corners: [Corner; 3]) {
        let [a, b, c] = corners.map(|(vertex, _)| vertex);
        if a != b && b != c && c != a {
            self.kept.mesh.triangles.push([a, b, c]);
            self.kept.corner_uvs.push(corners.map(|(_, uv)| uv));
        }
    }

    /// Where an edge between an opaque and another vertex crosses the border.
    fn crossing(&mut self, a: Corner, b: Corner) -> Corner {
        let ((from, to), is_turned) = match a.0 < b.0 {
            true => ((a, b), false),
            false => ((b, a), true),
        };
        let [low, high] = [from, to].map(|(vertex, _)| self.alpha[vertex as usize]);
        let share = ((OPAQUE - low) / (high - low)).clamp(0.0, 1.0);
        let kept = &mut self.kept;
        let vertex = *self.crossings.entry([from.0, to.0]).or_insert_with(|| {
            let [from, to] = [from.0, to.0].map(|vertex| vertex as usize);
            let (positions, normals) = (&mut kept.mesh.positions, &mut kept.normals);
            positions.push(positions[from].lerp(positions[to], share));
            let normal = normals[from].lerp(normals[to], share);
            normals.push(normal.try_normalize().unwrap_or(normals[from]));
            positions.len() as u32 - 1
        });
        let share_of_b = if is_turned { 1.0 - share } else { share };
        (vertex, a.1.lerp(b.1, share_of_b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::rings::vertex_normals;
    use crate::mesh::shapes;

    #[test]
    fn a_hole_takes_away_its_area_and_leaves_no_cracks() {
        let mesh = shapes::grid(40, 40, 1.0);
        let (low, high) = mesh.bounds();
        let centre = 0.5 * (low + high);
        let surface = TexturedMesh {
            normals: vertex_normals(&mesh),
            corner_uvs: vec![[Vec2::ZERO; 3]; mesh.triangles.len()],
            mesh,
        };
        let radius = 11.3;
        // Alpha falls by a half over the radius, to one half on the circle.
        let alpha: Vec<f32> = surface
            .mesh
            .positions
            .iter()
            .map(|p| 0.5 * p.distance(centre) / radius)
            .collect();
        let area = surface.mesh.area();
        let kept = cut(surface, &alpha);
        let gone = area - kept.mesh.area();
        let disk = std::f64::consts::PI * f64::from(radius).powi(2);
        assert!((gone - disk).abs() < 0.01 * disk, "{gone} of {disk}");
        let topology = crate::mesh::topology::Topology::new(&kept.mesh.triangles);
        for half_edge in topology.boundary_half_edges() {
            let vertex = kept.mesh.triangles[half_edge as usize / 3][half_edge as usize % 3];
            let p = kept.mesh.positions[vertex as usize];
            let on_square = (p - low).truncate().min_element() < 1e-4
                || (high - p).truncate().min_element() < 1e-4;
            assert!(
                on_square || (p.distance(centre) - radius).abs() < 0.1,
                "{p}"
            );
        }
    }

    #[test]
    fn all_or_nothing_is_kept_as_it_is() {
        let mesh = shapes::grid(2, 2, 1.0);
        let surface = TexturedMesh {
            normals: vertex_normals(&mesh),
            corner_uvs: vec![[Vec2::ZERO; 3]; mesh.triangles.len()],
            mesh,
        };
        let vertices = surface.mesh.positions.len();
        assert_eq!(cut(surface.clone(), &vec![1.0; vertices]), surface);
        assert!(cut(surface, &vec![0.0; vertices]).mesh.triangles.is_empty());
    }
}
