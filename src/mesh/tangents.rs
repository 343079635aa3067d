//! Tangents at the corners of textured triangles, as normal maps are read by them.
//!
//! At a corner the tangent is the direction in which u grows, the mean over the triangles that continue each
//! other there, each by its angle, in the plane of the vertex's normal (as MikkTSpace has it). Corners share a
//! tangent where they share vertex, texture coordinate and handedness.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};

use crate::mesh::triangle_mesh::TriangleMesh;

/// The tangent of every corner as glTF has it: x, y, z a unit vector in which u grows, w = ±1 such that
/// w · (n × tangent) points to where v grows upwards.
///
/// A triangle without area in the texture has a tangent of no meaning.
pub fn corner_tangents(
    mesh: &TriangleMesh,
    normals: &[Vec3],
    corner_uvs: &[[Vec2; 3]],
) -> Vec<[Vec4; 3]> {
    // Sum the directions of u at each corner; corners of one vertex and coordinate share a sum.
    let mut places: HashMap<(u32, [u32; 2], bool), u32> = HashMap::new();
    let mut sums: Vec<Vec3> = Vec::new();
    let mut corners = Vec::with_capacity(mesh.triangles.len());
    for (triangle, vertices) in mesh.triangles.iter().enumerate() {
        let points = mesh.corners(triangle);
        let uvs = corner_uvs[triangle];
        let (along_u, is_mirrored) = along_u(points, uvs);
        corners.push([0, 1, 2].map(|corner| {
            let key = (
                vertices[corner],
                uvs[corner].to_array().map(f32::to_bits),
                is_mirrored,
            );
            let place = *places.entry(key).or_insert_with(|| {
                sums.push(Vec3::ZERO);
                sums.len() as u32 - 1
            });
            let normal = normals[vertices[corner] as usize];
            let flat = along_u - normal * along_u.dot(normal);
            sums[place as usize] += flat.normalize_or_zero() * angle_at(points, corner);
            (place, is_mirrored)
        }));
    }
    // Make each sum a unit tangent.
    let tangent = |vertex: u32, (place, is_mirrored): (u32, bool)| {
        let normal = normals[vertex as usize];
        let sum = sums[place as usize];
        let flat = sum - normal * sum.dot(normal);
        let unit = flat
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        unit.extend(if is_mirrored { -1.0 } else { 1.0 })
    };
    let triangles = mesh.triangles.iter().zip(corners);
    triangles
        .map(|(vertices, corners)| [0, 1, 2].map(|at| tangent(vertices[at], corners[at])))
        .collect()
}

/// The direction of growing u in a triangle's plane, of any length, and whether the texture is mirrored there.
fn along_u([a, b, c]: [Vec3; 3], [u, v, w]: [Vec2; 3]) -> (Vec3, bool) {
    let (e, f) = (b - a, c - a);
    let (d, g) = (v - u, w - u);
    let determinant = d.perp_dot(g);
    let direction = (e * g.y - f * d.y) * determinant.signum();
    (direction.normalize_or_zero(), determinant < 0.0)
}

/// The angle of a triangle at a corner, in radians.
fn angle_at(points: [Vec3; 3], corner: usize) -> f32 {
    let [here, next, last] = [0, 1, 2].map(|step| points[(corner + step) % 3]);
    (next - here).angle_between(last - here)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::rings::vertex_normals;
    use crate::mesh::shapes::{grid, icosphere};

    /// The texture coordinates of a function of position.
    fn uvs(mesh: &TriangleMesh, of: impl Fn(Vec3) -> Vec2) -> Vec<[Vec2; 3]> {
        let triangles = 0..mesh.triangles.len();
        triangles.map(|t| mesh.corners(t).map(&of)).collect()
    }

    #[test]
    fn on_a_plane_tangents_are_the_axes_of_the_texture() {
        let mesh = grid(3, 2, 0.5);
        let normals = vertex_normals(&mesh);
        let facing = normals[0];
        let all = |of: fn(Vec3) -> Vec2| corner_tangents(&mesh, &normals, &uvs(&mesh, of));
        let is_all = |tangents: Vec<[Vec4; 3]>, wanted: Vec3| {
            for tangent in tangents.into_iter().flatten() {
                assert!((tangent.truncate() - wanted).length() < 1e-6, "{tangent}");
                // w turns n × s to where v grows: (0, 1, 0) in all cases here.
                let v = facing.cross(wanted) * tangent.w;
                assert!(v.y > 0.99, "{v}");
            }
        };
        is_all(all(|p| Vec2::new(p.x, p.y)), Vec3::X);
        is_all(all(|p| Vec2::new(1.0 - p.x, p.y)), -Vec3::X);
        is_all(all(|p| Vec2::new(3.0 * p.x, 0.1 * p.y)), Vec3::X);
    }

    #[test]
    fn corners_that_continue_each_other_share_a_tangent() {
        let mesh = icosphere(3);
        let normals = vertex_normals(&mesh);
        let uvs = uvs(&mesh, |p| 0.5 + 0.5 * Vec2::new(p.x, p.y));
        let tangents = corner_tangents(&mesh, &normals, &uvs);
        let mut known: HashMap<(u32, bool), Vec4> = HashMap::new();
        for (vertices, tangents) in mesh.triangles.iter().zip(&tangents) {
            for (vertex, tangent) in vertices.iter().zip(tangents) {
                assert!((tangent.truncate().length() - 1.0).abs() < 1e-5);
                assert!(tangent.truncate().dot(normals[*vertex as usize]).abs() < 1e-5);
                let held = known.entry((*vertex, tangent.w > 0.0)).or_insert(*tangent);
                assert_eq!(held, tangent);
            }
        }
        // Seen from +z the map is upright, from −z mirrored.
        assert!(known.keys().any(|(_, upright)| *upright) && known.keys().any(|(_, up)| !up));
    }

    #[test]
    fn triangles_without_a_texture_have_some_tangent() {
        let mesh = grid(1, 1, 1.0);
        let normals = vertex_normals(&mesh);
        let none = vec![[Vec2::ZERO; 3]; mesh.triangles.len()];
        for tangent in corner_tangents(&mesh, &normals, &none)
            .into_iter()
            .flatten()
        {
            assert!((tangent.truncate().length() - 1.0).abs() < 1e-6);
            assert_eq!(tangent.w, 1.0);
        }
    }
}
