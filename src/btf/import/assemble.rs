//! An image list becomes a sample, or the part of a shard: images are decoded side by side and written in order.
//!
//! As many images are in memory as threads can use, and no more than a bound allows. When an image cannot be used,
//! the others are read all the same, so that every fault is reported together; the sample appears when all images are
//! written.

use std::path::Path;

use rayon::prelude::*;

use crate::btf::import::arrangement::{Arrangement, Slot};
use crate::btf::import::destination::Destination;
use crate::btf::import::fill::Blend;
use crate::btf::import::image_list::{ImageList, MeasuredImage};
use crate::btf::import::image_reader::ImageReader;
use crate::btf::import::options::{ImportOptions, Values};
use crate::btf::import::prepare::{Preparation, Steps};
use crate::btf::import::reading_faults::ReadingFaults;
use crate::btf::import::shard_images::ShardImages;
use crate::btf::import::stations::{NearField, Patch, Resampler};
use crate::btf::import::subject::Subject;
use crate::btf::parts::{self, WrittenSample};
use crate::btf::sample::Description;
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::atomic::parent;
use crate::format::image::{FloatImage, Note, Notes};
use crate::progress::Progress;

/// Images decoded at a time, at most.
const BATCH: usize = 32;
/// Bytes of decoded images held at a time, beyond one image per thread.
const BATCH_BYTES: usize = 128 << 20;

/// Writes the sample of an image list, or the part of a shard: the same images as those of one run. A part that is
/// there already is kept, and one that was interrupted is continued.
pub fn assemble<'a>(
    list: &ImageList,
    options: &ImportOptions,
    destination: impl Into<Destination<'a>>,
    progress: Progress<'_>,
) -> Result<WrittenSample> {
    // Check the options against each other and against the list.
    let (destination, preparation) = (destination.into(), &options.preparation);
    preparation.check()?;
    check_grey_card(list, options)?;
    check_resampling(list, options)?;
    // Arrange the images by direction, and take those of the shard.
    let arrangement = Arrangement::of(list, preparation)?;
    let subject = Subject {
        list,
        options,
        arrangement: &arrangement,
    };
    arrangement
        .notes
        .iter()
        .for_each(|note| progress.warn(note.as_str()));
    let rectification = options.photographs.rectification()?;
    let used = arrangement.read_images();
    if let Some(rectification) = &rectification {
        let path = |&image: &usize| list.images[image].path.as_path();
        rectification.check(&used.iter().map(path).collect::<Vec<_>>())?;
    }
    let shard = ShardImages::of(&subject, destination, progress)?;
    if let Some(found) = shard.find(&subject, destination) {
        return Ok(WrittenSample::kept(found));
    }
    // Prepare the steps that every image goes through.
    let reader = ImageReader::new(list, options);
    let steps = Steps::new(preparation, rectification.as_ref(), used.len(), |place| {
        progress.check()?;
        Ok(reader.read(&list.images[used[place]])?.0)
    })?;
    let work = Work {
        subject,
        shard: &shard,
        reader: &reader,
        steps: &steps,
    };
    // Read, process and write image after image.
    let mut writing = Writing::to(destination.path);
    let written = work.write(&mut writing, progress);
    let written = written.and_then(|()| work.check_options_used(progress));
    writing.finish(written, &list.path)
}

/// The description of a list's sample as far as one image tells it, and the pixels of that image's file.
pub(crate) fn foresee(list: &ImageList, options: &ImportOptions) -> Result<(Description, u64)> {
    let preparation = Preparation {
        hot_pixels: None,
        ..options.preparation.clone()
    };
    let arrangement = Arrangement::of(list, &preparation)?;
    let rectification = options.photographs.rectification()?;
    let first = |image: &usize| &list.images[*image];
    let none = || Error::data("images", "none").in_file(&list.path);
    let used = arrangement.read_images();
    let measured = used.first().map(first).ok_or_else(none)?;
    let (image, _) = ImageReader::new(list, options).read(measured)?;
    let pixels = u64::from(image.width) * u64::from(image.height);
    let steps = Steps::new(&preparation, rectification.as_ref(), used.len(), |_| {
        Err(none())
    })?;
    let image = steps.apply(image, measured)?;
    let subject = Subject {
        list,
        options,
        arrangement: &arrangement,
    };
    Ok((subject.describe((image.width, image.height), None), pixels))
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
    subject: Subject<'a>,
    shard: &'a ShardImages,
    reader: &'a ImageReader<'a>,
    steps: &'a Steps<'a>,
}

/// Where images go: into the sample, or first to where they are resampled.
struct Output {
    writer: SampleWriter,
    /// Images of an interrupted run that the sample has already.
    resumed: usize,
    resampler: Option<Resampler>,
}

impl Output {
    /// Prepared images that need not be made again; where images are resampled, all of them are needed.
    fn unneeded(&self) -> usize {
        match self.resampler {
            Some(_) => 0,
            None => self.resumed,
        }
    }

    /// Adds the next image.
    fn push(&mut self, image: &[f32]) -> Result<()> {
        match &mut self.resampler {
            Some(resampler) => resampler.push(image),
            None => self.writer.push(image),
        }
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
    output: Option<Output>,
    notes: Notes,
    faults: ReadingFaults,
    /// Whether every image so far could be used.
    is_sound: bool,
    /// Images to decode at a time.
    batch: usize,
}

impl<'a> Writing<'a> {
    fn to(target: &'a Path) -> Self {
        Self {
            target,
            output: None,
            notes: Notes::default(),
            faults: ReadingFaults::default(),
            is_sound: true,
            batch: rayon::current_num_threads().min(BATCH),
        }
    }

    /// Finishes the sample, where all went well.
    fn finish(self, written: Result<()>, source: &Path) -> Result<WrittenSample> {
        match (self.output, written) {
            (Some(output), written) => parts::finish(output.writer, written, output.resumed),
            (None, Err(error)) => Err(error),
            (None, Ok(())) => Err(Error::data("images", "none").in_file(source)),
        }
    }
}

impl Work<'_> {
    /// Writes all images; refuses the set after the last one, where any could not be used.
    fn write(&self, writing: &mut Writing<'_>, progress: Progress<'_>) -> Result<()> {
        let places = &self.shard.prepared;
        progress.begin("importing images", places.len() as u64);
        let mut next = 0;
        while next < places.len() {
            let batch = next..(next + writing.batch).min(places.len());
            let made: Vec<(usize, Result<Made>)> = batch
                .clone()
                .into_par_iter()
                .map(|at| {
                    let made = progress.check().and_then(|()| self.made(places[at]));
                    (at, made)
                })
                .collect();
            for (at, made) in made {
                self.take(at, made, writing)?;
            }
            let unneeded = writing.output.as_ref().map_or(0, Output::unneeded);
            let end = batch.end.max(unneeded);
            progress.advance((end - next) as u64)?;
            next = end;
        }
        progress.end();
        std::mem::take(&mut writing.faults).into_result(&self.subject.list.path)?;
        writing.notes.warn(progress);
        self.resample(writing, progress)
    }

    /// Makes the images of near cameras and lamps from those that were gathered.
    fn resample(&self, writing: &mut Writing<'_>, progress: Progress<'_>) -> Result<()> {
        let Some(output) = &mut writing.output else {
            return Ok(());
        };
        let Some(resampler) = output.resampler.take() else {
            return Ok(());
        };
        let images = &self.shard.images;
        let left = images.start + output.resumed..images.end;
        resampler.finish(left, progress, |image| output.writer.push(image))
    }

    /// Appends a prepared image to the sample, or keeps what is wrong with it.
    fn take(&self, at: usize, made: Result<Made>, writing: &mut Writing<'_>) -> Result<()> {
        let made = match made {
            Ok(made) => made,
            Err(error) => {
                writing.is_sound = false;
                return writing.faults.add(error);
            }
        };
        let Subject {
            list,
            options,
            arrangement,
        } = self.subject;
        if let Slot::Read(image) = arrangement.slots[self.shard.prepared[at]] {
            let path = &list.images[image].path;
            // Photographs may be of any size: what counts is the patch.
            writing.is_sound &=
                options.photographs.corners.is_some() || writing.faults.add_size(path, made.size);
            writing.notes.add(path, made.notes);
        }
        if !writing.is_sound {
            return Ok(());
        }
        let output = match &mut writing.output {
            Some(output) => output,
            None => {
                writing.batch = batch(made.size);
                writing
                    .output
                    .insert(self.begun(writing.target, &made.image)?)
            }
        };
        match at < output.unneeded() {
            true => Ok(()),
            false => output.push(&made.image.data),
        }
    }

    /// The output of images like this one.
    fn begun(&self, target: &Path, image: &FloatImage) -> Result<Output> {
        let size = (image.width, image.height);
        let whole = self.subject.describe(size, self.steps.hot_pixels());
        let writer = match &self.shard.part {
            None => SampleWriter::create(target, whole)?,
            Some(part) => SampleWriter::resume(target, part.described_in(&whole))?,
        };
        let resampler = |near_field: &NearField| {
            let near_field = NearField {
                patch: Patch {
                    width: image.width,
                    height: image.height,
                    ..near_field.patch
                },
                ..near_field.clone()
            };
            Resampler::new(near_field, self.shard.prepared.clone(), parent(target))
        };
        Ok(Output {
            resumed: writer.images_written(),
            writer,
            resampler: self.shard.near_field.as_ref().map(resampler).transpose()?,
        })
    }

    /// Refuses options that no image has use for. Where a shard's own images have none, others may: they are read until
    /// one has.
    fn check_options_used(&self, progress: Progress<'_>) -> Result<()> {
        if self.shard.part.is_some() {
            for image in self.subject.arrangement.read_images() {
                if self.reader.check_options_used().is_ok() {
                    break;
                }
                progress.check()?;
                self.reader.read(&self.subject.list.images[image])?;
            }
        }
        self.reader.check_options_used()
    }

    /// The image at a place of the sample, in radiance.
    fn made(&self, place: usize) -> Result<Made> {
        match &self.subject.arrangement.slots[place] {
            Slot::Read(image) => self.radiance(&self.subject.list.images[*image]),
            Slot::Fill(blend) => self.blended(blend),
        }
    }

    /// A missing image, from those of other directions.
    fn blended(&self, Blend(shares): &Blend) -> Result<Made> {
        let mut sum: Option<Made> = None;
        for &(image, share) in shares {
            let mut part = self.radiance(&self.subject.list.images[image])?;
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
            Error::data("fill", "no image to interpolate from").in_file(&self.subject.list.path)
        })
    }

    /// An image's radiance for unit irradiance.
    fn radiance(&self, measured: &MeasuredImage) -> Result<Made> {
        let (image, notes) = self.reader.read(measured)?;
        check_values(&image).map_err(|error| error.in_file(&measured.path))?;
        let size = (image.width, image.height);
        let prepared = self.steps.apply(image, measured);
        let mut image = prepared.map_err(|error| error.in_file(&measured.path))?;
        let (values, family) = (self.subject.options.values, self.subject.list.family);
        let scale = values.radiance_per_number(family, measured.light);
        image.data.iter_mut().for_each(|value| *value *= scale);
        Ok(Made { image, size, notes })
    }
}

/// Images to decode at a time: a few per thread, as many as the bound allows, but one per thread in any case.
fn batch((width, height): (u32, u32)) -> usize {
    let bytes = width as usize * height as usize * 3 * size_of::<f32>();
    let threads = rayon::current_num_threads();
    (BATCH_BYTES / bytes.max(1)).clamp(threads, BATCH.max(threads))
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
    use crate::btf::sample::{Layout, Sample};
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
            place: Place::default(),
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
        assemble(&list, &options, target.as_path(), Progress::silent()).unwrap();
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
            target.as_path(),
            Progress::silent(),
        );
        let text = error.unwrap_err().to_string();
        assert!(text.contains("b.png") && text.contains("1 × 2"), "{text}");
        assert!(!target.exists());
    }
}
