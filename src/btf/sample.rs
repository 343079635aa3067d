//! A BTF sample on disk, `NAME.sample/`: `btf.json` describes, `radiance.npy` holds one image per
//! (view, light) pair, read in parts so that a sample larger than memory can be worked on.
//!
//! Values are linear Rec. 709 radiance for a directional light of unit irradiance at normal
//! incidence (a white Lambertian plane has cos θ/π).

use std::ops::Range;
use std::path::{Path, PathBuf};

use half::f16;
use half::slice::HalfFloatSliceExt;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::btf::direction::Direction;
use crate::error::{Error, Result};
use crate::format::atomic::folder::is_set_aside;
use crate::format::id::ContentId;
use crate::format::npy::{ArrayFile, Element};
use crate::format::{json, npy};
use crate::grid::TexelGrid;

/// The description in a sample's folder.
pub const DESCRIPTION: &str = "btf.json";
/// The array in a sample's folder.
pub const RADIANCE: &str = "radiance.npy";
/// The files of a sample's folder.
pub fn files_of(folder: &Path) -> [PathBuf; 2] {
    [DESCRIPTION, RADIANCE].map(|name| folder.join(name))
}

/// `format` of every `btf.json`.
pub const FORMAT: &str = "mesotex-btf";
/// The version written, and the only one read.
pub const VERSION: u32 = 1;

/// Number type of `radiance.npy`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
pub enum DType {
    /// 16-bit floats.
    #[default]
    #[serde(rename = "f2")]
    #[value(name = "f2")]
    F2,
    /// 32-bit floats.
    #[serde(rename = "f4")]
    #[value(name = "f4")]
    F4,
}

impl DType {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            Self::F2 => 2,
            Self::F4 => 4,
        }
    }
}

/// How views and lights combine to images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// Every view with every light: image v·L + l.
    Product,
    /// A list of (view, light) pairs: image p.
    Pairs,
}

/// `btf.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// Always [`FORMAT`].
    pub format: String,
    /// Always [`VERSION`].
    pub version: u32,
    /// What the material is called.
    pub name: String,
    /// Columns of the texel grid.
    pub width: u32,
    /// Rows of the texel grid.
    pub height: u32,
    /// Always 3: linear Rec. 709 R, G, B.
    pub channels: u32,
    /// Number type of `radiance.npy`.
    pub dtype: DType,
    /// Side of a texel in millimetres, where known.
    pub texel_mm: Option<f64>,
    /// How views and lights combine.
    pub layout: Layout,
    /// View directions.
    pub views: Vec<Direction>,
    /// Light directions.
    pub lights: Vec<Direction>,
    /// (view, light) indices of each image; layout `pairs` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pairs: Option<Vec<[u32; 2]>>,
    /// Whether opposite borders of the images continue each other.
    pub tileable: bool,
    /// BLAKE3 of `radiance.npy`.
    pub id: ContentId,
    /// Where the sample comes from; free.
    #[serde(default)]
    pub source: Value,
}

impl Description {
    /// Images in all.
    pub fn image_count(&self) -> usize {
        match &self.pairs {
            Some(pairs) => pairs.len(),
            None => self.views.len() * self.lights.len(),
        }
    }

    /// The texel grid of every image.
    pub fn grid(&self) -> TexelGrid {
        TexelGrid {
            width: self.width,
            height: self.height,
            tileable: self.tileable,
        }
    }

    /// Sides of `radiance.npy`: [V, L, H, W, C], or [P, H, W, C] for pairs.
    pub fn radiance_shape(&self) -> Vec<usize> {
        let image = [
            self.height as usize,
            self.width as usize,
            self.channels as usize,
        ];
        let mut shape = match &self.pairs {
            Some(pairs) => vec![pairs.len()],
            None => vec![self.views.len(), self.lights.len()],
        };
        shape.extend(image);
        shape
    }

    /// The view and the light of an image.
    pub fn view_and_light(&self, image: usize) -> (usize, usize) {
        match &self.pairs {
            Some(pairs) => (pairs[image][0] as usize, pairs[image][1] as usize),
            None => (image / self.lights.len(), image % self.lights.len()),
        }
    }

    /// Refuses a description that no sample can have.
    pub fn check(&self) -> Result<()> {
        if self.format != FORMAT {
            return Err(Error::data("format", format!("`{}`", self.format)).expected(FORMAT));
        }
        if self.version != VERSION {
            return Err(Error::data("version", self.version.to_string())
                .expected(VERSION.to_string())
                .advice("the sample was written by another version of mesotex; make it again"));
        }
        if self.channels != 3 {
            return Err(Error::data("channels", self.channels.to_string()).expected("3"));
        }
        if u64::from(self.width) * u64::from(self.height) > u64::from(u32::MAX) {
            return Err(Error::data(
                "width × height",
                format!("{} × {}", self.width, self.height),
            )
            .expected("fewer than 2^32 texels"));
        }
        for (field, count) in [
            ("width", self.width as usize),
            ("height", self.height as usize),
            ("views", self.views.len()),
            ("lights", self.lights.len()),
            ("images", self.image_count()),
        ] {
            if count == 0 {
                return Err(Error::data(field, "0").expected("at least 1"));
            }
        }
        if self
            .texel_mm
            .is_some_and(|mm| !(mm > 0.0 && mm.is_finite()))
        {
            return Err(Error::data("texel_mm", format!("{:?}", self.texel_mm)).expected("> 0"));
        }
        for (kind, directions) in [("views", &self.views), ("lights", &self.lights)] {
            for (index, direction) in directions.iter().enumerate() {
                direction.check(&format!("{kind}[{index}]"))?;
            }
        }
        self.check_pairs()
    }

    fn check_pairs(&self) -> Result<()> {
        let Some(pairs) = &self.pairs else {
            return match self.layout {
                Layout::Product => Ok(()),
                Layout::Pairs => Err(Error::data("pairs", "missing").expected("a list of pairs")),
            };
        };
        if self.layout == Layout::Product {
            return Err(Error::data("pairs", "a list").expected("none with layout `product`"));
        }
        for (index, &[view, light]) in pairs.iter().enumerate() {
            if view as usize >= self.views.len() || light as usize >= self.lights.len() {
                return Err(
                    Error::data(format!("pairs[{index}]"), format!("[{view}, {light}]")).expected(
                        format!(
                            "indices below {} views and {} lights",
                            self.views.len(),
                            self.lights.len()
                        ),
                    ),
                );
            }
        }
        Ok(())
    }
}

#[derive(Debug)]
enum Radiance {
    F2(ArrayFile<f16>),
    F4(ArrayFile<f32>),
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
    /// values and its hash are not read; `mesotex info` does that.
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
        let radiance_path = path.join(RADIANCE);
        let header = npy::read_header(&radiance_path)?;
        let expected = description.radiance_shape();
        if header.shape != expected {
            return Err(Error::data("shape", format!("{:?}", header.shape))
                .expected(format!("{expected:?}, as {DESCRIPTION} says"))
                .in_file(&radiance_path));
        }
        let radiance = match description.dtype {
            DType::F2 => Radiance::F2(ArrayFile::open(&radiance_path)?),
            DType::F4 => Radiance::F4(ArrayFile::open(&radiance_path)?),
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

    /// The id of the radiance array.
    pub fn id(&self) -> &ContentId {
        &self.description.id
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
        let channels = self.description.channels as usize;
        let first = (image * self.grid().len() + texels.start) * channels;
        let count = texels.len() * channels;
        match (&self.radiance, &mut *pixels) {
            (Radiance::F2(file), Pixels::F2(numbers)) => fill(file, first, count, numbers),
            (Radiance::F4(file), Pixels::F4(numbers)) => fill(file, first, count, numbers),
            (Radiance::F2(_) | Radiance::F4(_), _) => {
                *pixels = Pixels::of_type(self.description.dtype);
                self.read_texels(image, texels, pixels)
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
        .in_file(&self.path.join(RADIANCE)))
    }
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
