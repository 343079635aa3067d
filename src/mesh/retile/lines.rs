//! Boundaries and creases as a net of lines: how long they are, where they turn.
//!
//! In: a mesh and its sharp half-edges. Out: which creases are too short to keep, and how free
//! every vertex is to move along the lines.

use glam::Vec3;

use crate::mesh::retile::edge_operations::Freedom;
use crate::mesh::topology::{NONE, Topology, ends};
use crate::mesh::triangle_mesh::TriangleMesh;

/// The net of a mesh's sharp edges.
pub struct Lines<'a> {
    mesh: &'a TriangleMesh,
    /// The sharp edges, one half-edge each.
    edges: Vec<u32>,
    /// Per vertex the other ends of its sharp edges.
    arms: Vec<Vec<u32>>,
}

/// A way along a line: how far it goes and where it ends.
struct Way {
    length: f32,
    /// Vertices met, each with its distance from the start.
    met: Vec<(u32, f32)>,
    end: u32,
}

impl<'a> Lines<'a> {
    /// The net of the half-edges that are `sharp`.
    pub fn new(mesh: &'a TriangleMesh, topology: &Topology, sharp: &[bool]) -> Self {
        let stands_for_edge = |&half_edge: &u32| {
            let twin = topology.opposite[half_edge as usize];
            sharp[half_edge as usize] && (twin == NONE || half_edge < twin)
        };
        let edges: Vec<u32> = (0..sharp.len() as u32).filter(stands_for_edge).collect();
        let mut arms = vec![Vec::new(); mesh.positions.len()];
        for &edge in &edges {
            let [a, b] = ends(&mesh.triangles, edge);
            arms[a as usize].push(b);
            arms[b as usize].push(a);
        }
        Self { mesh, edges, arms }
    }

    /// The lines as triangles without width.
    pub fn segments(&self) -> Vec<[Vec3; 3]> {
        let segment = |&edge: &u32| {
            let [p, q] = self.positions(edge);
            [p, q, q]
        };
        self.edges.iter().map(segment).collect()
    }

    /// Takes creases that are connected over less than `shortest`, and touch no boundary, out of `sharp`.
    pub fn drop_short(&self, topology: &Topology, sharp: &mut [bool], shortest: f32) {
        let net_of = self.nets();
        let mut lengths = vec![0.0; net_of.len()];
        for &edge in &self.edges {
            let net = net_of[ends(&self.mesh.triangles, edge)[0] as usize] as usize;
            let [p, q] = self.positions(edge);
            lengths[net] += match topology.opposite[edge as usize] {
                NONE => f32::INFINITY,
                _ => p.distance(q),
            };
        }
        for &edge in &self.edges {
            let net = net_of[ends(&self.mesh.triangles, edge)[0] as usize] as usize;
            if lengths[net] < shortest {
                sharp[edge as usize] = false;
                sharp[topology.opposite[edge as usize] as usize] = false;
            }
        }
    }

    /// Per vertex the smallest vertex that it is connected with.
    fn nets(&self) -> Vec<u32> {
        let mut net_of = vec![NONE; self.arms.len()];
        let mut open = Vec::new();
        for start in 0..net_of.len() as u32 {
            if net_of[start as usize] != NONE {
                continue;
            }
            open.push(start);
            while let Some(vertex) = open.pop() {
                if net_of[vertex as usize] == NONE {
                    net_of[vertex as usize] = start;
                    open.extend(&self.arms[vertex as usize]);
                }
            }
        }
        net_of
    }

    /// How free every vertex is: not at all where lines end or meet, or where one turns by more
    /// than `crease` radians over the length `reach` either way, and nowhere more within `reach`.
    pub fn freedom(&self, crease: f64, reach: f32) -> Vec<Freedom> {
        let turns: Vec<f64> = (0..self.arms.len() as u32)
            .map(|vertex| self.turn(vertex, reach))
            .collect();
        (0..self.arms.len())
            .map(|vertex| match self.arms[vertex].len() {
                0 => Freedom::Surface,
                2 if turns[vertex] <= crease => Freedom::Line,
                2 if self.turns_more_nearby(vertex as u32, &turns, reach) => Freedom::Line,
                _ => Freedom::Fixed,
            })
            .collect()
    }

    /// By how much a line turns at a vertex between two edges, in radians; 0 elsewhere.
    fn turn(&self, vertex: u32, reach: f32) -> f64 {
        let [one, other] = self.arms[vertex as usize][..] else {
            return 0.0;
        };
        let position = |v: u32| self.mesh.positions[v as usize];
        let [a, b] = [one, other].map(|arm| {
            let end = self.way(vertex, arm, reach).end;
            (position(end) - position(vertex)).normalize_or_zero()
        });
        f64::from(-a.dot(b)).clamp(-1.0, 1.0).acos()
    }

    /// Whether the line turns more at another vertex within reach; of equal turns the first counts.
    fn turns_more_nearby(&self, vertex: u32, turns: &[f64], reach: f32) -> bool {
        let own = (turns[vertex as usize], std::cmp::Reverse(vertex));
        let more = |&(met, distance): &(u32, f32)| {
            distance < reach && (turns[met as usize], std::cmp::Reverse(met)) > own
        };
        self.arms[vertex as usize]
            .iter()
            .any(|&arm| self.way(vertex, arm, reach).met.iter().any(more))
    }

    /// Follows a line from a vertex through the neighbour `arm` over at least `reach`, or to where
    /// it ends, meets another or closes.
    fn way(&self, start: u32, arm: u32, reach: f32) -> Way {
        let distance = |a: u32, b: u32| {
            self.mesh.positions[a as usize].distance(self.mesh.positions[b as usize])
        };
        let (mut before, mut way) = (
            start,
            Way {
                length: distance(start, arm),
                met: Vec::new(),
                end: arm,
            },
        );
        loop {
            way.met.push((way.end, way.length));
            let [one, other] = self.arms[way.end as usize][..] else {
                return way;
            };
            let next = if one == before { other } else { one };
            if way.length >= reach || next == start {
                return way;
            }
            way.length += distance(way.end, next);
            (before, way.end) = (way.end, next);
        }
    }

    fn positions(&self, edge: u32) -> [Vec3; 2] {
        ends(&self.mesh.triangles, edge).map(|v| self.mesh.positions[v as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::retile::features::SharpFeatures;
    use crate::mesh::shapes;

    #[test]
    fn a_plate_has_four_corners_at_every_scale() {
        let mut mesh = shapes::grid(20, 10, 1.0);
        // A jagged border: every other vertex of one side stands out.
        for vertex in (1..20).step_by(2) {
            mesh.positions[vertex].y -= 0.6;
        }
        let fixed = |edge: f32| {
            let features = SharpFeatures::at_scale(&mesh, |_| true, 0.7, edge);
            let is_fixed = |&v: &usize| features.freedom[v] == Freedom::Fixed;
            (0..mesh.positions.len())
                .filter(is_fixed)
                .collect::<Vec<_>>()
        };
        assert!(fixed(0.0).len() > 15);
        assert_eq!(fixed(4.0), [0, 20, 10 * 21, 10 * 21 + 20]);
    }

    #[test]
    fn a_short_crease_is_none_at_a_coarse_scale() {
        let mut mesh = shapes::grid(20, 20, 1.0);
        for vertex in [10 * 21 + 10, 10 * 21 + 11] {
            mesh.positions[vertex].z = 1.5;
        }
        let creased = |edge: f32| {
            let features = SharpFeatures::at_scale(&mesh, |_| true, 0.7, edge);
            features.freedom[10 * 21 + 10] != Freedom::Surface
        };
        assert!(creased(0.0) && creased(0.5) && !creased(10.0));
    }
}
