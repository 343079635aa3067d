//! The frames that normals are turned between: from a texel's (s, t, n), in which the sample's normals stand,
//! to the tangent space in which programs that draw the GLB read its normal map.

use glam::{Mat3, Vec2, Vec3, Vec4};

use crate::mesh::tangents::corner_tangents;
use crate::mesh::triangle_mesh::TriangleMesh;

/// Tangent space at any point of a textured mesh.
pub(super) struct TangentFrames<'a> {
    mesh: &'a TriangleMesh,
    normals: &'a [Vec3],
    tangents: Vec<[Vec4; 3]>,
}

impl<'a> TangentFrames<'a> {
    pub(super) fn new(
        mesh: &'a TriangleMesh,
        normals: &'a [Vec3],
        corner_uvs: &[[Vec2; 3]],
    ) -> Self {
        Self {
            mesh,
            normals,
            tangents: corner_tangents(mesh, normals, corner_uvs),
        }
    }

    /// Tangent, bitangent and normal at a point of a triangle, as glTF interpolates them: the columns of a
    /// matrix that takes a vector of the normal map to mesh space.
    pub(super) fn at(&self, triangle: u32, weights: [f32; 3]) -> Mat3 {
        let vertices = self.mesh.triangles[triangle as usize];
        let corners = self.tangents[triangle as usize];
        let (mut normal, mut tangent) = (Vec3::ZERO, Vec4::ZERO);
        for ((vertex, corner), weight) in vertices.into_iter().zip(corners).zip(weights) {
            normal += weight * self.normals[vertex as usize];
            tangent += weight * corner;
        }
        let n = normal
            .try_normalize()
            .unwrap_or(self.normals[vertices[0] as usize]);
        let t = tangent
            .truncate()
            .try_normalize()
            .unwrap_or(corners[0].truncate());
        Mat3::from_cols(t, n.cross(t) * tangent.w.signum(), n)
    }
}

/// A texel's frame s, t, n: the columns of a matrix that takes a normal of the sample to mesh space.
pub(super) fn sample_frame(normal: Vec3, orientation: Vec3) -> Mat3 {
    Mat3::from_cols(orientation, normal.cross(orientation), normal)
}

/// A vector of mesh space in a frame, at length 1.
pub(super) fn in_frame(frame: &Mat3, vector: Vec3) -> Vec3 {
    let turned = match frame.determinant().abs() > 1e-3 {
        true => frame.inverse() * vector,
        false => frame.transpose() * vector,
    };
    turned.try_normalize().unwrap_or(Vec3::Z)
}
