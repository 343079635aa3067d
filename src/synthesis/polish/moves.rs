//! One move: of a proposal for a region, the part that is worth taking, by a smallest cut.

use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::synthesis::polish::links::Links;
use crate::synthesis::polish::max_flow::CutGraph;
use crate::synthesis::polish::region::{OUTSIDE, Region, RegionLink};
use crate::synthesis::polish::reuse_cost::ReuseCost;
use crate::synthesis::polish::seam_cost::SeamCost;

/// What moves are judged by.
#[derive(Clone, Copy, Debug)]
pub struct Judge<'a> {
    /// The exemplar.
    pub exemplar: &'a ExemplarLevel<'a>,
    /// The links of all sites.
    pub links: &'a Links,
    /// What links cost.
    pub seams: SeamCost<'a>,
}

/// A region and what is held in and round it.
#[derive(Debug)]
pub struct Here<'a> {
    /// The region.
    pub region: &'a Region,
    /// What its sites hold.
    pub coords: Vec<TexCoord>,
    /// What all sites hold, of which those of the region do not count.
    pub map: &'a [TexCoord],
}

impl Here<'_> {
    /// What the other end of a link holds.
    fn other_end(&self, link: &RegionLink) -> TexCoord {
        match link.at {
            OUTSIDE => self.map[link.near.site as usize],
            at => self.coords[at as usize],
        }
    }
}

/// A site that could take what is proposed.
#[derive(Clone, Copy)]
struct Node {
    number: u32,
    taken: TexCoord,
}

impl Judge<'_> {
    /// Lets the sites of a region take what a proposal says where that costs less. Returns what links cost less then.
    pub fn take_part(
        &self,
        here: &mut Here<'_>,
        proposal: &[TexCoord],
        reuse: &ReuseCost,
        graph: &mut CutGraph,
    ) -> f64 {
        // Find the sites that the proposal would change.
        let nodes = self.nodes(here, proposal);
        let count = nodes.iter().flatten().count();
        if count == 0 {
            return 0.0;
        }
        // Set up the graph: a node per site, a link where both ends count.
        graph.begin(count);
        for (at, node) in nodes.iter().enumerate() {
            let Some(node) = node else { continue };
            let price = |at| reuse.price(reuse.cell_at(at));
            graph.add_node_cost(node.number, price(node.taken) - price(here.coords[at]));
            for link in here.region.links(at) {
                let mate = nodes.get(link.at as usize).copied().flatten();
                self.add_link(here, (at, *node), (link, mate), graph);
            }
        }
        // Cut it, and take what costs less.
        let labels: Vec<bool> = graph.cut().collect();
        let taken = |node: &Option<Node>| {
            let node = node.filter(|node| labels[node.number as usize]);
            node.map(|node| node.taken)
        };
        let taken: Vec<Option<TexCoord>> = nodes.iter().map(taken).collect();
        let saved = self.saved(here, &taken);
        for (held, taken) in here.coords.iter_mut().zip(taken) {
            *held = taken.unwrap_or(*held);
        }
        saved
    }

    /// The sites that could take what is proposed, and it would be something else.
    fn nodes(&self, here: &Here<'_>, proposal: &[TexCoord]) -> Vec<Option<Node>> {
        let mut count = 0;
        let pairs = proposal.iter().zip(&here.coords);
        pairs
            .map(|(&proposed, &held)| {
                let taken = self.admitted(proposed)?;
                let (ds, dt) = self.exemplar.grid.difference(taken, held);
                if ds.abs().max(dt.abs()) < SAME {
                    return None;
                }
                count += 1;
                Some(Node {
                    number: count - 1,
                    taken,
                })
            })
            .collect()
    }

    /// Adds what a link of a node costs; one between two nodes is met from both and counts the first time.
    fn add_link(
        &self,
        here: &Here<'_>,
        (at, node): (usize, Node),
        (link, mate): (&RegionLink, Option<Node>),
        graph: &mut CutGraph,
    ) {
        let cost = |a, b| self.link_cost(a, b, link);
        let (held, other) = (here.coords[at], here.other_end(link));
        let Some(mate) = mate else {
            return graph.add_node_cost(node.number, cost(node.taken, other) - cost(held, other));
        };
        if mate.number > node.number {
            let costs = [
                cost(held, other),
                cost(held, mate.taken),
                cost(node.taken, other),
                cost(node.taken, mate.taken),
            ];
            graph.add_link_costs([node.number, mate.number], costs);
        }
    }

    fn link_cost(&self, a: TexCoord, b: TexCoord, link: &RegionLink) -> f64 {
        let cost = self.seams.between(a, b, [link.near.x, link.near.y]);
        f64::from(self.links.weight * cost)
    }

    /// What links cost less when some sites take something else.
    fn saved(&self, here: &Here<'_>, taken: &[Option<TexCoord>]) -> f64 {
        let mut saved = 0.0;
        for (at, own) in taken.iter().enumerate() {
            let Some(own) = *own else { continue };
            for link in here.region.links(at) {
                let other = here.other_end(link);
                let mate = taken.get(link.at as usize).copied().flatten();
                let less = self.link_cost(here.coords[at], other, link)
                    - self.link_cost(own, mate.unwrap_or(other), link);
                // Between two that take something, a link is met from both.
                saved += if mate.is_some() { 0.5 * less } else { less };
            }
        }
        saved
    }

    /// A proposed coordinate on the grid, if its texel may be picked.
    fn admitted(&self, at: TexCoord) -> Option<TexCoord> {
        let grid = self.exemplar.grid;
        if !at.s.is_finite() || !at.t.is_finite() {
            return None;
        }
        let texel = grid.texel_holding(at)?;
        let at = grid.coordinate(at.s, grid.height as f32 - at.t);
        self.exemplar.whole[texel.index()].then_some(at)
    }
}

/// Coordinates nearer than this are the same.
const SAME: f32 = 1e-3;
