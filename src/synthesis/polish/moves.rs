//! One move: of a proposal for a region, the part that is worth taking, by a smallest cut.

use crate::exemplar::level::ExemplarLevel;
use crate::grid::TexCoord;
use crate::synthesis::polish::energy::SeamCost;
use crate::synthesis::polish::links::Links;
use crate::synthesis::polish::max_flow::CutGraph;
use crate::synthesis::polish::region::{OUTSIDE, Region};
use crate::synthesis::polish::usage::Usage;

/// What a move is judged by.
#[derive(Clone, Copy, Debug)]
pub struct Judge<'a> {
    /// The exemplar.
    pub exemplar: &'a ExemplarLevel<'a>,
    /// The links of all sites.
    pub links: &'a Links,
    /// What links cost.
    pub seams: SeamCost<'a>,
}

/// Not a node of the graph: the proposal leaves the site as it is, or cannot be taken there.
const FIXED: u32 = u32::MAX;

impl Judge<'_> {
    /// Lets the sites of a region take what a proposal says where that costs less; `here` is what they hold, `map`
    /// what all others do. Returns the costs saved at links, 0 if nothing is taken.
    pub fn take_part(
        &self,
        region: &Region,
        (here, map): (&mut [TexCoord], &[TexCoord]),
        proposal: &[TexCoord],
        usage: &Usage,
        graph: &mut CutGraph,
    ) -> f64 {
        let proposal: Vec<Option<TexCoord>> = proposal
            .iter()
            .zip(&*here)
            .map(|(&at, &held)| self.admitted(at).filter(|&at| !self.is_same(at, held)))
            .collect();
        let mut nodes = vec![FIXED; here.len()];
        let mut count = 0;
        for (node, proposed) in nodes.iter_mut().zip(&proposal) {
            if proposed.is_some() {
                *node = count;
                count += 1;
            }
        }
        if count == 0 {
            return 0.0;
        }
        graph.begin(count as usize);
        let weight = f64::from(self.links.weight);
        let cost = |a, b, offset| weight * f64::from(self.seams.between(a, b, offset));
        for (at, &node) in nodes.iter().enumerate() {
            let Some(taken) = proposal[at] else { continue };
            let held = here[at];
            let price = |at| usage.price(usage.cell_at(at));
            graph.add_node_cost(node, price(taken) - price(held));
            for link in region.links(at) {
                let offset = [link.near.x, link.near.y];
                let other = (link.at != OUTSIDE).then_some(link.at as usize);
                let others = other.map_or(map[link.near.site as usize], |other| here[other]);
                match other.and_then(|other| Some((nodes[other], proposal[other]?))) {
                    // Every link inside is met from both ends.
                    Some((mate, _)) if mate < node => {}
                    Some((mate, theirs)) => {
                        let costs = [
                            cost(held, others, offset),
                            cost(held, theirs, offset),
                            cost(taken, others, offset),
                            cost(taken, theirs, offset),
                        ];
                        graph.add_link_costs([node, mate], costs);
                    }
                    None => {
                        let more = cost(taken, others, offset) - cost(held, others, offset);
                        graph.add_node_cost(node, more);
                    }
                }
            }
        }
        let labels: Vec<bool> = graph.cut().collect();
        let takes = |at: usize| nodes[at] != FIXED && labels[nodes[at] as usize];
        let next: Vec<TexCoord> = (0..here.len())
            .map(|at| proposal[at].filter(|_| takes(at)).unwrap_or(here[at]))
            .collect();
        let saved = self.saved(region, (here, &next, map), takes);
        here.copy_from_slice(&next);
        saved
    }

    /// What the links of the sites that take something cost less then.
    fn saved(
        &self,
        region: &Region,
        (here, next, map): (&[TexCoord], &[TexCoord], &[TexCoord]),
        takes: impl Fn(usize) -> bool,
    ) -> f64 {
        let mut saved = 0.0;
        for at in (0..here.len()).filter(|&at| takes(at)) {
            for link in region.links(at) {
                let offset = [link.near.x, link.near.y];
                let (before, after) = match link.at {
                    OUTSIDE => [map[link.near.site as usize]; 2].into(),
                    other => (here[other as usize], next[other as usize]),
                };
                let less = f64::from(self.seams.between(here[at], before, offset))
                    - f64::from(self.seams.between(next[at], after, offset));
                let is_met_twice = link.at != OUTSIDE && takes(link.at as usize);
                saved += if is_met_twice { 0.5 * less } else { less };
            }
        }
        saved * f64::from(self.links.weight)
    }

    /// A coordinate on the grid whose texel may be picked, if that is one.
    fn admitted(&self, at: TexCoord) -> Option<TexCoord> {
        let grid = self.exemplar.grid;
        let texel = grid.texel_holding(at)?;
        if at.s.is_nan() || !self.exemplar.whole[texel.index()] {
            return None;
        }
        Some(grid.coordinate(at.s, grid.height as f32 - at.t))
    }

    fn is_same(&self, a: TexCoord, b: TexCoord) -> bool {
        let (ds, dt) = self.exemplar.grid.difference(a, b);
        ds.abs().max(dt.abs()) < 1e-3
    }
}
