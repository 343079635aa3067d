//! What a material is, and what a scene asks of it.

use std::path::Path;

use crate::btf::bake::maps::{self, Loaded, MapOptions, Recipe, read_recipe};
use crate::btf::bake::steepness::Steepness;
use crate::btf::sample::Sample;
use crate::cli::info::kind::{Kind, unknown};
use crate::cli::outcome::Outcome;
use crate::error::{Error, Result};
use crate::format::image;
use crate::progress::Progress;

/// Texels along the longer side of a baked sample, where the maps have as many.
const SIZE: u32 = 128;
/// The fewest that are tried so that both sides fit the levels.
const LEAST_SIZE: u32 = 64;
/// Levels of textons and of an exemplar.
const LEVELS: u32 = 4;
/// The sides of a sample that is not made yet and of which nothing is known.
const UNKNOWN_SIDES: [u32; 2] = [128, 128];

/// A material, by what makes a sample of it.
pub(super) enum Material {
    /// Texture maps, baked.
    Maps(Maps),
    /// A sample that is there.
    Sample {
        /// Columns and rows.
        sides: [u32; 2],
        /// Levels that its sides allow.
        tiling: Tiling,
        /// Its images.
        images: usize,
    },
    /// A measured data set, imported.
    Capture,
    /// A plain image.
    Image {
        /// Columns and rows.
        sides: [u32; 2],
    },
}

/// Maps as they are baked.
pub(super) struct Maps {
    /// Texels along the longer side.
    pub(super) size: u32,
    /// Columns and rows of the sample.
    pub(super) sides: [u32; 2],
    /// Columns and rows of the maps.
    source: [u32; 2],
    /// Whether the sides fit the levels of a sample that tiles.
    pub(super) tiling: Tiling,
    /// The depth that the scene states, and what the material says or not.
    pub(super) depth: Depth,
    /// Slopes at that depth: 95 % are below, in degrees.
    pub(super) slope_deg: f64,
    /// Side of a texel in millimetres, where the material says.
    pub(super) texel_mm: Option<f64>,
}

/// How many levels a sample has, and whether it is taken as one that tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tiling {
    /// Levels.
    pub(super) levels: u32,
    /// Whether it must be taken as not tileable: its sides cannot be halved often enough.
    pub(super) is_given_up: bool,
}

/// Where the depth of a relief comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Depth {
    /// There is no height map: normals, or a plane.
    None,
    /// The material says it, as a share of its width.
    OfMaterial(f64),
    /// It is chosen so that slopes are plausible.
    Chosen(f64),
}

impl Material {
    /// Reads what is at a path.
    pub(super) fn read(path: &Path, progress: Progress<'_>) -> Result<Self> {
        match Kind::of(path)? {
            Kind::Material => Ok(Self::Maps(Maps::read(path, progress)?)),
            Kind::Sample => {
                let sample = Sample::open(path)?;
                let grid = sample.grid();
                let sides = [grid.width, grid.height];
                Ok(Self::Sample {
                    sides,
                    tiling: Tiling::of(sides, grid.tileable),
                    images: sample.image_count(),
                })
            }
            Kind::Capture | Kind::Bonn => Ok(Self::Capture),
            Kind::Image => {
                let image = image::read(path)?;
                Ok(Self::Image {
                    sides: [image.width, image.height],
                })
            }
            Kind::Ptm | Kind::Hsh | Kind::Array => Err(Error::data("kind", "a fit or an array")
                .expected("a material, a sample, a data set or an image")
                .advice("import it first (mesotex import --help), then give the sample")
                .in_file(path)),
            other => match other {
                Kind::Scene => Err(Error::data("kind", other.name())
                    .expected(
                        "a material: a folder of maps, a recipe, a sample, a data set or an image",
                    )
                    .in_file(path)),
                _ => Err(unknown(path)),
            },
        }
    }

    /// Columns and rows of the sample, as far as they are known.
    pub(super) fn sides(&self) -> [u32; 2] {
        match self {
            Self::Maps(maps) => maps.sides,
            Self::Sample { sides, .. } | Self::Image { sides } => *sides,
            Self::Capture => UNKNOWN_SIDES,
        }
    }

    /// What a person reads.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::Maps(maps) => maps.describe(),
            Self::Sample {
                sides: [width, height],
                images,
                ..
            } => format!("a sample of {width} × {height} texels, {images} images"),
            Self::Capture => "a measured data set: its size is known once it is imported".into(),
            Self::Image {
                sides: [width, height],
            } => format!("a plain image of {width} × {height} texels"),
        }
    }

    /// What a program reads.
    pub(super) fn add_figures(&self, outcome: Outcome) -> Outcome {
        let [width, height] = self.sides();
        let outcome = outcome.figure("width", width).figure("height", height);
        match self {
            Self::Maps(Maps {
                depth: Depth::Chosen(depth) | Depth::OfMaterial(depth),
                ..
            }) => outcome.figure("depth", *depth),
            _ => outcome,
        }
    }
}

impl Tiling {
    fn of(sides: [u32; 2], tiles: bool) -> Self {
        let is_given_up = tiles && !sides.iter().all(|side| fits_levels(*side));
        // Each level is at least 8 texels wide.
        let shorter = sides[0].min(sides[1]).max(8);
        Self {
            levels: LEVELS.min(1 + (shorter / 8).ilog2()),
            is_given_up,
        }
    }
}

fn fits_levels(side: u32) -> bool {
    side.is_multiple_of(1 << (LEVELS - 1))
}

impl Maps {
    fn read(path: &Path, progress: Progress<'_>) -> Result<Self> {
        let recipe = read_recipe(path)?;
        let of_material = |loaded: &Loaded| match is_stated(&recipe) {
            true => loaded.depth,
            false => None,
        };
        // What is warned of is what is chosen here.
        let silent = Progress::silent();
        progress.check()?;
        let loaded = maps::material(&recipe, &MapOptions::default(), SIZE, silent)?;
        let slopes = Steepness::of(&loaded.material);
        let depth = match (of_material(&loaded), loaded.depth) {
            (Some(depth), _) => Depth::OfMaterial(depth),
            (None, Some(depth)) => Depth::Chosen(slopes.plausible_depth(depth)),
            (None, None) => Depth::None,
        };
        let slope_deg = match (depth, loaded.depth) {
            (Depth::Chosen(chosen), Some(read)) => slopes.p95_at(chosen / read),
            _ => slopes.p95_deg,
        };
        let grid = loaded.material.grid;
        let (size, sides) = fitted_size(loaded.source);
        Ok(Self {
            size,
            sides,
            source: loaded.source,
            tiling: Tiling::of(sides, grid.tileable),
            depth,
            slope_deg,
            texel_mm: loaded
                .material
                .texel_mm
                .map(|mm| mm * f64::from(grid.width) / f64::from(sides[0])),
        })
    }

    fn describe(&self) -> String {
        let [width, height] = self.source;
        let [columns, rows] = self.sides;
        let depth = match self.depth {
            Depth::None => String::new(),
            Depth::OfMaterial(depth) => {
                format!(", depth {depth} of the width as the material states")
            }
            Depth::Chosen(depth) => format!(
                ", depth {depth} of the width: 95 % of the slopes are below {:.0}°",
                self.slope_deg
            ),
        };
        format!("maps of {width} × {height} texels, baked at {columns} × {rows}{depth}")
    }
}

/// Whether a material says how deep it is.
fn is_stated(recipe: &Recipe) -> bool {
    recipe.relief.depth.is_some() || recipe.relief.height_mm.is_some()
}

/// Texels along the longer side, and both sides: no more than the maps have, and such that each can be halved for
/// every level where a size near does that.
fn fitted_size([width, height]: [u32; 2]) -> (u32, [u32; 2]) {
    let longer = width.max(height);
    let sides = |size: u32| {
        let scaled = |side: u32| {
            let share = f64::from(side) / f64::from(longer);
            ((share * f64::from(size)).round() as u32).max(1)
        };
        [scaled(width), scaled(height)]
    };
    let most = SIZE.min(longer).max(16);
    let candidates = (LEAST_SIZE.min(most)..=most).rev();
    let mut fitting = candidates.filter(|size| sides(*size).iter().all(|side| fits_levels(*side)));
    let size = fitting.next().unwrap_or(most);
    (size, sides(size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_can_be_halved_for_every_level() {
        assert_eq!(fitted_size([2048, 2048]), (128, [128, 128]));
        assert_eq!(fitted_size([2048, 1024]), (128, [128, 64]));
        assert_eq!(fitted_size([1500, 1000]), (120, [120, 80]));
        assert_eq!(fitted_size([100, 100]), (96, [96, 96]));
        assert_eq!(fitted_size([40, 40]), (40, [40, 40]));
        let [width, height] = fitted_size([1000, 997]).1;
        assert!(width == 128 && height == 128, "rounding makes it square");
    }

    #[test]
    fn what_cannot_be_halved_is_not_taken_as_tileable() {
        let of = |sides, tiles| Tiling::of(sides, tiles);
        assert_eq!(
            (
                of([128, 128], true).levels,
                of([128, 128], true).is_given_up
            ),
            (4, false)
        );
        assert!(of([100, 100], true).is_given_up);
        assert!(!of([100, 100], false).is_given_up);
        assert_eq!(of([16, 16], true).levels, 2);
    }
}
