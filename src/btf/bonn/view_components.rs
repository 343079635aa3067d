//! The principal components of the images of one view, as PVF has them.
//!
//! The numbers of a texel under all lights, \[light\]\[channel\], are a point; the mean over all texels is taken off,
//! and the eigenvectors of the points' products are the components.

use ndarray::{Array2, Axis, s};

use crate::btf::bonn::pvf::View;
use crate::btf::factored::orthonormal::inner_products;
use crate::btf::sample::{Pixels, Sample};
use crate::error::Result;
use crate::matrix::{Update, eigen, multiply_on_all_threads};

/// The first `rank` components of a view with all values multiplied by `scale`.
pub(super) fn of(sample: &Sample, view: usize, rank: usize, scale: f32) -> Result<View> {
    let mut points = read(sample, view, scale)?;
    let texels = points.ncols() as f64;
    let mut mean = Vec::with_capacity(points.nrows());
    for mut row in points.axis_iter_mut(Axis(0)) {
        let average = row.iter().map(|&v| f64::from(v)).sum::<f64>() / texels;
        mean.push(average as f32);
        row.mapv_inplace(|v| v - average as f32);
    }
    let (_, vectors) = eigen(inner_products(points.t()));
    let components = vectors.slice(s![.., ..rank]).mapv(|v| v as f32);
    let mut weights = Array2::zeros((points.ncols(), rank));
    multiply_on_all_threads(
        points.t(),
        components.view(),
        weights.view_mut(),
        Update::Replace,
    );
    Ok(View {
        mean,
        components,
        weights,
    })
}

/// The images of a view, [(light, channel), texel].
fn read(sample: &Sample, view: usize, scale: f32) -> Result<Array2<f32>> {
    let (lights, texels) = (sample.description().lights.len(), sample.grid().len());
    let mut points = Array2::zeros((lights * 3, texels));
    let mut pixels = Pixels::of_type(sample.description().dtype);
    for light in 0..lights {
        sample.read_texels(view * lights + light, 0..texels, &mut pixels)?;
        for channel in 0..3 {
            let mut row = points.row_mut(light * 3 + channel);
            let numbers = row.iter_mut().enumerate();
            numbers.for_each(|(texel, to)| *to = pixels.get(texel * 3 + channel) * scale);
        }
    }
    Ok(points)
}
