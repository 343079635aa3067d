//! Triangles flipped so that neighbours face the same way; edges cut where that is impossible.

use glam::Vec3;

use crate::mesh::cleaning::report::{FlippedComponent, RepairReport};
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A mesh whose triangles meet in pairs, whatever way they face: twins per half-edge.
pub type Pairing = Vec<u32>;

/// Turns triangles so that across every paired edge the two run against each other; the larger
/// part of each component, and of a closed one the outside, keeps its facing. Pairs that cannot
/// agree are cut. Says which triangles are to be turned.
pub fn orient(mesh: &TriangleMesh, pairing: &mut Pairing, report: &mut RepairReport) -> Vec<bool> {
    let count = mesh.triangles.len();
    let mut turned = vec![false; count];
    let mut seen = vec![false; count];
    for start in 0..count {
        if seen[start] {
            continue;
        }
        let members = flood(mesh, pairing, start, &mut seen, &mut turned);
        if wants_turning(mesh, pairing, &members, &turned) {
            members
                .iter()
                .for_each(|&t| turned[t as usize] = !turned[t as usize]);
        }
        let turning = members.iter().filter(|&&t| turned[t as usize]).count();
        if turning > 0 {
            report.turned_triangles += turning;
            report.turned_components.push(FlippedComponent {
                triangles: members.len(),
                turned: turning,
                centre: centre(mesh, &members),
            });
        }
    }
    cut_disagreeing(mesh, pairing, &turned, report);
    turned
}

/// Reaches all triangles of a component, breadth first, each turned to agree with the one it was
/// reached from.
fn flood(
    mesh: &TriangleMesh,
    pairing: &Pairing,
    start: usize,
    seen: &mut [bool],
    turned: &mut [bool],
) -> Vec<u32> {
    let mut members = vec![start as u32];
    seen[start] = true;
    let mut next = 0;
    while next < members.len() {
        let triangle = members[next] as usize;
        next += 1;
        for side in 0..3 {
            let half_edge = triangle * 3 + side;
            let twin = pairing[half_edge];
            if twin == NONE || seen[twin as usize / 3] {
                continue;
            }
            let other = twin as usize / 3;
            seen[other] = true;
            turned[other] = turned[triangle] != same_way(mesh, half_edge as u32, twin);
            members.push(other as u32);
        }
    }
    members
}

/// Whether two paired half-edges run the same way, so that their triangles face differently.
fn same_way(mesh: &TriangleMesh, a: u32, b: u32) -> bool {
    let ends = |h| crate::mesh::topology::ends(&mesh.triangles, h);
    ends(a)[0] == ends(b)[0]
}

/// Whether a component faces the wrong way: most of it would be turned, or, where some of it must
/// be and it is closed, it would be inside out.
fn wants_turning(mesh: &TriangleMesh, pairing: &Pairing, members: &[u32], turned: &[bool]) -> bool {
    let turning = members.iter().filter(|&&t| turned[t as usize]).count();
    if turning == 0 {
        return false;
    }
    let sides = |t: u32| t as usize * 3..t as usize * 3 + 3;
    let closed = members
        .iter()
        .all(|&t| pairing[sides(t)].iter().all(|&twin| twin != NONE));
    if !closed {
        return 2 * turning > members.len();
    }
    let origin = mesh.corners(members[0] as usize)[0].as_dvec3();
    let volume: f64 = members
        .iter()
        .map(|&t| {
            let [a, b, c] = mesh
                .corners(t as usize)
                .map(|corner| corner.as_dvec3() - origin);
            let volume = a.dot(b.cross(c));
            if turned[t as usize] { -volume } else { volume }
        })
        .sum();
    volume < 0.0
}

/// The middle of the box round some triangles.
fn centre(mesh: &TriangleMesh, members: &[u32]) -> [f64; 3] {
    let corners = members.iter().flat_map(|&t| mesh.corners(t as usize));
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for corner in corners {
        (low, high) = (low.min(corner), high.max(corner));
    }
    (0.5 * (low.as_dvec3() + high.as_dvec3())).to_array()
}

fn cut_disagreeing(
    mesh: &TriangleMesh,
    pairing: &mut Pairing,
    turned: &[bool],
    report: &mut RepairReport,
) {
    for half_edge in 0..pairing.len() as u32 {
        let twin = pairing[half_edge as usize];
        if twin == NONE || twin < half_edge {
            continue;
        }
        let agree = turned[half_edge as usize / 3] == turned[twin as usize / 3];
        if agree == same_way(mesh, half_edge, twin) {
            pairing[half_edge as usize] = NONE;
            pairing[twin as usize] = NONE;
            report.one_sided_edges += 1;
            let [a, b] = crate::mesh::topology::ends(&mesh.triangles, half_edge);
            report.say_first(|| format!("edge {a}–{b} of a surface with one side"));
        }
    }
}
