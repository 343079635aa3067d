//! A BTF sample on disk, `NAME.sample/`: `btf.json` describes, `radiance.npy` holds one image per (view, light) pair,
//! read in parts so that a sample larger than memory can be worked on. A [factored](crate::btf::factored) sample
//! holds factors instead; its images are expanded as they are asked for.
//!
//! Values are linear Rec. 709 radiance for a directional light of unit irradiance at normal
//! incidence (a white Lambertian plane has cos θ/π).

use std::ops::Range;
use std::path::{Path, PathBuf};

use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

pub use crate::btf::description::{
    DESCRIPTION, DType, Description, FORMAT, Layout, RADIANCE, VERSION, files_of,
};
use crate::btf::description::{DIRECTIONS, EIGENTEXTURES};
use crate::btf::factored::content_id;
use crate::btf::factored::factors::Factors;
use crate::btf::factored::products::Values;
use crate::btf::height_map::HeightMap;
use crate::btf::image_source::ImageSource;
use crate::error::{Error, Result};
use crate::format::atomic::folder::is_set_aside;
use crate::format::id::ContentId;
use crate::format::npy::{ArrayFile, Element};
use crate::format::{json, npy};
use crate::grid::TexelGrid;

#[derive(Debug)]
enum Radiance {
    F2(ArrayFile<f16>),
    F4(ArrayFile<f32>),
    Factored(Factors),
}

/// The numbers of one image or a part of it, as they are stored: row-major (height, width, RGB).
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// 16-bit floats.
    F2(Vec<f16>),
    /// 32-bit floats.
    F4(Vec<f32>),
}

impl Pixels {
    /// None yet, of a number type.
    pub fn of_type(dtype: DType) -> Self {
        match dtype {
            DType::F2 => Self::F2(Vec::new()),
            DType::F4 => Self::F4(Vec::new()),
        }
    }

    /// How many numbers.
    pub fn len(&self) -> usize {
        match self {
            Self::F2(values) => values.len(),
            Self::F4(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One number.
    #[inline]
    pub fn get(&self, index: usize) -> f32 {
        match self {
            Self::F2(values) => values[index].to_f32(),
            Self::F4(values) => values[index],
        }
    }

    /// Takes these numbers in place of what was held, in the number type of what was held.
    pub(in crate::btf) fn assign(&mut self, numbers: &[f32]) {
        match self {
            Self::F2(values) => {
                values.resize(numbers.len(), f16::ZERO);
                values.convert_from_f32_slice(numbers);
            }
            Self::F4(values) => {
                values.clear();
                values.extend_from_slice(numbers);
            }
        }
    }

    /// All numbers as `f32`, into a slice of the same length.
    pub fn copy_to(&self, out: &mut [f32]) {
        match self {
            Self::F2(values) => values.convert_to_f32_slice(out),
            Self::F4(values) => out.copy_from_slice(values),
        }
    }
}

/// A sample open for reading; its images stay on disk until they are asked for.
#[derive(Debug)]
pub struct Sample {
    path: PathBuf,
    description: Description,
    radiance: Radiance,
}

impl Sample {
    /// Opens a sample folder and checks that description and array belong together. The array's
    /// values and its hash are not read; `mesotex info` does that. Factors are read, and their values
    /// checked.
    pub fn open(path: &Path) -> Result<Self> {
        let description_path = path.join(DESCRIPTION);
        if !description_path.is_file() {
            let fault = Error::data("sample", format!("no {DESCRIPTION} in it"))
                .expected("a folder NAME.sample made by `mesotex bake` or `mesotex import`")
                .in_file(path);
            return Err(match is_set_aside(path) {
                true => fault.advice("a run was killed while it replaced it: `mesotex info` puts the earlier one back"),
                false => fault,
            });
        }
        let description: Description = json::read(&description_path)?;
        description
            .check()
            .map_err(|error| error.in_file(&description_path))?;
        let radiance = match description.factors() {
            Some(factors) => Radiance::Factored(Factors::open(path, &description, factors)?),
            None => open_radiance(&path.join(RADIANCE), &description)?,
        };
        Ok(Self {
            path: path.to_path_buf(),
            description,
            radiance,
        })
    }

    /// `btf.json`.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The texel grid of every image.
    pub fn grid(&self) -> TexelGrid {
        self.description.grid()
    }

    /// Images in all.
    pub fn image_count(&self) -> usize {
        self.description.image_count()
    }

    /// The id of the sample, as its description states it.
    pub fn id(&self) -> &ContentId {
        &self.description.id
    }

    /// The id of what the sample's arrays hold: all their bytes are read.
    pub fn content_id(&self) -> Result<ContentId> {
        let [directions, eigentextures, radiance] =
            [DIRECTIONS, EIGENTEXTURES, RADIANCE].map(|name| self.path.join(name));
        match self.description.factors() {
            Some(factors) => content_id::of_files(&directions, &eigentextures, &factors),
            None => ContentId::of_file(&radiance),
        }
    }

    /// How high the surface lies at every texel, where that is known. It is read and checked whenever it is asked for.
    pub fn heights(&self) -> Result<Option<HeightMap>> {
        HeightMap::read(&self.path, self.grid())
    }

    /// The factors of a factored sample.
    pub fn factors(&self) -> Option<&Factors> {
        match &self.radiance {
            Radiance::Factored(factors) => Some(factors),
            Radiance::F2(_) | Radiance::F4(_) => None,
        }
    }

    /// The numbers of one image, row-major (height, width, RGB).
    pub fn image(&self, image: usize) -> Result<Pixels> {
        let mut pixels = Pixels::of_type(self.description.dtype);
        self.read_texels(image, 0..self.grid().len(), &mut pixels)?;
        Ok(pixels)
    }

    /// The numbers of some texels of an image, row-major, in place of what `pixels` held.
    pub fn read_texels(
        &self,
        image: usize,
        texels: Range<usize>,
        pixels: &mut Pixels,
    ) -> Result<()> {
        self.read_texels_of(&[image as u32], texels, std::slice::from_mut(pixels))
    }

    /// The numbers of the same texels of several images, in place of what `pixels` held: one for each
    /// image. Of factored samples many images at once are cheaper than one by one.
    pub fn read_texels_of(
        &self,
        images: &[u32],
        texels: Range<usize>,
        pixels: &mut [Pixels],
    ) -> Result<()> {
        // Make the buffers of the sample's type.
        for pixels in pixels.iter_mut() {
            let is_half = matches!(pixels, Pixels::F2(_));
            if is_half != (self.description.dtype == DType::F2) {
                *pixels = Pixels::of_type(self.description.dtype);
            }
        }
        // Multiply factors for all images at once.
        if let Radiance::Factored(factors) = &self.radiance {
            let mut numbers = vec![0.0; images.len() * texels.len() * 3];
            factors.multiply(images, texels.clone(), Values::Radiance, &mut numbers);
            let parts = numbers.chunks_exact((texels.len() * 3).max(1));
            pixels
                .iter_mut()
                .zip(parts)
                .for_each(|(pixels, part)| pixels.assign(part));
            return Ok(());
        }
        // Read stored images one by one.
        for (&image, pixels) in images.iter().zip(pixels) {
            let first = (image as usize * self.grid().len() + texels.start) * 3;
            let count = texels.len() * 3;
            match (&self.radiance, pixels) {
                (Radiance::F2(file), Pixels::F2(numbers)) => fill(file, first, count, numbers)?,
                (Radiance::F4(file), Pixels::F4(numbers)) => fill(file, first, count, numbers)?,
                (Radiance::F2(_) | Radiance::F4(_) | Radiance::Factored(_), _) => {
                    unreachable!("pixels are of the sample's type")
                }
            }
        }
        Ok(())
    }

    /// Tells the system that these texels of several images will be read soon. Where each is a short piece of a large
    /// file that is not in memory, this is many times faster than to wait for one after the other.
    pub fn announce_texels_of(&self, images: &[u32], texels: Range<usize>) {
        let first = |image: u32| (image as usize * self.grid().len() + texels.start) * 3;
        let count = texels.len() * 3;
        for &image in images {
            match &self.radiance {
                Radiance::F2(file) => file.announce(first(image), count),
                Radiance::F4(file) => file.announce(first(image), count),
                Radiance::Factored(_) => {}
            }
        }
    }

    /// Checks that an image's values are finite and not negative; says which texel is not.
    pub fn check_image(&self, image: usize, values: &[f32]) -> Result<()> {
        // One pass without branches; the slow search runs only when something is wrong.
        let sound = |v: &f32| (0.0..f32::INFINITY).contains(v);
        if values.iter().all(sound) {
            return Ok(());
        }
        let at = values.iter().position(|v| !sound(v)).unwrap_or(0);
        let (view, light) = self.description.view_and_light(image);
        let (texel, channel) = (at / 3, at % 3);
        let (row, col) = (
            texel / self.grid().width as usize,
            texel % self.grid().width as usize,
        );
        Err(Error::data(
            format!("view {view}, light {light}, row {row}, column {col}, channel {channel}"),
            format!("radiance {}", values[at]),
        )
        .expected("finite and not negative")
        .in_file(&self.path.join(match self.factors() {
            Some(_) => EIGENTEXTURES,
            None => RADIANCE,
        })))
    }
}

/// Images of a factored sample read at once by one task.
const IMAGES_PER_TASK: usize = 8;

impl ImageSource for Sample {
    fn description(&self) -> &Description {
        &self.description
    }

    fn heights(&self) -> Result<Option<HeightMap>> {
        Sample::heights(self)
    }

    fn read_images(&self, images: Range<usize>, out: &mut [f32]) -> Result<()> {
        let image_length = self.grid().len() * 3;
        let numbers: Vec<u32> = images.map(|image| image as u32).collect();
        out.par_chunks_mut(IMAGES_PER_TASK * image_length)
            .zip(numbers.par_chunks(IMAGES_PER_TASK))
            .try_for_each(|(out, images)| {
                let mut held = vec![Pixels::of_type(self.description.dtype); images.len()];
                self.read_texels_of(images, 0..self.grid().len(), &mut held)?;
                let read = images.iter().zip(&held);
                read.zip(out.chunks_exact_mut(image_length)).try_for_each(
                    |((&image, pixels), out)| {
                        pixels.copy_to(out);
                        self.check_image(image as usize, out)
                    },
                )
            })
    }
}

fn open_radiance(path: &Path, description: &Description) -> Result<Radiance> {
    let header = npy::read_header(path)?;
    let expected = description.radiance_shape();
    if header.shape != expected {
        return Err(Error::data("shape", format!("{:?}", header.shape))
            .expected(format!("{expected:?}, as {DESCRIPTION} states"))
            .in_file(path));
    }
    Ok(match description.dtype {
        DType::F2 => Radiance::F2(ArrayFile::open(path)?),
        DType::F4 => Radiance::F4(ArrayFile::open(path)?),
    })
}

/// Reads `count` numbers from number `first` on.
fn fill<T: Element>(
    file: &ArrayFile<T>,
    first: usize,
    count: usize,
    numbers: &mut Vec<T>,
) -> Result<()> {
    numbers.resize(count, T::zeroed());
    file.read(first, numbers)
}
