//! The sample laid out for shading: all images of a texel together, so that a texel's blend reads
//! one small piece of memory, and vertices sorted by texel share it.
//!
//! In: a sample, the images to keep, in the order wanted. Out: per pyramid level an array
//! [H, W, images, RGB] in the sample's number type, weighted sums of the images beside them where asked for. Level l +
//! 1 holds 2×2 means of level l. Levels that do not fit the memory budget are built slab by slab in temporary files.

use std::ops::{Deref, Range};
use std::path::{Path, PathBuf};

use glam::Vec4;
use half::f16;
use rayon::prelude::*;

use crate::btf::sample::{DType, Pixels, Sample};
use crate::error::{Error, Result};
use crate::format::nameless::{Nameless, NamelessWriter};
use crate::format::npy;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::progress::Progress;
use crate::render::table_levels::TableLevels;

/// Texels transposed together: their numbers in one image are a few cache lines.
const BLOCK: usize = 64;
/// The most texels of an image read at once.
const READ: usize = 1024;
/// Images of which some texels are held while they are transposed.
const GROUP: usize = 64;
/// Bytes of the slab that is filled at a time when the table goes to disk.
const SLAB: usize = 256 << 20;

/// Where a table may live.
#[derive(Clone, Debug)]
pub struct MemoryBudget {
    /// What the levels that stay in memory may take together.
    pub bytes: u64,
    /// Folder of the temporary files.
    pub folder: PathBuf,
}

/// How the images of a texel are laid out: row after row, of views.
#[derive(Clone, Debug, PartialEq)]
pub struct RowLayout {
    /// Images of a row.
    pub images: usize,
    /// Sums of a row's images that follow them: per sum the share of each image. What is below 0 is stored as 0.
    pub sums: Vec<Vec<f32>>,
}

impl RowLayout {
    /// One row without sums.
    pub fn plain(images: usize) -> Self {
        Self {
            images,
            sums: Vec::new(),
        }
    }

    /// Images and sums of a row.
    fn row(&self) -> usize {
        self.images + self.sums.len()
    }

    /// Where an image lies among images and sums.
    fn place(&self, image: usize) -> usize {
        image / self.images * self.row() + image % self.images
    }

    /// Adds the sums to a texel's numbers.
    fn add_sums<T: Stored>(&self, texel: &mut [T]) {
        for row in texel.chunks_exact_mut(3 * self.row()) {
            let (images, sums) = row.split_at_mut(3 * self.images);
            for (shares, out) in self.sums.iter().zip(sums.chunks_exact_mut(3)) {
                let mut sum = [0.0; 3];
                for (share, color) in shares.iter().zip(images.chunks_exact(3)) {
                    for (sum, number) in sum.iter_mut().zip(color) {
                        *sum += share * number.value();
                    }
                }
                for (out, sum) in out.iter_mut().zip(sum) {
                    *out = T::nearest(sum.clamp(0.0, T::LARGEST));
                }
            }
        }
    }
}

/// A number type of tables. Numbers are finite and not negative.
pub trait Stored: npy::Element + Copy {
    /// Four neighbouring numbers, times 2 to the power of −112 for halfs.
    fn widen(four: [Self; 4]) -> Vec4;
    /// What undoes the factor of [`widen`](Self::widen), as a product of two safe factors.
    const UNDO: [f32; 2];
    /// The largest number.
    const LARGEST: f32;
    /// The number itself.
    fn value(self) -> f32;
    /// The nearest stored number.
    fn nearest(value: f32) -> Self;
    /// A number of a sample's image; `None` for what no radiance can be.
    fn read(pixels: &Pixels, index: usize) -> Option<Self>;
}

/// 2⁵⁶.
const TWO_56: f32 = (1u64 << 56) as f32;

impl Stored for u16 {
    // A half's bits, moved to a float's place, are the float 2⁻¹¹² times as large; subnormal
    // halfs too. So no table and no instruction set is needed to read them.
    #[inline(always)]
    fn widen(four: [Self; 4]) -> Vec4 {
        let moved = |bits: u16| f32::from_bits(u32::from(bits) << 13);
        let [a, b, c, d] = four;
        Vec4::new(moved(a), moved(b), moved(c), moved(d))
    }

    const UNDO: [f32; 2] = [TWO_56, TWO_56];
    const LARGEST: f32 = 65504.0;

    fn value(self) -> f32 {
        f16::from_bits(self).to_f32()
    }

    fn nearest(value: f32) -> Self {
        f16::from_f32(value).to_bits()
    }

    #[inline]
    fn read(pixels: &Pixels, index: usize) -> Option<Self> {
        const NEGATIVE_ZERO: u16 = 0x8000;
        const INFINITY: u16 = 0x7c00;
        let Pixels::F2(values) = pixels else {
            return None;
        };
        match values[index].to_bits() {
            NEGATIVE_ZERO => Some(0),
            bits => (bits < INFINITY).then_some(bits),
        }
    }
}

impl Stored for f32 {
    #[inline(always)]
    fn widen(four: [Self; 4]) -> Vec4 {
        Vec4::from_array(four)
    }

    const UNDO: [f32; 2] = [1.0, 1.0];
    const LARGEST: f32 = f32::MAX;

    fn value(self) -> f32 {
        self
    }

    fn nearest(value: f32) -> Self {
        value
    }

    #[inline]
    fn read(pixels: &Pixels, index: usize) -> Option<Self> {
        let Pixels::F4(values) = pixels else {
            return None;
        };
        // Adding 0 turns −0 into 0.
        Some(values[index] + 0.0).filter(|value| (0.0..f32::INFINITY).contains(value))
    }
}

/// Numbers in memory or in a temporary file.
#[derive(Debug)]
enum Buffer<T> {
    Owned(Vec<T>),
    OnDisk(Nameless<T>),
}

impl<T: Stored> Deref for Buffer<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            Self::Owned(numbers) => numbers,
            Self::OnDisk(numbers) => numbers.as_slice(),
        }
    }
}

/// One level of a table.
#[derive(Debug)]
pub struct MipLevel<T> {
    /// The texels.
    pub grid: TexelGrid,
    /// Numbers of each texel: 3 per image.
    stride: usize,
    /// Texel after texel, and one number more, so that four can be read at the last image.
    numbers: Buffer<T>,
}

impl<T: Stored> MipLevel<T> {
    /// The numbers of a texel, RGB of image after image, and one number more.
    #[inline(always)]
    pub fn texel(&self, texel: TexelIndex) -> &[T] {
        let start = texel.index() * self.stride;
        &self.numbers[start..start + self.stride + 1]
    }
}

/// All levels of a table.
#[derive(Debug)]
pub struct TexelTable<T> {
    /// Finest first.
    pub levels: Vec<MipLevel<T>>,
}

/// A table in the number type of its sample.
#[derive(Debug)]
pub enum AnyTable {
    /// 16-bit floats, as their bits.
    Half(TexelTable<u16>),
    /// 32-bit floats.
    Single(TexelTable<f32>),
}

impl AnyTable {
    /// Lays out the wanted `images` of a sample, in their order, in rows; with `mip` all levels down to a
    /// single texel, else the finest alone.
    pub fn build(
        sample: &Sample,
        (images, layout): (&[u32], &RowLayout),
        mip: bool,
        budget: &MemoryBudget,
        progress: Progress<'_>,
    ) -> Result<Self> {
        let source = Source {
            sample,
            images,
            layout,
            progress,
        };
        Ok(match sample.description().dtype {
            DType::F2 => Self::Half(TexelTable::build(&source, mip, budget)?),
            DType::F4 => Self::Single(TexelTable::build(&source, mip, budget)?),
        })
    }

    /// Bytes of all levels.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Half(table) => table.bytes(),
            Self::Single(table) => table.bytes(),
        }
    }

    /// Whether the finest level lies on disk.
    pub fn is_mapped(&self) -> bool {
        match self {
            Self::Half(table) => table.is_mapped(),
            Self::Single(table) => table.is_mapped(),
        }
    }
}

struct Source<'a> {
    sample: &'a Sample,
    images: &'a [u32],
    layout: &'a RowLayout,
    progress: Progress<'a>,
}

impl<T: Stored> TexelTable<T> {
    fn build(source: &Source, mip: bool, budget: &MemoryBudget) -> Result<Self> {
        let finest = source.sample.grid();
        let stride = source.stride();
        let table = TableLevels {
            finest,
            stride: (stride * size_of::<T>()) as u64,
            mip,
        };
        let on_disk = table.on_disk(budget.bytes);
        let begun = |level: usize, grid: TexelGrid| {
            LevelWriter::new(grid, stride, &budget.folder, level >= on_disk)
        };
        // Transpose the sample slab by slab.
        source
            .progress
            .begin("copying the sample for shading", finest.len() as u64);
        let mut writer = begun(0, finest)?;
        for slab in writer.slabs() {
            writer.append(slab, |texels, out| {
                source.transpose(texels.start, out)?;
                source.progress.advance(texels.len() as u64)
            })?;
        }
        let mut levels = vec![writer.finish()?];
        // Average coarser levels.
        for (level, grid) in table.grids().enumerate().skip(1) {
            let finer = &levels[level - 1];
            let mut writer = begun(level, grid)?;
            for slab in writer.slabs() {
                writer.append(slab, |texels, out| {
                    source.progress.check()?;
                    for (texel, out) in texels.zip(out.chunks_mut(stride)) {
                        finer.mean_of_children(grid, TexelIndex(texel as u32), out);
                    }
                    Ok(())
                })?;
            }
            levels.push(writer.finish()?);
        }
        source.progress.end();
        Ok(Self { levels })
    }

    fn bytes(&self) -> usize {
        let numbers: usize = self.levels.iter().map(|level| level.numbers.len()).sum();
        numbers * size_of::<T>()
    }

    fn is_mapped(&self) -> bool {
        matches!(self.levels[0].numbers, Buffer::OnDisk(_))
    }
}

impl<T: Stored> MipLevel<T> {
    /// The mean of the texels of this level that exist below a texel of the coarser `grid`.
    fn mean_of_children(&self, grid: TexelGrid, parent: TexelIndex, out: &mut [T]) {
        let (row, col) = grid.row_col(parent);
        let (rows, cols) = (self.grid.height, self.grid.width);
        let children: Vec<&[T]> = [(0, 0), (0, 1), (1, 0), (1, 1)]
            .into_iter()
            .map(|(down, right)| (2 * row + down, 2 * col + right))
            .filter(|&(row, col)| row < rows && col < cols)
            .map(|(row, col)| self.texel(self.grid.texel(row, col)))
            .collect();
        let scale = 1.0 / children.len() as f32;
        for (number, out) in out.iter_mut().enumerate() {
            let sum: f32 = children.iter().map(|child| child[number].value()).sum();
            *out = T::nearest(sum * scale);
        }
    }
}

impl Source<'_> {
    /// Numbers of a texel.
    fn stride(&self) -> usize {
        3 * self.layout.place(self.images.len())
    }

    /// Fills the numbers of the texels from `first` on, some images at a time.
    fn transpose<T: Stored>(&self, first: usize, out: &mut [T]) -> Result<()> {
        let stride = self.stride();
        let texels = first..first + out.len() / stride;
        let unread = Pixels::of_type(self.sample.description().dtype);
        let mut held = vec![unread; GROUP.min(self.images.len())];
        let mut groups = self.images.chunks(GROUP).enumerate().peekable();
        while let Some((group, images)) = groups.next() {
            if let Some((_, next)) = groups.peek() {
                self.sample.announce_texels_of(next, texels.clone());
            }
            self.sample
                .read_texels_of(images, texels.clone(), &mut held[..images.len()])?;
            for (block, out) in out.chunks_mut(BLOCK * stride).enumerate() {
                for (position, pixels) in held[..images.len()].iter().enumerate() {
                    let at = 3 * self.layout.place(group * GROUP + position);
                    put(pixels, block * BLOCK, out, stride, at).ok_or_else(|| self.fault())?;
                }
            }
        }
        if !self.layout.sums.is_empty() {
            out.chunks_exact_mut(stride)
                .for_each(|texel| self.layout.add_sums(texel));
        }
        Ok(())
    }

    /// Says which texel of the sample is not a radiance: the first of the first image.
    fn fault(&self) -> Error {
        let images = 0..self.sample.image_count();
        images
            .map(|image| {
                let pixels = self.sample.image(image)?;
                let mut values = vec![0.0; pixels.len()];
                pixels.copy_to(&mut values);
                self.sample.check_image(image, &values)
            })
            .find_map(Result::err)
            .unwrap_or_else(|| Error::data("radiance", "changed while it was read"))
    }
}

/// Puts an image's texels from `first` on to place `at` of each of `out`, `stride` numbers per texel;
/// `None` when one is no radiance.
fn put<T: Stored>(
    pixels: &Pixels,
    first: usize,
    out: &mut [T],
    stride: usize,
    at: usize,
) -> Option<()> {
    for (texel, out) in out.chunks_mut(stride).enumerate() {
        for channel in 0..3 {
            out[at + channel] = T::read(pixels, (first + texel) * 3 + channel)?;
        }
    }
    Some(())
}

/// Collects a level, in memory or in a temporary file.
struct LevelWriter<'a, T> {
    grid: TexelGrid,
    stride: usize,
    memory: Vec<T>,
    file: Option<(NamelessWriter, &'a Path)>,
}

impl<'a, T: Stored> LevelWriter<'a, T> {
    /// Nothing of a level yet; it goes to the disk of `folder` unless it shall stay in memory and there is some.
    fn new(grid: TexelGrid, stride: usize, folder: &'a Path, stays: bool) -> Result<Self> {
        let length = grid.len() * stride + 1;
        let mut writer = Self {
            grid,
            stride,
            memory: Vec::new(),
            file: None,
        };
        if stays && writer.memory.try_reserve_exact(length).is_ok() {
            return Ok(writer);
        }
        let file = NamelessWriter::create_in(folder)
            .map_err(Error::io(folder, "write the shading table to"))?;
        writer.file = Some((file, folder));
        Ok(writer)
    }

    /// Runs of texels to append one after the other.
    fn slabs(&self) -> Vec<Range<usize>> {
        let texels = self.grid.len();
        let each = match self.file {
            None => texels,
            Some(_) => (SLAB / (self.stride * size_of::<T>())).clamp(BLOCK, texels.max(BLOCK)),
        };
        (0..texels)
            .step_by(each)
            .map(|start| start..texels.min(start + each))
            .collect()
    }

    /// Appends the texels of a slab; `fill` is called for blocks of them, in parallel.
    fn append(
        &mut self,
        slab: Range<usize>,
        fill: impl Fn(Range<usize>, &mut [T]) -> Result<()> + Sync,
    ) -> Result<()> {
        let start = self.memory.len();
        let tasks = 4 * rayon::current_num_threads();
        let read = (slab.len() / tasks)
            .next_multiple_of(BLOCK)
            .clamp(BLOCK, READ);
        self.memory
            .resize(start + slab.len() * self.stride, T::zeroed());
        self.memory[start..]
            .par_chunks_mut(read * self.stride)
            .enumerate()
            .try_for_each(|(block, out)| {
                let first = slab.start + block * read;
                fill(first..first + out.len() / self.stride, out)
            })?;
        if let Some((file, folder)) = &mut self.file {
            file.write(&self.memory)
                .map_err(Error::io(folder, "write the shading table to"))?;
            self.memory.clear();
        }
        Ok(())
    }

    fn finish(mut self) -> Result<MipLevel<T>> {
        self.memory.push(T::zeroed());
        let numbers = match self.file {
            None => Buffer::Owned(self.memory),
            Some((mut file, folder)) => {
                let finished = file.write(&self.memory).and_then(|()| file.finish());
                Buffer::OnDisk(finished.map_err(Error::io(folder, "write the shading table to"))?)
            }
        };
        Ok(MipLevel {
            grid: self.grid,
            stride: self.stride,
            numbers,
        })
    }
}
