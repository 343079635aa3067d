//! Images of near cameras and lamps become those of distant ones.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;

use crate::btf::import::stations::station::{Patch, Station, spread};
use crate::btf::import::stations::weights::{Varying, candidates, weights};
use crate::error::{Error, Result};
use crate::format::nameless::{Nameless, NamelessWriter};
use crate::progress::Progress;

/// Weights are found at this many points and one more along each side of the patch, and linear between.
const CELLS: usize = 8;
/// Points at which weights are found.
const NODES: usize = (CELLS + 1) * (CELLS + 1);

/// What resampling needs to know: the stations of all images, in their order, and the patch.
#[derive(Clone, Debug)]
pub struct NearField {
    /// Per image, in the order in which they are written.
    pub stations: Vec<Station>,
    /// The patch.
    pub patch: Patch,
}

impl NearField {
    /// The images that some resampled ones may be made of, in order. They do not depend on the patch's texels.
    pub fn sources_of(&self, wanted: Range<usize>) -> Vec<usize> {
        let (varying, spread) = self.reach();
        let sources = wanted.flat_map(|image| candidates(&self.stations, image, varying, spread));
        sources.collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// What differs from image to image, and how much directions differ over the patch.
    fn reach(&self) -> (Varying, f64) {
        let spread = spread(&self.stations, self.patch);
        (Varying::of(&self.stations), spread.most())
    }
}

/// Gathers images, then makes the resampled ones.
#[derive(Debug)]
pub struct Resampler {
    near_field: NearField,
    /// The images that are gathered, in order.
    sources: Vec<usize>,
    gathered: NamelessWriter,
    folder: PathBuf,
}

impl Resampler {
    /// Images, `sources` in order, are gathered in a file without a name on the disk of `folder`.
    pub fn new(near_field: NearField, sources: Vec<usize>, folder: &Path) -> Result<Self> {
        let gathered = NamelessWriter::create_in(folder).map_err(Error::io(folder, "write"))?;
        Ok(Self {
            near_field,
            sources,
            gathered,
            folder: folder.to_path_buf(),
        })
    }

    /// Adds the next image: row-major (height, width, RGB).
    pub fn push(&mut self, image: &[f32]) -> Result<()> {
        self.gathered
            .write(image)
            .map_err(Error::io(&self.folder, "write"))
    }

    /// Hands the resampled images of a range to `write`, in order; all their sources must be there.
    pub fn finish(
        self,
        wanted: Range<usize>,
        progress: Progress<'_>,
        mut write: impl FnMut(&[f32]) -> Result<()>,
    ) -> Result<()> {
        let images: Nameless<f32> = self
            .gathered
            .finish()
            .map_err(Error::io(&self.folder, "read"))?;
        progress.begin("resampling the near field", wanted.len() as u64);
        for image in wanted {
            let blend = Blend::new(&self.near_field, &self.sources, image);
            write(&blend.image(self.near_field.patch, images.as_slice()))?;
            progress.advance(1)?;
        }
        progress.end();
        Ok(())
    }
}

/// The gathered images that make one resampled image, by their places, and their weights at the nodes.
struct Blend {
    images: Vec<(usize, [f32; NODES])>,
}

impl Blend {
    fn new(near_field: &NearField, sources: &[usize], wanted: usize) -> Self {
        let (varying, spread) = near_field.reach();
        let chosen = candidates(&near_field.stations, wanted, varying, spread);
        let stations: Vec<Station> = chosen
            .iter()
            .map(|&image| near_field.stations[image])
            .collect();
        let target = near_field.stations[wanted];
        let at_node = |node: usize| {
            let point = node_point(near_field.patch, node);
            weights(&stations, &target, point, varying)
        };
        let at_nodes: Vec<Vec<f64>> = (0..NODES).into_par_iter().map(at_node).collect();
        let of_image = |(at, image): (usize, &usize)| {
            let mut weights = [0.0; NODES];
            for (weight, at_node) in weights.iter_mut().zip(&at_nodes) {
                *weight = at_node[at] as f32;
            }
            (sources.partition_point(|source| source < image), weights)
        };
        let images = chosen.iter().enumerate().map(of_image);
        Self {
            images: images
                .filter(|(_, weights)| weights.iter().any(|&weight| weight != 0.0))
                .collect(),
        }
    }

    /// The blended image.
    fn image(&self, patch: Patch, images: &[f32]) -> Vec<f32> {
        let (width, height) = (patch.width as usize, patch.height as usize);
        let mut out = vec![0.0; 3 * width * height];
        out.par_chunks_mut(3 * width)
            .enumerate()
            .for_each(|(row, texels)| {
                let (top, down) = cell(row, height);
                for (image, weights) in &self.images {
                    let line = &images[(image * height + row) * 3 * width..][..3 * width];
                    for column in 0..width {
                        let (left, right) = cell(column, width);
                        let node = |i: usize, j: usize| weights[(top + i) * (CELLS + 1) + left + j];
                        let upper = node(0, 0) * (1.0 - right) + node(0, 1) * right;
                        let lower = node(1, 0) * (1.0 - right) + node(1, 1) * right;
                        let weight = upper * (1.0 - down) + lower * down;
                        for channel in 3 * column..3 * column + 3 {
                            texels[channel] += weight * line[channel];
                        }
                    }
                }
            });
        out
    }
}

/// The cell of nodes that a texel's middle lies in, and how far into it.
fn cell(at: usize, side: usize) -> (usize, f32) {
    let place = (at as f32 + 0.5) / side as f32 * CELLS as f32;
    let first = (place as usize).min(CELLS - 1);
    (first, place - first as f32)
}

fn node_point(patch: Patch, node: usize) -> DVec3 {
    let share = |at: usize| at as f64 / CELLS as f64;
    patch.point(share(node % (CELLS + 1)), share(node / (CELLS + 1)))
}
