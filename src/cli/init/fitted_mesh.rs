//! How finely a mesh is retiled, and how large the texture is on it.

use crate::cli::machine::available_memory;
use crate::error::{Error, Result};
use crate::mesh::reading::UserMesh;
use crate::sites::vertices::memory::vertices_retiled_in;

/// How often a sample is laid side by side across the square that has the surface's area.
const REPEATS: f64 = 4.0;
/// Vertices at least and at most, whatever the sample.
const VERTICES: std::ops::RangeInclusive<f64> = 5_000.0..=300_000.0;
/// How far the mesh's own number of vertices may be from the wanted one to be kept.
const NEAR: std::ops::RangeInclusive<f64> = 0.8..=1.5;

/// A mesh fitted to a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FittedMesh {
    /// Its own vertices.
    own: usize,
    /// Vertices it is retiled to.
    pub(super) vertices: usize,
    /// Whether it keeps its own.
    pub(super) keeps_own: bool,
    /// Mesh units that a texel covers.
    pub(super) texel: f64,
    /// How often the sample is laid side by side across the square of the surface's area.
    pub(super) repeats: f64,
    /// Its size, in mesh units.
    pub(super) extent: [f32; 3],
}

impl FittedMesh {
    /// One vertex per texel, and the sample about [`REPEATS`] times across.
    pub(super) fn new(user: &UserMesh, [width, height]: [u32; 2]) -> Result<Self> {
        let mesh = &user.mesh;
        let (own, area) = (mesh.referenced_count(), mesh.area());
        if !(area > 0.0 && area.is_finite()) {
            return Err(Error::data("mesh", format!("area {area}")).expected("a surface"));
        }
        let texels = f64::from(width) * f64::from(height);
        let wanted = (REPEATS.powi(2) * texels).clamp(*VERTICES.start(), *VERTICES.end());
        let most =
            available_memory().map_or(f64::MAX, |free| vertices_retiled_in(free.0 / 2) as f64);
        let keeps_own = NEAR.contains(&(own as f64 / wanted));
        let vertices = match keeps_own {
            true => own as f64,
            false => rounded(wanted.min(most)),
        };
        let texel = rounded((area / vertices).sqrt());
        let (low, high) = mesh.bounds();
        Ok(Self {
            own,
            vertices: vertices as usize,
            keeps_own,
            texel,
            repeats: (area / texels).sqrt() / texel,
            extent: (high - low).to_array(),
        })
    }

    /// What a person reads.
    pub(super) fn describe(&self) -> String {
        let Self {
            own,
            vertices,
            texel,
            repeats,
            ..
        } = self;
        let retiled = match self.keeps_own {
            true => String::new(),
            false => format!(", retiled to {vertices}"),
        };
        format!(
            "a mesh of {own} vertices{retiled}; a texel covers {texel} mesh units, so that the sample repeats \
             {repeats:.1} times across the surface"
        )
    }
}

/// A number with two significant digits.
fn rounded(number: f64) -> f64 {
    format!("{number:.1e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::builtin::kettlebell;

    #[test]
    fn vertices_follow_the_sample_and_the_texel_follows_them() {
        let user = UserMesh::from(kettlebell(4000));
        let fitted = |side: u32| FittedMesh::new(&user, [side, side]).unwrap();
        assert_eq!(fitted(64).vertices, 66_000);
        assert_eq!(fitted(128).vertices, 260_000);
        assert_eq!(fitted(512).vertices, 300_000);
        for side in [64, 128] {
            let repeats = fitted(side).repeats;
            assert!((repeats / REPEATS - 1.0).abs() < 0.1, "{repeats}");
        }
        assert!(fitted(128).texel < fitted(64).texel);
    }

    #[test]
    fn a_mesh_that_fits_is_kept() {
        let user = UserMesh::from(kettlebell(16_000));
        let fitted = FittedMesh::new(&user, [32, 32]).unwrap();
        assert!(fitted.keeps_own);
        assert_eq!(fitted.vertices, user.mesh.referenced_count());
    }
}
