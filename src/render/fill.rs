//! Fill light: a dim environment beside the lights, brighter from above, that lightens shaded parts.
//!
//! Its radiance changes linearly with direction, so a sample under it is a combination of four sums of each view's
//! images (`even_light`), which are laid out beside the images. So it costs four more images to read instead of one
//! light for each part of the sky. Its occlusion at a vertex is one number: the share of the hemisphere that is open,
//! weighted by the cosine.

use std::f32::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::render::occlusion::{Occluders, RayOrigin};

/// How much the radiance rises from the horizon to the zenith, and sinks to the nadir, over that at the horizon.
const GRADIENT: f64 = 0.75;
/// Rays that find how much of a vertex's hemisphere is open.
pub const RAYS: u32 = 32;
/// Vertices of one task.
const CHUNK: usize = 1 << 10;

/// A dim environment: in direction ω its radiance is `radiance` · (1 + ¾ ω · up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Linear radiance at the horizon, the mean of all directions.
    pub radiance: f32,
    /// Unit vector that points up.
    pub up: DVec3,
}

impl Fill {
    /// By what the four sums of a view's images are multiplied where `up` points to the zenith.
    #[inline(always)]
    pub fn shares(&self, up: DVec3) -> [f32; 4] {
        let gradient = (GRADIENT * up).as_vec3();
        // With E = ∫ T and Pₖ = ∫ T (1 + ωₖ)/2, ∫ T (1 + g · ω) is E + Σ gₖ (2 Pₖ − E).
        let [x, y, z] = gradient.to_array();
        [1.0 - x - y - z, 2.0 * x, 2.0 * y, 2.0 * z].map(|share| share * self.radiance)
    }

    /// Irradiance of a plane whose normal has this cosine to the zenith.
    #[inline(always)]
    pub fn irradiance(&self, cosine: f64) -> f32 {
        PI * self.radiance * (1.0 + 2.0 / 3.0 * GRADIENT * cosine) as f32
    }
}

/// The open share of the hemisphere of each of some vertices, by vertex; 1 for all others.
pub fn openness(
    occluders: &Occluders,
    map: &SurfaceTextonMap,
    vertices: &[u32],
    progress: Progress<'_>,
) -> Vec<f32> {
    let find = |&vertex: &u32| {
        if progress.is_interrupted() {
            return 1.0;
        }
        let point = map.mesh.positions[vertex as usize];
        let normal = map.normals[vertex as usize];
        occluders.openness(point, normal, RayOrigin::Vertex(point), RAYS, vertex)
    };
    let found: Vec<f32> = vertices.par_iter().with_min_len(CHUNK).map(find).collect();
    let mut open = vec![1.0; map.mesh.positions.len()];
    for (&vertex, found) in vertices.iter().zip(found) {
        open[vertex as usize] = found;
    }
    open
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_plane_receives_what_its_shares_say() {
        // The four sums of a white plane, and a plane turned about x away from the zenith.
        let sums = [1.0, 0.5, 0.5, 5.0 / 6.0];
        for turn in [0.0f64, 0.5, 1.2, 2.5] {
            let fill = Fill {
                radiance: 0.3,
                up: DVec3::Y,
            };
            let up = DVec3::new(0.0, turn.sin(), turn.cos());
            let shares = fill.shares(up);
            let shown: f32 = shares.iter().zip(sums).map(|(a, b)| a * b).sum();
            let wanted = fill.irradiance(up.z) / PI;
            assert!((shown - wanted).abs() < 1e-6, "{turn}: {shown} {wanted}");
        }
    }
}
