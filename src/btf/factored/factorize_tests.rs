//! Factors against exact ones.

use std::ops::Range;

use nalgebra::DMatrix;
use serde_json::Value;

use crate::btf::description::{DType, Description};
use crate::btf::direction::Direction;
use crate::btf::factored::factorize::{Accuracy, FactorOptions, factorize};
use crate::btf::factored::image_matrix::ImageMatrix;
use crate::btf::factored::residual::measure;
use crate::btf::height_map::HeightMap;
use crate::btf::image_source::ImageSource;
use crate::btf::sample::Sample;
use crate::error::Result;
use crate::progress::Progress;

/// Images held in memory.
struct Held {
    description: Description,
    numbers: Vec<f32>,
}

impl ImageSource for Held {
    fn description(&self) -> &Description {
        &self.description
    }

    fn heights(&self) -> Result<Option<HeightMap>> {
        Ok(None)
    }

    fn read_images(&self, images: Range<usize>, out: &mut [f32]) -> Result<()> {
        let image = self.description.grid().len() * 3;
        out.copy_from_slice(&self.numbers[images.start * image..images.end * image]);
        Ok(())
    }
}

/// Images with a slowly falling spectrum: shaded waves and some that nothing foretells.
fn images(lights: usize, width: u32, height: u32) -> Held {
    let directions =
        (0..lights).map(|i| Direction::from_angles(1.3 * i as f64 / lights as f64, i as f64 * 2.4));
    let lights: Vec<Direction> = directions.collect();
    let mut numbers = Vec::new();
    for (image, light) in lights.iter().enumerate() {
        for texel in 0..width * height {
            let (row, col) = (f64::from(texel / width), f64::from(texel % width));
            let slope = glam::DVec3::new((0.9 * col).cos(), (0.7 * row + 0.2 * col).sin(), 2.0);
            let shade = slope.normalize().dot(light.0).max(0.0);
            for channel in 0..3 {
                let noise = (image * 7919 + texel as usize * 104_729 + channel * 31) % 251;
                numbers.push((shade * (0.4 - 0.1 * channel as f64) + 1e-4 * noise as f64) as f32);
            }
        }
    }
    Held {
        description: Description {
            tileable: true,
            ..Description::product(
                "waves",
                [width, height],
                vec![Direction::from_angles(0.0, 0.0)],
                lights,
            )
        },
        numbers,
    }
}

/// The error that the exact truncated decompositions of the three channels leave.
fn exact_error(images: &Held, rank: usize) -> f64 {
    let (rows, columns) = (
        images.description.image_count(),
        images.description.grid().len(),
    );
    let (mut left, mut total) = (0.0, 0.0);
    for channel in 0..3 {
        let number =
            |i: usize, x: usize| f64::from(images.numbers[(i * columns + x) * 3 + channel]);
        let mut values = DMatrix::from_fn(rows, columns, number).singular_values();
        values.as_mut_slice().sort_by(|a, b| b.total_cmp(a));
        total += values.iter().map(|v| v * v).sum::<f64>();
        left += values.iter().skip(rank).map(|v| v * v).sum::<f64>();
    }
    (left / total).sqrt()
}

fn options(accuracy: Accuracy) -> FactorOptions {
    FactorOptions {
        accuracy,
        dtype: DType::F4,
        seed: 0,
    }
}

#[test]
fn the_error_is_that_of_the_exact_decomposition() {
    let source = images(40, 15, 11);
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    for rank in [1, 4, 9, 40] {
        let exact = exact_error(&source, rank);
        let accuracy = Accuracy::Rank(rank as u32);
        let (description, left) = factorize(
            &source,
            &options(accuracy),
            Value::Null,
            &target,
            Progress::silent(),
        )
        .unwrap();
        assert_eq!(description.factors().unwrap().rank as usize, rank);
        assert!(
            left.relative <= 1.01 * exact + 1e-6,
            "{} against {exact}",
            left.relative
        );
        // What is reported is what a reader finds.
        let sample = Sample::open(&target).unwrap();
        let matrix = ImageMatrix::new(&source);
        let found = measure(
            &matrix,
            sample.factors().unwrap(),
            DType::F4,
            Progress::silent(),
        )
        .unwrap();
        assert_eq!(found, left);
        assert!(left.worst_image_error >= left.relative && left.worst_texel_error >= left.relative);
    }
}

#[test]
fn the_least_rank_for_an_error_is_found() {
    let source = images(120, 15, 11);
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    for limit in [0.2, 0.05, 0.01, 0.002] {
        let run = options(Accuracy::Error(limit));
        let (description, left) =
            factorize(&source, &run, Value::Null, &target, Progress::silent()).unwrap();
        let rank = description.factors().unwrap().rank as usize;
        assert!(left.relative <= limit, "{} for {limit}", left.relative);
        let fewer = exact_error(&source, rank.saturating_sub(1 + rank / 16));
        assert!(
            fewer > 0.98 * limit,
            "rank {rank}: {fewer} would do for {limit}"
        );
    }
    let halves = FactorOptions {
        dtype: DType::F2,
        ..options(Accuracy::Error(1e-5))
    };
    let refused = factorize(&source, &halves, Value::Null, &target, Progress::silent());
    assert!(refused.unwrap_err().to_string().contains("--dtype f4"));
}

#[test]
fn images_of_fewer_directions_leave_nothing() {
    let mut source = images(20, 9, 9);
    let image = source.numbers[..243].to_vec();
    for (at, number) in source.numbers.iter_mut().enumerate() {
        *number = image[at % 243] * (1.0 + (at / 243) as f32);
    }
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("x.sample");
    let run = options(Accuracy::Rank(7));
    let (_, left) = factorize(&source, &run, Value::Null, &target, Progress::silent()).unwrap();
    assert!(left.relative < 1e-6, "{}", left.relative);
    source.numbers.fill(0.0);
    let (_, left) = factorize(&source, &run, Value::Null, &target, Progress::silent()).unwrap();
    assert_eq!(left.relative, 0.0);
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let source = images(60, 24, 20);
    let run = |threads| {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("x.sample");
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let factored = pool.install(|| {
            factorize(
                &source,
                &options(Accuracy::Rank(10)),
                Value::Null,
                &target,
                Progress::silent(),
            )
        });
        factored.unwrap().0.id
    };
    assert_eq!(run(1), run(4));
}

#[test]
fn ranks_and_errors_out_of_range_are_refused() {
    let source = images(5, 9, 9);
    let refused = |accuracy| {
        options(accuracy)
            .validate(&source.description)
            .unwrap_err()
            .to_string()
    };
    assert!(refused(Accuracy::Rank(0)).contains("--rank"));
    assert!(refused(Accuracy::Rank(6)).contains("1 to 5"));
    for error in [0.0, -1.0, 1.0, f64::NAN] {
        assert!(refused(Accuracy::Error(error)).contains("--error"));
    }
}
