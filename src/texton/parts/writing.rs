//! Writing a part: what it holds is written as it is made.

use std::cell::RefCell;
use std::io;
use std::ops::Range;
use std::path::Path;

use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::npz;
use crate::progress::Progress;
use crate::shard::Shard;
use crate::texton::filter_bank::leung_malik;
use crate::texton::image_batches::{ImageBatches, PlaneSource};
use crate::texton::image_blocks::ImageBlocks;
use crate::texton::image_products::ImageProducts;
use crate::texton::parts::job::{FORMAT, Job, Meta, VERSION, as_map};
use crate::texton::parts::part::Part;
use crate::texton::parts::work::{VECTORS, Work, products_of};
use crate::texton::study::{Study, random_of_images};

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
        write(&work, (study, &job), shard, path, progress)?;
    }
    Ok(PartReport { images, is_kept })
}

/// Whether `path` holds the whole part of this shard, every checksum right.
fn is_there(path: &Path, job: &Job, shard: Shard, study: &Study<'_>, work: &Work) -> bool {
    let Ok(mut part) = Part::open(path) else {
        return false;
    };
    let is_this = part.meta.shard == shard && part.meta.job == *job;
    let mut arrays = work.arrays(study, shard).into_iter();
    is_this && arrays.all(|(name, shape)| part.stored(&name, &shape).is_ok())
}

fn write(
    work: &Work,
    (study, job): (&Study<'_>, &Job),
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
    let written = npz::write(path, as_map(&meta)?, |file| match work {
        Work::Vectors(_) => write_vectors(file, study, work.images(shard), &fault, progress),
        Work::Products(blocks) => {
            let own = shard.range(blocks.count());
            write_products(file, study, *blocks, own, &fault, progress)
        }
    });
    match fault.into_inner() {
        Some(error) => Err(error),
        None => written,
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
    let batches = ImageBatches::new(&study.stack, PlaneSource::Images(&numbers), blocks, false);
    let mut products = ImageProducts::new(&study.stack.grids);
    let lengths = ImageProducts::stored_lengths(&study.stack.grids);
    let images: usize = own.clone().map(|block| blocks.images(block).len()).sum();
    progress.begin("image dot products", images as u64);
    for block in own {
        let summed =
            batches.each_of_block(block, progress, |planes| products.add(planes, progress));
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
