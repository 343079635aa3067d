//! Images at another size: area means where they shrink, linear between texel centres where they
//! grow, along each axis by itself. Sides keep their extent, so tileable stays tileable.

use crate::format::image::FloatImage;

/// Sides with `longer` texels along the longer one, in the proportions of `width` × `height`.
pub(super) fn fitted(width: u32, height: u32, longer: u32) -> (u32, u32) {
    let shorter = |short: u32, long: u32| {
        let scaled = f64::from(short) * f64::from(longer) / f64::from(long);
        (scaled.round() as u32).max(1)
    };
    if width >= height {
        (longer, shorter(height, width))
    } else {
        (shorter(width, height), longer)
    }
}

/// The image with other sides.
pub(super) fn resampled(image: &FloatImage, width: u32, height: u32) -> FloatImage {
    let channels = image.channels as usize;
    let across = along_rows(&image.data, image.width as usize, width as usize, channels);
    let line = width as usize * channels;
    // A column of lines is a row of wide texels.
    let data = along_rows(&across, image.height as usize, height as usize, line);
    FloatImage {
        width,
        height,
        data,
        ..*image
    }
}

/// Resamples rows of `from` texels to rows of `to`, each texel `channels` numbers.
fn along_rows(data: &[f32], from: usize, to: usize, channels: usize) -> Vec<f32> {
    if from == to {
        return data.to_vec();
    }
    let taps: Vec<Vec<(usize, f32)>> = (0..to).map(|target| weights(target, from, to)).collect();
    let rows = data.chunks_exact(from * channels);
    let mut out = vec![0.0; data.len() / from * to];
    for (row, out) in rows.zip(out.chunks_exact_mut(to * channels)) {
        for (taps, texel) in taps.iter().zip(out.chunks_exact_mut(channels)) {
            for &(source, weight) in taps {
                let source = &row[source * channels..][..channels];
                for (sum, value) in texel.iter_mut().zip(source) {
                    *sum += weight * value;
                }
            }
        }
    }
    out
}

/// The source texels of a target texel with their weights, which sum to 1.
fn weights(target: usize, from: usize, to: usize) -> Vec<(usize, f32)> {
    let scale = from as f64 / to as f64;
    if to > from {
        let place = (target as f64 + 0.5) * scale - 0.5;
        let share = place - place.floor();
        let wrap = |index: f64| (index.rem_euclid(from as f64)) as usize;
        return vec![
            (wrap(place.floor()), (1.0 - share) as f32),
            (wrap(place.floor() + 1.0), share as f32),
        ];
    }
    let (low, high) = (target as f64 * scale, (target + 1) as f64 * scale);
    (low.floor() as usize..(high.ceil() as usize).min(from))
        .map(|source| {
            let covered = high.min(source as f64 + 1.0) - low.max(source as f64);
            (source, (covered / scale) as f32)
        })
        .filter(|&(_, weight)| weight > 0.0)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn shrinking_takes_area_means_and_keeps_the_mean() {
        let source = FloatImage::gray(4, 2, vec![1.0, 3.0, 5.0, 7.0, 1.0, 3.0, 5.0, 7.0]);
        assert_eq!(resampled(&source, 2, 1).data, [2.0, 6.0]);
        let thirds = resampled(&source, 3, 2);
        let mean = thirds.data.iter().sum::<f32>() / 6.0;
        assert!((mean - 4.0).abs() < 1e-6);
        // Texel 0 covers texel 0 whole and a third of texel 1.
        assert!((thirds.data[0] - 1.5).abs() < 1e-6);
    }

    #[test]
    fn growing_is_linear_and_wraps() {
        let grown = resampled(&FloatImage::gray(2, 1, vec![0.0, 4.0]), 4, 1);
        assert_eq!(grown.data, [1.0, 1.0, 3.0, 3.0]);
        let same = FloatImage::gray(3, 1, vec![1.0, 2.0, 3.0]);
        assert_eq!(resampled(&same, 3, 1).data, same.data);
    }

    #[test]
    fn proportions_are_kept() {
        assert_eq!(fitted(512, 512, 128), (128, 128));
        assert_eq!(fitted(300, 200, 150), (150, 100));
        assert_eq!(fitted(10, 1000, 50), (1, 50));
    }
}
