//! What happens to each picture between its file and the sample: hot pixels, grey card, rectification, crop,
//! downsampling.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`region`] | a rectangle of an image |
//! | [`hot_pixels`] | pixels that are bright in every picture |
//! | [`grey_card`] | exposure and white balance |
//! | [`downsample`] | means of blocks |
//! | [`selection`] | which directions are kept |

mod downsample;
mod grey_card;
mod hot_pixels;
mod region;
mod selection;

use serde::Serialize;

pub use crate::btf::import::prepare::grey_card::GreyCard;
pub use crate::btf::import::prepare::region::Region;
pub use crate::btf::import::prepare::selection::Selection;

use crate::btf::import::image_list::MeasuredImage;
use crate::btf::import::photographs::Rectification;
use crate::btf::import::prepare::downsample::{cropped, downsampled};
use crate::btf::import::prepare::hot_pixels::{Counts, FEWEST_PICTURES, HotPixels, MOST_PICTURES};
use crate::error::{Error, Result};
use crate::format::image::FloatImage;

/// How the pictures of a set are prepared, and which are used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, clap::Args)]
#[serde(rename_all = "kebab-case")]
pub struct Preparation {
    /// The part of every image that is used, in pixels from the top left corner, as 256x256+40+60.
    #[arg(long, value_name = "WxH+X+Y")]
    pub crop: Option<Region>,
    /// Average blocks of N × N pixels to one texel.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub downsample: Option<u32>,
    /// Views that are used: numbers from 0 and ranges, as 0,4-11, or theta:60 in degrees.
    #[arg(long, value_name = "VIEWS")]
    pub keep_views: Option<Selection>,
    /// Lights that are used, in the form of --keep-views.
    #[arg(long, value_name = "LIGHTS")]
    pub keep_lights: Option<Selection>,
    /// A grey card in the plane of the patch: its rectangle, and its reflectance (0.18). It sets exposure and white
    /// balance of every image.
    #[arg(long, value_name = "WxH+X+Y[:R]")]
    pub grey_card: Option<GreyCard>,
    /// Replace pixels that are more than FACTOR times as bright as each neighbour in three of four images; for images
    /// of a fixed camera. [default without FACTOR: 3]
    #[arg(long, value_name = "FACTOR", num_args = 0..=1, default_missing_value = "3")]
    pub hot_pixels: Option<f32>,
    /// Interpolate missing images from those of the nearest directions, and mark them in btf.json.
    #[arg(long)]
    pub fill: bool,
    /// Import the images as scattered pairs of view and light if some are missing.
    #[arg(long, conflicts_with = "fill")]
    pub scattered: bool,
}

impl Preparation {
    /// The flag of an option that was given, if any was.
    pub fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.crop.is_some(), "crop"),
            (self.downsample.is_some(), "downsample"),
            (self.keep_views.is_some(), "keep-views"),
            (self.keep_lights.is_some(), "keep-lights"),
            (self.grey_card.is_some(), "grey-card"),
            (self.hot_pixels.is_some(), "hot-pixels"),
            (self.fill, "fill"),
            (self.scattered, "scattered"),
        ];
        flags
            .into_iter()
            .find(|(is_given, _)| *is_given)
            .map(|(_, flag)| flag)
    }

    /// Refuses numbers that no picture could satisfy.
    pub(super) fn check(&self) -> Result<()> {
        if self.downsample == Some(0) {
            return Err(Error::option("downsample", "0", "1 or more"));
        }
        match self.hot_pixels {
            Some(factor) if !(factor > 1.0 && factor.is_finite()) => Err(Error::option(
                "hot-pixels",
                factor.to_string(),
                "a number above 1",
            )),
            _ => Ok(()),
        }
    }

    /// Pixels of an image per side of a texel.
    pub(super) fn pixels_per_texel(&self) -> u32 {
        self.downsample.unwrap_or(1)
    }
}

/// The steps from a picture to a sample's image.
#[derive(Debug)]
pub(super) struct Steps<'a> {
    preparation: &'a Preparation,
    hot_pixels: HotPixels,
    rectification: Option<&'a Rectification>,
}

impl<'a> Steps<'a> {
    /// Looks for hot pixels where they are to be replaced: `read` reads one of `count` pictures.
    pub(super) fn new(
        preparation: &'a Preparation,
        rectification: Option<&'a Rectification>,
        count: usize,
        read: impl Fn(usize) -> Result<FloatImage>,
    ) -> Result<Self> {
        let hot_pixels = match preparation.hot_pixels {
            Some(factor) => find_hot_pixels(factor, count, read)?,
            None => HotPixels::default(),
        };
        Ok(Self {
            preparation,
            hot_pixels,
            rectification,
        })
    }

    /// How many hot pixels there are; `None` where they are not looked for.
    pub(super) fn hot_pixels(&self) -> Option<usize> {
        let is_asked = self.preparation.hot_pixels.is_some();
        is_asked.then_some(self.hot_pixels.texels.len())
    }

    /// Takes a picture through all steps.
    pub(super) fn apply(
        &self,
        mut image: FloatImage,
        measured: &MeasuredImage,
    ) -> Result<FloatImage> {
        self.hot_pixels.mend(&mut image);
        if let Some(card) = &self.preparation.grey_card {
            card.balance(&mut image, measured.light)?;
        }
        if let Some(rectification) = self.rectification {
            image = rectification.rectify(&measured.path, &image)?;
        }
        if let Some(region) = self.preparation.crop {
            image = cropped(&image, region)?;
        }
        match self.preparation.pixels_per_texel() {
            1 => Ok(image),
            block => downsampled(&image, block),
        }
    }
}

/// The places of the pictures, spread evenly over a set of `count`, that are looked at for hot pixels.
pub(super) fn inspected(count: usize) -> impl Iterator<Item = usize> {
    let most = count.min(MOST_PICTURES);
    (0..most).map(move |picture| picture * count / most)
}

/// Looks at pictures spread over the set, all of the first one's size.
fn find_hot_pixels(
    factor: f32,
    count: usize,
    read: impl Fn(usize) -> Result<FloatImage>,
) -> Result<HotPixels> {
    if count < FEWEST_PICTURES {
        return Err(Error::option(
            "hot-pixels",
            format!("a set of {count} pictures"),
            format!("at least {FEWEST_PICTURES}, to distinguish hot pixels from highlights"),
        ));
    }
    let mut counts: Option<(u32, u32, Counts)> = None;
    for picture in inspected(count) {
        let image = read(picture)?;
        let (width, height, counts) = counts.get_or_insert_with(|| {
            let counts = Counts::new(image.width, image.height, factor);
            (image.width, image.height, counts)
        });
        if (*width, *height) == (image.width, image.height) {
            counts.add(&image);
        }
    }
    Ok(counts.map_or_else(HotPixels::default, |(_, _, counts)| counts.hot()))
}
