//! Photographs of a patch, rectified: four corner points per picture say where the patch lies in it, and its texels
//! are means of what they cover there.
//!
//! The plane of the patch and that of an ideal picture are related by a [`homography`], found from the four points. A
//! [`lens`] that bends lines is accounted for. [`resampling`] takes the means, of linear numbers; [`corners`] reads
//! the points.

mod corners;
mod homography;
mod lens;
mod resampling;

use std::path::{Path, PathBuf};

use crate::btf::import::photographs::corners::Corners;
use crate::btf::import::photographs::homography::Homography;
use crate::btf::import::photographs::lens::Lens;
pub use crate::btf::import::photographs::lens::LensOptions;
use crate::error::{Error, Result};
use crate::format::image::FloatImage;

/// The most texels of a side.
const MOST_SIDE: u32 = 16384;

/// How photographs become images of the patch alone.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub struct PhotographOptions {
    /// The images are photographs of a patch, and this table locates its corners in each. Its columns are file, x1, y1,
    /// … x4, y4: top left, top right, bottom right, bottom left, in pixels from the left and top border of the picture;
    /// (0.5, 0.5) is the middle of the first pixel.
    #[arg(long, value_name = "FILE.csv")]
    pub corners: Option<PathBuf>,
    /// Size of the rectified patch in texels: N for both sides, or WxH. [default: as many as the longest sides of the
    /// patch have pixels]
    #[arg(long, value_name = "N|WxH", value_parser = parse_size)]
    pub size: Option<(u32, u32)>,
    /// The lens that took the photographs.
    #[command(flatten)]
    pub lens: LensOptions,
}

/// `128` or `128x96`.
fn parse_size(text: &str) -> std::result::Result<(u32, u32), String> {
    let side = |text: &str| {
        text.parse()
            .ok()
            .filter(|side| (1..=MOST_SIDE).contains(side))
    };
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    match (side(width), side(height)) {
        (Some(width), Some(height)) => Ok((width, height)),
        _ => Err(format!("expected N or WxH, sides from 1 to {MOST_SIDE}")),
    }
}

impl PhotographOptions {
    /// Refuses options that only corners give a meaning.
    pub fn check(&self) -> Result<()> {
        self.lens.check()?;
        let alone = [
            ("size", self.size.is_some()),
            ("distortion", self.lens.is_given()),
        ];
        match alone
            .iter()
            .find(|(_, is_given)| *is_given && self.corners.is_none())
        {
            None => Ok(()),
            Some((option, _)) => Err(Error::option(
                *option,
                "given without --corners",
                "photographs, whose corners --corners lists",
            )),
        }
    }

    /// Reads the corners and finds the size of the patch; `None` where the images are rectified already.
    pub fn rectification(&self) -> Result<Option<Rectification>> {
        self.check()?;
        let Some(path) = &self.corners else {
            return Ok(None);
        };
        let corners = Corners::read(path)?;
        let size = self
            .size
            .unwrap_or_else(|| corners.longest_sides(MOST_SIDE));
        Ok(Some(Rectification {
            corners,
            size,
            lens: self.lens.clone(),
        }))
    }
}

/// Where the patch lies in each photograph, and how many texels it gets.
#[derive(Clone, Debug, PartialEq)]
pub struct Rectification {
    corners: Corners,
    /// Columns and rows.
    size: (u32, u32),
    lens: LensOptions,
}

impl Rectification {
    /// Columns and rows of rectified images.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Refuses a list of images some of which have no corners; all are named.
    pub fn check(&self, images: &[&Path]) -> Result<()> {
        self.corners.check(images)
    }

    /// The patch of a photograph with linear numbers.
    pub fn rectify(&self, path: &Path, photograph: &FloatImage) -> Result<FloatImage> {
        let corners = self.corners.of(path)?;
        let (width, height) = (photograph.width, photograph.height);
        let inside = |[x, y]: [f64; 2]| {
            (0.0..=f64::from(width)).contains(&x) && (0.0..=f64::from(height)).contains(&y)
        };
        if let Some(at) = corners.iter().position(|&corner| !inside(corner)) {
            let [x, y] = corners[at];
            return Err(
                Error::data(format!("corner {}", at + 1), format!("({x}, {y})"))
                    .expected(format!(
                        "a point in the picture of {width} × {height} pixels"
                    ))
                    .in_file(path),
            );
        }
        let lens = Lens::new(&self.lens, (width, height));
        let ideal = corners.map(|corner| lens.undistorted(corner));
        let homography = Homography::from_unit_square(ideal).ok_or_else(|| {
            Error::data("corners", format!("{corners:?}"))
                .expected("a convex quadrilateral: top left, top right, bottom right, bottom left")
                .in_file(path)
        })?;
        Ok(resampling::resample(photograph, self.size, |point| {
            lens.distorted(homography.apply(point))
        }))
    }
}

#[cfg(test)]
mod tests;
