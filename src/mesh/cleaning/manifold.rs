//! Edges and vertices where more than one sheet of the surface meets, split so that each sheet has
//! its own (Guéziec 2001, "cutting and stitching").

use crate::mesh::cleaning::RepairReport;
use crate::mesh::cleaning::orientation::{Pairing, orient};
use crate::mesh::topology::{NONE, Topology, ends, find, join, next};
use crate::mesh::triangle_mesh::TriangleMesh;

/// Rounds of splitting; at edges still crowded then, every triangle gets vertices of its own.
const ROUNDS: usize = 4;

/// What became of a mesh made manifold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Split {
    /// For every vertex added at the end, the one it is a copy of.
    pub copies: Vec<u32>,
    /// Which triangles were turned over: corners (a, b, c) became (a, c, b).
    pub turned: Vec<bool>,
}

/// Makes a mesh manifold and consistently facing.
pub fn split_non_manifold(mesh: &mut TriangleMesh, report: &mut RepairReport) -> Split {
    let mut split = Split {
        copies: Vec::new(),
        turned: vec![false; mesh.triangles.len()],
    };
    for round in 0..=ROUNDS {
        let (mut pairing, crowded) = pair_up(mesh, round == 0, report);
        if round == ROUNDS {
            detach(mesh, &crowded, &mut split.copies);
            (pairing, _) = pair_up(mesh, false, &mut RepairReport::default());
        }
        let turned = orient(mesh, &mut pairing, report);
        turn_over(mesh, &mut pairing, &turned);
        for (all, now) in split.turned.iter_mut().zip(turned) {
            *all ^= now;
        }
        let before = split.copies.len();
        split_vertices(mesh, &pairing, &mut split.copies);
        let topology = Topology::new(&mesh.triangles);
        if split.copies.len() == before && topology.non_manifold.is_empty() {
            break;
        }
    }
    report.split_vertices = split.copies.len();
    split
}

/// Pairs half-edges between the same two vertices, whatever way they run. Of three and more those
/// go together whose triangles are nearest to one plane, if `by_plane`; else none do. Also lists
/// the half-edges of such crowds.
fn pair_up(mesh: &TriangleMesh, by_plane: bool, report: &mut RepairReport) -> (Pairing, Vec<u32>) {
    let mut keyed: Vec<(u32, u32, u32)> = (0..mesh.triangles.len() as u32 * 3)
        .map(|half_edge| {
            let [a, b] = ends(&mesh.triangles, half_edge);
            (a.min(b), a.max(b), half_edge)
        })
        .collect();
    keyed.sort_unstable();
    let mut pairing = vec![NONE; keyed.len()];
    let mut crowded = Vec::new();
    for group in keyed.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        match group {
            [_] => {}
            [first, second] => pair(&mut pairing, first.2, second.2),
            crowd => {
                let members: Vec<u32> = crowd.iter().map(|entry| entry.2).collect();
                if by_plane {
                    pair_by_plane(mesh, &members, &mut pairing);
                    report.cut_edges += 1;
                    report.say_first(|| {
                        format!(
                            "edge {}–{} of {} triangles",
                            crowd[0].0,
                            crowd[0].1,
                            crowd.len()
                        )
                    });
                }
                crowded.extend(members);
            }
        }
    }
    (pairing, crowded)
}

fn pair(pairing: &mut Pairing, a: u32, b: u32) {
    pairing[a as usize] = b;
    pairing[b as usize] = a;
}

/// Pairs the flattest first; of an odd crowd one stays alone.
fn pair_by_plane(mesh: &TriangleMesh, members: &[u32], pairing: &mut Pairing) {
    // From the edge towards the far corner, at right angles to the edge.
    let wings: Vec<glam::DVec3> = members
        .iter()
        .map(|&half_edge| {
            let [a, b] =
                ends(&mesh.triangles, half_edge).map(|v| mesh.positions[v as usize].as_dvec3());
            let apex = ends(&mesh.triangles, next(half_edge))[1];
            let arm = mesh.positions[apex as usize].as_dvec3() - a;
            arm.reject_from(b - a).normalize_or_zero()
        })
        .collect();
    let mut pairs = Vec::new();
    for i in 0..members.len() {
        for j in i + 1..members.len() {
            pairs.push((wings[i].dot(wings[j]), members[i], members[j]));
        }
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    for (_, a, b) in pairs {
        if pairing[a as usize] == NONE && pairing[b as usize] == NONE {
            pair(pairing, a, b);
        }
    }
}

/// Turns triangles over: corners (a, b, c) become (a, c, b), half-edge k becomes 2 − k.
fn turn_over(mesh: &mut TriangleMesh, pairing: &mut Pairing, turned: &[bool]) {
    let moved = |half_edge: u32| {
        if half_edge != NONE && turned[half_edge as usize / 3] {
            half_edge - half_edge % 3 + (2 - half_edge % 3)
        } else {
            half_edge
        }
    };
    let mut after = vec![NONE; pairing.len()];
    for (half_edge, &twin) in pairing.iter().enumerate() {
        after[moved(half_edge as u32) as usize] = moved(twin);
    }
    *pairing = after;
    for (triangle, _) in mesh
        .triangles
        .iter_mut()
        .zip(turned)
        .filter(|(_, turned)| **turned)
    {
        triangle.swap(1, 2);
    }
}

/// Gives each fan of triangles round a vertex, joined across paired edges, a vertex of its own;
/// the fan of the first triangle keeps the old one.
fn split_vertices(mesh: &mut TriangleMesh, pairing: &Pairing, copies: &mut Vec<u32>) {
    let mut fan: Vec<u32> = (0..pairing.len() as u32).collect();
    for (half_edge, &twin) in pairing.iter().enumerate() {
        if twin != NONE {
            // Corner h of one triangle meets corner next(twin) of the other, and the reverse.
            join(&mut fan, half_edge as u32, next(twin));
            join(&mut fan, next(half_edge as u32), twin);
        }
    }
    let mut keeper = vec![NONE; mesh.positions.len()];
    let mut own = vec![NONE; fan.len()];
    for corner in 0..fan.len() as u32 {
        let root = find(&mut fan, corner) as usize;
        let vertex = mesh.triangles[corner as usize / 3][corner as usize % 3];
        if own[root] == NONE {
            own[root] = if keeper[vertex as usize] == NONE {
                keeper[vertex as usize] = root as u32;
                vertex
            } else {
                copy_vertex(mesh, vertex, copies)
            };
        }
        mesh.triangles[corner as usize / 3][corner as usize % 3] = own[root];
    }
}

fn copy_vertex(mesh: &mut TriangleMesh, vertex: u32, copies: &mut Vec<u32>) -> u32 {
    mesh.positions.push(mesh.positions[vertex as usize]);
    copies.push(vertex);
    mesh.positions.len() as u32 - 1
}

/// Gives the triangles of crowded half-edges vertices of their own.
fn detach(mesh: &mut TriangleMesh, crowded: &[u32], copies: &mut Vec<u32>) {
    let mut triangles: Vec<u32> = crowded.iter().map(|half_edge| half_edge / 3).collect();
    triangles.sort_unstable();
    triangles.dedup();
    for triangle in triangles {
        for corner in 0..3 {
            let vertex = mesh.triangles[triangle as usize][corner];
            let copy = copy_vertex(mesh, vertex, copies);
            mesh.triangles[triangle as usize][corner] = copy;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use glam::Vec3;

    fn made_manifold(mut mesh: TriangleMesh) -> (TriangleMesh, RepairReport, Split) {
        let mut report = RepairReport::default();
        let split = split_non_manifold(&mut mesh, &mut report);
        let topology = Topology::new(&mesh.triangles);
        assert!(topology.non_manifold.is_empty());
        (mesh, report, split)
    }

    #[test]
    fn a_sound_mesh_is_left_alone() {
        for mesh in [shapes::icosphere(1), shapes::grid(3, 3, 1.0)] {
            let (after, report, _) = made_manifold(mesh.clone());
            assert_eq!(after, mesh);
            assert!(report.is_sound());
        }
    }

    #[test]
    fn a_turned_triangle_is_turned_back() {
        let sound = shapes::icosphere(1);
        let mut mesh = sound.clone();
        mesh.triangles[7].swap(1, 2);
        let (after, report, _) = made_manifold(mesh);
        assert_eq!(after, sound);
        assert_eq!(report.turned_triangles, 1);
    }

    #[test]
    fn a_fan_of_three_leaves_the_flattest_pair_joined() {
        let mesh = TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z],
            triangles: vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]],
        };
        let (after, report, _) = made_manifold(mesh);
        assert_eq!((report.cut_edges, report.split_vertices), (1, 2));
        assert_eq!(after.triangles[2], [5, 6, 4]);
        assert!(report.first.unwrap().contains("edge 0–1 of 3 triangles"));
    }

    #[test]
    fn two_surfaces_that_touch_in_a_point_part() {
        let mut mesh = shapes::icosphere(0);
        let far = shapes::icosphere(0);
        mesh.positions
            .extend(far.positions[1..].iter().map(|p| *p + Vec3::X * 3.0));
        let moved = |v: u32| if v == 0 { 0 } else { v + 11 };
        mesh.triangles
            .extend(far.triangles.iter().map(|t| t.map(moved)));
        let (after, report, split) = made_manifold(mesh);
        assert_eq!(split.copies, [0]);
        assert_eq!(report.split_vertices, 1);
        assert_eq!(Topology::new(&after.triangles).shape(&after).components, 2);
    }

    #[test]
    fn a_moebius_strip_is_cut_open() {
        let around = 12;
        let mut mesh = TriangleMesh::default();
        for k in 0..around {
            let angle = std::f32::consts::TAU * k as f32 / around as f32;
            for side in [-0.3, 0.3] {
                let radius = 1.0 + side * (angle / 2.0).cos();
                let z = side * (angle / 2.0).sin();
                mesh.positions
                    .push(Vec3::new(radius * angle.cos(), radius * angle.sin(), z));
            }
        }
        for k in 0..around {
            let (a, b) = (2 * k, 2 * k + 1);
            let (c, d) = if k + 1 == around {
                (1, 0)
            } else {
                (2 * k + 2, 2 * k + 3)
            };
            mesh.triangles.extend([[a, c, b], [b, c, d]]);
        }
        let (after, report, _) = made_manifold(mesh);
        assert!(report.one_sided_edges > 0);
        let shape = Topology::new(&after.triangles).shape(&after);
        assert_eq!(
            (
                shape.components,
                shape.boundaries,
                shape.euler_characteristic
            ),
            (1, 1, 1)
        );
    }
}
