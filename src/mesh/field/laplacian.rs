//! The connection Laplacian of a surface (Knöppel 2013 §3; Sharp 2019 §4): how much a field of
//! tangents changes from vertex to vertex, each carried into the other's plane.
//!
//! E(u) = Σ over edges of w_ij |u_i − r_ij u_j|², w the cotangent weights. An edge that is not
//! Delaunay has a negative weight. Where that lets E itself be negative, on triangles far too thin,
//! such edges get almost none instead.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::mesh::compressed_rows::Rows;
use crate::mesh::field::hermitian::{Entry, Hermitian};
use crate::mesh::rings::Rings;
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;

/// What the weight of an edge may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// The cotangents, whatever their sign.
    Cotangent,
    /// At least a little above nothing.
    Positive,
}

/// The least positive weight of an edge.
const LEAST_WEIGHT: f64 = 1e-4;

/// The weight of every ring entry's edge.
pub fn edge_weights(mesh: &TriangleMesh, rings: &Rings, weights: Weights) -> Vec<f64> {
    let half: Vec<f64> = (0..rings.edges.len())
        .into_par_iter()
        .flat_map_iter(|vertex| {
            rings
                .edges
                .row(vertex)
                .iter()
                .map(move |edge| left_cotangent(mesh, vertex, edge.target, edge.triangle))
        })
        .collect();
    let both = |(entry, half_weight): (usize, &f64)| {
        let reverse = rings.edges.entries[entry].reverse as usize;
        match weights {
            Weights::Cotangent => half_weight + half[reverse],
            Weights::Positive => (half_weight + half[reverse]).max(LEAST_WEIGHT),
        }
    };
    half.iter().enumerate().map(both).collect()
}

/// Half the cotangent of the angle that an edge is seen under from the triangle on its left.
fn left_cotangent(mesh: &TriangleMesh, from: usize, to: u32, triangle: u32) -> f64 {
    if triangle == NONE {
        return 0.0;
    }
    let corners = mesh.triangles[triangle as usize];
    let apex = corners.into_iter().find(|&v| v as usize != from && v != to);
    let at = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
    let apex = apex.map_or(DVec3::ZERO, at);
    let (u, v) = (at(from as u32) - apex, at(to) - apex);
    let cotangent = 0.5 * u.dot(v) / u.cross(v).length().max(f64::MIN_POSITIVE);
    cotangent.clamp(-1e4, 1e4)
}

/// The matrix of E over all vertices (a vertex in no triangle has an empty row).
pub fn connection_laplacian(mesh: &TriangleMesh, rings: &Rings, weights: Weights) -> Hermitian {
    let weights = edge_weights(mesh, rings, weights);
    let entries = (0..rings.edges.entries.len())
        .into_par_iter()
        .map(|entry| Entry {
            column: rings.edges.entries[entry].target,
            value: DVec2::from_angle(rings.transport(entry)) * -weights[entry],
        })
        .collect();
    let diagonal = (0..rings.edges.len())
        .map(|vertex| weights[rings.edges.range(vertex)].iter().sum())
        .collect();
    let rows = Rows {
        starts: rings.edges.starts.clone(),
        entries,
    };
    Hermitian::new(diagonal, rows)
}
