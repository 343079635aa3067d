//! Edges and vertices where more than one sheet of the surface meets, split so that each sheet has
//! its own (Guéziec 2001, "cutting and stitching").

use crate::mesh::cleaning::orientation::{Pairing, orient};
use crate::mesh::cleaning::report::RepairReport;
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

/// Pairs half-edges between the same two vertices, whatever way they run. Where three and more meet,
/// only those are joined that run against each other, so that a solid whose triangles agree is never
/// turned: first those of one sheet, then those nearest to one plane, if `by_plane`; else none. Also lists
/// the half-edges of such crowds.
fn pair_up(mesh: &TriangleMesh, by_plane: bool, report: &mut RepairReport) -> (Pairing, Vec<u32>) {
    // Sort the half-edges by their ends.
    let mut keyed: Vec<(u32, u32, u32)> = (0..mesh.triangles.len() as u32 * 3)
        .map(|half_edge| {
            let [a, b] = ends(&mesh.triangles, half_edge);
            (a.min(b), a.max(b), half_edge)
        })
        .collect();
    keyed.sort_unstable();
    // Pair those that are two; set aside where three and more meet.
    let mut pairing = vec![NONE; keyed.len()];
    let mut crowds: Vec<Vec<u32>> = Vec::new();
    for group in keyed.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        match group {
            [_] => {}
            [first, second] => pair(&mut pairing, first.2, second.2),
            crowd => crowds.push(crowd.iter().map(|entry| entry.2).collect()),
        }
    }
    // Pair the crowds by the angles between their triangles.
    if by_plane && !crowds.is_empty() {
        let mut sheets = sheets(&pairing);
        for members in &crowds {
            pair_crowd(mesh, members, &mut sheets, &mut pairing);
            report.cut_edges += 1;
            report.say_first(|| {
                let [a, b] = ends(&mesh.triangles, members[0]);
                format!(
                    "edge {}–{} of {} triangles",
                    a.min(b),
                    a.max(b),
                    members.len()
                )
            });
        }
    }
    (pairing, crowds.concat())
}

/// The triangles that are connected across paired half-edges, as a union–find forest.
fn sheets(pairing: &Pairing) -> Vec<u32> {
    let mut sheets: Vec<u32> = (0..pairing.len() as u32 / 3).collect();
    for (half_edge, &twin) in pairing.iter().enumerate() {
        if twin != NONE {
            join(&mut sheets, half_edge as u32 / 3, twin / 3);
        }
    }
    sheets
}

fn pair(pairing: &mut Pairing, a: u32, b: u32) {
    pairing[a as usize] = b;
    pairing[b as usize] = a;
}

/// Pairs half-edges that run against each other: those of one sheet first, then the flattest.
fn pair_crowd(mesh: &TriangleMesh, members: &[u32], sheets: &mut [u32], pairing: &mut Pairing) {
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
    let begins = |half_edge: u32| ends(&mesh.triangles, half_edge)[0];
    let mut pairs = Vec::new();
    for i in 0..members.len() {
        for j in i + 1..members.len() {
            let (a, b) = (members[i], members[j]);
            if begins(a) != begins(b) {
                let apart = find(sheets, a / 3) != find(sheets, b / 3);
                pairs.push((apart, wings[i].dot(wings[j]), a, b));
            }
        }
    }
    pairs.sort_by(|x, y| {
        let key = |pair: &(bool, f64, u32, u32)| (pair.2, pair.3);
        x.0.cmp(&y.0)
            .then(x.1.total_cmp(&y.1))
            .then(key(x).cmp(&key(y)))
    });
    for (_, _, a, b) in pairs {
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

    /// A cube whose least corner is `at`, facing outwards.
    fn cube(at: Vec3) -> [[Vec3; 3]; 12] {
        let corner = |k: u32| at + Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32);
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        std::array::from_fn(|k| {
            let [a, b, c, d] = quads[k / 2];
            if k % 2 == 0 { [a, b, c] } else { [a, c, d] }.map(corner)
        })
    }

    /// The triangles of some bodies, with one vertex per place.
    fn welded(triangles: &[[Vec3; 3]]) -> TriangleMesh {
        let positions: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        let first = crate::mesh::cleaning::weld(&positions);
        let triangles = first.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        TriangleMesh {
            positions,
            triangles,
        }
    }

    fn volume(mesh: &TriangleMesh) -> f32 {
        let volumes = (0..mesh.triangles.len()).map(|t| {
            let [a, b, c] = mesh.corners(t);
            a.dot(b.cross(c)) / 6.0
        });
        volumes.sum()
    }

    #[test]
    fn solids_that_touch_in_an_edge_part_and_are_not_turned() {
        let far = [
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(0.0, 1.0, 1.0),
            Vec3::new(1.0, 0.0, 1.0),
        ];
        for at in far {
            let mesh = welded(&[cube(Vec3::ZERO), cube(at)].concat());
            assert!((volume(&mesh) - 2.0).abs() < 1e-5);
            let (after, report, _) = made_manifold(mesh);
            assert_eq!((report.turned_triangles, report.cut_edges), (0, 1));
            assert!((volume(&after) - 2.0).abs() < 1e-5);
            assert_eq!(Topology::new(&after.triangles).shape(&after).components, 2);
        }
    }

    #[test]
    fn a_hollow_body_keeps_the_facing_of_its_inside() {
        let hollow = cube(Vec3::ZERO).map(|t| [t[0], t[2], t[1]].map(|p| p * 0.5 + 0.25));
        let mesh = welded(&[cube(Vec3::ZERO), hollow].concat());
        let (after, report, _) = made_manifold(mesh);
        assert!(report.is_sound() && (volume(&after) - 0.875).abs() < 1e-5);
    }

    #[test]
    fn a_component_that_is_turned_is_named() {
        let mut flawed = cube(Vec3::ZERO);
        flawed[3].swap(0, 1);
        let sound = cube(Vec3::X * 7.0);
        let (after, report, _) = made_manifold(welded(&[flawed, sound].concat()));
        assert!((volume(&after) - 2.0).abs() < 1e-4);
        let [named] = &report.turned_components[..] else {
            panic!("{report:?}")
        };
        assert_eq!((named.triangles, named.turned), (12, 1));
        assert_eq!(named.centre, [0.5; 3]);
        assert!(report.lines()[1].contains("round (0.500000, 0.500000, 0.500000): 1 of 12"));
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
