//! The parts of all shards, and what they hold together.

use std::path::PathBuf;

use ndarray::{Array2, s};

use crate::btf::sample::Sample;
use crate::byte_size::ByteSize;
use crate::error::{Error, Result};
use crate::format::seal::ENGINE;
use crate::shard;
use crate::texton::image_products::ImageProducts;
use crate::texton::options::TextonOptions;
use crate::texton::parts::job::Job;
use crate::texton::parts::part::Part;
use crate::texton::parts::work::{VECTORS, Work, products_of};
use crate::texton::study::Study;

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
            return Err(
                Error::data("meta.json", "routes that do not match each other")
                    .expected("what `mesotex textons --shard` writes for this sample")
                    .in_file(&self.parts[0].path),
            );
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
    // Compare the samples.
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
    // Compare the versions of the program.
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
    // Compare the options with those of the first part.
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
