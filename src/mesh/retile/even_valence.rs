//! Even valences by splitting edges, so that the triangles can have two colours.
//!
//! A split edge gives its two apexes one more triangle each, and has a new vertex of valence four. So a chain of
//! splits, each apex shared with the next, changes the parity of its two ends only. Chains join odd vertices in pairs,
//! the nearest first. A hole counts as one vertex: it is odd where a walk round it meets an odd number of triangles.
//!
//! On surfaces without handles all are even in the end, and two colours suffice. On others a walk round a handle can
//! remain odd: see [`even_walks`](crate::mesh::retile::even_walks).

use std::collections::{BTreeMap, VecDeque};

use crate::mesh::retile::edge_operations::EditMesh;
use crate::mesh::topology::{NONE, find, join, next};

/// The longest chain, in splits.
const LONGEST: u32 = 1 << 10;

/// Splits edges until all valences are even; says whether they are.
pub fn make_even(edited: &mut EditMesh) -> bool {
    let mut parities = Parities::new(edited);
    let mut longest = 1;
    while longest <= LONGEST {
        for vertex in 0..parities.groups.len() as u32 {
            if parities.is_odd(vertex)
                && let Some(chain) = nearest_odd(edited, &parities, vertex, longest)
            {
                split_chain(edited, &mut parities, &chain);
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
    fn new(edited: &EditMesh) -> Self {
        let mut groups: Vec<u32> = (0..edited.positions.len() as u32).collect();
        for half_edge in 0..edited.opposite.len() as u32 {
            if edited.is_alive(half_edge) && edited.opposite[half_edge as usize] == NONE {
                let [a, b] = edited.ends(half_edge);
                join(&mut groups, a, b);
            }
        }
        let mut odd = vec![false; groups.len()];
        for vertex in 0..groups.len() as u32 {
            let group = find(&mut groups, vertex);
            let mut triangles = 0;
            let is_inner = edited.each_leaving(vertex, |_| triangles += 1);
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

/// The edges opposite the vertices of the shortest chain from a vertex to an odd one of another group.
fn nearest_odd(
    edited: &EditMesh,
    parities: &Parities,
    start: u32,
    longest: u32,
) -> Option<Vec<Split>> {
    let own = parities.groups[start as usize];
    let mut reached = BTreeMap::from([(start, None::<Step>)]);
    let mut waiting = VecDeque::from([(start, 0)]);
    while let Some((from, steps)) = waiting.pop_front() {
        if parities.groups[from as usize] != own && parities.is_odd(from) {
            return Some(chain_to(edited, &reached, from));
        }
        if steps == longest {
            continue;
        }
        edited.each_leaving(from, |leaving| {
            let over = next(leaving);
            let twin = edited.opposite[over as usize];
            if twin != NONE && !edited.sharp[over as usize] {
                let far = edited.apex(twin);
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
fn chain_to(edited: &EditMesh, reached: &BTreeMap<u32, Option<Step>>, end: u32) -> Vec<Split> {
    let mut chain = Vec::new();
    let mut at = end;
    while let Some(Some(Step { from, over })) = reached.get(&at) {
        chain.push(Split::of(edited, *over));
        at = *from;
    }
    chain
}

/// An edge to split, known by its vertices, since splits of other edges renumber half-edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Split {
    ends: [u32; 2],
    apexes: [u32; 2],
}

impl Split {
    /// The split of the edge of a half-edge that has a twin.
    pub fn of(edited: &EditMesh, half_edge: u32) -> Self {
        let twin = edited.opposite[half_edge as usize];
        Self {
            ends: edited.ends(half_edge),
            apexes: [edited.apex(half_edge), edited.apex(twin)],
        }
    }

    /// The half-edge, if its edge still lies between the same triangles.
    fn half_edge(&self, edited: &EditMesh) -> Option<u32> {
        let mut found = None;
        edited.each_leaving(self.ends[0], |leaving| {
            let has_twin = edited.opposite[leaving as usize] != NONE;
            if has_twin && Self::of(edited, leaving) == *self {
                found = Some(leaving);
            }
        });
        found
    }
}

/// Splits the edges of a chain in the middle. It ends early where a split has changed the triangles at the next edge;
/// hands back the new vertices and the edges that were split.
pub fn split_all<'a>(edited: &mut EditMesh, chain: &'a [Split]) -> Vec<(u32, &'a Split)> {
    let mut done = Vec::with_capacity(chain.len());
    for split in chain {
        let Some(half_edge) = split.half_edge(edited) else {
            break;
        };
        let [a, b] = split.ends.map(|end| edited.positions[end as usize]);
        done.push((edited.split(half_edge, a.midpoint(b)), split));
    }
    done
}

/// The same, and keeps the parities right.
fn split_chain(edited: &mut EditMesh, parities: &mut Parities, chain: &[Split]) {
    for (middle, split) in split_all(edited, chain) {
        parities.add_even(middle);
        split
            .apexes
            .into_iter()
            .for_each(|apex| parities.turn(apex));
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
        let mut edited = EditMesh::new(mesh, sharp, vec![Freedom::Surface; mesh.positions.len()]);
        (make_even(&mut edited), edited.finish())
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
