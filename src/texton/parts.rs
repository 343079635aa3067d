//! Parts of a texton analysis, `PART.npz`: what the images of one shard contribute, and how parts are joined.
//!
//! In: a study and a shard, or the parts of all shards. Out: a file, or what the whole analysis would have made of
//! all images. Where images are chosen, a part holds the appearance vectors of its images; where all are taken,
//! the dot products of its blocks of images. Both are written as they are made. What they hold is the same
//! numbers that one run works with, bit for bit, whatever the number of shards.

use std::cell::RefCell;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use ndarray::{Array2, s};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::npz;
use crate::format::seal::ENGINE;
use crate::format::stored_array::StoredArray;
use crate::progress::Progress;
use crate::shard::{self, Shard};
use crate::texton::filter_bank::leung_malik;
use crate::texton::image_blocks::ImageBlocks;
use crate::texton::image_products::ImageProducts;
use crate::texton::options::{ByteSize, TextonOptions};
use crate::texton::panels::{Panels, PlaneSource};
use crate::texton::representatives::ImageVectors;
use crate::texton::study::{Study, random_of_images, recorded, standing_for};

/// `format` in the file's `meta.json`.
pub const FORMAT: &str = "mesotex-textons-part";
/// The version written, and the only one read.
pub const VERSION: u32 = 1;

/// The array of image appearance vectors.
const VECTORS: &str = "image_vectors";

/// What the parts of one analysis share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// The version of the program.
    program: String,
    /// The sample's id.
    sample: ContentId,
    /// What parts hold.
    holds: Holds,
    /// How many of the finest levels are sketched.
    sketched_levels: usize,
    /// How image appearance vectors are held.
    image_vectors: ImageVectors,
    /// The options, without those that change no number.
    options: Value,
}

/// What parts of an analysis hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Holds {
    /// Appearance vectors of images, from which some are chosen.
    ImageVectors,
    /// Dot products of blocks of images.
    ImageProducts,
}

/// `meta.json`.
#[derive(Debug, Serialize, Deserialize)]
struct Meta {
    format: String,
    version: u32,
    shard: Shard,
    #[serde(flatten)]
    job: Job,
}

/// What making a part did.
#[derive(Clone, Debug)]
pub struct PartReport {
    /// Images of the part.
    pub images: Range<usize>,
    /// Whether the part was there, whole, and nothing was done.
    pub is_kept: bool,
}

/// Makes the part of a shard, unless it stands at `path` already.
pub fn write_part(
    study: &Study<'_>,
    shard: Shard,
    path: &Path,
    progress: Progress<'_>,
) -> Result<PartReport> {
    let work = Work::of(study)?;
    shard.check(work.units(), work.name_of_units())?;
    let job = Job::of(study, &work)?;
    let images = work.images(shard);
    let is_kept = is_there(path, &job, shard, study, &work);
    if !is_kept {
        work.write(study, &job, shard, path, progress)?;
    }
    Ok(PartReport { images, is_kept })
}

/// What is shared among shards.
enum Work {
    /// So many images, one by one.
    Vectors(usize),
    /// Blocks of images.
    Products(ImageBlocks),
}

impl Work {
    /// What the parts of a study hold; refuses studies that cannot be shared.
    fn of(study: &Study<'_>) -> Result<Self> {
        let sample = study.stack.sample;
        let images = sample.image_count();
        if study.chosen()?.is_some() {
            return Ok(Self::Vectors(images));
        }
        if let Some(factors) = standing_for(sample, images, study.stack.channels) {
            return Err(Error::option(
                "shard",
                format!("given for a sample of rank {}", factors.rank()),
                "one run without --shard: it reads eigentextures in place of images",
            ));
        }
        match study.plan.sketched() {
            0 => Ok(Self::Products(ImageBlocks::of_all(images))),
            levels => Err(Error::option(
                "shard",
                format!(
                    "with all images, the finest {levels} of {} levels would be sketched for want of memory",
                    study.plan.routes.len()
                ),
                "--images N, a larger --memory (for the reduction), or one run without --shard",
            )),
        }
    }

    fn holds(&self) -> Holds {
        match self {
            Self::Vectors(_) => Holds::ImageVectors,
            Self::Products(_) => Holds::ImageProducts,
        }
    }

    /// Shards at most.
    fn units(&self) -> usize {
        match self {
            Self::Vectors(images) => *images,
            Self::Products(blocks) => blocks.count(),
        }
    }

    fn name_of_units(&self) -> &'static str {
        match self {
            Self::Vectors(_) => "images",
            Self::Products(_) => "blocks of images that are summed",
        }
    }

    /// The images of a shard.
    fn images(&self, shard: Shard) -> Range<usize> {
        let units = shard.range(self.units());
        match self {
            Self::Vectors(_) => units,
            Self::Products(blocks) => {
                blocks.images(units.start).start..blocks.images(units.end - 1).end
            }
        }
    }

    fn write(
        &self,
        study: &Study<'_>,
        job: &Job,
        shard: Shard,
        path: &Path,
        progress: Progress<'_>,
    ) -> Result<ContentId> {
        let meta = Meta {
            format: FORMAT.into(),
            version: VERSION,
            shard,
            job: job.clone(),
        };
        // What stops the work in the midst of the archive is not of the archive's own kind of error.
        let fault = RefCell::new(None);
        let written = npz::write(path, as_map(&meta)?, |file| match self {
            Self::Vectors(_) => write_vectors(file, study, self.images(shard), &fault, progress),
            Self::Products(blocks) => {
                let own = shard.range(blocks.count());
                write_products(file, study, *blocks, own, &fault, progress)
            }
        });
        match fault.into_inner() {
            Some(error) => Err(error),
            None => written,
        }
    }
}

/// Writes the rows of some images while they are made.
fn write_vectors(
    file: &mut npz::Writer<'_>,
    study: &Study<'_>,
    images: Range<usize>,
    fault: &RefCell<Option<Error>>,
    progress: Progress<'_>,
) -> io::Result<()> {
    let bank = leung_malik();
    let appearance = study.appearance(&bank, &mut random_of_images(study.options));
    progress.begin("image appearance", images.len() as u64);
    let shape = [images.len(), appearance.columns()];
    let rows = appearance.rows_of(images, progress);
    let blocks = rows.map_while(|rows| match rows {
        Ok(rows) => Some(rows.into_raw_vec_and_offset().0),
        Err(error) => {
            *fault.borrow_mut() = Some(error);
            None
        }
    });
    file.blocks(VECTORS, &shape, blocks)?;
    progress.end();
    Ok(())
}

/// Writes the dot products of some blocks, each when it is summed.
fn write_products(
    file: &mut npz::Writer<'_>,
    study: &Study<'_>,
    blocks: ImageBlocks,
    own: Range<usize>,
    fault: &RefCell<Option<Error>>,
    progress: Progress<'_>,
) -> io::Result<()> {
    let numbers: Vec<u32> = (0..study.stack.sample.image_count() as u32).collect();
    let panels = Panels::new(&study.stack, PlaneSource::Images(&numbers), blocks, false);
    let mut products = ImageProducts::new(&study.stack.grids);
    let lengths = ImageProducts::stored_lengths(&study.stack.grids);
    let images: usize = own.clone().map(|block| blocks.images(block).len()).sum();
    progress.begin("image dot products", images as u64);
    for block in own {
        let summed = panels.each_of_block(block, progress, |planes| products.add(planes, progress));
        if let Err(error) = summed.and_then(|()| progress.check()) {
            *fault.borrow_mut() = Some(error);
            return Err(io::Error::from(io::ErrorKind::Interrupted));
        }
        for (level, (sums, &length)) in products.block().zip(&lengths).enumerate() {
            file.blocks(&products_of(level, block), &[length], sums.stored())?;
        }
        products.clear_block();
    }
    progress.end();
    Ok(())
}

fn products_of(level: usize, block: usize) -> String {
    format!("L{level}/products{block}")
}

impl Job {
    fn of(study: &Study<'_>, work: &Work) -> Result<Self> {
        Ok(Self {
            program: ENGINE.into(),
            sample: study.stack.sample.id().clone(),
            holds: work.holds(),
            sketched_levels: study.plan.sketched(),
            image_vectors: study.plan.image_vectors,
            options: recorded(study.options)?,
        })
    }

    /// How a part of one sample and version differs from the first; `None` where both belong to one analysis.
    fn difference(&self, first: &Self) -> Option<String> {
        if self.options != first.options {
            return Some(format!(
                "made with {}",
                other_options(&self.options, &first.options)
            ));
        }
        let routes = |job: &Self| (job.holds, job.sketched_levels, job.image_vectors);
        (routes(self) != routes(first)).then(|| "made for another --memory".into())
    }
}

/// The options that differ, as they are typed.
fn other_options(own: &Value, first: &Value) -> String {
    let (Some(own), Some(first)) = (own.as_object(), first.as_object()) else {
        return "unreadable options".into();
    };
    let differing = own
        .iter()
        .filter(|(name, value)| first.get(*name) != Some(value));
    let listed = differing.map(|(name, value)| {
        let text = |value: Option<&Value>| match value {
            Some(Value::String(text)) => text.clone(),
            Some(Value::Null) | None => "its default".into(),
            Some(other) => other.to_string(),
        };
        format!(
            "--{name} {}, not {}",
            text(Some(value)),
            text(first.get(name))
        )
    });
    let listed: Vec<String> = listed.collect();
    match listed.is_empty() {
        true => "fewer options".into(),
        false => listed.join(", "),
    }
}

fn as_map(meta: &Meta) -> Result<Map<String, Value>> {
    match serde_json::to_value(meta) {
        Ok(Value::Object(map)) => Ok(map),
        Ok(_) => Err(Error::data("meta.json", "no object")),
        Err(error) => Err(Error::data("meta.json", error.to_string())),
    }
}

/// One part, open for reading.
struct Part {
    path: PathBuf,
    file: npz::Reader,
    meta: Meta,
}

impl Part {
    fn open(path: &Path) -> Result<Self> {
        let mut file = npz::Reader::open(path)?;
        let told: Value = file.meta()?;
        if told["format"] != FORMAT {
            let found = format!("`{}`", told["format"].as_str().unwrap_or("no format"));
            return Err(file
                .fault("meta.json: format", found)
                .expected(format!("{FORMAT}, as `mesotex textons --shard` writes it")));
        }
        if told["version"] != VERSION {
            return Err(file
                .fault("meta.json: version", told["version"].to_string())
                .expected(VERSION.to_string()));
        }
        let meta = file.meta()?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            meta,
        })
    }

    /// An array of one shape, its checksum compared.
    fn stored(&mut self, name: &str, shape: &[usize]) -> Result<StoredArray<f32>> {
        let stored = self.file.stored::<f32>(name)?;
        match stored.shape() == shape {
            true => Ok(stored),
            false => Err(self
                .file
                .fault(name, format!("shape {:?}", stored.shape()))
                .expected(format!("{shape:?}, as the sample and the options say"))),
        }
    }

    /// Names and shapes of the arrays that belong in a part.
    fn arrays(study: &Study<'_>, work: &Work, shard: Shard) -> Vec<(String, Vec<usize>)> {
        match work {
            Work::Vectors(images) => {
                let bank = leung_malik();
                let appearance = study.appearance(&bank, &mut random_of_images(study.options));
                let shape = vec![shard.range(*images).len(), appearance.columns()];
                vec![(VECTORS.into(), shape)]
            }
            Work::Products(blocks) => {
                let lengths = ImageProducts::stored_lengths(&study.stack.grids);
                let of_block = |block: usize| {
                    let levels = lengths.iter().enumerate();
                    levels.map(move |(level, &length)| (products_of(level, block), vec![length]))
                };
                shard.range(blocks.count()).flat_map(of_block).collect()
            }
        }
    }
}

/// Whether `path` holds the whole part of this shard, every checksum right.
fn is_there(path: &Path, job: &Job, shard: Shard, study: &Study<'_>, work: &Work) -> bool {
    let Ok(mut part) = Part::open(path) else {
        return false;
    };
    let is_this = part.meta.shard == shard && part.meta.job == *job;
    let mut arrays = Part::arrays(study, work, shard).into_iter();
    is_this && arrays.all(|(name, shape)| part.stored(&name, &shape).is_ok())
}

/// What a part says of itself.
pub struct PartFile {
    /// Which share of the work it holds.
    pub shard: Shard,
    /// The options it was made with.
    pub options: Value,
    /// The id of its sample.
    pub sample: ContentId,
    /// The version of the program that made it.
    pub program: String,
    /// How many numbers it holds.
    pub numbers: usize,
}

impl PartFile {
    /// Reads a part and compares all its checksums.
    pub fn read(path: &Path) -> Result<Self> {
        let Part { mut file, meta, .. } = Part::open(path)?;
        let arrays = file.names().into_iter();
        let lengths = arrays.map(|name| Ok(file.stored::<f32>(&name)?.len()));
        let numbers = lengths.sum::<Result<usize>>()?;
        Ok(Self {
            shard: meta.shard,
            options: meta.job.options,
            sample: meta.job.sample,
            program: meta.job.program,
            numbers,
        })
    }
}

/// The parts of all shards of one analysis, in order.
pub struct Parts {
    parts: Vec<Part>,
    job: Job,
    /// The options they were made with.
    pub options: TextonOptions,
}

impl Parts {
    /// Opens parts. Refuses those of another sample than `sample`, of other options or routes than the first, and
    /// shards that are missing or there twice.
    pub fn open(paths: &[PathBuf], sample: &Sample) -> Result<Self> {
        let opened = paths.iter().map(|path| Part::open(path));
        let mut parts: Vec<Part> = opened.collect::<Result<_>>()?;
        check_alike(&parts, sample)?;
        let Some(first) = parts.first() else {
            return Err(Error::option("reduce", "no part", "all parts"));
        };
        let job = first.meta.job.clone();
        let options = options_of(first)?;
        let shards = parts.iter();
        let shards: Vec<_> = shards
            .map(|part| (part.path.as_path(), part.meta.shard))
            .collect();
        let order = shard::in_order(&shards)?;
        let mut places: Vec<(usize, Part)> = parts.drain(..).enumerate().collect();
        places.sort_by_key(|(at, _)| order.iter().position(|place| place == at));
        let parts: Vec<Part> = places.into_iter().map(|(_, part)| part).collect();
        Ok(Self {
            parts,
            job,
            options,
        })
    }

    /// The study that the parts belong to; `options` are theirs. `memory` bounds what is kept to save reading.
    pub fn study<'a>(
        &self,
        sample: &'a Sample,
        options: &'a TextonOptions,
        memory: Option<ByteSize>,
    ) -> Result<Study<'a>> {
        let routes = (self.job.sketched_levels, self.job.image_vectors);
        let study = Study::decided(sample, options, routes, memory)?;
        self.check(&study)?;
        Ok(study)
    }

    /// Refuses parts that do not hold what a study needs.
    fn check(&self, study: &Study<'_>) -> Result<()> {
        let work = Work::of(study)?;
        if self.job != Job::of(study, &work)? {
            return Err(Error::data("meta.json", "routes that do not go together")
                .expected("what `mesotex textons --shard` writes for this sample")
                .in_file(&self.parts[0].path));
        }
        let shard = self.parts[0].meta.shard;
        shard
            .check(work.units(), work.name_of_units())
            .map_err(|error| {
                Error::data("meta.json: shard", error.to_string()).in_file(&self.parts[0].path)
            })
    }

    /// The appearance vectors [images, columns] of all images.
    pub fn image_vectors(&mut self, images: usize, columns: usize) -> Result<Array2<f32>> {
        let mut vectors = Array2::zeros((images, columns));
        for part in &mut self.parts {
            let range = part.meta.shard.range(images);
            let stored = part.stored(VECTORS, &[range.len(), columns])?;
            let mut rows = vectors.slice_mut(s![range, ..]);
            let Some(numbers) = rows.as_slice_mut() else {
                unreachable!("whole rows lie together");
            };
            stored.read(0, numbers)?;
            if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
                let found = number.to_string();
                return Err(part.file.fault(VECTORS, found).expected("finite numbers"));
            }
        }
        Ok(vectors)
    }

    /// The dot products of all images, where parts hold them.
    pub fn image_products(&mut self, study: &Study<'_>) -> Result<Option<ImageProducts>> {
        let Work::Products(blocks) = Work::of(study)? else {
            return Ok(None);
        };
        let mut products = ImageProducts::new(&study.stack.grids);
        let lengths = ImageProducts::stored_lengths(&study.stack.grids);
        for part in &mut self.parts {
            for block in part.meta.shard.range(blocks.count()) {
                for (level, &length) in lengths.iter().enumerate() {
                    let name = products_of(level, block);
                    let stored = part.stored(&name, &[length])?;
                    let added = products.add_stored(level, &stored);
                    added.map_err(|error| part.file.at(&name, error))?;
                }
            }
        }
        Ok(Some(products))
    }
}

/// Refuses parts of another sample or of another analysis than the first, naming each.
fn check_alike(parts: &[Part], sample: &Sample) -> Result<()> {
    let named = |difference: &dyn Fn(&Job) -> Option<String>| {
        let others = parts.iter().filter_map(|part| {
            let difference = difference(&part.meta.job)?;
            Some(format!("{} is {difference}", part.path.display()))
        });
        others.collect::<Vec<_>>().join("; ")
    };
    let refuse = |others: String, expected: String, advice: &str| match others.is_empty() {
        true => Ok(()),
        false => Err(Error::data("parts", others)
            .expected(expected)
            .advice(advice)),
    };
    let of_another = named(&|job| {
        let is_other = job.sample != *sample.id();
        is_other.then(|| format!("of the sample {}", job.sample))
    });
    let expected = format!("parts of the sample {}", sample.id());
    refuse(
        of_another,
        expected,
        "make these parts again from this sample",
    )?;
    let of_version = named(&|job| {
        let is_other = job.program != ENGINE;
        is_other.then(|| format!("made by version {} of the program", job.program))
    });
    let expected = format!("parts of version {ENGINE}");
    refuse(
        of_version,
        expected,
        "make these parts again with this version",
    )?;
    let Some(first) = parts.first() else {
        return Ok(());
    };
    let otherwise = named(&|job| job.difference(&first.meta.job));
    let expected = format!("parts of one analysis, as {}", first.path.display());
    refuse(
        otherwise,
        expected,
        "give every shard the same options and --memory",
    )
}

/// The options that a part was made with.
fn options_of(part: &Part) -> Result<TextonOptions> {
    let job = &part.meta.job;
    let options = serde_json::from_value(job.options.clone());
    let options: TextonOptions =
        options.map_err(|error| part.file.fault("meta.json: options", error.to_string()))?;
    match job.sketched_levels <= options.levels as usize {
        true => Ok(options),
        false => Err(part
            .file
            .fault(
                "meta.json: sketched_levels",
                job.sketched_levels.to_string(),
            )
            .expected(format!("at most {}, the levels", options.levels))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::direction::Direction;
    use crate::btf::sample::{DType, Description, Layout, VERSION as SAMPLE_VERSION};
    use crate::btf::{sample, writer::SampleWriter};
    use crate::texton::analysis;

    /// Thirty images of 8 × 8 texels.
    fn write_sample(path: &Path) -> Sample {
        let lights: Vec<Direction> = (0..30)
            .map(|i| Direction::from_angles(0.04 * f64::from(i), f64::from(i)))
            .collect();
        let description = Description {
            format: sample::FORMAT.into(),
            version: SAMPLE_VERSION,
            name: "waves".into(),
            width: 8,
            height: 8,
            channels: 3,
            dtype: DType::F4,
            texel_mm: None,
            layout: Layout::Product,
            views: vec![Direction::from_angles(0.0, 0.0)],
            lights,
            pairs: None,
            tileable: true,
            id: ContentId::of_bytes(b""),
            source: Value::Null,
        };
        let mut writer = SampleWriter::create(path, description).unwrap();
        for image in 0..30 {
            let number = |at: usize| ((at * at + image * (at % 7)) % 31) as f32 / 31.0;
            let numbers: Vec<f32> = (0..8 * 8 * 3).map(number).collect();
            writer.push(&numbers).unwrap();
        }
        writer.finish().unwrap();
        Sample::open(path).unwrap()
    }

    /// What little memory leads to: folded vectors of images, a sketched level.
    #[test]
    fn parts_of_every_route_join_to_the_same_vocabulary() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let sample = write_sample(&at("a.sample"));
        let options: TextonOptions =
            toml::from_str("textons = 6\nlevels = 2\nimages = 7\nimage-grid = 3").unwrap();
        let quiet = Progress::silent();
        for routes in [(1, ImageVectors::Folded), (1, ImageVectors::Exact)] {
            let study = Study::decided(&sample, &options, routes, None).unwrap();
            let whole = analysis::find(&study, None, quiet).unwrap().vocabulary;
            let whole = whole.write(&at("whole.npz")).unwrap();
            let paths = ["p0.npz", "p1.npz", "p2.npz"].map(at);
            for (index, path) in (0..).zip(&paths) {
                let shard = Shard { index, count: 3 };
                assert!(!write_part(&study, shard, path, quiet).unwrap().is_kept);
                assert!(write_part(&study, shard, path, quiet).unwrap().is_kept);
            }
            let parts = Parts::open(&paths, &sample).unwrap();
            let options = parts.options.clone();
            let study = parts.study(&sample, &options, None).unwrap();
            let joined = analysis::find(&study, Some(parts), quiet)
                .unwrap()
                .vocabulary;
            assert_eq!(
                joined.write(&at("joined.npz")).unwrap(),
                whole,
                "{routes:?}"
            );
        }
        let all = TextonOptions {
            images: Some("all".parse().unwrap()),
            ..options
        };
        let study = Study::decided(&sample, &all, (1, ImageVectors::Exact), None).unwrap();
        let shard = Shard { index: 0, count: 2 };
        let refused = write_part(&study, shard, &at("p.npz"), quiet).unwrap_err();
        assert!(
            refused
                .to_string()
                .contains("the finest 1 of 2 levels would be sketched"),
            "{refused}"
        );
    }
}
