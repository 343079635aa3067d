//! Positions by percentage of arc length (Chen 2008 §4.3, Eq. 1), and neighbours measured the same way, for
//! one field: the circles stay as they are.
//!
//! P_0 of a circle is where it meets the texture direction s. The n-th sample of a ring lies where the arc
//! length from P_0, counter-clockwise about the normal, is the same share of the circle as on the flat
//! template.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::arcs::{Arc, Circles};
use super::frame::{AxisFrame, Manifold};
use crate::error::{Error, Result};
use crate::mesh::compressed_rows::Rows;
use crate::mesh::frame::Frame;
use crate::mesh::topology::NONE;
use crate::neighborhood::{Template, turn_of};
use crate::sites::level::Neighbor;
use crate::sites::vertices::sampling::SampleCounts;
use crate::sites::vertices::stencil::{PackedSample, PatchStencils};

/// Vertices that a thread takes at a time.
const BLOCK: usize = 1024;

/// A template's samples by ring and share of the ring.
struct RingSamples {
    /// Per ring, from the innermost, the shares of its samples in turns.
    shares: Vec<Vec<f32>>,
}

impl RingSamples {
    fn new(template: &Template, circles: u32) -> Result<Self> {
        let ends = &template.ring_ends;
        let ordered = ends.len() == circles as usize + 1
            && ends.first() == Some(&1)
            && ends.last() == Some(&template.positions.len());
        if !ordered {
            return Err(Error::data("template", format!("ring ends {ends:?}"))
                .expected(format!("a round template of {circles} rings")));
        }
        let shares = |pair: &[usize]| {
            let ring = &template.positions[pair[0]..pair[1]];
            ring.iter().map(|p| turn_of(p.as_dvec2()) as f32).collect()
        };
        Ok(Self {
            shares: ends.windows(2).map(shares).collect(),
        })
    }
}

/// The samples of a round template at every vertex, under the directions of `frames`.
pub fn stencils(
    circles: &Circles,
    surface: Manifold<'_>,
    frames: &[Frame],
    template: &Template,
) -> Result<(PatchStencils, SampleCounts)> {
    check_frames(circles, frames)?;
    // Sample each vertex.
    let rings = RingSamples::new(template, circles.per_vertex)?;
    let per_site = template.positions.len();
    let mut samples = vec![PackedSample::OUTSIDE; per_site * frames.len()];
    samples
        .par_chunks_mut(per_site)
        .enumerate()
        .for_each(|(vertex, samples)| {
            samples[0] = centre(surface, vertex);
            let place = Placement::new(circles, surface, &frames[vertex], vertex);
            place.samples(&rings, &mut samples[1..]);
        });
    // Count what fell outside.
    let outside = samples
        .par_iter()
        .filter(|sample| **sample == PackedSample::OUTSIDE)
        .count() as u64;
    let stencils = PatchStencils {
        samples_per_site: per_site,
        cells: surface.mesh.triangles.clone(),
        samples,
    };
    let counts = SampleCounts {
        valued: stencils.samples.len() as u64 - outside,
        outside,
        folded: 0,
    };
    Ok((stencils, counts))
}

fn check_frames(circles: &Circles, frames: &[Frame]) -> Result<()> {
    match frames.len() == circles.radii.len() {
        true => Ok(()),
        false => Err(Error::data("frames", frames.len().to_string())
            .expected(circles.radii.len().to_string())),
    }
}

/// The sample that stands on a vertex itself.
fn centre(surface: Manifold<'_>, vertex: usize) -> PackedSample {
    let edges = surface.rings.edges.row(vertex);
    let Some(edge) = edges.first().filter(|edge| edge.triangle != NONE) else {
        return PackedSample::OUTSIDE;
    };
    let corners = surface.mesh.triangles[edge.triangle as usize];
    let weights = corners.map(|corner| f32::from(u8::from(corner as usize == vertex)));
    PackedSample::new(edge.triangle, weights)
}

/// The circles of one vertex under one direction.
struct Placement<'a> {
    circles: &'a Circles,
    surface: Manifold<'a>,
    frame: AxisFrame,
    vertex: usize,
    /// The texture direction, in turns from the reference tangent.
    direction: f32,
}

impl<'a> Placement<'a> {
    fn new(circles: &'a Circles, surface: Manifold<'a>, frame: &Frame, vertex: usize) -> Self {
        let axis = AxisFrame::new(surface, vertex);
        Self {
            circles,
            surface,
            frame: axis,
            vertex,
            direction: axis.turn_of(frame.s) as f32,
        }
    }

    fn samples(&self, rings: &RingSamples, out: &mut [PackedSample]) {
        let mut slots = out.iter_mut();
        for (number, shares) in (1..).zip(&rings.shares) {
            let circle = self.circles.circle(self.vertex, number);
            let first = circle.fraction_at(self.direction);
            for (share, slot) in shares.iter().zip(&mut slots) {
                let (triangle, turn) = circle.point_at((first + share).fract());
                if triangle != Arc::GAP {
                    let radius = f64::from(self.circles.radii[self.vertex]) * f64::from(number);
                    *slot = self.sample(triangle, radius, turn);
                }
            }
        }
    }

    /// The point of a triangle at a distance and an angle from the axis.
    fn sample(&self, triangle: u32, radius: f64, turn: f32) -> PackedSample {
        let at = DVec2::from_angle(f64::from(turn) * std::f64::consts::TAU) * radius;
        let corners = self.surface.mesh.corners(triangle as usize);
        let [a, b, c] = corners.map(|corner| self.frame.place(corner).truncate() - at);
        let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let sum: f64 = weights.iter().sum();
        PackedSample::new(triangle, weights.map(|weight| (weight / sum) as f32))
    }

    /// The vertices inside the outermost circle, with their offsets in texels along s and t.
    fn neighbors(&self) -> impl Iterator<Item = Neighbor> + '_ {
        let near = self.circles.near.row(self.vertex);
        near.iter().map(|near| {
            let distance = near.share() * self.circles.per_vertex as f32;
            let first = self
                .circles
                .fraction_between(self.vertex, distance, self.direction);
            let angle = (near.turn() - first) * std::f32::consts::TAU;
            let offset = Vec2::from_angle(angle) * distance;
            Neighbor {
                site: near.vertex,
                x: offset.x,
                y: offset.y,
            }
        })
    }
}

/// The neighbours of every vertex, nearest first, under the directions of `frames`. A neighbour's radius is
/// its distance from the axis, its angle the share of the arc length from P_0 on the circle through it.
pub fn neighbors(
    circles: &Circles,
    surface: Manifold<'_>,
    frames: &[Frame],
) -> Result<Rows<Neighbor>> {
    check_frames(circles, frames)?;
    let blocks: Vec<Vec<Neighbor>> = frames
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, frames)| {
            let vertices = (BLOCK * block..).zip(frames);
            let places =
                vertices.map(|(vertex, frame)| Placement::new(circles, surface, frame, vertex));
            let mut entries = Vec::new();
            places.for_each(|place| entries.extend(place.neighbors()));
            entries
        })
        .collect();
    Ok(Rows {
        starts: circles.near.starts.clone(),
        entries: blocks.concat(),
    })
}
