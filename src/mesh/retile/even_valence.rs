//! Even valences by splitting edges, so that the triangles can have two colours.
//!
//! A split edge gives its two apexes one more triangle each, and has a new vertex of valence four. So a chain of splits,
//! each apex shared with the next, changes the parity of its two ends only. Chains join odd vertices in pairs, the
//! nearest first. A hole counts as one vertex: it is odd where a walk round it meets an odd number of triangles.
//!
//! On surfaces without handles all are even in the end, and two colours suffice. On others a walk round a handle can remain odd.

use std::collections::{BTreeMap, VecDeque};

use crate::mesh::retile::edge_operations::Surgery;
use crate::mesh::topology::{NONE, find, join, next};

/// The longest chain, in splits.
const LONGEST: u32 = 1 << 10;

/// Splits edges until all valences are even; says whether they are.
pub fn make_even(surgery: &mut Surgery) -> bool {
    let mut parities = Parities::new(surgery);
    let mut longest = 1;
    while longest <= LONGEST {
        for vertex in 0..parities.groups.len() as u32 {
            if parities.is_odd(vertex)
                && let Some(chain) = nearest_odd(surgery, &parities, vertex, longest)
            {
                split_chain(surgery, &mut parities, &chain);
            }
        }
        longest *= 2;
    }
    parities.odd.iter().all(|odd| !odd)
}

/// Which vertices and holes are odd.
struct Parities {
    /// Per vertex what stands for it: itself, or a vertex of its boundary.
    groups: Vec<u32>,
    /// Per vertex that stands for a group, whether the group is odd.
    odd: Vec<bool>,
}

impl Parities {
    fn new(surgery: &Surgery) -> Self {
        let mut groups: Vec<u32> = (0..surgery.positions.len() as u32).collect();
        for half_edge in 0..surgery.opposite.len() as u32 {
            if surgery.is_alive(half_edge) && surgery.opposite[half_edge as usize] == NONE {
                let [a, b] = surgery.ends(half_edge);
                join(&mut groups, a, b);
            }
        }
        let mut odd = vec![false; groups.len()];
        for vertex in 0..groups.len() as u32 {
            let group = find(&mut groups, vertex);
            let mut triangles = 0;
            let is_inner = surgery.each_leaving(vertex, |_| triangles += 1);
            // A walk round a hole meets the triangles at each boundary vertex, the last of one being the first of
            // the next.
            let met = if is_inner || triangles == 0 {
                triangles
            } else {
                triangles - 1
            };
            odd[group as usize] ^= met % 2 == 1;
        }
        let groups = (0..groups.len() as u32)
            .map(|v| find(&mut groups, v))
            .collect();
        Self { groups, odd }
    }

    fn is_odd(&self, vertex: u32) -> bool {
        self.odd[self.groups[vertex as usize] as usize]
    }

    fn turn(&mut self, vertex: u32) {
        self.odd[self.groups[vertex as usize] as usize] ^= true;
    }

    fn add_even(&mut self, vertex: u32) {
        self.groups.push(vertex);
        self.odd.push(false);
    }
}

/// A step from the apex of a triangle over the edge opposite.
#[derive(Clone, Copy)]
struct Step {
    from: u32,
    over: u32,
}

/// The half-edges opposite the vertices of the shortest chain from a vertex to an odd one of another group.
fn nearest_odd(
    surgery: &Surgery,
    parities: &Parities,
    start: u32,
    longest: u32,
) -> Option<Vec<u32>> {
    let own = parities.groups[start as usize];
    let mut reached = BTreeMap::from([(start, None::<Step>)]);
    let mut waiting = VecDeque::from([(start, 0)]);
    while let Some((from, steps)) = waiting.pop_front() {
        if parities.groups[from as usize] != own && parities.is_odd(from) {
            return Some(chain_to(&reached, from));
        }
        if steps == longest {
            continue;
        }
        surgery.each_leaving(from, |leaving| {
            let over = next(leaving);
            let twin = surgery.opposite[over as usize];
            if twin != NONE && !surgery.sharp[over as usize] {
                let far = surgery.apex(twin);
                reached.entry(far).or_insert_with(|| {
                    waiting.push_back((far, steps + 1));
                    Some(Step { from, over })
                });
            }
        });
    }
    None
}

/// The edges of a chain, from its end to its start.
fn chain_to(reached: &BTreeMap<u32, Option<Step>>, end: u32) -> Vec<u32> {
    let mut chain = Vec::new();
    let mut at = end;
    while let Some(Some(Step { from, over })) = reached.get(&at) {
        chain.push(*over);
        at = *from;
    }
    chain
}

/// Splits the edges of a chain. It ends early where a split has changed the triangles at the next edge; parities are
/// right nevertheless.
fn split_chain(surgery: &mut Surgery, parities: &mut Parities, chain: &[u32]) {
    let edges: Vec<[u32; 2]> = chain.iter().map(|&edge| surgery.ends(edge)).collect();
    let apexes_of = |surgery: &Surgery, edge: u32| {
        let twin = surgery.opposite[edge as usize];
        [surgery.apex(edge), surgery.apex(twin)]
    };
    let wanted: Vec<[u32; 2]> = chain.iter().map(|&edge| apexes_of(surgery, edge)).collect();
    for ((&edge, ends), apexes) in chain.iter().zip(edges).zip(wanted) {
        let twin = surgery.opposite[edge as usize];
        if surgery.ends(edge) != ends || twin == NONE || apexes_of(surgery, edge) != apexes {
            return;
        }
        let [a, b] = ends.map(|end| surgery.positions[end as usize]);
        let middle = surgery.split(edge, a.midpoint(b));
        parities.add_even(middle);
        apexes.into_iter().for_each(|apex| parities.turn(apex));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::face_colors::two_coloring;
    use crate::mesh::retile::edge_operations::Freedom;
    use crate::mesh::topology::Topology;
    use crate::mesh::{TriangleMesh, shapes};

    fn evened(mesh: &TriangleMesh) -> (bool, TriangleMesh) {
        let twins = Topology::new(&mesh.triangles).opposite;
        let sharp = twins.iter().map(|&twin| twin == NONE).collect();
        let mut surgery = Surgery::new(mesh, sharp, vec![Freedom::Surface; mesh.positions.len()]);
        (make_even(&mut surgery), surgery.finish())
    }

    #[test]
    fn spheres_disks_and_surfaces_with_holes_get_two_colors() {
        let sphere = shapes::icosphere(2);
        let mut disk = sphere.clone();
        disk.triangles.truncate(200);
        let mut holes = sphere.clone();
        for triangle in [300, 200, 77, 3] {
            holes.triangles.remove(triangle);
        }
        for mesh in [sphere, disk, holes] {
            assert!(two_coloring(&Topology::new(&mesh.triangles)).is_err());
            let (is_even, even) = evened(&mesh);
            assert!(is_even);
            let topology = Topology::new(&even.triangles);
            assert!(two_coloring(&topology).is_ok());
            let before = Topology::new(&mesh.triangles).shape(&mesh);
            assert_eq!(topology.shape(&even), before);
            assert!((even.area() / mesh.area() - 1.0).abs() < 1e-5);
            assert!(even.positions.len() < 2 * mesh.positions.len());
        }
    }

    #[test]
    fn even_meshes_are_kept() {
        for mesh in [shapes::torus(12, 8, 1.0, 0.4), shapes::grid(5, 4, 1.0)] {
            assert_eq!(evened(&mesh), (true, mesh));
        }
    }
}
