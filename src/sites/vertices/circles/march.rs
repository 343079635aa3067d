//! Marching one circle over a patch (Chen 2008 §4.3): from triangle to triangle, counter-clockwise about
//! the axis, until the circle closes or the patch ends.
//!
//! In each triangle the cylinder cuts an arc of an ellipse, which is exact here but for its length
//! (Simpson's rule over short arcs). What is found is laid out as one partition of the full turn, from the
//! reference tangent on, in which stretches without surface are gaps.
//!
//! Deviation: the paper takes every circle as closed. A gap counts here with the length that it would have in
//! the plane, so that percentages near a boundary stay those of the surface that is there.

use std::f64::consts::TAU;

use glam::DVec2;

use super::arcs::Arc;
use super::patch::{Facet, Patch, Way};
use crate::mesh::topology::{next, previous};
use crate::neighborhood::turn_of;

/// The largest angle of an arc in radians, where the triangle rises by 45° or more: between its ends the
/// length is linear in the angle, which is exact in a level triangle and off by h² m²/16 radians for an arc of
/// h radians on a slope m.
const LONGEST_ARC: f64 = TAU / 24.0;
/// How much larger it may be in a triangle that is nearly level.
const LEVEL_ARC: f64 = 4.0;
/// Narrower gaps, in radians, are rounding: angles are stored to 10⁻⁴.
const LEAST_GAP: f64 = 1e-6;
/// Steps of a stored angle or arc length in a full turn.
const STEPS: f64 = 65536.0;

/// A stretch of a circle in one triangle, or a gap.
#[derive(Clone, Copy, Debug)]
struct Span {
    triangle: u32,
    /// Angles from the reference tangent, in radians, 0 ≤ from < to ≤ 2π.
    from: f64,
    to: f64,
    /// In mesh units.
    length: f64,
}

impl Span {
    /// The span from an angle on, its length cut in proportion.
    fn after(self, angle: f64) -> Self {
        let kept = (self.to - angle) / (self.to - self.from);
        Self {
            from: angle,
            length: self.length * kept,
            ..self
        }
    }
}

/// Marches circles; keeps its memory from one to the next.
#[derive(Default)]
pub(super) struct Marcher {
    /// Marched spans, chain after chain.
    spans: Vec<Span>,
    /// Chains within one turn: index of the first span and past the last.
    chains: Vec<(usize, usize)>,
    /// First span of the chain being marched, and the angle it has reached.
    chain: usize,
    angle: f64,
    /// The partition of the turn.
    laid_out: Vec<Span>,
}

impl Marcher {
    /// Marches circle `circle` of a patch; appends its arcs and returns its length, gaps counted as in the
    /// plane.
    pub(super) fn circle(&mut self, patch: &Patch<'_>, circle: u32, out: &mut Vec<Arc>) -> f64 {
        self.spans.clear();
        self.chains.clear();
        let starts = |&&half_edge: &&u32| {
            let facet = patch.facet_at(half_edge);
            facet.is_some_and(|facet| patch.crosses(half_edge, facet, circle, Way::Out))
        };
        for &start in patch.border.iter().filter(starts) {
            self.march(patch, circle, start);
        }
        if self.spans.is_empty()
            && let Some(start) = first_crossing(patch, circle)
        {
            self.march(patch, circle, start);
        }
        self.lay_out(patch.radius_of(circle));
        self.pack(out)
    }

    /// Follows the circle from the half-edge at which it enters a triangle.
    fn march(&mut self, patch: &Patch<'_>, circle: u32, start: u32) {
        let Some(mut facet) = patch.facet_at(start) else {
            return;
        };
        let mut entry = start;
        let mut at = patch.crossing(start, facet, circle, Way::Out);
        let radius = patch.radius_of(circle);
        self.chain = self.spans.len();
        self.angle = turn_of(at) * TAU;
        // Each half-edge leaves a circle once, so no chain has more steps.
        for _ in 0..3 * patch.facets.len() {
            let ways_out = [next(entry), previous(entry), entry];
            let exit = ways_out
                .into_iter()
                .find(|&edge| patch.crosses(edge, facet, circle, Way::In));
            let Some(exit) = exit else { break };
            let to = patch.crossing(exit, facet, circle, Way::In);
            self.add(facet, at, to, radius);
            at = to;
            match patch.twin(exit) {
                Some(twin) if twin != start => entry = twin,
                _ => break,
            }
            let Some(onward) = patch.facet_at(entry) else {
                break;
            };
            facet = onward;
        }
        self.end_chain();
    }

    /// Adds the arc of a triangle between two points of a circle, in short pieces.
    fn add(&mut self, facet: &Facet, from: DVec2, to: DVec2, radius: f64) {
        // Find how many pieces the arc needs.
        let angle = from.perp_dot(to).atan2(from.dot(to));
        if angle <= 0.0 {
            return;
        }
        let longest = LONGEST_ARC / facet.slope.length().clamp(1.0 / LEVEL_ARC, 1.0);
        let pieces = (angle / longest) as usize + 1;
        let step = angle / pieces as f64;
        let turn = if pieces > 1 {
            DVec2::from_angle(step)
        } else {
            DVec2::X
        };
        // Measure each by Simpson's rule.
        let speed = |at: DVec2| (1.0 + facet.slope.dot(at.perp()).powi(2)).sqrt();
        let mut at = from / radius;
        let mut speed_at = speed(at);
        for piece in 1..=pieces {
            let end = if piece < pieces {
                turn.rotate(at)
            } else {
                to / radius
            };
            let middle = (at + end).normalize_or(at);
            let speed_end = speed(end);
            let mean = (speed_at + 4.0 * speed(middle) + speed_end) / 6.0;
            self.push(Span {
                triangle: facet.triangle,
                from: self.angle,
                to: self.angle + step,
                length: radius * step * mean,
            });
            (at, speed_at) = (end, speed_end);
        }
    }

    /// Appends a span and moves on; one that passes the reference tangent is cut there and begins another
    /// chain.
    fn push(&mut self, span: Span) {
        if span.to < TAU {
            self.angle = span.to;
            self.spans.push(span);
            return;
        }
        let rest = span.after(TAU);
        self.spans.push(Span {
            to: TAU,
            length: span.length - rest.length,
            ..span
        });
        self.end_chain();
        self.chain = self.spans.len();
        self.angle = span.to - TAU;
        if self.angle > 0.0 {
            self.spans.push(Span {
                from: 0.0,
                to: self.angle,
                ..rest
            });
        }
    }

    fn end_chain(&mut self) {
        if self.chain < self.spans.len() {
            self.chains.push((self.chain, self.spans.len()));
        }
    }

    /// Lays the chains round the turn. Where two cover an angle, the one that begins first keeps it.
    fn lay_out(&mut self, radius: f64) {
        let Self {
            spans,
            chains,
            laid_out,
            ..
        } = self;
        // Sort the chains by where they begin.
        chains.sort_by(|a, b| spans[a.0].from.total_cmp(&spans[b.0].from));
        laid_out.clear();
        let mut reached = 0.0;
        let gap = |from: f64, to: f64| Span {
            triangle: Arc::GAP,
            from,
            to,
            length: radius * (to - from),
        };
        // Lay them out, with gaps where none covers.
        for &(first, end) in chains.iter() {
            for &span in &spans[first..end] {
                if span.to <= reached {
                    continue;
                }
                if span.from > reached + LEAST_GAP {
                    laid_out.push(gap(reached, span.from));
                }
                laid_out.push(span.after(span.from.max(reached)));
                reached = span.to;
            }
        }
        if reached < TAU - LEAST_GAP {
            laid_out.push(gap(reached, TAU));
        }
    }

    /// Appends the partition in whole steps and returns its length.
    fn pack(&self, out: &mut Vec<Arc>) -> f64 {
        let total: f64 = self.laid_out.iter().map(|span| span.length).sum();
        let (turns, fractions) = (STEPS / TAU, STEPS / total);
        let begin = out.len();
        let mut length = 0.0;
        for span in &self.laid_out {
            let turn = (span.from * turns + 0.5) as u32;
            let fraction = ((length * fractions + 0.5) as u32).min(STEPS as u32 - 1);
            length += span.length;
            if turn >= STEPS as u32 {
                break;
            }
            let arc = Arc {
                triangle: span.triangle,
                turn: turn as u16,
                fraction: fraction as u16,
            };
            // An arc narrower than a step gives way to the next.
            match out[begin..].last_mut() {
                Some(last) if last.turn == arc.turn => *last = arc,
                _ => out.push(arc),
            }
        }
        if let Some(first) = out.get_mut(begin) {
            (first.turn, first.fraction) = (0, 0);
        }
        total
    }
}

/// The first half-edge of the patch that leaves a circle.
fn first_crossing(patch: &Patch<'_>, circle: u32) -> Option<u32> {
    patch.facets.iter().find_map(|facet| {
        let mut half_edges = 3 * facet.triangle..3 * facet.triangle + 3;
        half_edges.find(|&edge| patch.crosses(edge, facet, circle, Way::Out))
    })
}
