//! What a user may choose in texton analysis, and what is refused before work begins.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::btf::sample::Sample;
use crate::byte_size::ByteSize;
use crate::error::{Error, Result};
use crate::grid::TexelGrid;

/// The paper's number of textons and of representative images (Tong 2002 §4).
const PAPER_COUNT: u32 = 400;
/// Textons a coarser level has at least: with the handful that quarters leave, most neighbourhoods of
/// the coarsest level are equal, and synthesis settles on a corner of the sample.
const LEAST_COARSE_TEXTONS: u32 = 64;
/// Labels are 16 bits and 65535 means none.
const MOST_TEXTONS: u32 = 65_534;

/// Options of texton analysis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct TextonOptions {
    /// Textons at the finest level. Each coarser level has about a quarter as many, but at least 64 if the finest has
    /// 64 or more (Tong 2002: 400).
    #[arg(long, default_value_t = Self::default().textons, value_name = "N")]
    pub textons: u32,
    /// Representative images, or `all`. [default: 400; all if the sample has fewer or is factored]
    #[arg(long, value_name = "N|all")]
    pub images: Option<ImageCount>,
    /// Pyramid levels, the finest included.
    #[arg(long, default_value_t = Self::default().levels, value_name = "N")]
    pub levels: u32,
    /// Filter Rec. 709 luminance instead of R, G and B.
    #[arg(long)]
    pub luminance: bool,
    /// Treat the sample as not tileable, even if it states that it is; borders are continued by reflection.
    #[arg(long)]
    pub no_tile: bool,
    /// Runs of K-means from other seeds; the best is kept.
    #[arg(long, default_value_t = Self::default().restarts, value_name = "N")]
    pub restarts: u32,
    /// Most Lloyd steps. If K-means needs more, some labels are not those of the nearest texton.
    #[arg(long, default_value_t = Self::default().max_iterations, value_name = "N")]
    pub max_iterations: u32,
    /// Rows and columns of the sub-grid at which images are compared to choose representatives.
    #[arg(long, default_value_t = Self::default().image_grid, value_name = "N")]
    pub image_grid: u32,
    /// Memory to work in, as `3GiB` or `800MiB`. [default: a quarter of the machine's]
    #[arg(long, value_name = "SIZE")]
    pub memory: Option<ByteSize>,
    /// Seed of everything drawn at random.
    #[arg(skip)]
    pub seed: u64,
}

impl Default for TextonOptions {
    fn default() -> Self {
        Self {
            textons: PAPER_COUNT,
            images: None,
            levels: 4,
            luminance: false,
            no_tile: false,
            restarts: 1,
            max_iterations: 1000,
            image_grid: 8,
            memory: None,
            seed: 0,
        }
    }
}

impl TextonOptions {
    /// Refuses numbers no analysis can have.
    pub fn validate(&self) -> Result<()> {
        let within = |name: &str, value: u32, least: u32, most: u32| {
            if (least..=most).contains(&value) {
                Ok(())
            } else {
                Err(Error::option(
                    name,
                    value.to_string(),
                    format!("{least} to {most}"),
                ))
            }
        };
        within("textons", self.textons, 1, MOST_TEXTONS)?;
        within("levels", self.levels, 1, 16)?;
        within("restarts", self.restarts, 1, 10_000)?;
        within("max-iterations", self.max_iterations, 1, u32::MAX)?;
        within("image-grid", self.image_grid, 1, 64)?;
        if self.images == Some(ImageCount::Count(0)) {
            return Err(Error::option("images", "0", "at least 1, or `all`"));
        }
        Ok(())
    }

    /// How many representative images a sample gives.
    pub fn image_count(&self, sample: &Sample) -> Result<usize> {
        let held = sample.image_count();
        match self.images {
            None if sample.factors().is_some() => Ok(held),
            Some(ImageCount::Count(count)) if count as usize > held => Err(Error::option(
                "images",
                format!("{count} of a sample of {held} images"),
                format!("at most {held}, or `all`"),
            )),
            _ => Ok(self.chosen_of(held)),
        }
    }

    /// How many representative images are taken of this many, at most all of them.
    pub fn chosen_of(&self, held: usize) -> usize {
        match self.images {
            None => held.min(PAPER_COUNT as usize),
            Some(ImageCount::Named(Named::All)) => held,
            Some(ImageCount::Count(count)) => held.min(count as usize),
        }
    }

    /// Textons at a level: about a quarter of those of the level below (Tong 2002 §5.1), but no fewer
    /// than [`LEAST_COARSE_TEXTONS`] where the finest has as many.
    pub fn textons_at(&self, level: usize) -> usize {
        let quarter = 4_f64.powi(level as i32);
        let least = LEAST_COARSE_TEXTONS.min(self.textons);
        ((f64::from(self.textons) / quarter).round() as usize).max(least as usize)
    }

    /// The texel grids of all levels, finest first.
    pub fn grids(&self, sample: &Sample) -> Result<Vec<TexelGrid>> {
        let mut grid = sample.grid();
        grid.tileable &= !self.no_tile;
        let multiple = 1_u32 << (self.levels - 1);
        if grid.tileable
            && !(grid.width.is_multiple_of(multiple) && grid.height.is_multiple_of(multiple))
        {
            return Err(Error::option(
                "levels",
                format!(
                    "{} with a tileable sample of {} × {} texels",
                    self.levels, grid.width, grid.height
                ),
                format!("sides divisible by {multiple}: fewer --levels, or --no-tile"),
            ));
        }
        let mut grids = vec![grid];
        while grids.len() < self.levels as usize {
            if grid.len() == 1 {
                return Err(Error::option(
                    "levels",
                    format!(
                        "{}: level {} has a single texel",
                        self.levels,
                        grids.len() - 1
                    ),
                    format!("at most {}", grids.len()),
                ));
            }
            grid = grid.coarser();
            grids.push(grid);
        }
        Ok(grids)
    }
}

/// A number of images, or all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ImageCount {
    /// So many.
    Count(u32),
    /// A word.
    Named(Named),
}

/// Words that stand for a number of images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Named {
    /// Every image of the sample.
    All,
}

impl FromStr for ImageCount {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == "all" {
            return Ok(Self::Named(Named::All));
        }
        let count = text
            .parse()
            .map_err(|_| format!("`{text}` is neither a number nor `all`"))?;
        Ok(Self::Count(count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_read_from_toml_as_from_the_command_line() {
        let options: TextonOptions =
            toml::from_str("textons = 50\nimages = \"all\"\nmemory = \"1GiB\"\nno-tile = true")
                .unwrap();
        assert_eq!(options.images, Some(ImageCount::Named(Named::All)));
        assert_eq!(options.memory, Some(ByteSize(1 << 30)));
        let options: TextonOptions = toml::from_str("images = 25").unwrap();
        assert_eq!(options.images, "25".parse().ok());
        assert!(toml::from_str::<TextonOptions>("texton = 5").is_err());
    }

    #[test]
    fn impossible_numbers_are_refused_by_name() {
        for (options, name) in [
            (
                TextonOptions {
                    textons: 0,
                    ..Default::default()
                },
                "--textons: 0",
            ),
            (
                TextonOptions {
                    textons: 65_535,
                    ..Default::default()
                },
                "--textons: 65535",
            ),
            (
                TextonOptions {
                    levels: 0,
                    ..Default::default()
                },
                "--levels: 0",
            ),
            (
                TextonOptions {
                    images: Some(ImageCount::Count(0)),
                    ..Default::default()
                },
                "--images: 0",
            ),
        ] {
            let error = options.validate().unwrap_err().to_string();
            assert!(error.starts_with(name), "{error}");
        }
    }

    #[test]
    fn coarser_levels_have_a_quarter_of_the_textons_but_not_too_few() {
        let options = TextonOptions::default();
        let counts: Vec<_> = (0..6).map(|level| options.textons_at(level)).collect();
        assert_eq!(counts, [400, 100, 64, 64, 64, 64]);
        let few = TextonOptions {
            textons: 24,
            ..options
        };
        assert_eq!([few.textons_at(0), few.textons_at(3)], [24, 24]);
    }
}
