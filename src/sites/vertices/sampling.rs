//! Where the samples of a neighbourhood fall in a chart (Tong 2002 §5.1, Fig. 4): the patch
//! triangle that contains each, and the barycentric weights there.
//!
//! A sample has no value when no patch triangle contains it, when a folded triangle does (one the
//! chart turns over), or when two do. Triangles that the chart stretches to more than twice the
//! length of an edge close the ring round a narrow part of the surface; they are no part of the
//! patch.

use glam::Vec2;

use crate::mesh::chart::{ChartGrower, Placed};
use crate::mesh::connection::Connection;
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::Template;
use crate::sites::vertices::stencil::PackedSample;

/// Longer than this multiple of the real edge, a chart edge is no image of it.
const STRETCH_LIMIT: f32 = 2.0;
/// A sample this near a triangle's edge (in weight) may belong to the neighbour as well.
const ON_EDGE: f32 = 1e-3;
/// A sample this little outside a triangle (in weight) still belongs to it.
const SLACK: f32 = 1e-5;

/// A template sorted into unit squares, so that a triangle finds its samples.
#[derive(Clone, Debug)]
pub struct BinnedTemplate {
    positions: Vec<Vec2>,
    low: Vec2,
    columns: i32,
    rows: i32,
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl BinnedTemplate {
    /// Sorts a template.
    pub fn new(template: &Template) -> Self {
        let positions = template.positions.clone();
        let first = positions.first().copied().unwrap_or_default();
        let (low, high) = positions
            .iter()
            .fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
        // Shifted so that samples on whole numbers lie amid their squares.
        let low = low - 0.5;
        let size = (high - low).floor().as_ivec2() + 1;
        let mut binned = Self {
            low,
            columns: size.x,
            rows: size.y,
            starts: Vec::new(),
            members: Vec::new(),
            positions,
        };
        for bin in 0..size.x * size.y {
            binned.starts.push(binned.members.len() as u32);
            let inside = |&sample: &u32| {
                let at = (binned.positions[sample as usize] - low).floor().as_ivec2();
                at.y * size.x + at.x == bin
            };
            let members: Vec<u32> = (0..binned.positions.len() as u32).filter(inside).collect();
            binned.members.extend(members);
        }
        binned.starts.push(binned.members.len() as u32);
        binned
    }

    /// Samples of the template.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// The farthest sample from the centre, in texels.
    pub fn radius(&self) -> f32 {
        self.positions.iter().fold(0.0, |r, p| r.max(p.length()))
    }

    #[inline]
    fn within(&self, low: Vec2, high: Vec2, mut visit: impl FnMut(u32, Vec2)) {
        let from = (low - self.low).floor().as_ivec2().max(glam::IVec2::ZERO);
        let to = (high - self.low).floor().as_ivec2();
        for row in from.y..=to.y.min(self.rows - 1) {
            for column in from.x..=to.x.min(self.columns - 1) {
                let bin = (row * self.columns + column) as usize;
                for slot in self.starts[bin]..self.starts[bin + 1] {
                    let sample = self.members[slot as usize];
                    visit(sample, self.positions[sample as usize]);
                }
            }
        }
    }
}

/// What is known of a sample so far.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Found {
    Nothing,
    OnEdge(u32, [f32; 3]),
    Inside(u32, [f32; 3]),
    Folded,
}

/// What became of the samples of one site.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleCounts {
    /// With a value.
    pub valued: u64,
    /// Outside every patch triangle.
    pub outside: u64,
    /// Marked, because the chart folds there.
    pub folded: u64,
}

impl std::ops::AddAssign for SampleCounts {
    fn add_assign(&mut self, more: Self) {
        self.valued += more.valued;
        self.outside += more.outside;
        self.folded += more.folded;
    }
}

/// Finds the samples of a template in charts; keeps its memory from one to the next.
pub struct Sampler<'a> {
    mesh: &'a TriangleMesh,
    connection: &'a Connection,
    template: &'a BinnedTemplate,
    found: Vec<Found>,
}

impl<'a> Sampler<'a> {
    /// For one mesh and template.
    pub fn new(
        mesh: &'a TriangleMesh,
        connection: &'a Connection,
        template: &'a BinnedTemplate,
    ) -> Self {
        Self {
            mesh,
            connection,
            template,
            found: Vec::new(),
        }
    }

    /// Finds every sample in the chart `grower` grew last, of which `placed` are the vertices;
    /// one texel is `texel` mesh units. Appends one packed sample each.
    pub fn locate(
        &mut self,
        grower: &ChartGrower,
        placed: &[Placed],
        texel: f32,
        out: &mut Vec<PackedSample>,
    ) -> SampleCounts {
        self.locate_drawn(grower, placed, |position| position / texel, out)
    }

    /// Like [`locate`](Self::locate) in any drawing of the chart: `draw` takes a position of the chart to the
    /// template's plane and keeps the orientation.
    pub fn locate_drawn(
        &mut self,
        grower: &ChartGrower,
        placed: &[Placed],
        draw: impl Fn(Vec2) -> Vec2,
        out: &mut Vec<PackedSample>,
    ) -> SampleCounts {
        self.found.clear();
        self.found.resize(self.template.len(), Found::Nothing);
        for from in placed {
            let spokes = self.connection.spokes.row(from.vertex as usize);
            for spoke in spokes.iter().filter(|spoke| spoke.triangle != NONE) {
                let corners = self.mesh.triangles[spoke.triangle as usize];
                if corners.iter().all(|&corner| corner >= from.vertex) {
                    self.visit_triangle(grower, spoke.triangle, &draw);
                }
            }
        }
        self.pack(out)
    }

    /// Like [`locate`](Self::locate), where one sample is known to stand on a vertex: a template's
    /// centre in a chart round a vertex.
    pub fn stands_on(&self, vertex: u32) -> PackedSample {
        let spokes = self.connection.spokes.row(vertex as usize);
        let Some(spoke) = spokes.first().filter(|spoke| spoke.triangle != NONE) else {
            return PackedSample::OUTSIDE;
        };
        let corners = self.mesh.triangles[spoke.triangle as usize];
        let weights = corners.map(|corner| f32::from(u8::from(corner == vertex)));
        PackedSample::new(spoke.triangle, weights)
    }

    fn visit_triangle(
        &mut self,
        grower: &ChartGrower,
        triangle: u32,
        draw: &impl Fn(Vec2) -> Vec2,
    ) {
        let ids = self.mesh.triangles[triangle as usize];
        let [Some(a), Some(b), Some(c)] = ids.map(|id| grower.position_of(id)) else {
            return;
        };
        let chart = [a, b, c];
        let [a, b, c] = chart.map(draw);
        let doubled = (b - a).perp_dot(c - a);
        if doubled == 0.0 {
            return;
        }
        let (mesh, found) = (self.mesh, &mut self.found);
        // Most triangles hold no sample and need not be asked.
        let mut stretched = None;
        let mut is_stretched = || {
            *stretched.get_or_insert_with(|| is_stretched(mesh.corners(triangle as usize), chart))
        };
        self.template.within(
            a.min(b).min(c) - SLACK,
            a.max(b).max(c) + SLACK,
            |sample, p| {
                let first = (b - p).perp_dot(c - p) / doubled;
                let second = (c - p).perp_dot(a - p) / doubled;
                let weights = [first, second, 1.0 - first - second];
                let least = weights[0].min(weights[1]).min(weights[2]);
                if least >= -SLACK && !is_stretched() {
                    let slot = &mut found[sample as usize];
                    *slot = merge(*slot, triangle, weights, least, doubled > 0.0);
                }
            },
        );
    }

    fn pack(&self, out: &mut Vec<PackedSample>) -> SampleCounts {
        let mut counts = SampleCounts::default();
        out.extend(self.found.iter().map(|found| match *found {
            Found::OnEdge(triangle, weights) | Found::Inside(triangle, weights) => {
                counts.valued += 1;
                PackedSample::new(triangle, weights)
            }
            Found::Nothing => {
                counts.outside += 1;
                PackedSample::OUTSIDE
            }
            Found::Folded => {
                counts.folded += 1;
                PackedSample::OUTSIDE
            }
        }));
        counts
    }
}

/// What a sample becomes when one more triangle contains it.
fn merge(found: Found, triangle: u32, weights: [f32; 3], least: f32, upright: bool) -> Found {
    let inside = least > ON_EDGE;
    match found {
        Found::Folded => Found::Folded,
        Found::Inside(..) if inside => Found::Folded,
        Found::Inside(..) => found,
        Found::Nothing | Found::OnEdge(..) if inside && !upright => Found::Folded,
        Found::Nothing | Found::OnEdge(..) if inside => Found::Inside(triangle, weights),
        Found::Nothing if upright => Found::OnEdge(triangle, weights),
        Found::OnEdge(first, _) if upright && triangle < first => Found::OnEdge(triangle, weights),
        Found::Nothing | Found::OnEdge(..) => found,
    }
}

/// Whether a chart draws a triangle's edges more than [`STRETCH_LIMIT`] times as long as they are.
fn is_stretched(corners: [glam::Vec3; 3], chart: [Vec2; 3]) -> bool {
    (0..3).any(|k| {
        let real = corners[k].distance_squared(corners[(k + 1) % 3]);
        let drawn = chart[k].distance_squared(chart[(k + 1) % 3]);
        drawn > STRETCH_LIMIT * STRETCH_LIMIT * real
    })
}
