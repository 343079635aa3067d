//! Photometric stereo (Woodham 1980): a matte texel's luminance is ρ n·l/π, so its normal follows from several lights
//! by least squares. Shadows and highlights are outliers: squares are weighted by 1/|residual|, again and again, which
//! minimises the sum of absolute residuals.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::btf::bake::maps::normals::Slopes;
use crate::btf::heights::planes::LitPlane;
use crate::grid::TexelGrid;

/// Rounds of weighting.
const ROUNDS: usize = 10;
/// Residuals below this share of a texel's median luminance count alike.
const ALIKE: f64 = 0.05;
/// Slopes beyond this many texels per texel are cut to it.
const STEEPEST: f64 = 3.0;

/// Heights in texels, mean 0.
pub(super) fn heights(planes: &[LitPlane], grid: TexelGrid) -> Vec<f32> {
    let lights: Vec<DVec3> = planes.iter().map(|plane| plane.light).collect();
    let texel = |texel: usize| {
        let values = planes.iter().map(|plane| f64::from(plane.luminance[texel]));
        normal(&lights, &values.collect::<Vec<_>>())
    };
    let normals: Vec<DVec3> = (0..grid.len()).into_par_iter().map(texel).collect();
    let size = [grid.width, grid.height].map(|side| side as usize);
    let heights = Slopes::of_normals(size, &normals).heights(grid.tileable);
    heights.into_iter().map(|height| height as f32).collect()
}

/// The normal of a texel, no steeper than [`STEEPEST`]; straight up where it is black.
pub(super) fn normal(lights: &[DVec3], values: &[f64]) -> DVec3 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let alike = ALIKE * sorted[sorted.len() / 2] + 1e-6;
    let mut weights = vec![1.0; values.len()];
    let mut found = DVec3::Z;
    for _ in 0..ROUNDS {
        let (mut matrix, mut vector) = (DMat3::from_diagonal(DVec3::splat(1e-9)), DVec3::ZERO);
        for ((&light, &value), &weight) in lights.iter().zip(values).zip(&weights) {
            let scaled = weight * light;
            matrix += DMat3::from_cols(scaled * light.x, scaled * light.y, scaled * light.z);
            vector += scaled * value;
        }
        found = matrix.inverse() * vector;
        for ((&light, &value), weight) in lights.iter().zip(values).zip(&mut weights) {
            *weight = 1.0 / ((value - found.dot(light).max(0.0)).abs() + alike);
        }
    }
    let slope = -found.truncate() / found.z.max(1e-9);
    match found.is_finite() && found.z > 0.0 {
        true => {
            let slope = slope.clamp_length_max(STEEPEST);
            DVec3::new(-slope.x, -slope.y, 1.0).normalize()
        }
        false => DVec3::Z,
    }
}
