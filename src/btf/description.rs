//! `btf.json`: what a sample's arrays hold.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::btf::direction::Direction;
use crate::btf::factored::factorization::Factorization;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::grid::TexelGrid;

/// The description in a sample's folder.
pub const DESCRIPTION: &str = "btf.json";
/// The array in a sample's folder.
pub const RADIANCE: &str = "radiance.npy";
/// The directions' array in a factored sample's folder.
pub const DIRECTIONS: &str = "directions.npy";
/// The eigentextures' array in a factored sample's folder.
pub const EIGENTEXTURES: &str = "eigentextures.npy";
/// The heights' array in a sample's folder, where the sample has heights.
pub const HEIGHTS: &str = "height.npy";
/// All arrays that a sample's folder may hold.
pub const ARRAYS: [&str; 4] = [RADIANCE, DIRECTIONS, EIGENTEXTURES, HEIGHTS];

/// The files of a sample's folder: the description, and the arrays that are there.
pub fn files_of(folder: &Path) -> Vec<PathBuf> {
    let arrays = ARRAYS.map(|name| folder.join(name));
    let arrays = arrays.into_iter().filter(|path| path.is_file());
    std::iter::once(folder.join(DESCRIPTION))
        .chain(arrays)
        .collect()
}

/// `format` of every `btf.json`.
pub const FORMAT: &str = "mesotex-btf";
/// The version written, and the only one read.
pub const VERSION: u32 = 1;

/// Number type of a sample's arrays.
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

/// How views and lights combine to images, and how these are stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "layout", rename_all = "lowercase")]
pub enum Layout {
    /// Every view with every light: image v·L + l.
    Product,
    /// A list of (view, light) pairs: image p.
    Pairs,
    /// Either, with the images as products of factors.
    Factored(Factorization),
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
    /// Number type of the arrays.
    pub dtype: DType,
    /// Side of a texel in millimetres, where known.
    pub texel_mm: Option<f64>,
    /// How views and lights combine; the fields of [`Factorization`] beside it where images are factored.
    #[serde(flatten)]
    pub layout: Layout,
    /// View directions.
    pub views: Vec<Direction>,
    /// Light directions.
    pub lights: Vec<Direction>,
    /// (view, light) indices of each image; layout `pairs`, or `factored` where images are no product.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pairs: Option<Vec<[u32; 2]>>,
    /// Whether opposite borders of the images continue each other.
    pub tileable: bool,
    /// BLAKE3 of `radiance.npy`, or of the [factors](Factorization).
    pub id: ContentId,
    /// Where the sample comes from; free.
    #[serde(default)]
    pub source: Value,
}

impl Description {
    /// A sample of all pairs of some views and lights, `[width, height]` texels large: in 32-bit floats, not tileable,
    /// of unknown scale and origin. The writer of its images sets the id.
    pub fn product(
        name: impl Into<String>,
        [width, height]: [u32; 2],
        views: Vec<Direction>,
        lights: Vec<Direction>,
    ) -> Self {
        Self {
            format: FORMAT.into(),
            version: VERSION,
            name: name.into(),
            width,
            height,
            channels: 3,
            dtype: DType::F4,
            texel_mm: None,
            layout: Layout::Product,
            views,
            lights,
            pairs: None,
            tileable: false,
            id: ContentId::of_bytes(b""),
            source: Value::Null,
        }
    }

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

    /// How factors make images; none where images are stored whole.
    pub fn factors(&self) -> Option<Factorization> {
        match self.layout {
            Layout::Product | Layout::Pairs => None,
            Layout::Factored(factors) => Some(factors),
        }
    }

    /// The same images, stored whole.
    #[must_use]
    pub fn with_whole_images(self) -> Self {
        let layout = match self.pairs {
            Some(_) => Layout::Pairs,
            None => Layout::Product,
        };
        Self { layout, ..self }
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
        // Check what the file is.
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
        // Check sizes and counts.
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
        // Check the directions and what refers to them.
        for (kind, directions) in [("views", &self.views), ("lights", &self.lights)] {
            for (index, direction) in directions.iter().enumerate() {
                direction.check(&format!("{kind}[{index}]"))?;
            }
        }
        self.check_pairs()?;
        self.check_factors()
    }

    fn check_factors(&self) -> Result<()> {
        match self.factors() {
            None => Ok(()),
            Some(factors) => factors.check(self.image_count(), self.grid().len()),
        }
    }

    fn check_pairs(&self) -> Result<()> {
        let Some(pairs) = &self.pairs else {
            return match self.layout {
                Layout::Product | Layout::Factored(_) => Ok(()),
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
