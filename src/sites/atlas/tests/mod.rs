//! Meshes with known atlases.

mod closed_forms;
mod faces;
mod flat;
mod prepared;

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::options::{AtlasOptions, Sampling};
use super::preparation::{AtlasSurface, prepare};
use super::sites::AtlasSites;
use crate::mesh::reading::UserMesh;
use crate::mesh::shapes;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;
use crate::sites::level::{SampleLocation, SiteHierarchy};

const BOTH: [Sampling; 2] = [Sampling::Charts, Sampling::Marching];

fn prepared(user: &UserMesh, options: &AtlasOptions) -> (AtlasSurface, SiteHierarchy<AtlasSites>) {
    prepare(user, options, Progress::silent()).unwrap()
}

/// The unit square as a grid, s along x; texture coordinates are positions.
fn flat(side: u32) -> UserMesh {
    let mesh = shapes::grid(side, side, 1.0 / side as f32);
    let uvs = (0..mesh.triangles.len())
        .map(|t| mesh.corners(t).map(|corner| corner.truncate()))
        .collect();
    UserMesh {
        orientation: Some(vec![Vec3::X; mesh.positions.len()]),
        corner_uvs: Some(uvs),
        ..UserMesh::from(mesh)
    }
}

const AROUND: u32 = 48;
const STEP: f32 = 0.1;
/// Mesh units that the texture of the cylinder is wide.
const WIDE: f32 = 7.0;

/// A cylinder of radius 1 that is cut open along x, unrolled in its texture; s runs around it.
fn cylinder() -> UserMesh {
    let mesh = shapes::cylinder(AROUND, 12, 1.0, STEP);
    let side = side_of_cylinder();
    let corner = |vertex: u32, last: bool| {
        let (column, row) = (vertex % AROUND, vertex / AROUND);
        let column = if last && column == 0 { AROUND } else { column };
        Vec2::new(column as f32 * side, row as f32 * STEP) / WIDE + 0.02
    };
    let uvs = mesh
        .triangles
        .iter()
        .map(|ids| {
            let last = ids.iter().any(|id| id % AROUND == AROUND - 1);
            ids.map(|id| corner(id, last))
        })
        .collect();
    let around = |p: &Vec3| Vec3::new(-p.y, p.x, 0.0).normalize();
    UserMesh {
        orientation: Some(mesh.positions.iter().map(around).collect()),
        corner_uvs: Some(uvs),
        ..UserMesh::from(mesh)
    }
}

/// The width of a flat side of the cylinder.
fn side_of_cylinder() -> f32 {
    2.0 * (TAU / AROUND as f32 / 2.0).sin()
}

/// Where a point on or inside the cylinder lies on the unrolled one: along its circumference, and up.
fn unrolled(point: Vec3) -> Vec2 {
    let turn = (point.y.atan2(point.x) / TAU).rem_euclid(1.0) * AROUND as f32;
    let (side, part) = (turn.floor(), turn.fract());
    let angle = TAU / AROUND as f32;
    // Along the chord of the side.
    let half = angle / 2.0;
    let along = 0.5 + (part * angle - half).tan() / (2.0 * half.tan());
    Vec2::new((side + along) * side_of_cylinder(), point.z)
}

/// Where a sample lies in space.
fn place(surface: &AtlasSurface, sample: SampleLocation<4>) -> Option<Vec3> {
    let position = |site: u32| surface.positions[site as usize];
    match sample {
        SampleLocation::Outside => None,
        SampleLocation::AtSite(site) => Some(position(site)),
        SampleLocation::Between(sites, weights) => {
            Some((0..4).map(|k| position(sites[k]) * weights[k]).sum())
        }
    }
}

/// An unwrapped mesh.
fn unwrapped(mesh: TriangleMesh, options: AtlasOptions) -> (UserMesh, AtlasOptions) {
    let options = AtlasOptions {
        unwrap: true,
        ..options
    };
    (UserMesh::from(mesh), options)
}
