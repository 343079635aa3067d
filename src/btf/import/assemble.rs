//! An image list becomes a sample: images are decoded side by side and written in order.
//!
//! As many images are in memory as threads can use, and no more than a bound allows. When an image cannot be used,
//! the others are read all the same, so that every fault is reported together; the sample appears when all images are
//! written.

use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::btf::import::arrangement::{Arrangement, Slot};
use crate::btf::import::fill::Blend;
use crate::btf::import::image_list::{ImageList, MeasuredImage};
use crate::btf::import::image_reader::ImageReader;
use crate::btf::import::near_field::NearPositions;
use crate::btf::import::options::{ImportOptions, Values};
use crate::btf::import::prepare::Steps;
use crate::btf::import::reading_faults::ReadingFaults;
use crate::btf::import::stations::{NearField, Patch, Resampler, Station};
use crate::btf::sample::{Description, FORMAT, Layout, VERSION};
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::atomic::parent;
use crate::format::id::ContentId;
use crate::format::image::{FloatImage, Note, Notes};
use crate::progress::Progress;

/// Images decoded at a time, at most.
const BATCH: usize = 32;
/// Bytes of decoded images held at a time, beyond one image per thread.
const BATCH_BYTES: usize = 128 << 20;

/// Writes the sample of an image list to `target`.
pub fn assemble(
    list: &ImageList,
    options: &ImportOptions,
    target: &Path,
    progress: Progress<'_>,
) -> Result<Description> {
    // Check the options against each other and against the list.
    let preparation = &options.preparation;
    preparation.check()?;
    check_grey_card(list, options)?;
    check_resampling(list, options)?;
    // Arrange the images by direction.
    let arrangement = Arrangement::of(list, preparation)?;
    arrangement
        .notes
        .iter()
        .for_each(|note| progress.warn(note.as_str()));
    // Prepare the steps that every image goes through.
    let reader = ImageReader::new(list, options);
    let used = arrangement.read_images();
    let rectification = options.photographs.rectification()?;
    if let Some(rectification) = &rectification {
        let path = |&image: &usize| list.images[image].path.as_path();
        rectification.check(&used.iter().map(path).collect::<Vec<_>>())?;
    }
    let steps = Steps::new(preparation, rectification.as_ref(), used.len(), |place| {
        progress.check()?;
        Ok(reader.read(&list.images[used[place]])?.0)
    })?;
    let work = Work {
        list,
        options,
        arrangement: &arrangement,
        reader: &reader,
        steps: &steps,
    };
    // Read, process and write image after image.
    progress.begin("importing images", arrangement.slots.len() as u64);
    let (writer, notes) = work.write(target, progress)?;
    progress.end();
    notes.warn(progress);
    reader.check_options_used()?;
    writer.finish()
}

/// A grey card sets what the numbers mean.
fn check_grey_card(list: &ImageList, options: &ImportOptions) -> Result<()> {
    let is_reflectance = options.values.of_family(list.family) == Values::Reflectance;
    match &options.preparation.grey_card {
        Some(card) if !is_reflectance => Err(Error::option(
            "grey-card",
            format!("{card} with other values than reflectance"),
            "--values reflectance, which a grey card scales to",
        )),
        _ => Ok(()),
    }
}

/// Images of near cameras and lamps are resampled over the whole patch, each at its own place.
fn check_resampling(list: &ImageList, options: &ImportOptions) -> Result<()> {
    let preparation = &options.preparation;
    let other = [
        ("crop", preparation.crop.is_some()),
        ("fill", preparation.fill),
    ];
    match other.iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) if list.positions.is_some() => Err(Error::option(
            *option,
            "given with --near-field",
            "either of them: the patch is resampled as a whole, from images that were taken",
        )),
        _ => Ok(()),
    }
}

/// All that is needed to make the images of a sample.
struct Work<'a> {
    list: &'a ImageList,
    options: &'a ImportOptions,
    arrangement: &'a Arrangement,
    reader: &'a ImageReader<'a>,
    steps: &'a Steps<'a>,
}

/// Where images go: into the sample, or first to where they are resampled.
#[derive(Default)]
struct Output {
    writer: Option<SampleWriter>,
    resampler: Option<Resampler>,
}

impl Output {
    /// Adds the next image.
    fn push(&mut self, image: &[f32]) -> Result<()> {
        match (&mut self.resampler, &mut self.writer) {
            (Some(resampler), _) => resampler.push(image),
            (None, Some(writer)) => writer.push(image),
            (None, None) => Ok(()),
        }
    }

    /// The writer of the sample, when all images are in it; `None` where there were none.
    fn finish(mut self, progress: Progress<'_>) -> Result<Option<SampleWriter>> {
        if let (Some(resampler), Some(writer)) = (self.resampler.take(), &mut self.writer) {
            resampler.finish(progress, |image| writer.push(image))?;
        }
        Ok(self.writer)
    }
}

/// An image of the sample.
struct Made {
    image: FloatImage,
    /// Width and height of its file.
    size: (u32, u32),
    notes: Vec<Note>,
}

/// How far the sample is.
struct Writing<'a> {
    target: &'a Path,
    /// Begun with the first image, whose size is the sample's.
    output: Output,
    notes: Notes,
    faults: ReadingFaults,
    /// Whether every image so far could be used.
    is_sound: bool,
    /// Images to decode at a time.
    batch: usize,
}

impl Work<'_> {
    /// Writes all images; refuses the set after the last one, where any could not be used.
    fn write(&self, target: &Path, progress: Progress<'_>) -> Result<(SampleWriter, Notes)> {
        let mut writing = Writing {
            target,
            output: Output::default(),
            notes: Notes::default(),
            faults: ReadingFaults::default(),
            is_sound: true,
            batch: rayon::current_num_threads().min(BATCH),
        };
        let (mut next, all) = (0, self.arrangement.slots.len());
        while next < all {
            let places = next..(next + writing.batch).min(all);
            next = places.end;
            let count = places.len() as u64;
            let made: Vec<(usize, Result<Made>)> = places
                .into_par_iter()
                .map(|place| (place, progress.check().and_then(|()| self.made(place))))
                .collect();
            for (place, made) in made {
                self.take(place, made, &mut writing)?;
            }
            progress.advance(count)?;
        }
        writing.faults.into_result(&self.list.path)?;
        let none = || Error::data("images", "none").in_file(&self.list.path);
        let writer = writing.output.finish(progress)?.ok_or_else(none)?;
        Ok((writer, writing.notes))
    }

    /// Appends an image to the sample, or keeps what is wrong with it.
    fn take(&self, place: usize, made: Result<Made>, writing: &mut Writing<'_>) -> Result<()> {
        let made = match made {
            Ok(made) => made,
            Err(error) => {
                writing.is_sound = false;
                return writing.faults.add(error);
            }
        };
        if let Slot::Read(image) = self.arrangement.slots[place] {
            let path = &self.list.images[image].path;
            // Photographs may be of any size: what counts is the patch.
            writing.is_sound &= self.options.photographs.corners.is_some()
                || writing.faults.add_size(path, made.size);
            writing.notes.add(path, made.notes);
        }
        if !writing.is_sound {
            return Ok(());
        }
        if writing.output.writer.is_none() {
            writing.output = self.begun(writing.target, &made.image)?;
            writing.batch = batch(made.size);
        }
        writing.output.push(&made.image.data)
    }

    /// The output of images like this one.
    fn begun(&self, target: &Path, image: &FloatImage) -> Result<Output> {
        let size = (image.width, image.height);
        let resampler =
            |positions| Resampler::new(self.near_field(positions, size), parent(target));
        Ok(Output {
            writer: Some(SampleWriter::create(target, self.description(size))?),
            resampler: self.list.positions.as_ref().map(resampler).transpose()?,
        })
    }

    /// Where the cameras and lamps of the sample's images stood, in their order.
    fn near_field(&self, positions: &NearPositions, (width, height): (u32, u32)) -> NearField {
        let at = |all: &Option<Vec<DVec3>>, image: usize| all.as_ref().map(|all| all[image]);
        let station = |slot: &Slot| match slot {
            Slot::Read(image) => Some(Station {
                view: self.list.images[*image].view,
                light: self.list.images[*image].light,
                view_at: at(&positions.cameras, *image),
                light_at: at(&positions.lamps, *image),
            }),
            Slot::Fill(_) => None,
        };
        NearField {
            stations: self.arrangement.slots.iter().filter_map(station).collect(),
            patch: Patch {
                width,
                height,
                sides_mm: [positions.patch.width, positions.patch.height],
            },
        }
    }

    /// The image at a place of the sample, in radiance.
    fn made(&self, place: usize) -> Result<Made> {
        match &self.arrangement.slots[place] {
            Slot::Read(image) => self.radiance(&self.list.images[*image]),
            Slot::Fill(blend) => self.blended(blend),
        }
    }

    /// A missing image, from those of other directions.
    fn blended(&self, Blend(shares): &Blend) -> Result<Made> {
        let mut sum: Option<Made> = None;
        for &(image, share) in shares {
            let mut part = self.radiance(&self.list.images[image])?;
            part.image.data.iter_mut().for_each(|v| *v *= share);
            let Some(sum) = &mut sum else {
                sum = Some(part);
                continue;
            };
            // Of another size: the fault is told where the image itself is read.
            let pairs = sum.image.data.iter_mut().zip(&part.image.data);
            pairs.for_each(|(sum, v)| *sum += v);
        }
        sum.ok_or_else(|| {
            Error::data("fill", "no image to interpolate from").in_file(&self.list.path)
        })
    }

    /// An image's radiance for unit irradiance.
    fn radiance(&self, measured: &MeasuredImage) -> Result<Made> {
        let (image, notes) = self.reader.read(measured)?;
        check_values(&image).map_err(|error| error.in_file(&measured.path))?;
        let size = (image.width, image.height);
        let prepared = self.steps.apply(image, measured);
        let mut image = prepared.map_err(|error| error.in_file(&measured.path))?;
        let (values, family) = (self.options.values, self.list.family);
        let scale = values.radiance_per_number(family, measured.light);
        image.data.iter_mut().for_each(|value| *value *= scale);
        Ok(Made { image, size, notes })
    }

    fn description(&self, (width, height): (u32, u32)) -> Description {
        let (options, arrangement) = (self.options, self.arrangement);
        let pixels = f64::from(options.preparation.pixels_per_texel());
        Description {
            format: FORMAT.into(),
            version: VERSION,
            name: options
                .name
                .clone()
                .unwrap_or_else(|| self.list.name.clone()),
            width,
            height,
            channels: 3,
            dtype: options.dtype,
            texel_mm: options.texel_mm.map(|mm| mm * pixels),
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
            source: self.source(),
        }
    }

    /// Where the sample comes from: what is said of every import, then what is said where it was used.
    fn source(&self) -> Value {
        // Collect what is said of every import.
        let (list, options, preparation) = (self.list, self.options, &self.options.preparation);
        let mut source = json!({ "kind": list.kind, "handedness": list.handedness,
            "values": options.values.of_family(list.family), "encoding": options.encoding,
            "orientation": options.orientation, "layer": options.layer });
        // Add what was used of the rest.
        let given = [
            ("illuminant", json!(options.illuminant)),
            ("crop", json!(preparation.crop)),
            ("reduce", json!(preparation.reduce)),
            ("keep_views", json!(preparation.keep_views)),
            ("keep_lights", json!(preparation.keep_lights)),
            ("grey_card", json!(preparation.grey_card)),
            (
                "rectified",
                json!(options.photographs.corners.as_ref().map(|_| "corners")),
            ),
            (
                "resampled",
                json!(list.positions.as_ref().map(|_| "near field")),
            ),
            (
                "hot_pixels",
                json!(preparation.hot_pixels.map(|_| self.steps.hot_pixels())),
            ),
            ("filled", filled(&self.arrangement.filled)),
        ];
        if let Some(fields) = source.as_object_mut() {
            let used = given.into_iter().filter(|(_, value)| !value.is_null());
            fields.extend(used.map(|(name, value)| (name.to_owned(), value)));
            fields.extend(list.facts.clone());
        }
        source
    }
}

/// Images to decode at a time: a few per thread, as many as the bound allows, but one per thread in any case.
fn batch((width, height): (u32, u32)) -> usize {
    let bytes = width as usize * height as usize * 3 * size_of::<f32>();
    let threads = rayon::current_num_threads();
    (BATCH_BYTES / bytes.max(1)).clamp(threads, BATCH.max(threads))
}

/// The interpolated images as [view, light] numbers; null where there are none.
fn filled(pairs: &[[u32; 2]]) -> Value {
    match pairs {
        [] => Value::Null,
        pairs => json!(pairs),
    }
}

/// Refuses what no light can be.
fn check_values(image: &FloatImage) -> Result<()> {
    let usable = |value: f32| value >= 0.0 && value.is_finite();
    let Some(at) = image.data.iter().position(|&value| !usable(value)) else {
        return Ok(());
    };
    let (row, col) = (at / 3 / image.width as usize, at / 3 % image.width as usize);
    Err(Error::data(
        format!("row {row}, column {col}"),
        image.data[at].to_string(),
    )
    .expected("a finite number, not negative"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::direction::Direction;
    use crate::btf::import::family::Family;
    use crate::btf::import::list_options::Handedness;
    use crate::btf::import::place::Place;
    use crate::btf::sample::Sample;
    use crate::format::image;

    fn measured(folder: &Path, name: &str, grey: u8, view: f64, light: f64) -> MeasuredImage {
        let path = folder.join(name);
        image::write_png(&path, 2, 2, &[grey; 12]).unwrap();
        MeasuredImage {
            path,
            view: Direction::from_angles(view, 0.0),
            light: Direction::from_angles(light, 1.0),
        }
    }

    fn list_of(images: Vec<MeasuredImage>) -> ImageList {
        ImageList {
            name: "set".into(),
            path: "list.csv".into(),
            kind: "test",
            family: Family::Any,
            handedness: Handedness::Right,
            images,
            place: Place::Files,
            is_set: false,
            positions: None,
            notes: Vec::new(),
            facts: serde_json::Map::new(),
        }
    }

    fn import(folder: &Path, images: Vec<MeasuredImage>) -> Sample {
        let list = list_of(images);
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
        let target = folder.path().join("x.sample");
        let error = assemble(
            &list_of(images),
            &ImportOptions::default(),
            &target,
            Progress::silent(),
        );
        let text = error.unwrap_err().to_string();
        assert!(text.contains("b.png") && text.contains("1 × 2"), "{text}");
        assert!(!target.exists());
    }
}
