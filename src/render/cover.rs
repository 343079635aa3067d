//! A plain colour that shows where a texture is transparent (Ying 2001, Figure 9): the surface below reflects as
//! Lambert's law says, under the same lights and shadows as the sample above it.

use std::f32::consts::FRAC_1_PI;

use glam::Vec4;

/// The surface below a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// Per vertex the share of the colour that the texture has, from 0 to 1; the rest is the plain colour's.
    pub alpha: Vec<f32>,
    /// The plain colour: linear albedo, red to blue.
    pub color: [f32; 3],
}

impl Cover {
    /// The radiance of a vertex: that of the texture, and that of the plain colour under the same
    /// `irradiance`, the cosine included.
    #[inline(always)]
    pub(super) fn mixed(&self, vertex: usize, texture: Vec4, irradiance: Vec4) -> Vec4 {
        let [r, g, b] = self.color;
        let plain = irradiance * Vec4::new(r, g, b, 0.0) * FRAC_1_PI;
        plain + self.alpha[vertex] * (texture - plain)
    }
}

/// Light of three channels from a direction whose cosine to the normal is given.
#[inline(always)]
pub(super) fn received([r, g, b]: [f32; 3], cosine: f64) -> Vec4 {
    Vec4::new(r, g, b, 0.0) * cosine as f32
}
