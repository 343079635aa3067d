//! The factors of a sample in memory.
//!
//! In: `directions.npy` and `eigentextures.npy`, which a few megabytes hold where the images take gigabytes. They are
//! read when a sample is opened, and every number is checked then. Out: eigentextures as planes, and images
//! [expanded](super::products).

use std::path::Path;

use half::f16;
use half::slice::HalfFloatSliceExt;
use ndarray::{Array2, s};
use rayon::prelude::*;

use crate::btf::description::{DIRECTIONS, DType, Description, EIGENTEXTURES};
use crate::btf::factored::factorization::{CHANNELS, Factorization};
use crate::error::{Error, Result};
use crate::format::npy::{self, ArrayFile, Element};

/// The largest number of a factor.
pub const LARGEST_FACTOR: f32 = 1e12;

/// Texels whose eigentextures lie together: a run of each fills a few cache lines, and those of all
/// factors of a usual rank fit the second cache.
pub(super) const TILE: usize = 256;
/// Numbers read at once.
const READ: usize = 1 << 18;

/// The factors of a sample.
#[derive(Debug)]
pub struct Factors {
    /// What the description states about them.
    pub(super) factorization: Factorization,
    images: usize,
    texels: usize,
    /// [C, images, K].
    directions: Vec<f32>,
    /// [sets, tiles, K, TILE]; the last tile filled up with 0.
    pub(super) tiles: Vec<f32>,
}

impl Factors {
    /// Reads the factors of a sample's folder and checks that shapes fit and that numbers are finite.
    pub fn open(
        folder: &Path,
        description: &Description,
        factorization: Factorization,
    ) -> Result<Self> {
        let (images, texels) = (description.image_count(), description.grid().len());
        let [directions, eigentextures] = [DIRECTIONS, EIGENTEXTURES].map(|name| folder.join(name));
        let directions_shape = factorization.directions_shape(images);
        let eigentextures_shape = factorization.eigentextures_shape(texels);
        check_shape(&directions, &directions_shape)?;
        check_shape(&eigentextures, &eigentextures_shape)?;
        let directions = Numbers::open(&directions, description.dtype)?;
        let eigentextures = Numbers::open(&eigentextures, description.dtype)?;
        Ok(Self {
            factorization,
            images,
            texels,
            directions: read_all(&directions, &directions_shape)?,
            tiles: read_tiles(&eigentextures, &eigentextures_shape)?,
        })
    }

    /// Factors of every channel: directions [images, K] and eigentextures [texels, K].
    pub(super) fn of_arrays(
        factorization: Factorization,
        directions: &[Array2<f32>; CHANNELS],
        eigentextures: &[Array2<f32>; CHANNELS],
    ) -> Self {
        let rank = factorization.rank as usize;
        let [images, texels] = [directions, eigentextures].map(|arrays| arrays[0].nrows());
        let tiles = texels.div_ceil(TILE);
        let mut numbers = vec![0.0; CHANNELS * tiles * rank * TILE];
        for (at, tile) in numbers.chunks_exact_mut(rank * TILE).enumerate() {
            let first = at % tiles * TILE;
            let rows = first..texels.min(first + TILE);
            fill_tile(
                eigentextures[at / tiles].slice(s![rows, ..]).outer_iter(),
                tile,
            );
        }
        let rows = directions.iter().flat_map(|array| array.iter().copied());
        Self {
            factorization,
            images,
            texels,
            directions: rows.collect(),
            tiles: numbers,
        }
    }

    /// What the description states about them.
    pub fn factorization(&self) -> &Factorization {
        &self.factorization
    }

    /// Eigentextures per channel.
    pub fn rank(&self) -> usize {
        self.factorization.rank as usize
    }

    /// Bytes the factors take in memory.
    pub fn bytes(&self) -> u64 {
        4 * (self.directions.len() + self.tiles.len()) as u64
    }

    /// The factors of one channel of an image.
    pub fn direction(&self, channel: usize, image: usize) -> &[f32] {
        let row = (channel * self.images + image) * self.rank();
        &self.directions[row..row + self.rank()]
    }

    /// Copies one eigentexture of a set, a number per texel.
    pub fn copy_eigentexture(&self, set: usize, factor: usize, plane: &mut [f32]) {
        let tiles = self.set(set).chunks_exact(self.rank() * TILE);
        for (part, tile) in plane.chunks_mut(TILE).zip(tiles) {
            part.copy_from_slice(&tile[factor * TILE..][..part.len()]);
        }
    }

    /// The tiles of one set of eigentextures.
    pub(super) fn set(&self, set: usize) -> &[f32] {
        let length = self.tiles.len() / self.factorization.sets();
        &self.tiles[set * length..(set + 1) * length]
    }

    /// How many images and texels.
    pub fn sides(&self) -> [usize; 2] {
        [self.images, self.texels]
    }
}

fn check_shape(path: &Path, expected: &[usize]) -> Result<()> {
    let header = npy::read_header(path)?;
    match header.shape == expected {
        true => Ok(()),
        false => Err(Error::data("shape", format!("{:?}", header.shape))
            .expected(format!("{expected:?}, as btf.json states"))
            .in_file(path)),
    }
}

/// An array of either number type.
enum Numbers {
    F2(ArrayFile<f16>),
    F4(ArrayFile<f32>),
}

impl Numbers {
    fn open(path: &Path, dtype: DType) -> Result<Self> {
        Ok(match dtype {
            DType::F2 => Self::F2(ArrayFile::open(path)?),
            DType::F4 => Self::F4(ArrayFile::open(path)?),
        })
    }

    /// Fills `out` from number `first` on; refuses what no factor can be, by its place in `shape`.
    fn read(&self, first: usize, shape: &[usize], out: &mut [f32]) -> Result<()> {
        match self {
            Self::F2(file) => {
                let mut halves = vec![f16::ZERO; out.len()];
                file.read(first, &mut halves)?;
                halves.convert_to_f32_slice(out);
                check_numbers(file, first, shape, out)
            }
            Self::F4(file) => {
                file.read(first, out)?;
                check_numbers(file, first, shape, out)
            }
        }
    }
}

fn check_numbers<T: Element>(
    file: &ArrayFile<T>,
    first: usize,
    shape: &[usize],
    numbers: &[f32],
) -> Result<()> {
    let sound = |number: &f32| number.abs() <= LARGEST_FACTOR;
    let Some(at) = numbers.iter().position(|number| !sound(number)) else {
        return Ok(());
    };
    Err(unsound(first + at, shape, numbers[at]).in_file(file.path()))
}

/// Says where in an array [channels, rows, K] a number stands that no factor can be.
pub(super) fn unsound(flat: usize, shape: &[usize], number: f32) -> Error {
    let (rows, rank) = (shape[1], shape[2]);
    let place = [flat / rank / rows, flat / rank % rows, flat % rank];
    Error::data(format!("{place:?}"), number.to_string()).expected(format!(
        "numbers from −{LARGEST_FACTOR:e} to {LARGEST_FACTOR:e}"
    ))
}

/// Room for numbers, or an error that says how much was asked for.
fn zeros(count: usize) -> Result<Vec<f32>> {
    let mut numbers = Vec::new();
    numbers.try_reserve_exact(count).map_err(|error| {
        Error::data(
            "factors",
            format!("no memory for {count} numbers of 4 bytes: {error}"),
        )
    })?;
    numbers.resize(count, 0.0);
    Ok(numbers)
}

fn read_all(array: &Numbers, shape: &[usize]) -> Result<Vec<f32>> {
    let mut numbers = zeros(shape.iter().product())?;
    let parts = numbers.par_chunks_mut(READ).enumerate();
    parts.try_for_each(|(part, numbers)| array.read(part * READ, shape, numbers))?;
    Ok(numbers)
}

/// Eigentextures [sets, texels, K] as tiles.
fn read_tiles(array: &Numbers, shape: &[usize]) -> Result<Vec<f32>> {
    let &[sets, texels, rank] = shape else {
        unreachable!("eigentextures have three sides");
    };
    let tiles = texels.div_ceil(TILE);
    let mut numbers = zeros(sets * tiles * rank * TILE)?;
    numbers
        .par_chunks_mut(rank * TILE)
        .enumerate()
        .try_for_each_init(Vec::new, |rows, (at, tile)| {
            let (set, first) = (at / tiles, at % tiles * TILE);
            let count = TILE.min(texels - first);
            rows.resize(count * rank, 0.0);
            array.read((set * texels + first) * rank, shape, rows)?;
            fill_tile(rows.chunks_exact(rank), tile);
            Ok(())
        })?;
    Ok(numbers)
}

/// Puts texels' numbers, K of each, into a tile [K, TILE].
fn fill_tile<'a, Row>(rows: impl Iterator<Item = Row>, tile: &mut [f32])
where
    Row: IntoIterator<Item = &'a f32>,
{
    for (texel, row) in rows.enumerate() {
        for (factor, &number) in row.into_iter().enumerate() {
            tile[factor * TILE + texel] = number;
        }
    }
}

/// Which set of eigentextures a channel takes.
pub(super) fn set_of(factorization: &Factorization, channel: usize) -> usize {
    channel.min(factorization.sets() - 1).min(CHANNELS - 1)
}
