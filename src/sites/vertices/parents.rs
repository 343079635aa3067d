//! The parent point of every vertex on the coarser level, found along the normal (Tong 2002 §5.1),
//! and the chart that begins there.

use glam::{DVec2, Quat, Vec2, Vec3};
use rayon::prelude::*;

use crate::mesh::chart::Placed;
use crate::mesh::connection::Connection;
use crate::mesh::frame::Frame;
use crate::mesh::surface_bvh::{SurfaceBvh, SurfacePoint};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::level::Parent;

/// Farther along the normal than this multiple of the coarser level's texel, a crossing belongs to
/// another part of the surface.
const REACH: f32 = 2.0;

/// Parent points of all vertices; nowhere for one in no triangle. Where the normal meets nothing
/// near that faces the same way, the nearest point that does, or else the nearest, stands in;
/// `coarse_texel` is the coarser level's texel in mesh units.
pub fn parent_points(
    mesh: &TriangleMesh,
    normals: &[Vec3],
    coarse: &SurfaceBvh,
    coarse_texel: f32,
) -> Vec<SurfacePoint> {
    let referenced = mesh.referenced();
    (0..mesh.positions.len())
        .into_par_iter()
        .with_min_len(256)
        .map(|vertex| {
            let (point, normal) = (mesh.positions[vertex], normals[vertex]);
            let facing = |corners: &[Vec3; 3]| {
                let [a, b, c] = corners;
                (b - a).cross(c - a).dot(normal) > 0.0
            };
            let reach = REACH * coarse_texel;
            if !referenced[vertex] {
                return SurfacePoint::NOWHERE;
            }
            coarse
                .along_line(point, normal, reach)
                .or_else(|| coarse.nearest_accepted(point, 2.0 * reach, facing))
                .or_else(|| coarse.nearest(point))
                .unwrap_or(SurfacePoint::NOWHERE)
        })
        .collect()
}

/// The corners of a parent point's triangle as seeds of a chart round the point, in the frame of the child carried
/// there: rotated by the least rotation that lays its normal on the triangle's.
pub fn seeds(
    coarse: &TriangleMesh,
    connection: &Connection,
    point: &SurfacePoint,
    child: &Frame,
) -> [Placed; 3] {
    let ids = coarse.triangles[point.triangle as usize];
    let corners = coarse.corners(point.triangle as usize);
    let normal = coarse
        .area_normal(point.triangle as usize)
        .normalize_or(child.n);
    let s = Quat::from_rotation_arc(child.n, normal) * child.s;
    let t = normal.cross(s);
    let flat = corners.map(|corner| {
        let arm = corner - point.position;
        Vec2::new(arm.dot(s), arm.dot(t))
    });
    std::array::from_fn(|k| Placed {
        vertex: ids[k],
        position: flat[k],
        rotation: corner_rotation(connection, ids, flat, k),
    })
}

/// How a corner's frame stands to the chart: its two edges of the triangle are seen in both.
fn corner_rotation(connection: &Connection, ids: [u32; 3], flat: [Vec2; 3], k: usize) -> Vec2 {
    let spokes = connection.spokes.row(ids[k] as usize);
    let mut sum = DVec2::ZERO;
    for other in [(k + 1) % 3, (k + 2) % 3] {
        let drawn = (flat[other] - flat[k]).as_dvec2();
        if let Some(spoke) = spokes.iter().find(|spoke| spoke.target == ids[other]) {
            let own = spoke.edge.as_dvec2().normalize_or_zero();
            sum += DVec2::new(own.x, -own.y).rotate(drawn.normalize_or_zero());
        }
    }
    sum.normalize_or(DVec2::X).as_vec2()
}

/// The corner with the largest weight (ties: the first), seen from the parent point; one coarse
/// texel is `texel` mesh units.
pub fn nearest_corner(point: &SurfacePoint, seeds: &[Placed; 3], texel: f32) -> Parent {
    let w = point.weights;
    let largest = if w[0] >= w[1] && w[0] >= w[2] {
        0
    } else if w[1] >= w[2] {
        1
    } else {
        2
    };
    let at = seeds[largest].position / texel;
    Parent {
        site: seeds[largest].vertex,
        x: at.x,
        y: at.y,
    }
}
