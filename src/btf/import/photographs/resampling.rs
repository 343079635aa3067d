//! Means of what texels cover in a picture: bilinear numbers at points spread evenly over each texel, as many as it
//! covers pixels.

use rayon::prelude::*;

use crate::format::image::{Encoding, FloatImage};

/// The most points along a side of a texel.
const MOST_POINTS: f64 = 32.0;

/// The image of `size` whose texels cover what `map` says: it takes (u, v) of the unit square, v down, to pixels from
/// the picture's left and top border.
pub(super) fn resample(
    picture: &FloatImage,
    (width, height): (u32, u32),
    map: impl Fn([f64; 2]) -> [f64; 2] + Sync,
) -> FloatImage {
    let channels = picture.channels as usize;
    let mut data = vec![0.0; width as usize * height as usize * channels];
    let (across, down) = (1.0 / f64::from(width), 1.0 / f64::from(height));
    let rows = data.par_chunks_mut(width as usize * channels).enumerate();
    rows.for_each(|(row, texels)| {
        let top = row as f64 * down;
        for (column, texel) in texels.chunks_exact_mut(channels).enumerate() {
            let left = column as f64 * across;
            // Average as many points as the texel covers pixels.
            let (columns, rows) = points(&map, [left, top], [across, down]);
            for point in 0..columns * rows {
                let u = left + ((point % columns) as f64 + 0.5) / columns as f64 * across;
                let v = top + ((point / columns) as f64 + 0.5) / rows as f64 * down;
                add_bilinear(picture, map([u, v]), texel);
            }
            texel
                .iter_mut()
                .for_each(|value| *value /= (columns * rows) as f32);
        }
    });
    FloatImage {
        width,
        height,
        channels: picture.channels,
        data,
        encoding: Encoding::Linear,
        precision: picture.precision,
    }
}

/// Points across and down a texel: as many as the longer of its opposite sides have pixels.
fn points(
    map: &impl Fn([f64; 2]) -> [f64; 2],
    [left, top]: [f64; 2],
    [across, down]: [f64; 2],
) -> (usize, usize) {
    let corner = |i: f64, j: f64| map([left + i * across, top + j * down]);
    let [a, b, c, d] = [
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 1.0),
    ];
    let length = |p: [f64; 2], q: [f64; 2]| (q[0] - p[0]).hypot(q[1] - p[1]);
    let count = |one: f64, other: f64| one.max(other).ceil().clamp(1.0, MOST_POINTS) as usize;
    (
        count(length(a, b), length(d, c)),
        count(length(a, d), length(b, c)),
    )
}

/// Adds the bilinear number of each channel; beyond the border it is that of the border.
fn add_bilinear(picture: &FloatImage, [x, y]: [f64; 2], sums: &mut [f32]) {
    let place = |at: f64, side: u32| {
        let last = f64::from(side - 1);
        let at = (at - 0.5).clamp(0.0, last);
        let low = at.floor();
        (low as u32, (low + 1.0).min(last) as u32, (at - low) as f32)
    };
    let (left, right, x) = place(x, picture.width);
    let (top, bottom, y) = place(y, picture.height);
    for (channel, sum) in sums.iter_mut().enumerate() {
        let get = |row, column| picture.get(row, column, channel as u32);
        let upper = get(top, left) * (1.0 - x) + get(top, right) * x;
        let lower = get(bottom, left) * (1.0 - x) + get(bottom, right) * x;
        *sum += upper * (1.0 - y) + lower * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::Precision;

    fn picture(width: u32, height: u32, value: impl Fn(u32, u32) -> f32) -> FloatImage {
        let texel = |at: u32| value(at % width, at / width);
        FloatImage {
            width,
            height,
            channels: 1,
            data: (0..width * height).map(texel).collect(),
            encoding: Encoding::Linear,
            precision: Precision::Float,
        }
    }

    #[test]
    fn texels_of_the_same_size_keep_their_numbers() {
        let before = picture(5, 4, |x, y| (x * 10 + y) as f32);
        let after = resample(&before, (5, 4), |[u, v]| [5.0 * u, 4.0 * v]);
        assert_eq!(after.data, before.data);
    }

    #[test]
    fn larger_texels_are_means_of_what_they_cover() {
        let before = picture(8, 8, |x, y| ((x + y) % 2) as f32);
        let after = resample(&before, (2, 2), |[u, v]| [8.0 * u, 8.0 * v]);
        assert!(
            after.data.iter().all(|value| (value - 0.5).abs() < 1e-6),
            "{after:?}"
        );
    }

    #[test]
    fn a_ramp_stays_one_however_it_is_cut_out() {
        let before = picture(40, 30, |x, y| {
            2.0 * (x as f32 + 0.5) + 3.0 * (y as f32 + 0.5)
        });
        let after = resample(&before, (6, 5), |[u, v]| {
            [5.0 + 20.0 * u + 4.0 * v, 3.0 + 16.0 * v]
        });
        for (at, value) in after.data.iter().enumerate() {
            let (u, v) = ((at % 6) as f32 + 0.5, (at / 6) as f32 + 0.5);
            let (x, y) = (5.0 + 20.0 * u / 6.0 + 4.0 * v / 5.0, 3.0 + 16.0 * v / 5.0);
            assert!((value - (2.0 * x + 3.0 * y)).abs() < 1e-3, "{at}: {value}");
        }
    }
}
