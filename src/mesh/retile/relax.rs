//! The pass that spreads vertices evenly: each moves to the middle of its surroundings, within the
//! tangent plane, and back onto the surface (Botsch and Kobbelt 2004 §4, area-weighted).
//!
//! All vertices move at once, from the positions before the pass, so that the result does not
//! depend on the number of threads.

use glam::Vec3;
use rayon::prelude::*;

use crate::mesh::retile::edge_operations::{EditMesh, Freedom};
use crate::mesh::retile::features::SharpFeatures;
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;

/// The surface that vertices are kept on.
pub struct ReferenceSurface {
    /// Its triangles.
    pub tree: SurfaceBvh,
    /// Its lines.
    pub features: SharpFeatures,
    /// The angle of a crease, radians.
    pub crease: f64,
}

impl ReferenceSurface {
    /// A mesh, with the creases of `crease` radians and more.
    pub fn new(mesh: &TriangleMesh, crease: f64) -> Self {
        Self::along(mesh, crease, &[])
    }

    /// The same with the lines of some half-edges besides.
    pub fn along(mesh: &TriangleMesh, crease: f64, lines: &[bool]) -> Self {
        Self {
            tree: SurfaceBvh::new(mesh),
            features: SharpFeatures::find(mesh, crease, lines),
            crease,
        }
    }
}

/// Moves every vertex to the middle of its surroundings and onto the target.
pub fn relax(edited: &mut EditMesh, target: &ReferenceSurface) {
    let moved: Vec<Vec3> = (0..edited.positions.len() as u32)
        .into_par_iter()
        .with_min_len(1024)
        .map(|vertex| relaxed(edited, target, vertex))
        .collect();
    edited.positions = without_spoiling(edited, moved);
}

/// Rounds of taking moves back; if triangles are spoiled even so, no vertex moves.
const ROUNDS: usize = 12;
/// A triangle is spoiled when its normal turns farther than this (cosine) …
const TURN_LIMIT: f32 = 0.2;
/// … or its doubled area falls below this share of its longest edge squared.
const SLIVER: f32 = 1e-2;

/// Takes back the moves that would turn a triangle over or flatten it.
fn without_spoiling(edited: &EditMesh, mut moved: Vec<Vec3>) -> Vec<Vec3> {
    for _ in 0..ROUNDS {
        let spoiled: Vec<[u32; 3]> = edited
            .triangles
            .par_iter()
            .copied()
            .filter(|triangle| triangle[0] != NONE && is_spoiled(edited, &moved, *triangle))
            .collect();
        if spoiled.is_empty() {
            return moved;
        }
        for vertex in spoiled.into_iter().flatten() {
            moved[vertex as usize] = edited.positions[vertex as usize];
        }
    }
    edited.positions.clone()
}

fn is_spoiled(edited: &EditMesh, moved: &[Vec3], triangle: [u32; 3]) -> bool {
    let still = triangle
        .iter()
        .all(|&v| moved[v as usize] == edited.positions[v as usize]);
    if still {
        return false;
    }
    // The unit normal, and the doubled area over the longest edge squared.
    let measure = |positions: &[Vec3]| {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        let normal = (b - a).cross(c - a);
        (
            normal.normalize_or_zero(),
            normal.length() / longest.max(f32::MIN_POSITIVE),
        )
    };
    let ((before, full), (after, left)) = (measure(&edited.positions), measure(moved));
    // A sliver's normal says nothing; it may only get better.
    let turned = full >= SLIVER && before.dot(after) < TURN_LIMIT;
    turned || (left < SLIVER && left < full)
}

fn relaxed(edited: &EditMesh, target: &ReferenceSurface, vertex: u32) -> Vec3 {
    let position = edited.positions[vertex as usize];
    if edited.leaving[vertex as usize] == NONE {
        return position;
    }
    match edited.freedom[vertex as usize] {
        Freedom::Fixed => position,
        Freedom::Line => along_line(edited, vertex)
            .and_then(|middle| target.features.nearest(middle))
            .unwrap_or(position),
        Freedom::Surface => on_surface(edited, target, vertex, position),
    }
}

fn on_surface(edited: &EditMesh, target: &ReferenceSurface, vertex: u32, position: Vec3) -> Vec3 {
    let (mut normal, mut sum, mut area, mut reach) = (Vec3::ZERO, Vec3::ZERO, 0.0, 0.0f32);
    edited.each_leaving(vertex, |half_edge| {
        let triangle = edited.triangles[half_edge as usize / 3];
        let [a, b, c] = triangle.map(|v| edited.positions[v as usize]);
        let area_normal = (b - a).cross(c - a);
        let weight = area_normal.length();
        normal += area_normal;
        sum += weight * ((a - position) + (b - position) + (c - position)) / 3.0;
        area += weight;
        let far = edited.ends(half_edge)[1];
        reach = reach.max(edited.positions[far as usize].distance_squared(position));
    });
    let (Some(n), true) = (normal.try_normalize(), area > 0.0) else {
        return position;
    };
    let step = sum / area;
    let wanted = position + (step - n * n.dot(step));
    let facing = |corners: &[Vec3; 3]| {
        (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .dot(n)
            > 0.0
    };
    let found = target.tree.nearest_accepted(wanted, reach.sqrt(), facing);
    found.map_or(position, |point| point.position)
}

/// The middle between a vertex's two neighbours along its line.
fn along_line(edited: &EditMesh, vertex: u32) -> Option<Vec3> {
    let mut ends = Vec::with_capacity(2);
    edited.each_leaving(vertex, |half_edge| {
        let incoming = crate::mesh::topology::previous(half_edge);
        if edited.sharp[half_edge as usize] {
            ends.push(edited.ends(half_edge)[1]);
        }
        if edited.sharp[incoming as usize] && edited.opposite[incoming as usize] == NONE {
            ends.push(edited.ends(incoming)[0]);
        }
    });
    match ends[..] {
        [a, b] => Some(edited.positions[a as usize].midpoint(edited.positions[b as usize])),
        _ => None,
    }
}
