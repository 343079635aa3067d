//! The vertices that are shaded: all that some triangle uses, or those of the triangles that a view sees.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::mesh::triangle_mesh::TriangleMesh;
use crate::render::raster::{Hit, SurfaceBuffer};
use crate::render::vertex_shading::Site;

/// Vertices that one task chooses from.
const CHOSEN: usize = 1 << 14;

/// Vertices to shade, those that some triangle uses.
pub struct Vertices {
    /// In the order of their texels.
    pub by_texel: Vec<Site>,
    /// The same, neighbours after each other; empty where nothing casts shadows.
    pub by_place: Vec<u32>,
}

impl Vertices {
    /// Those of all triangles that some sample sees. One is turned where all of its triangles are seen from `inside`.
    pub fn seen_in(
        &self,
        surface: &SurfaceBuffer,
        mesh: &TriangleMesh,
        inside: impl Fn(&Hit) -> bool + Sync,
    ) -> Self {
        // Mark the vertices of the triangles that are seen, and from which side.
        let none = || -> Vec<AtomicBool> {
            let vertices = mesh.positions.iter();
            vertices.map(|_| AtomicBool::new(false)).collect()
        };
        let [needed, outside] = [none(), none()];
        surface.for_each_surface(|hit| {
            let is_outside = !inside(hit);
            for vertex in mesh.triangles[hit.triangle as usize] {
                needed[vertex as usize].store(true, Ordering::Relaxed);
                if is_outside {
                    outside[vertex as usize].store(true, Ordering::Relaxed);
                }
            }
        });
        // Keep the marked ones.
        let is_needed = |vertex: u32| needed[vertex as usize].load(Ordering::Relaxed);
        let turned = |site: &Site| {
            let mut site = *site;
            site.turned = !outside[site.vertex as usize].load(Ordering::Relaxed);
            site
        };
        Self {
            by_texel: self
                .by_texel
                .par_iter()
                .with_min_len(CHOSEN)
                .filter(|site| is_needed(site.vertex))
                .map(turned)
                .collect(),
            by_place: self
                .by_place
                .par_iter()
                .with_min_len(CHOSEN)
                .copied()
                .filter(|&vertex| is_needed(vertex))
                .collect(),
        }
    }
}
