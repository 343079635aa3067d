//! Every image of a source, written into a sample.

use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use crate::btf::bonn::images::BonnImages;
use crate::btf::bonn::local_frames::TexelFrames;
use crate::btf::description::Description;
use crate::btf::image_source::ImageSource;
use crate::btf::parts::{NewPart, WrittenSample, write_sample_or_part};
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::atomic::parent;
use crate::format::nameless::{Nameless, NamelessWriter};
use crate::progress::Progress;

/// Bytes of a block of texels while local frames are undone.
const BLOCK: usize = 64 << 20;

/// Writes all images to `target`, or those of one part.
pub(super) fn expand(
    images: &BonnImages,
    target: &Path,
    part: Option<&NewPart>,
    progress: Progress<'_>,
) -> Result<WrittenSample> {
    let (whole, heights) = (images.description.clone(), images.heights.clone());
    write_sample_or_part(target, whole, part, heights, |writer, range| {
        each_image(images, range, progress, |image| writer.push(image))
    })
}

/// The same where each texel has a frame of its own: the numbers go over the disk, once by images and once by blocks
/// of texels.
pub(super) fn expand_turned(
    images: &BonnImages,
    frames: &TexelFrames<'_>,
    target: &Path,
    progress: Progress<'_>,
) -> Result<Description> {
    let mut writer = SampleWriter::create(target, images.description.clone())?;
    writer.set_heights(images.heights.clone());
    let io = |action| Error::io(target, action);
    let scratch = || NamelessWriter::create_in(parent(target)).map_err(io("write"));
    let mut by_image = scratch()?;
    let all = 0..images.description.image_count();
    each_image(images, all, progress, |image| {
        by_image.write(image).map_err(io("write"))
    })?;
    let by_image: Nameless<f32> = by_image.finish().map_err(io("read"))?;
    let description = &images.description;
    let (count, texels) = (description.image_count(), description.grid().len());
    let per_block = (BLOCK / (count * 12)).clamp(1, texels);
    let mut by_block = scratch()?;
    progress.begin("undoing local frames", texels as u64);
    for start in (0..texels).step_by(per_block) {
        let block = start..texels.min(start + per_block);
        let mut values = gathered(by_image.as_slice(), texels, block.clone());
        frames.turn_block(&mut values, block.clone());
        by_block.write(&values).map_err(io("write"))?;
        progress.advance(block.len() as u64)?;
    }
    progress.end();
    let by_block: Nameless<f32> = by_block.finish().map_err(io("read"))?;
    let mut values = vec![0.0; texels * 3];
    for image in 0..count {
        progress.check()?;
        let (out, _) = values.as_chunks_mut::<3>();
        let (all, _) = by_block.as_slice().as_chunks::<3>();
        // Blocks follow each other, so a texel's numbers lie together whatever its block.
        let pairs = out.iter_mut().enumerate();
        pairs.for_each(|(texel, out)| *out = all[texel * count + image]);
        writer.push(&values)?;
    }
    writer.finish()
}

/// A block of texels, \[texel\]\[image\]\[RGB\], of numbers that lie image by image.
fn gathered(by_image: &[f32], texels: usize, block: Range<usize>) -> Vec<f32> {
    let count = by_image.len() / (texels * 3);
    let mut values = vec![0.0; block.len() * count * 3];
    values
        .par_chunks_mut(count * 3)
        .zip(block)
        .for_each(|(values, texel)| {
            for (image, out) in values.chunks_mut(3).enumerate() {
                let from = (image * texels + texel) * 3;
                out.copy_from_slice(&by_image[from..from + 3]);
            }
        });
    values
}

/// Calls `take` with each image of a range in order. Images are expanded in the same groups whatever the range is: the
/// last bits of their products may depend on the group.
fn each_image(
    images: &BonnImages,
    range: Range<usize>,
    progress: Progress<'_>,
    mut take: impl FnMut(&[f32]) -> Result<()>,
) -> Result<()> {
    let count = images.description.image_count();
    let image = images.description.grid().len() * 3;
    let run = images.run().min(count);
    let mut values = vec![0.0; run * image];
    progress.begin("expanding images", range.len() as u64);
    let first = range.start - range.start % run;
    for start in (first..range.end).step_by(run) {
        progress.check()?;
        let group = start..count.min(start + run);
        let values = &mut values[..group.len() * image];
        images.read_images(group.clone(), values)?;
        let own = group.start.max(range.start)..group.end.min(range.end);
        let numbers = (own.start - start) * image..(own.end - start) * image;
        values[numbers].chunks(image).try_for_each(&mut take)?;
        progress.advance(own.len() as u64)?;
    }
    progress.end();
    Ok(())
}
