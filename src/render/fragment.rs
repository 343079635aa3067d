//! The pieces of surface in a pixel: samples of one smooth piece are shaded once, at the one
//! nearest to the pixel's centre.
//!
//! Meshes finer than pixels put a different triangle under almost every sample, so samples count
//! as one piece when their triangles share a vertex, or when they lie on one plane to within a
//! pixel and face the same way.

use glam::Vec3;

use crate::mesh::triangle_mesh::TriangleMesh;
use crate::render::camera::View;
use crate::render::raster::Hit;

/// The most samples of colour a pixel has.
pub const MOST: usize = 16;

/// Some of the samples of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleSet(u16);

impl SampleSet {
    /// The first alone.
    pub const ONE: Self = Self(1);

    fn add(&mut self, sample: usize) {
        self.0 |= 1 << sample;
    }

    /// How many there are.
    pub fn len(self) -> u32 {
        self.0.count_ones()
    }

    /// The numbers of the samples, in order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        (0..MOST).filter(move |sample| self.0 >> sample & 1 == 1)
    }
}

/// The smooth pieces of surface in one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Pieces {
    /// Where each piece is shaded.
    hits: [Hit; MOST],
    /// The samples that see each piece.
    samples: [SampleSet; MOST],
    count: usize,
    /// All samples of the pixel.
    total: usize,
}

impl Pieces {
    /// Finds the pieces of a pixel; `order` has its colour samples, nearest to the centre first.
    pub fn of_pixel(mesh: &TriangleMesh, view: &View, hits: &[Hit], order: &[usize]) -> Self {
        let mut pieces = Self {
            hits: [Hit::MISS; MOST],
            samples: [SampleSet::default(); MOST],
            count: 0,
            total: order.len(),
        };
        for &sample in order {
            if hits[sample].is_surface() {
                pieces.add(mesh, view, sample, &hits[sample]);
            }
        }
        pieces
    }

    fn add(&mut self, mesh: &TriangleMesh, view: &View, sample: usize, hit: &Hit) {
        let same = |known: &Hit| is_one_piece(mesh, view, known, hit);
        let piece = self.hits().iter().position(same).unwrap_or(self.count);
        if piece == self.count {
            self.hits[piece] = *hit;
            self.count += 1;
        }
        self.samples[piece].add(sample);
    }

    /// Where each piece is shaded.
    pub fn hits(&self) -> &[Hit] {
        &self.hits[..self.count]
    }

    /// The samples that see a piece.
    pub fn samples(&self, piece: usize) -> SampleSet {
        self.samples[piece]
    }

    /// The share of the pixel's samples that see a piece.
    pub fn share(&self, piece: usize) -> f32 {
        self.samples[piece].len() as f32 / self.total as f32
    }
}

fn is_one_piece(mesh: &TriangleMesh, view: &View, a: &Hit, b: &Hit) -> bool {
    let (first, second) = (a.triangle as usize, b.triangle as usize);
    let others = mesh.triangles[second];
    if mesh.triangles[first].iter().any(|v| others.contains(v)) {
        return true;
    }
    let normals = [first, second].map(|t| mesh.area_normal(t).normalize_or_zero());
    if normals[0].dot(normals[1]) < 0.7 {
        return false;
    }
    let (p, q) = (point(mesh, a), point(mesh, b));
    let depth = view.camera_from_world(p.as_dvec3()).z;
    let pixel = 1.0 / view.pixels_per_unit_at(depth) as f32;
    normals[0].dot(q - p).abs() < pixel
}

/// The point of the surface that a sample sees.
#[inline]
pub fn point(mesh: &TriangleMesh, hit: &Hit) -> Vec3 {
    let [a, b, c] = mesh.triangles[hit.triangle as usize];
    let [u, v, w] = hit.barycentric();
    mesh.positions[a as usize] * u + mesh.positions[b as usize] * v + mesh.positions[c as usize] * w
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::camera::{Camera, Projection};
    use glam::DVec3;

    #[test]
    fn pieces_are_split_at_silhouettes_and_joined_on_a_surface() {
        // Two coplanar triangles without a common vertex, and one far behind them.
        let mesh = TriangleMesh {
            positions: [
                [-1.0, -1.0, 0.0],
                [0.0, -1.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.01, -1.0, 0.0],
                [1.0, -1.0, 0.0],
                [0.01, 1.0, 0.0],
                [-1.0, -1.0, -3.0],
                [1.0, -1.0, -3.0],
                [0.0, 1.0, -3.0],
            ]
            .map(Vec3::from_array)
            .to_vec(),
            triangles: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]],
        };
        let camera = Camera {
            position: DVec3::new(0.0, 0.0, 5.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Orthographic { height: 2.0 },
        };
        let view = View::new(camera, [20, 20]).unwrap();
        let hit = |triangle| Hit {
            triangle,
            weights: [0.3, 0.3],
        };
        let hits = [hit(2), hit(0), Hit::MISS, hit(1)];
        let pieces = Pieces::of_pixel(&mesh, &view, &hits, &[1, 0, 2, 3]);
        assert_eq!(pieces.hits(), [hit(0), hit(2)]);
        assert_eq!((pieces.share(0), pieces.share(1)), (0.5, 0.25));
        let samples = [0, 1].map(|piece| pieces.samples(piece).iter().collect::<Vec<_>>());
        assert_eq!(samples, [vec![1, 3], vec![0]]);
    }
}
