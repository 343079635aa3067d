//! Even walks round handles, by splitting edges along closed chains.
//!
//! Where all valences are even, two colours fail only where a walk round a handle meets an odd number of triangles.
//! A closed chain of splits keeps the parities of valences, since each apex gets two more triangles. It draws a closed
//! line of new edges, and every walk that crosses this line meets one triangle more. So one line is looked for that
//! crosses an odd walk an odd number of times and an even walk an even number of times.
//!
//! The walks are those of a tree of triangles and a tree of vertices that do not cross (tree–cotree decomposition,
//! Eppstein 2003): one for every edge in neither tree.

use std::collections::VecDeque;

use crate::mesh::retile::edge_operations::EditMesh;
use crate::mesh::retile::even_valence::{self, Split};
use crate::mesh::topology::{NONE, find, join, next};

/// Rounds of closed chains and of the open ones that make even what they left odd.
const ROUNDS: usize = 4;
/// States a search may have: vertices times the parities of all walks.
const MOST_STATES: usize = 1 << 25;
/// Vertices a search begins at.
const STARTS: usize = 24;

/// Splits edges until all valences and all walks round handles are even, which is when two colours suffice; says
/// whether they are. Surfaces of very many handles are given up.
pub fn make_even(edited: &mut EditMesh) -> bool {
    for _ in 0..ROUNDS {
        if !even_valence::make_even(edited) {
            return false;
        }
        let Some(mut odd) = Walks::of_components(edited) else {
            return false;
        };
        odd.retain(|walks| walks.odd != 0);
        if odd.is_empty() {
            return true;
        }
        // One component's chain leaves the triangles of the others as they are.
        for walks in odd {
            let Some(chain) = shortest_closed_chain(edited, &walks) else {
                return false;
            };
            even_valence::split_all(edited, &chain);
        }
    }
    false
}

/// Walks over the triangles of one component that every other closed walk is a sum of.
struct Walks {
    /// How many there are.
    count: u32,
    /// The walks that meet an odd number of triangles, a bit each.
    odd: u64,
    /// Per half-edge of the mesh, the walks that cross its edge.
    crossing: Vec<u64>,
}

impl Walks {
    /// The walks of every component that has any; `None` where one has 64 or more.
    fn of_components(edited: &EditMesh) -> Option<Vec<Self>> {
        let tree = TriangleTree::new(edited);
        let mut edges_of = vec![Vec::new(); tree.components as usize];
        for edge in edges_in_neither_tree(edited, &tree) {
            edges_of[tree.component[edge as usize / 3] as usize].push(edge);
        }
        edges_of
            .into_iter()
            .filter(|edges| !edges.is_empty())
            .map(|edges| {
                let few = edges.len() < u64::BITS as usize;
                few.then(|| Self::through(edited, &tree, &edges))
            })
            .collect()
    }

    /// The walks that cross one of `edges` each, and otherwise edges of the tree only.
    fn through(edited: &EditMesh, tree: &TriangleTree, edges: &[u32]) -> Self {
        let mut walks = Self {
            count: edges.len() as u32,
            odd: 0,
            crossing: vec![0; edited.opposite.len()],
        };
        for (number, &edge) in edges.iter().enumerate() {
            let (twin, walk) = (edited.opposite[edge as usize], 1u64 << number);
            walks.cross(edited, edge, walk);
            for end in [edge, twin] {
                let mut triangle = end / 3;
                while tree.entered[triangle as usize] != NONE {
                    let entered = tree.entered[triangle as usize];
                    walks.cross(edited, entered, walk);
                    triangle = edited.opposite[entered as usize] / 3;
                }
            }
            if tree.is_white[edge as usize / 3] == tree.is_white[twin as usize / 3] {
                walks.odd |= walk;
            }
        }
        walks
    }

    fn cross(&mut self, edited: &EditMesh, half_edge: u32, walk: u64) {
        self.crossing[half_edge as usize] ^= walk;
        self.crossing[edited.opposite[half_edge as usize] as usize] ^= walk;
    }
}

/// A spanning tree of the triangles of every component, coloured along its branches.
struct TriangleTree {
    /// Per triangle its half-edge towards the root; [`NONE`] for roots and removed triangles.
    entered: Vec<u32>,
    is_white: Vec<bool>,
    component: Vec<u32>,
    components: u32,
}

impl TriangleTree {
    fn new(edited: &EditMesh) -> Self {
        let triangles = edited.triangles.len();
        let mut tree = Self {
            entered: vec![NONE; triangles],
            is_white: vec![false; triangles],
            component: vec![NONE; triangles],
            components: 0,
        };
        for root in 0..triangles as u32 {
            if edited.is_alive(3 * root) && tree.component[root as usize] == NONE {
                tree.grow(edited, root);
            }
        }
        tree
    }

    fn grow(&mut self, edited: &EditMesh, root: u32) {
        self.component[root as usize] = self.components;
        let mut waiting = VecDeque::from([root]);
        while let Some(triangle) = waiting.pop_front() {
            for half_edge in 3 * triangle..3 * triangle + 3 {
                let twin = edited.opposite[half_edge as usize];
                if twin != NONE && self.component[twin as usize / 3] == NONE {
                    let other = twin as usize / 3;
                    self.component[other] = self.components;
                    self.entered[other] = twin;
                    self.is_white[other] = !self.is_white[triangle as usize];
                    waiting.push_back(other as u32);
                }
            }
        }
        self.components += 1;
    }

    /// Whether the tree crosses the edge of a half-edge.
    fn crosses(&self, edited: &EditMesh, half_edge: u32) -> bool {
        let twin = edited.opposite[half_edge as usize];
        let enters = |at: u32| at != NONE && self.entered[at as usize / 3] == at;
        enters(half_edge) || enters(twin)
    }
}

/// The inner edges that neither the tree of triangles crosses nor a tree of vertices needs: two for each handle, one
/// for each hole after the first.
fn edges_in_neither_tree(edited: &EditMesh, tree: &TriangleTree) -> Vec<u32> {
    let mut roots: Vec<u32> = (0..edited.positions.len() as u32).collect();
    let (mut boundary, mut inner) = (Vec::new(), Vec::new());
    for half_edge in 0..edited.opposite.len() as u32 {
        if edited.is_alive(half_edge) && edited.stands_for_edge(half_edge) {
            match edited.opposite[half_edge as usize] {
                NONE => boundary.push(half_edge),
                _ if tree.crosses(edited, half_edge) => {}
                _ => inner.push(half_edge),
            }
        }
    }
    let mut is_needed = |half_edge: &u32| {
        let [a, b] = edited.ends(*half_edge);
        let apart = find(&mut roots, a) != find(&mut roots, b);
        join(&mut roots, a, b);
        apart
    };
    boundary.iter().for_each(|half_edge| {
        is_needed(half_edge);
    });
    inner.retain(|half_edge| !is_needed(half_edge));
    inner
}

/// The shortest closed chain found that crosses just the odd walks an odd number of times.
fn shortest_closed_chain(edited: &EditMesh, walks: &Walks) -> Option<Vec<Split>> {
    let vertices = edited.positions.len();
    let states = 1usize.checked_shl(walks.count)?.checked_mul(vertices)?;
    if states > MOST_STATES {
        return None;
    }
    let mut search = Search {
        edited,
        walks,
        came: vec![(NONE, NONE); states],
        reached: Vec::new(),
    };
    let mut shortest: Option<Vec<Split>> = None;
    for start in starts(edited, walks) {
        let limit = shortest.as_ref().map_or(usize::MAX, Vec::len);
        shortest = search.from(start, limit).or(shortest);
    }
    shortest
}

/// Vertices to begin at, all beside one odd walk, which the chain has to cross.
fn starts(edited: &EditMesh, walks: &Walks) -> Vec<u32> {
    let length = |walk: u64| walks.crossing.iter().filter(|&&c| c & walk != 0).count();
    let odd = (0..walks.count).map(|number| 1u64 << number);
    let odd = odd.filter(|walk| walks.odd & walk != 0);
    let Some(walk) = odd.min_by_key(|&walk| length(walk)) else {
        return Vec::new();
    };
    let mut beside: Vec<u32> = (0..walks.crossing.len() as u32)
        .filter(|&half_edge| walks.crossing[half_edge as usize] & walk != 0)
        .map(|half_edge| edited.ends(half_edge)[0])
        .collect();
    beside.sort_unstable();
    beside.dedup();
    let step = beside.len().div_ceil(STARTS).max(1);
    beside.into_iter().step_by(step).collect()
}

/// A breadth-first search over the states of chains: where they are, and which walks they have crossed an odd number of
/// times.
struct Search<'a> {
    edited: &'a EditMesh,
    walks: &'a Walks,
    /// Per state the state before and the edge split on the way.
    came: Vec<(u32, u32)>,
    reached: Vec<u32>,
}

impl Search<'_> {
    /// The shortest closed chain from a vertex, if it is shorter than `limit`.
    fn from(&mut self, start: u32, limit: usize) -> Option<Vec<Split>> {
        for state in self.reached.drain(..) {
            self.came[state as usize] = (NONE, NONE);
        }
        let bits = self.walks.count;
        let first = start << bits;
        let goal = first | self.walks.odd as u32;
        self.came[first as usize] = (first, NONE);
        self.reached.push(first);
        let mut waiting = VecDeque::from([(first, 1)]);
        while let Some((state, length)) = waiting.pop_front() {
            if length >= limit {
                break;
            }
            let (edited, walks) = (self.edited, self.walks);
            let (came, reached) = (&mut self.came, &mut self.reached);
            edited.each_leaving(state >> bits, |leaving| {
                let over = next(leaving);
                let twin = edited.opposite[over as usize];
                if twin == NONE || edited.sharp[over as usize] {
                    return;
                }
                // The step to the far apex is the same as one along two edges of its triangles.
                let crossed =
                    walks.crossing[leaving as usize] ^ walks.crossing[next(twin) as usize];
                let parities = (state ^ crossed as u32) & ((1 << bits) - 1);
                let to = edited.apex(twin) << bits | parities;
                if came[to as usize].0 == NONE {
                    came[to as usize] = (state, over);
                    reached.push(to);
                    waiting.push_back((to, length + 1));
                }
            });
            if self.came[goal as usize].0 != NONE {
                return Some(self.chain_to(goal, first));
            }
        }
        None
    }

    fn chain_to(&self, goal: u32, first: u32) -> Vec<Split> {
        let mut chain = Vec::new();
        let mut at = goal;
        while at != first {
            let (before, over) = self.came[at as usize];
            chain.push(Split::of(self.edited, over));
            at = before;
        }
        chain
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::mesh::face_colors::two_coloring;
    use crate::mesh::retile::edge_operations::Freedom;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;

    /// A torus with a third of its edges turned at random.
    fn turned_torus(seed: u64) -> EditMesh {
        let mesh = shapes::torus(18, 12, 1.0, 0.4);
        let half_edges = 3 * mesh.triangles.len() as u32;
        let freedom = vec![Freedom::Surface; mesh.positions.len()];
        let mut edited = EditMesh::new(&mesh, vec![false; half_edges as usize], freedom);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut ring = Vec::new();
        for _ in 0..half_edges / 6 {
            let edge = random.gen_range(0..half_edges);
            if edited.may_flip(edge, &mut ring) {
                edited.flip(edge);
            }
        }
        edited
    }

    fn has_two_colors(edited: &EditMesh) -> bool {
        two_coloring(&Topology::new(&edited.finish().triangles)).is_ok()
    }

    #[test]
    fn walks_round_handles_become_even() {
        let mut odd = 0;
        for seed in 0..12 {
            let mut edited = turned_torus(seed);
            let before = Topology::new(&edited.finish().triangles).shape(&edited.finish());
            let mut without = edited.clone();
            assert!(even_valence::make_even(&mut without));
            odd += usize::from(!has_two_colors(&without));
            assert!(make_even(&mut edited), "seed {seed}");
            assert!(has_two_colors(&edited), "seed {seed}");
            let mesh = edited.finish();
            assert_eq!(Topology::new(&mesh.triangles).shape(&mesh), before);
            assert!(mesh.positions.len() < without.vertex_count() + 60);
        }
        assert!(odd >= 3, "{odd} of 12 tori have odd walks");
    }
}
