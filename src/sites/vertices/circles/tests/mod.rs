//! Tests of circles, and the meshes they share.

mod closed_forms;
mod prepared;

use glam::Vec3;

use super::*;
use crate::mesh::frame::Frame;
use crate::mesh::rings::Rings;
use crate::mesh::shapes;
use crate::mesh::topology::Topology;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::neighborhood::Template;
use crate::progress::Progress;
use crate::sites::level::SampleLocation;
use crate::sites::vertices::stencil::PatchStencils;

/// A mesh with what marching needs.
struct Ready {
    mesh: TriangleMesh,
    topology: Topology,
    rings: Rings,
}

impl Ready {
    fn new(mesh: TriangleMesh) -> Self {
        let topology = Topology::new(&mesh.triangles);
        let rings = Rings::new(&mesh, &topology);
        Self {
            mesh,
            topology,
            rings,
        }
    }

    fn surface(&self) -> Manifold<'_> {
        Manifold {
            mesh: &self.mesh,
            topology: &self.topology,
            rings: &self.rings,
        }
    }

    fn march(&self, radius: f32, count: u32) -> Circles {
        let radii = vec![radius; self.mesh.positions.len()];
        marching::march(self.surface(), &radii, count, Progress::silent()).unwrap()
    }

    /// Frames whose s is a direction, projected; rotated by an angle.
    fn frames(&self, direction: Vec3, turned: f32) -> Vec<Frame> {
        let frame = |n: &Vec3| {
            let level =
                Frame::new(*n, direction).or_else(|| Frame::new(*n, Vec3::new(0.3, 0.5, 0.8)));
            let Frame { s, t, .. } = level.unwrap();
            Frame::new(*n, s * turned.cos() + t * turned.sin()).unwrap()
        };
        self.rings.normals.iter().map(frame).collect()
    }

    fn stencils(&self, circles: &Circles, frames: &[Frame]) -> PatchStencils {
        let template = Template::round(circles.per_vertex);
        let found = sampling::stencils(circles, self.surface(), frames, &template);
        found.unwrap().0
    }

    fn position(&self, sample: SampleLocation<3>) -> Option<Vec3> {
        let (sites, weights) = match sample {
            SampleLocation::Outside => return None,
            SampleLocation::AtSite(site) => ([site; 3], [1.0, 0.0, 0.0]),
            SampleLocation::Between(sites, weights) => (sites, weights),
        };
        let corners = sites.map(|site| self.mesh.positions[site as usize]);
        Some((0..3).map(|k| corners[k] * weights[k]).sum())
    }

    /// The vertex nearest to a point.
    fn vertex_at(&self, point: Vec3) -> usize {
        let distance = |v: &usize| self.mesh.positions[*v].distance(point);
        let all = 0..self.mesh.positions.len();
        all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap()
    }
}

fn flat(side: u32) -> Ready {
    Ready::new(shapes::grid(side, side, 0.5))
}
