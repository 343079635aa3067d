//! An array of numpy, `.npy`, with directions that the user states.
//!
//! Shape `[V, L, 3]`, one texel, or `[V, L, H, W, 3]`, row 0 at the top; half, single or double floats. Floats are
//! linear unless `--encoding srgb` says otherwise.

use std::ops::Range;
use std::path::Path;

use half::f16;
use serde_json::json;

use crate::btf::direction::Direction;
use crate::btf::import::curve::curve;
use crate::btf::import::destination::{Destination, InputIds};
use crate::btf::import::family::Family;
use crate::btf::import::options::ImportOptions;
use crate::btf::import::prepare::inspected;
use crate::btf::parts::{WrittenSample, write_sample_or_part};
use crate::btf::sample::{Description, FORMAT, Layout, VERSION};
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::npy::{self, ArrayFile, Header};
use crate::progress::Progress;

/// The numbers of an array file.
enum Numbers {
    F2(ArrayFile<f16>),
    F4(ArrayFile<f32>),
    F8(ArrayFile<f64>),
}

impl Numbers {
    fn open(path: &Path, header: &Header) -> Result<Self> {
        match header.dtype.as_str() {
            "<f2" => Ok(Self::F2(ArrayFile::open(path)?)),
            "<f4" => Ok(Self::F4(ArrayFile::open(path)?)),
            "<f8" => Ok(Self::F8(ArrayFile::open(path)?)),
            other => Err(Error::data("dtype", format!("`{other}`"))
                .expected("`<f2`, `<f4` or `<f8`")
                .advice("convert it in numpy: a.astype(\"<f4\")")
                .in_file(path)),
        }
    }

    /// Fills `out` from number `first` on.
    fn read(&self, first: usize, out: &mut [f32]) -> Result<()> {
        match self {
            Self::F2(file) => {
                let mut numbers = vec![f16::ZERO; out.len()];
                file.read(first, &mut numbers)?;
                out.iter_mut()
                    .zip(numbers)
                    .for_each(|(out, number)| *out = number.to_f32());
            }
            Self::F4(file) => file.read(first, out)?,
            Self::F8(file) => {
                let mut numbers = vec![0.0; out.len()];
                file.read(first, &mut numbers)?;
                out.iter_mut()
                    .zip(numbers)
                    .for_each(|(out, number)| *out = number as f32);
            }
        }
        Ok(())
    }
}

/// Writes the sample of an array, or the part of a shard; the array's views and lights are these.
pub fn import<'a>(
    path: &Path,
    (views, lights): (&[Direction], &[Direction]),
    options: &ImportOptions,
    destination: impl Into<Destination<'a>>,
    progress: Progress<'_>,
) -> Result<WrittenSample> {
    // Open the array.
    let header = npy::read_header(path)?;
    let sides =
        sides(&header.shape, views.len(), lights.len()).map_err(|error| error.in_file(path))?;
    let numbers = Numbers::open(path, &header)?;
    let linear = curve(options.encoding, |number| number)?;
    // Take the images of the shard.
    let destination = destination.into();
    let description = describe(path, sides, (views, lights), options);
    let (count, length) = (description.image_count(), 3 * description.grid().len());
    let part = destination.part(count, options, |own| {
        progress.begin("comparing numbers", own.len() as u64);
        let source = ids(&numbers, length, &header, inspected(count), progress)?;
        let own = ids(&numbers, length, &header, own, progress)?;
        progress.end();
        Ok(InputIds {
            source,
            own: Some(own),
        })
    })?;
    // Convert image after image.
    let convert = |writer: &mut SampleWriter, images: Range<usize>| {
        progress.begin("importing images", images.len() as u64);
        let mut image = vec![0.0; length];
        for at in images {
            numbers.read(at * length, &mut image)?;
            let light = lights[at % lights.len()];
            let scale = options.values.radiance_per_number(Family::Any, light);
            image
                .iter_mut()
                .for_each(|value| *value = scale * linear(*value));
            writer.push(&image).map_err(|error| error.in_file(path))?;
            progress.advance(1)?;
        }
        progress.end();
        Ok(())
    };
    write_sample_or_part(destination.path, description, part.as_ref(), None, convert)
}

/// The id of the shape of an array and of some of its images.
fn ids(
    numbers: &Numbers,
    length: usize,
    header: &Header,
    images: impl Iterator<Item = usize>,
    progress: Progress<'_>,
) -> Result<ContentId> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(format!("{} {:?}", header.dtype, header.shape).as_bytes());
    let mut image = vec![0.0_f32; length];
    for at in images {
        numbers.read(at * length, &mut image)?;
        hasher.update(bytemuck::cast_slice(&image));
        progress.check()?;
    }
    Ok(ContentId::of_hash(&hasher.finalize()))
}

/// Columns and rows of the images; refuses shapes that do not fit the directions.
fn sides(shape: &[usize], views: usize, lights: usize) -> Result<(u32, u32)> {
    let (found, height, width) = match *shape {
        [v, l, 3] => ((v, l), 1, 1),
        [v, l, h, w, 3] => ((v, l), h, w),
        _ => ((0, 0), 0, 0),
    };
    let fault = |expected: String| Error::data("shape", format!("{shape:?}")).expected(expected);
    if found == (0, 0) {
        return Err(fault(
            "[views, lights, 3] or [views, lights, rows, columns, 3]".into(),
        ));
    }
    if found != (views, lights) {
        return Err(fault(format!(
            "{views} views (--views) and {lights} lights (--lights)"
        )));
    }
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(width), Ok(height)) => Ok((width, height)),
        _ => Err(fault("fewer than 2^32 rows and columns".into())),
    }
}

fn describe(
    path: &Path,
    (width, height): (u32, u32),
    (views, lights): (&[Direction], &[Direction]),
    options: &ImportOptions,
) -> Description {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    Description {
        format: FORMAT.into(),
        version: VERSION,
        name: options.name.clone().unwrap_or_else(|| stem.into_owned()),
        width,
        height,
        channels: 3,
        dtype: options.dtype,
        texel_mm: options.texel_mm,
        layout: Layout::Product,
        views: views.to_vec(),
        lights: lights.to_vec(),
        pairs: None,
        tileable: options.tileable,
        id: ContentId::of_bytes(b""),
        source: json!({ "kind": "array", "values": options.values.of_family(Family::Any), "encoding": options.encoding }),
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array3, Array5};

    use super::*;
    use crate::btf::direction_set::DirectionSet;
    use crate::btf::import::options::Values;
    use crate::btf::sample::{DType, Sample};

    fn directions(count: usize) -> Vec<Direction> {
        DirectionSet::Fibonacci(count).directions().unwrap()
    }

    #[test]
    fn arrays_of_either_shape_become_samples() {
        let folder = tempfile::tempdir().unwrap();
        let (path, target) = (folder.path().join("a.npy"), folder.path().join("a.sample"));
        let options = ImportOptions {
            values: Values::Radiance,
            dtype: DType::F4,
            ..ImportOptions::default()
        };
        let (views, lights) = (directions(2), directions(3));
        let import = || {
            let directions = (&views[..], &lights[..]);
            let written = import(
                &path,
                directions,
                &options,
                target.as_path(),
                Progress::silent(),
            );
            written.map(|written| written.description)
        };
        let flat = Array3::from_shape_fn((2, 3, 3), |(v, l, c)| (9 * v + 3 * l + c) as f64);
        npy::write(&path, flat.view().into_dyn()).unwrap();
        assert_eq!(
            (import().unwrap().width, import().unwrap().name.as_str()),
            (1, "a")
        );
        assert_eq!(
            Sample::open(&target).unwrap().image(4).unwrap().get(1),
            13.0
        );
        let whole = Array5::from_shape_fn((2, 3, 4, 5, 3), |(v, l, h, w, c)| {
            f16::from_f32((v + l) as f32 + 0.25 * (h * 5 + w) as f32 + c as f32)
        });
        npy::write(&path, whole.view().into_dyn()).unwrap();
        assert_eq!((import().unwrap().width, import().unwrap().height), (5, 4));
        let texel = (2 * 5 + 3) * 3;
        assert_eq!(
            Sample::open(&target).unwrap().image(5).unwrap().get(texel),
            3.0 + 3.25
        );
    }

    #[test]
    fn shapes_and_numbers_that_do_not_fit_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (path, target) = (folder.path().join("a.npy"), folder.path().join("a.sample"));
        let refused = |array: ndarray::ArrayViewD<'_, f32>| {
            npy::write(&path, array).unwrap();
            let directions = (&directions(2)[..], &directions(3)[..]);
            let options = ImportOptions::default();
            let error = import(
                &path,
                directions,
                &options,
                target.as_path(),
                Progress::silent(),
            );
            error.unwrap_err().to_string()
        };
        let of_shape = |shape| Array3::<f32>::zeros(shape);
        let swapped = refused(of_shape((3, 2, 3)).view().into_dyn());
        assert!(
            swapped.contains("a.npy") && swapped.contains("2 views (--views)"),
            "{swapped}"
        );
        assert!(refused(of_shape((2, 3, 4)).view().into_dyn()).contains("[views, lights, 3]"));
        let mut bad = of_shape((2, 3, 3));
        bad[[1, 2, 0]] = f32::NAN;
        let refused = refused(bad.view().into_dyn());
        assert!(
            refused.contains("view 1, light 2") && refused.contains("NaN"),
            "{refused}"
        );
        assert!(!target.exists());
    }
}
