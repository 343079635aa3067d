//! The factors of a factored sample, as a `.btf` file takes them.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use ndarray::{Array2, s};

use crate::btf::bonn::factors::Channel;
use crate::btf::factored::factorization::CHANNELS;
use crate::btf::factored::factors::Factors;

/// T and m of a sample's colour step.
pub(super) fn color_step(factors: &Factors) -> (DMat3, DVec3) {
    let factorization = factors.factorization();
    (
        DMat3::from_cols_array(&factorization.color_transform).transpose(),
        DVec3::from_array(factorization.color_mean),
    )
}

/// U of a channel, [images, K].
pub(super) fn directions(factors: &Factors, channel: usize) -> Array2<f32> {
    let [images, _] = factors.sides();
    let mut rows = Array2::zeros((images, factors.rank()));
    for (image, mut row) in rows.rows_mut().into_iter().enumerate() {
        let numbers = factors.direction(channel, image);
        row.iter_mut()
            .zip(numbers)
            .for_each(|(to, &from)| *to = from);
    }
    rows
}

/// E of a set, [texels, K].
pub(super) fn eigentextures(factors: &Factors, set: usize) -> Array2<f32> {
    let [_, texels] = factors.sides();
    let mut rows = Array2::zeros((texels, factors.rank()));
    let mut plane = vec![0.0; texels];
    for (factor, mut column) in rows.columns_mut().into_iter().enumerate() {
        factors.copy_eigentexture(set, factor, &mut plane);
        column
            .iter_mut()
            .zip(&plane)
            .for_each(|(to, &from)| *to = from);
    }
    rows
}

/// The first `rank` factors of each channel, eigentextures multiplied by `scale`.
pub(super) fn channels(factors: &Factors, rank: usize, scale: f32) -> Vec<Channel> {
    let sets = factors.factorization().sets();
    let mut channels: Vec<Channel> = Vec::new();
    for channel in 0..CHANNELS {
        let eigentextures = match channels.first().filter(|_| sets == 1) {
            Some(first) => Arc::clone(&first.eigentextures),
            None => {
                let all = eigentextures(factors, channel);
                Arc::new(all.slice(s![.., ..rank]).mapv(|number| number * scale))
            }
        };
        let directions = directions(factors, channel);
        channels.push(Channel {
            directions: Arc::new(directions.slice(s![.., ..rank]).to_owned()),
            eigentextures,
        });
    }
    channels
}
