//! Field distortion (Zhang 2003 §4.1): a texture synthesized with windows that are scaled and turned at every
//! pixel, so that its elements change their size and direction.
//!
//! In: a material, a transition and an orientation of the output's size. Out: the texel of every pixel of the
//! output. A pixel's window is read from the output, scaled and turned, bilinearly; it is compared with the
//! straight windows of the material. The coarsest level grows along the orientation field (Turk 2001).
//!
//! Deviations: the paper's scale is the transition function itself, F_o; here the scale goes evenly from one
//! number, where the transition is 0, to another, where it is 1, so that the transition keeps its range from 0
//! to 1 for equation (1). Levels and passes are those of this program's k-coherence, of which all texels are
//! candidates unless asked otherwise.

use glam::Vec2;
use ndarray::{Array2, Array3};

use crate::error::{Error, Result};
use crate::exemplar::controls::Controls;
use crate::exemplar::knn_options::KnnOptions;
use crate::exemplar::neighbor_table;
use crate::exemplar::plain_images::space_of_images;
use crate::format::id::ContentId;
use crate::grid::TexelGrid;
use crate::neighborhood::Neighborhood;
use crate::progress::Progress;
use crate::sites::grid::turned::{TurnedGridSites, TurnedWindows};
use crate::sites::level::SiteHierarchy;
use crate::sites::order::Order;
use crate::synthesis::all_levels::synthesize;
use crate::synthesis::inputs::Inputs;
use crate::synthesis::options::{CandidateSearch, KCoherenceOptions, SynthesisOptions};
use crate::vary::filtering::{MOST_OUTPUT, MOST_SOURCE};
use crate::vary::material::Material;

/// The least and the largest scale.
pub const SCALES: std::ops::RangeInclusive<f64> = 0.1..=8.0;

/// The options of field distortion.
#[derive(Clone, Debug, PartialEq, clap::Args)]
#[command(next_help_heading = "Field distortion")]
pub struct DistortionOptions {
    /// Size of the texture's elements where the transition is 0; 1 is their own size
    #[arg(long, default_value_t = Self::default().scale_from, value_name = "X")]
    pub scale_from: f64,
    /// Size of the texture's elements where the transition is 1
    #[arg(long, default_value_t = Self::default().scale_to, value_name = "X")]
    pub scale_to: f64,
    /// Width of the windows that are compared, in texels; odd
    #[arg(long, default_value_t = Self::default().window, value_name = "N")]
    pub window: u32,
    /// Levels of the pyramid that is synthesized
    #[arg(long, default_value_t = Self::default().distortion_levels, value_name = "N")]
    pub distortion_levels: u32,
    /// Passes per level
    #[arg(long, default_value_t = Self::default().passes, value_name = "N")]
    pub passes: u32,
    /// Which texels are tried at a pixel
    #[arg(long, value_enum, default_value = "full", value_name = "SEARCH")]
    pub tried: CandidateSearch,
}

impl Default for DistortionOptions {
    fn default() -> Self {
        Self {
            scale_from: 1.0,
            scale_to: 0.5,
            window: 7,
            distortion_levels: 3,
            passes: 2,
            tried: CandidateSearch::Full,
        }
    }
}

impl DistortionOptions {
    /// Checks every field by itself.
    pub fn validate(&self) -> Result<()> {
        for (name, scale) in [("scale-from", self.scale_from), ("scale-to", self.scale_to)] {
            if !SCALES.contains(&scale) {
                let expected = format!("{} to {}", SCALES.start(), SCALES.end());
                return Err(Error::option(name, scale.to_string(), expected));
            }
        }
        if self.window.is_multiple_of(2) || !(3..=31).contains(&self.window) {
            let found = self.window.to_string();
            return Err(Error::option("window", found, "an odd width from 3 to 31"));
        }
        if !(1..=16).contains(&self.distortion_levels) {
            let found = self.distortion_levels.to_string();
            return Err(Error::option("distortion-levels", found, "1 to 16"));
        }
        self.synthesis(0).validate()
    }

    fn synthesis(&self, seed: u64) -> SynthesisOptions {
        let default = KCoherenceOptions::default();
        let is_full = self.tried == CandidateSearch::Full;
        SynthesisOptions {
            passes: self.passes,
            k_coherence: KCoherenceOptions {
                search: self.tried,
                order: Order::Field,
                repair_rounds: if is_full { 0 } else { default.repair_rounds },
                reuse_penalty: if is_full { 0.0 } else { default.reuse_penalty },
                ..default
            },
            seed,
            ..SynthesisOptions::default()
        }
    }

    fn table(&self) -> KnnOptions {
        KnnOptions {
            k: match self.tried {
                CandidateSearch::Full => 1,
                CandidateSearch::KCoherence => KnnOptions::default().k,
            },
            neighborhood: self.window,
            ..KnnOptions::default()
        }
    }
}

/// The texel of every pixel. Errors: sizes and options that do not fit, and [`Error::Interrupted`].
pub fn distorted(
    material: &Material,
    (transition, orientation): (&Array2<f32>, &Array3<f32>),
    options: &DistortionOptions,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    // Check what is given.
    options.validate()?;
    let output = check(material.grid(), transition, orientation)?;
    let controls = Controls {
        mask: None,
        transition: Some(transition.clone()),
        orientation: Some(orientation.clone()),
    };
    controls.check(output)?;
    let levels = options.distortion_levels;
    // Make an exemplar of the material.
    let none = ContentId::of_bytes(&[]);
    let space = space_of_images(
        &material.images,
        Controls::default(),
        levels,
        material.tileable,
        &none,
    );
    let space = space.map_err(named_as_here)?;
    let table = neighbor_table::build(&space, &options.table(), progress)?;
    // Synthesize on a grid of turned and scaled sites.
    let sites = hierarchy(controls, output, &table.neighborhoods(), options);
    let inputs = Inputs {
        space: &space,
        table: &table,
        sites: &sites,
        controls: None,
    };
    let asked = options.synthesis(seed);
    let map = synthesize(inputs, &asked, None, &mut |_| Ok(()), progress).map_err(named_as_here)?;
    let grid = space.levels[0].grid;
    Ok(map
        .coords
        .iter()
        .map(|&at| grid.texel_nearest(at).0)
        .collect())
}

/// The sites of all levels, finest first.
fn hierarchy(
    finest: Controls,
    output: TexelGrid,
    neighborhoods: &[Neighborhood],
    options: &DistortionOptions,
) -> SiteHierarchy<TurnedGridSites> {
    let (mut controls, mut grid) = (finest, output);
    let mut levels = Vec::new();
    for neighborhood in neighborhoods {
        let transition = controls.transition.clone().unwrap_or_default();
        let scale = |share: f32| {
            let share = f64::from(share);
            (options.scale_from + (options.scale_to - options.scale_from) * share) as f32
        };
        let windows = TurnedWindows {
            positions: positions(&neighborhood.offsets),
            coarse_positions: positions(&neighborhood.coarse_offsets),
            reach: (options.window / 2) as f32,
        };
        let orientation = controls.orientation.clone().unwrap_or_default();
        levels.push(TurnedGridSites::new(
            &transition.mapv(scale),
            &orientation,
            windows,
        ));
        controls = controls.coarser(grid);
        grid = grid.coarser();
    }
    SiteHierarchy { levels }
}

fn positions(offsets: &[[i32; 2]]) -> Vec<Vec2> {
    offsets
        .iter()
        .map(|&[drow, dcol]| Vec2::new(dcol as f32, -drow as f32))
        .collect()
}

/// Refuses sizes before anything is made of them.
fn check(
    source: TexelGrid,
    transition: &Array2<f32>,
    orientation: &Array3<f32>,
) -> Result<TexelGrid> {
    let (rows, cols) = transition.dim();
    if source.len() > MOST_SOURCE || rows * cols == 0 || rows * cols > MOST_OUTPUT {
        let (width, height) = (source.width, source.height);
        return Err(
            Error::data("sizes", format!("{width}×{height} onto {cols}×{rows}")).expected(format!(
                "at most {MOST_SOURCE} texels onto 1 to {MOST_OUTPUT}"
            )),
        );
    }
    if orientation.dim() != (rows, cols, 2) {
        return Err(
            Error::data("orientation", format!("{:?}", orientation.dim()))
                .expected(format!("{:?}, the transition's size", (rows, cols, 2))),
        );
    }
    Ok(TexelGrid {
        width: cols as u32,
        height: rows as u32,
        tileable: false,
    })
}

/// Levels of spaces and of synthesis are those of `--distortion-levels` here.
fn named_as_here(error: Error) -> Error {
    match error {
        Error::Option {
            option,
            found,
            expected,
        } if option == "levels" => Error::Option {
            option: "distortion-levels".into(),
            found,
            expected,
        },
        other => other,
    }
}

#[cfg(test)]
mod tests;
