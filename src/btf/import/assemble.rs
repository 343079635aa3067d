//! An image list becomes a sample: directions are gathered, images decoded and written in order.
//!
//! Where every view stands with every light just once the layout is `product`, else `pairs`.

use std::path::Path;

use rayon::prelude::*;
use serde_json::json;

use crate::btf::direction::{Direction, SAME_DIRECTION};
use crate::btf::import::{ImageList, ImportOptions, MeasuredImage, Values};
use crate::btf::sample::{Description, FORMAT, Layout, VERSION};
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::image::{self, Notes, ReadImage, ReadOptions};
use crate::progress::Progress;

/// Images decoded at a time; bounds the memory.
const BATCH: usize = 32;

/// Writes the sample of an image list to `target`.
pub fn assemble(
    list: &ImageList,
    options: &ImportOptions,
    target: &Path,
    progress: Progress<'_>,
) -> Result<Description> {
    let arrangement = Arrangement::of(&list.images);
    let reading = options.reading();
    let first = read_image(&list.images[arrangement.order[0]], &reading)?;
    let size = (first.image.width, first.image.height);
    let description = describe(list, options, &arrangement, size);
    let mut writer = SampleWriter::create(target, description)?;
    progress.begin("importing images", list.images.len() as u64);
    let (mut notes, mut layer_taken) = (Notes::default(), false);
    for batch in arrangement.order.chunks(BATCH) {
        let images: Vec<(Vec<f32>, ReadImage)> = batch
            .par_iter()
            .map(|&index| {
                progress.check()?;
                radiance(&list.images[index], size, options, &reading)
            })
            .collect::<Result<_>>()?;
        for ((image, read), &index) in images.into_iter().zip(batch) {
            progress.check()?;
            writer.push(&image)?;
            notes.add(&list.images[index].path, read.notes);
            layer_taken |= read.layer_taken;
        }
        progress.advance(batch.len() as u64)?;
    }
    progress.end();
    notes.warn(&progress);
    reading.check_layer_taken(layer_taken)?;
    writer.finish()
}

fn describe(
    list: &ImageList,
    options: &ImportOptions,
    arrangement: &Arrangement,
    (width, height): (u32, u32),
) -> Description {
    Description {
        format: FORMAT.into(),
        version: VERSION,
        name: options.name.clone().unwrap_or_else(|| list.name.clone()),
        width,
        height,
        channels: 3,
        dtype: options.dtype,
        texel_mm: options.texel_mm,
        layout: if arrangement.pairs.is_some() {
            Layout::Pairs
        } else {
            Layout::Product
        },
        views: arrangement.views.clone(),
        lights: arrangement.lights.clone(),
        pairs: arrangement.pairs.clone(),
        tileable: options.tileable,
        id: ContentId::of_bytes(b""),
        source: json!({ "kind": list.kind, "handedness": list.handedness, "values": options.values,
            "encoding": options.encoding, "orientation": options.orientation, "layer": options.layer }),
    }
}

/// Which directions there are, and in which order the images are written.
struct Arrangement {
    views: Vec<Direction>,
    lights: Vec<Direction>,
    /// (view, light) of each written image; `None` for the full product.
    pairs: Option<Vec<[u32; 2]>>,
    /// The written images, by their place in the list.
    order: Vec<usize>,
}

impl Arrangement {
    fn of(images: &[MeasuredImage]) -> Self {
        let (mut views, mut lights) = (Vec::new(), Vec::new());
        let pairs: Vec<[u32; 2]> = images
            .iter()
            .map(|image| {
                [
                    place_of(image.view, &mut views),
                    place_of(image.light, &mut lights),
                ]
            })
            .collect();
        let mut order: Vec<usize> = (0..images.len()).collect();
        order.sort_by_key(|&index| pairs[index]);
        let sorted: Vec<[u32; 2]> = order.iter().map(|&index| pairs[index]).collect();
        let product = (0..views.len() as u32)
            .flat_map(|view| (0..lights.len() as u32).map(move |light| [view, light]));
        if product.eq(sorted.iter().copied()) {
            return Self {
                views,
                lights,
                pairs: None,
                order,
            };
        }
        Self {
            views,
            lights,
            pairs: Some(pairs),
            order: (0..images.len()).collect(),
        }
    }
}

/// The place of a direction among those seen so far; a new one is added.
fn place_of(direction: Direction, seen: &mut Vec<Direction>) -> u32 {
    let known = seen
        .iter()
        .position(|&other| other.angle_to(direction) <= SAME_DIRECTION);
    known.unwrap_or_else(|| {
        seen.push(direction);
        seen.len() - 1
    }) as u32
}

fn read_image(image: &MeasuredImage, reading: &ReadOptions) -> Result<ReadImage> {
    let mut read = image::read_with(&image.path, reading)?;
    read.image = read.image.into_linear().into_rgb();
    Ok(read)
}

/// An image's radiance for unit irradiance, row-major (height, width, RGB), and what its reader said.
fn radiance(
    image: &MeasuredImage,
    size: (u32, u32),
    options: &ImportOptions,
    reading: &ReadOptions,
) -> Result<(Vec<f32>, ReadImage)> {
    let mut read = read_image(image, reading)?;
    let pixels = &mut read.image;
    if (pixels.width, pixels.height) != size {
        return Err(
            Error::data("size", format!("{} × {}", pixels.width, pixels.height))
                .expected(format!("{} × {}, as the first image", size.0, size.1))
                .advice("the images of a sample are rectified to one texel grid")
                .in_file(&image.path),
        );
    }
    let usable = |value: f32| value >= 0.0 && value.is_finite();
    if let Some(at) = pixels.data.iter().position(|&value| !usable(value)) {
        let (row, col) = (at / 3 / size.0 as usize, at / 3 % size.0 as usize);
        return Err(Error::data(
            format!("row {row}, column {col}"),
            pixels.data[at].to_string(),
        )
        .expected("a finite number, not negative")
        .in_file(&image.path));
    }
    let scale = match options.values {
        Values::Reflectance => std::f32::consts::FRAC_1_PI,
        Values::Radiance => 1.0,
    };
    let mut numbers = std::mem::take(&mut pixels.data);
    numbers.iter_mut().for_each(|value| *value *= scale);
    Ok((numbers, read))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::import::Handedness;
    use crate::btf::sample::Sample;

    fn measured(folder: &Path, name: &str, grey: u8, view: f64, light: f64) -> MeasuredImage {
        let path = folder.join(name);
        image::write_png(&path, 2, 2, &[grey; 12]).unwrap();
        MeasuredImage {
            path,
            view: Direction::from_angles(view, 0.0),
            light: Direction::from_angles(light, 1.0),
        }
    }

    fn import(folder: &Path, images: Vec<MeasuredImage>) -> Sample {
        let list = ImageList {
            name: "set".into(),
            path: "list.csv".into(),
            kind: "test",
            handedness: Handedness::Right,
            images,
            notes: Vec::new(),
        };
        let target = folder.join("x.sample");
        let options = ImportOptions {
            dtype: crate::btf::sample::DType::F4,
            ..Default::default()
        };
        assemble(&list, &options, &target, Progress::silent()).unwrap();
        Sample::open(&target).unwrap()
    }

    #[test]
    fn a_full_product_is_sorted_into_one() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str, grey, view, light| measured(folder.path(), name, grey, view, light);
        let images = vec![
            at("a.png", 255, 0.0, 0.2),
            at("b.png", 0, 0.5, 0.4),
            at("c.png", 128, 0.5, 0.2),
            at("d.png", 64, 0.0, 0.4),
        ];
        let sample = import(folder.path(), images);
        assert_eq!(sample.description().layout, Layout::Product);
        let greys: Vec<f32> = (0..4)
            .map(|image| sample.image(image).unwrap().get(0))
            .collect();
        let expected = [255u8, 64, 128, 0]
            .map(|grey| image::decode_srgb(f32::from(grey) / 255.0) * std::f32::consts::FRAC_1_PI);
        for (grey, expected) in greys.iter().zip(expected) {
            assert!((grey - expected).abs() < 1e-7);
        }
    }

    #[test]
    fn scattered_images_keep_their_order() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str, view, light| measured(folder.path(), name, 9, view, light);
        let images = vec![at("a.png", 0.3, 0.2), at("b.png", 0.0, 0.4)];
        let sample = import(folder.path(), images);
        assert_eq!(sample.description().pairs, Some(vec![[0, 0], [1, 1]]));
    }

    #[test]
    fn images_of_another_size_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let mut images = vec![measured(folder.path(), "a.png", 1, 0.0, 0.0)];
        images.push(measured(folder.path(), "b.png", 1, 0.0, 0.5));
        image::write_png(&images[1].path, 1, 2, &[1; 6]).unwrap();
        let list = ImageList {
            name: "set".into(),
            path: "list.csv".into(),
            kind: "test",
            handedness: Handedness::Right,
            images,
            notes: Vec::new(),
        };
        let target = folder.path().join("x.sample");
        let error = assemble(
            &list,
            &ImportOptions::default(),
            &target,
            Progress::silent(),
        );
        let text = error.unwrap_err().to_string();
        assert!(text.contains("b.png") && text.contains("1 × 2"), "{text}");
        assert!(!target.exists());
    }
}
