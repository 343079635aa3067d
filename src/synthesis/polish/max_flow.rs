//! The smallest cut of a small graph, by the largest flow through it (Dinic 1970).
//!
//! In: costs of two labels at every node, and of the four pairs of labels along links (Kolmogorov and Zabih 2004).
//! Out: the labels of least total cost. Costs are whole numbers, so that a cut is the same everywhere.

/// Units of a cost of 1.
const UNITS: f64 = (1u64 << 24) as f64;
/// No arc.
const NONE: u32 = u32::MAX;
/// Farther from the sink than any node.
const FAR: u32 = u32::MAX;

/// A graph whose nodes keep what they hold (label 0) or take something else (label 1).
#[derive(Clone, Debug, Default)]
pub struct CutGraph {
    /// The first arc of every node.
    first: Vec<u32>,
    arcs: Vec<Arc>,
    /// What label 1 costs more than label 0 at every node.
    excess: Vec<i64>,
    /// Arcs to the sink on the shortest way.
    distances: Vec<u32>,
    /// The next arc to try at every node.
    cursors: Vec<u32>,
    queue: Vec<u32>,
    path: Vec<u32>,
}

/// An arc and, beside it in the list, its reverse.
#[derive(Clone, Copy, Debug)]
struct Arc {
    to: u32,
    next: u32,
    room: i64,
}

impl CutGraph {
    /// Begins a graph of this many nodes without costs.
    pub fn begin(&mut self, nodes: usize) {
        self.first.clear();
        self.first.resize(nodes + 2, NONE);
        self.excess.clear();
        self.excess.resize(nodes, 0);
        self.arcs.clear();
    }

    /// Label 1 costs so much more at a node than label 0.
    pub fn add_node_cost(&mut self, node: u32, more: f64) {
        self.excess[node as usize] += units(more);
    }

    /// What the labels of two nodes cost together: both 0, the second 1, the first 1, both 1.
    ///
    /// A link whose middle costs are less than the outer ones has no place in a cut. They are raised until they
    /// are not: what all labels 0 cost stays exact, and no labels seem cheaper than they are (Rother 2005).
    pub fn add_link_costs(&mut self, [i, j]: [u32; 2], costs: [f64; 4]) {
        let [neither, second, first, both] = costs.map(units);
        let lacking = (neither + both - second - first).max(0);
        let (second, first) = (second + lacking / 2, first + (lacking - lacking / 2));
        self.excess[i as usize] += first - neither;
        self.excess[j as usize] += both - first;
        let room = second + first - neither - both;
        if room > 0 {
            self.add_arc(i, j, room);
        }
    }

    /// Whether each node takes label 1 in the cheapest labelling; of equals the one with fewest.
    pub fn cut(&mut self) -> impl Iterator<Item = bool> + '_ {
        let nodes = self.excess.len() as u32;
        let (source, sink) = (nodes, nodes + 1);
        for node in 0..nodes {
            match self.excess[node as usize] {
                0 => {}
                more if more > 0 => self.add_arc(source, node, more),
                less => self.add_arc(node, sink, -less),
            }
        }
        self.find_distances(sink);
        while self.distances[source as usize] != FAR {
            self.cursors.clone_from(&self.first);
            self.saturate(source, sink);
            self.find_distances(sink);
        }
        self.distances[..nodes as usize]
            .iter()
            .map(|&far| far != FAR)
    }

    fn add_arc(&mut self, from: u32, to: u32, room: i64) {
        for (from, to, room) in [(from, to, room), (to, from, 0)] {
            let next = std::mem::replace(&mut self.first[from as usize], self.arcs.len() as u32);
            self.arcs.push(Arc { to, next, room });
        }
    }

    /// How many arcs with room lead from every node to the sink.
    fn find_distances(&mut self, sink: u32) {
        self.distances.clear();
        self.distances.resize(self.first.len(), FAR);
        self.distances[sink as usize] = 0;
        self.queue.clear();
        self.queue.push(sink);
        let mut visited = 0;
        while let Some(&node) = self.queue.get(visited) {
            visited += 1;
            let mut at = self.first[node as usize];
            while at != NONE {
                let Arc { to, next, .. } = self.arcs[at as usize];
                let has_room = self.arcs[(at ^ 1) as usize].room > 0;
                if has_room && self.distances[to as usize] == FAR {
                    self.distances[to as usize] = self.distances[node as usize] + 1;
                    self.queue.push(to);
                }
                at = next;
            }
        }
    }

    /// Sends flow along shortest ways until each has an arc without room.
    fn saturate(&mut self, source: u32, sink: u32) {
        self.path.clear();
        let mut node = source;
        loop {
            if node == sink {
                node = self.send_along_path();
                continue;
            }
            let at = self.cursors[node as usize];
            if at != NONE {
                let arc = self.arcs[at as usize];
                let far = self.distances[arc.to as usize];
                if arc.room > 0 && far != FAR && far + 1 == self.distances[node as usize] {
                    self.path.push(at);
                    node = arc.to;
                } else {
                    self.cursors[node as usize] = arc.next;
                }
                continue;
            }
            // Nothing leads on from here.
            self.distances[node as usize] = FAR;
            match self.path.pop() {
                Some(back) => node = self.arcs[(back ^ 1) as usize].to,
                None => return,
            }
        }
    }

    /// Fills the way to the sink and returns the node before its first full arc.
    fn send_along_path(&mut self) -> u32 {
        let room = |at: &u32| self.arcs[*at as usize].room;
        let sent = self.path.iter().map(room).min().unwrap_or(0);
        for &at in &self.path {
            self.arcs[at as usize].room -= sent;
            self.arcs[(at ^ 1) as usize].room += sent;
        }
        let is_full = |at: &u32| self.arcs[*at as usize].room == 0;
        let full = self.path.iter().position(is_full).unwrap_or(0);
        let node = self.arcs[(self.path[full] ^ 1) as usize].to;
        self.path.truncate(full);
        node
    }
}

fn units(cost: f64) -> i64 {
    (cost * UNITS).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;
    use rand::Rng;

    /// What labels cost.
    fn cost(nodes: &[f64], links: &[([u32; 2], [f64; 4])], labels: u32) -> f64 {
        let label = |node: u32| ((labels as usize) >> node) & 1;
        let nodes = nodes.iter().enumerate();
        let nodes = nodes.map(|(node, more)| more * label(node as u32) as f64);
        let links = links
            .iter()
            .map(|(ends, costs)| costs[2 * label(ends[0]) + label(ends[1])]);
        nodes.sum::<f64>() + links.sum::<f64>()
    }

    #[test]
    fn a_cut_is_the_cheapest_of_all_labellings() {
        let mut graph = CutGraph::default();
        for seed in 0..200 {
            let mut stream = random::stream(seed, "cuts", 0, 0);
            let count = stream.gen_range(1..9u32);
            let nodes: Vec<f64> = (0..count).map(|_| stream.gen_range(-1.0..1.0)).collect();
            let mut links = Vec::new();
            for i in 0..count {
                for j in (0..count).filter(|&j| j != i) {
                    if stream.gen_range(0..3) == 0 {
                        let [neither, both, more] = [0; 3].map(|_| stream.gen_range(0.0..1.0));
                        let first: f64 = stream.gen_range(0.0..1.0);
                        links.push((
                            [i, j],
                            [neither, neither + both + more - first, first, both],
                        ));
                    }
                }
            }
            graph.begin(nodes.len());
            for (node, &more) in nodes.iter().enumerate() {
                graph.add_node_cost(node as u32, more);
            }
            for &(ends, costs) in &links {
                graph.add_link_costs(ends, costs);
            }
            let labels = graph.cut().enumerate();
            let labels = labels.map(|(node, label)| u32::from(label) << node).sum();
            let best = (0..1 << count)
                .map(|labels| cost(&nodes, &links, labels))
                .fold(f64::INFINITY, f64::min);
            assert!(cost(&nodes, &links, labels) < best + 1e-5, "seed {seed}");
        }
    }

    #[test]
    fn of_equals_the_labels_are_kept() {
        let mut graph = CutGraph::default();
        graph.begin(3);
        graph.add_node_cost(0, 0.0);
        graph.add_link_costs([1, 2], [0.0, 1.0, 1.0, 0.0]);
        assert_eq!(graph.cut().collect::<Vec<_>>(), [false; 3]);
    }

    #[test]
    fn costs_that_no_cut_has_never_make_things_worse() {
        // The middle costs are 0, the outer ones 1: alone, one node should change.
        let mut graph = CutGraph::default();
        graph.begin(2);
        graph.add_link_costs([0, 1], [1.0, 0.0, 0.0, 1.0]);
        let labels: Vec<bool> = graph.cut().collect();
        assert!(labels == [false; 2] || labels[0] != labels[1]);
    }
}
