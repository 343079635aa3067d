//! A sample small enough for a page: the images of each view factored by themselves.
//!
//! In: a sample, an error and a number of bytes. Out: per view a few eigentextures in whole numbers of one step, and
//! per light the numbers that mix them.
//!
//! Parallax and masking differ from view to view; so a view's own eigentextures reach an error with far fewer than
//! those of all images together (Sattler 2003), and a browser multiplies them out in about a second. The step is that
//! of a transform code: the same for all, so that the many weak eigentextures have few values and compress well. An
//! eigentexture weaker than the step's rounding is left out.

use std::io;
use std::ops::Range;
use std::path::Path;

use ndarray::{Array2, ArrayView2, s};
use rayon::prelude::*;

use crate::btf::description::Description;
use crate::btf::image_source::ImageSource;
use crate::error::{Error, Result};
use crate::matrix::{Update, as_rows, eigen, multiply, product_of};
use crate::progress::Progress;
use crate::render::nearest::{DirectionSet, PairSet, Weighting};
use crate::report::numbers;

/// Channels of an image.
const CHANNELS: usize = 3;
/// The largest number of a direction's factor.
const DIRECTION_STEP: f32 = 32767.0;
/// How much coarser the step becomes where the bytes are too many.
const COARSER: f64 = 1.3;
/// The largest error that a page is made with where none as large is asked for.
const LARGEST_ERROR: f64 = 0.5;

/// How good and how small factors are to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The error asked for, relative to the root mean square of all values.
    pub error: f64,
    /// The most bytes, compressed; where they do not suffice, the error grows.
    pub bytes: usize,
    /// The most texels of all images expanded; where there are more, grids are halved.
    pub texels: u64,
}

/// Images that share their eigentextures.
#[derive(Clone, Debug)]
pub struct Group {
    /// How many images.
    pub images: usize,
    /// How many eigentextures.
    pub rank: usize,
    /// [images, rank], in units of 1 / 32767.
    directions: Vec<i16>,
    /// [rank, texels · 3], in steps.
    eigentextures: Vec<i16>,
}

/// A sample in factors.
#[derive(Clone, Debug)]
pub struct ViewFactors {
    /// Columns and rows.
    pub size: [u32; 2],
    /// How often the sample's grid was halved.
    pub halvings: u32,
    /// What an eigentexture's 1 stands for.
    pub step: f64,
    /// One per distinct view; one in all for scattered pairs.
    pub groups: Vec<Group>,
    /// The views, and the lights, that the images are of; of pairs image by image.
    pub directions: [Vec<u32>; 2],
    /// The error that is left, relative to the root mean square of all values, measured.
    pub error: f64,
    /// Everything as the page carries it, compressed.
    pub packed: Vec<u8>,
}

/// Factors a sample.
pub fn view_factors(
    source: &dyn ImageSource,
    limits: &Limits,
    progress: Progress<'_>,
) -> Result<ViewFactors> {
    // Factor the images of each view.
    let images = GroupedImages::new(source, limits.texels)?;
    progress.begin("eigentextures of views", images.groups.len() as u64);
    let spectra: Vec<Spectrum> = images
        .groups
        .par_iter()
        .map(|group| {
            let spectrum = Spectrum::of(&images.read(group)?);
            progress.advance(1)?;
            Ok(spectrum)
        })
        .collect::<Result<_>>()?;
    progress.end();
    // Find the largest step that meets the wanted error.
    let total: f64 = spectra.iter().map(|spectrum| spectrum.total).sum();
    let mut step = step_for(&spectra, images.columns(), limits.error, total);
    // Quantize, and coarsen the step until the bytes suffice.
    loop {
        let (groups, squares) = images.quantized(&spectra, step, progress)?;
        let error = if total > 0.0 {
            (squares / total).sqrt()
        } else {
            0.0
        };
        if error > limits.error.max(LARGEST_ERROR) {
            let found = format!(
                "{} images of {} × {} texels",
                images.count(),
                images.size[0],
                images.size[1]
            );
            return Err(Error::data("sample", found)
                .expected(format!("a sample that fits {} kB", limits.bytes / 1000))
                .advice(
                    "crop it, or take fewer directions (mesotex import --help), or a smaller mesh",
                ));
        }
        let packed = packed(&groups).map_err(Error::io(Path::new("the page"), "compress"))?;
        if packed.len() <= limits.bytes {
            return Ok(ViewFactors {
                size: images.size,
                halvings: images.halvings,
                step,
                groups,
                directions: images.directions,
                error,
                packed,
            });
        }
        step *= COARSER * (packed.len() as f64 / limits.bytes as f64).powf(0.25);
    }
}

/// The images of a sample by groups, at a size that a graphics card holds.
struct GroupedImages<'a> {
    source: &'a dyn ImageSource,
    groups: Vec<Rows>,
    directions: [Vec<u32>; 2],
    size: [u32; 2],
    halvings: u32,
}

/// A run of images and those of it that count.
struct Rows {
    run: Range<usize>,
    kept: Vec<usize>,
}

impl<'a> GroupedImages<'a> {
    fn new(source: &'a dyn ImageSource, texels: u64) -> Result<Self> {
        let description = source.description();
        let (groups, directions) = grouped(description)?;
        let count: usize = groups.iter().map(|group| group.kept.len()).sum();
        let mut size = [description.width, description.height];
        let mut halvings = 0;
        while size.map(u64::from).iter().product::<u64>() * count as u64 > texels && size != [1, 1]
        {
            size = size.map(|side| side.div_ceil(2));
            halvings += 1;
        }
        Ok(Self {
            source,
            groups,
            directions,
            size,
            halvings,
        })
    }

    fn count(&self) -> usize {
        self.groups.iter().map(|group| group.kept.len()).sum()
    }

    /// Numbers of an image.
    fn columns(&self) -> usize {
        CHANNELS * self.size[0] as usize * self.size[1] as usize
    }

    /// The images of a group, one per row.
    fn read(&self, group: &Rows) -> Result<Array2<f32>> {
        let description = self.source.description();
        let length = CHANNELS * description.grid().len();
        let mut numbers = vec![0.0; length * group.run.len()];
        self.source.read_images(group.run.clone(), &mut numbers)?;
        let mut rows = Vec::with_capacity(group.kept.len() * self.columns());
        for &image in &group.kept {
            let at = (image - group.run.start) * length;
            let mut pixels = numbers[at..at + length].to_vec();
            let mut size = [description.width, description.height].map(|side| side as usize);
            for _ in 0..self.halvings {
                (pixels, size) = halved(&pixels, size);
            }
            rows.extend(pixels);
        }
        Ok(as_rows(&rows, group.kept.len(), self.columns()).to_owned())
    }

    /// Factors of a step, and the sum of squared differences that they leave.
    fn quantized(
        &self,
        spectra: &[Spectrum],
        step: f64,
        progress: Progress<'_>,
    ) -> Result<(Vec<Group>, f64)> {
        progress.begin("factors of views", self.groups.len() as u64);
        let found: Vec<(Group, f64)> = self
            .groups
            .par_iter()
            .zip(spectra)
            .map(|(group, spectrum)| {
                let found = quantize(&self.read(group)?, spectrum, step);
                progress.advance(1)?;
                Ok(found)
            })
            .collect::<Result<_>>()?;
        progress.end();
        let squares = found.iter().map(|(_, squares)| squares).sum();
        Ok((found.into_iter().map(|(group, _)| group).collect(), squares))
    }
}

/// Groups of distinct views, lights or pairs, and which directions these are.
fn grouped(description: &Description) -> Result<(Vec<Rows>, [Vec<u32>; 2])> {
    let (views, lights) = (&description.views, &description.lights);
    // Make one group of a scattered sample.
    if let Some(pairs) = &description.pairs {
        let kept = PairSet::new(views, lights, pairs, Weighting::Continuous)?
            .kept()
            .to_vec();
        let side = |k: usize| kept.iter().map(|&image| pairs[image as usize][k]).collect();
        let directions = [side(0), side(1)];
        let kept = kept.into_iter().map(|image| image as usize).collect();
        let run = 0..pairs.len();
        return Ok((vec![Rows { run, kept }], directions));
    }
    // Make a group per view.
    let [views_kept, lights_kept] = [views, lights].map(|directions| {
        DirectionSet::new(directions, Weighting::Continuous)
            .kept()
            .to_vec()
    });
    let stride = lights.len();
    let group = |&view: &u32| {
        let first = view as usize * stride;
        Rows {
            run: first..first + stride,
            kept: lights_kept
                .iter()
                .map(|&light| first + light as usize)
                .collect(),
        }
    };
    Ok((
        views_kept.iter().map(group).collect(),
        [views_kept, lights_kept],
    ))
}

/// Means of 2 × 2 texels of what exists.
fn halved(pixels: &[f32], [width, height]: [usize; 2]) -> (Vec<f32>, [usize; 2]) {
    let size = [width.div_ceil(2), height.div_ceil(2)];
    let mut out = Vec::with_capacity(CHANNELS * size[0] * size[1]);
    for row in 0..size[1] {
        for column in 0..size[0] {
            let rows = 2 * row..height.min(2 * row + 2);
            let columns = 2 * column..width.min(2 * column + 2);
            let count = (rows.len() * columns.len()) as f32;
            for channel in 0..CHANNELS {
                let values = rows
                    .clone()
                    .flat_map(|r| columns.clone().map(move |c| r * width + c));
                let sum: f32 = values.map(|at| pixels[CHANNELS * at + channel]).sum();
                out.push(sum / count);
            }
        }
    }
    (out, size)
}

/// How the energy of a group's images spreads over their eigentextures.
struct Spectrum {
    /// Squared singular values, largest first.
    energies: Vec<f64>,
    /// Per column the numbers that mix an image's eigentextures.
    vectors: Array2<f32>,
    /// The sum of all squares.
    total: f64,
}

impl Spectrum {
    fn of(images: &Array2<f32>) -> Self {
        let gram = product_of(images.view(), images.t());
        let (energies, vectors) = eigen(gram.mapv(f64::from));
        Self {
            total: gram.diag().iter().map(|&v| f64::from(v)).sum(),
            energies: energies.into_iter().map(|energy| energy.max(0.0)).collect(),
            vectors: vectors.mapv(|v| v as f32),
        }
    }

    /// How many eigentextures are stronger than the rounding to a step.
    fn rank(&self, step: f64, columns: usize) -> usize {
        let noise = columns as f64 * step * step / 12.0;
        self.energies
            .iter()
            .take_while(|&&energy| energy > noise)
            .count()
    }

    /// The squared error that a step is expected to leave.
    fn left(&self, step: f64, columns: usize) -> f64 {
        let noise = columns as f64 * step * step / 12.0;
        self.energies.iter().map(|&energy| energy.min(noise)).sum()
    }
}

/// The largest step that is expected to leave at most `error`.
fn step_for(spectra: &[Spectrum], columns: usize, error: f64, total: f64) -> f64 {
    let wanted = error * error * total;
    let left = |step: f64| -> f64 { spectra.iter().map(|s| s.left(step, columns)).sum() };
    let (mut low, mut high) = (1e-9_f64, 1e9_f64);
    for _ in 0..80 {
        let middle = (low * high).sqrt();
        if left(middle) > wanted {
            high = middle;
        } else {
            low = middle;
        }
    }
    // No number of an eigentexture is larger than its singular value: all fit 16 bits.
    let strongest = spectra.iter().filter_map(|s| s.energies.first());
    let largest = strongest.fold(0.0_f64, |a, &b| a.max(b)).sqrt();
    low.max(largest / f64::from(i16::MAX))
        .max(f64::MIN_POSITIVE)
}

/// A group's factors, and the sum of squared differences that they leave.
fn quantize(images: &Array2<f32>, spectrum: &Spectrum, step: f64) -> (Group, f64) {
    let (count, columns) = images.dim();
    let rank = spectrum.rank(step, columns);
    let vectors: ArrayView2<'_, f32> = spectrum.vectors.slice(s![.., ..rank]);
    let exact = product_of(vectors.t(), images.view());
    let most = f32::from(i16::MAX);
    let whole = |value: f32| (f64::from(value) / step).round() as f32;
    let stored = exact.mapv(|value| whole(value).clamp(-most, most));
    let directions = vectors.mapv(|value| (value * DIRECTION_STEP).round().clamp(-most, most));
    let squares = squared_differences(images, &directions, &stored, step);
    let group = Group {
        images: count,
        rank,
        directions: directions.iter().map(|&value| value as i16).collect(),
        eigentextures: stored.iter().map(|&value| value as i16).collect(),
    };
    (group, squares)
}

fn squared_differences(
    images: &Array2<f32>,
    directions: &Array2<f32>,
    stored: &Array2<f32>,
    step: f64,
) -> f64 {
    let mut found = Array2::zeros(images.dim());
    let scale = step as f32 / DIRECTION_STEP;
    let directions = directions.mapv(|value| value * scale);
    multiply(
        directions.view(),
        stored.view(),
        found.view_mut(),
        Update::Replace,
    );
    let pairs = images.iter().zip(&found);
    pairs
        .map(|(&wanted, &found)| f64::from(wanted - found.max(0.0)).powi(2))
        .sum()
}

/// Group after group, directions and eigentextures.
fn packed(groups: &[Group]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    for group in groups {
        bytes.extend(
            group
                .directions
                .iter()
                .flat_map(|number| number.to_le_bytes()),
        );
        let folded: Vec<u16> = group
            .eigentextures
            .iter()
            .map(|&v| numbers::fold(v))
            .collect();
        numbers::append_planes(&mut bytes, &folded);
    }
    numbers::gzip(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::direction::Direction;
    use crate::btf::direction_set::DirectionSet as Named;
    use crate::btf::height_map::HeightMap;
    use crate::btf::sample::{DType, Layout};
    use crate::format::id::ContentId;

    /// Smooth images with a little structure, 4 views by 6 lights.
    struct Made(Description);

    fn directions(name: &str) -> Vec<Direction> {
        name.parse::<Named>().unwrap().directions().unwrap()
    }

    fn made() -> Made {
        Made(Description {
            format: "mesotex-btf".into(),
            version: 1,
            name: "made".into(),
            width: 9,
            height: 8,
            channels: 3,
            dtype: DType::F4,
            texel_mm: None,
            layout: Layout::Product,
            views: directions("fibonacci:4"),
            lights: directions("fibonacci:6"),
            pairs: None,
            tileable: true,
            id: ContentId::of_bytes(b"made"),
            source: serde_json::Value::Null,
        })
    }

    impl ImageSource for Made {
        fn description(&self) -> &Description {
            &self.0
        }

        fn heights(&self) -> Result<Option<HeightMap>> {
            Ok(None)
        }

        fn read_images(&self, images: Range<usize>, out: &mut [f32]) -> Result<()> {
            let length = out.len() / images.len();
            for (at, value) in out.iter_mut().enumerate() {
                let (image, number) = (images.start + at / length, at % length);
                let phase = 0.7 * image as f32 + 0.31 * number as f32;
                *value = 0.3 + 0.2 * phase.sin() + 0.05 * (3.1 * phase * phase).cos();
            }
            Ok(())
        }
    }

    fn factored(error: f64, bytes: usize, texels: u64) -> Result<ViewFactors> {
        let limits = Limits {
            error,
            bytes,
            texels,
        };
        view_factors(&made(), &limits, Progress::silent())
    }

    #[test]
    fn an_error_is_kept_and_less_of_it_takes_more_bytes() {
        let [fine, coarse] = [0.01, 0.1].map(|error| factored(error, 1 << 20, 1 << 20).unwrap());
        assert!(
            fine.error < 0.012 && coarse.error < 0.12,
            "{} {}",
            fine.error,
            coarse.error
        );
        assert!(fine.packed.len() > coarse.packed.len());
        assert_eq!((fine.groups.len(), fine.groups[0].images), (4, 6));
        assert_eq!(fine.directions.each_ref().map(Vec::len), [4, 6]);
    }

    #[test]
    fn too_few_bytes_cost_accuracy_and_then_are_refused() {
        let fine = factored(0.01, 1 << 20, 1 << 20).unwrap();
        let squeezed = factored(0.01, fine.packed.len() / 2, 1 << 20).unwrap();
        assert!(squeezed.error > fine.error && squeezed.packed.len() <= fine.packed.len() / 2);
        let error = factored(0.01, 10, 1 << 20).unwrap_err().to_string();
        assert!(error.contains("24 images of 9 × 8 texels"), "{error}");
    }

    #[test]
    fn grids_are_halved_until_they_fit() {
        let small = factored(0.01, 1 << 20, 24 * 20).unwrap();
        assert_eq!((small.size, small.halvings), ([5, 4], 1));
        let (pixels, size) = halved(&[1.0, 2.0, 3.0, 3.0, 4.0, 5.0, 9.0, 8.0, 7.0], [3, 1]);
        assert_eq!((pixels, size), (vec![2.0, 3.0, 4.0, 9.0, 8.0, 7.0], [2, 1]));
    }
}
