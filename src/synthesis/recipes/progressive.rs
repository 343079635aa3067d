//! Zhang 2003 §5, *Synthesis of Progressively-Variant Textures on Arbitrary Surfaces*.
//!
//! The exemplar has a transition value, an orientation and a mask at every texel; the surface has a transition value
//! and an orientation at every site. A site takes only texels whose value is near its own ([`band`]), in windows
//! rotated by the exemplar's orientation ([`exemplar`]). First it gets a label, then a texel ([`rule`]). The coarsest
//! level grows along the field; finer levels begin with their parents' coordinates. The finest level ends with a pass
//! over small windows.
//!
//! Deviations: the distances of texels that no neighbour proposes itself count κ times, as in
//! [`tong`](super::tong), so that patches are copied. Candidates come from neighbours at most 3 texels away, for speed.
//! Finer levels are visited by colour classes, so that a class is searched in parallel. Masks are compared as the
//! corners of a simplex, scaled to the variance of the features, so that images and textons weigh alike against them.

mod band;
mod exemplar;
mod label_vectors;
pub(crate) mod options;
mod plan;
mod ring_metric;
mod rule;

use std::sync::atomic::{AtomicU64, Ordering as Memory};

use rand::Rng;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::random;
use crate::sites::coloring::color_classes;
use crate::sites::controls::SiteControls;
use crate::sites::level::{Parent, SiteHierarchy, Sites};
use crate::sites::order::{Order, growing_orders};
use crate::synthesis::check::Plan;
use crate::synthesis::drive::{class_by_class, coarse_to_fine, one_by_one};
use crate::synthesis::inputs::{Inputs, LevelContent, LevelMap};
use crate::synthesis::method::{Figure, MethodDescription, MethodSites, SharedOption};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::recipes::progressive::exemplar::VariantLevel;
use crate::synthesis::recipes::progressive::options::Widths;
use crate::synthesis::recipes::progressive::plan::{check_surface, plan, window_bytes, windows};
use crate::synthesis::recipes::progressive::rule::{Pass, State, Varied};
use crate::synthesis::state::Texels;

/// Sweeps over the coarsest level: the first sees only what is synthesized.
const START_SWEEPS: u32 = 2;

/// The method, as the rest of the program sees it.
pub const DESCRIPTION: MethodDescription = MethodDescription {
    name: "progressive",
    help: "Zhang 2003 §5: textures that change over the surface, with masks that keep elements whole",
    sites: MethodSites::Windows(windows),
    plan,
    chooses_levels: false,
    unused: &[
        (SharedOption::Metric, "a metric of its own"),
        (SharedOption::Neighborhood, "neighbourhoods of its own"),
    ],
    own_options: Some(|options| &options.progressive),
    check_options: check_passes,
    follows_controls: true,
    figures: &[Figure::Searched],
    microseconds: |work, _| 200.0 + 2.0 * work.texels.sqrt(),
    bytes: |space, _, options| window_bytes(space, options),
};

/// Refuses a single pass.
fn check_passes(options: &SynthesisOptions) -> Result<()> {
    if options.passes >= 2 {
        return Ok(());
    }
    let found = format!("{} with --method progressive", options.passes);
    let expected = "2 or more: the first is a guess";
    Err(Error::option("passes", found, expected))
}

/// Synthesizes all levels and returns the finest.
pub fn synthesize<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    (options, plan): (&SynthesisOptions, &Plan),
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    // Check the surface, and carry its controls down the levels.
    check_surface(inputs, (options, plan))?;
    let controls = match inputs.controls {
        Some(controls) => controls.pyramid(inputs.sites),
        None => still(inputs.sites),
    };
    coarse_to_fine(plan.levels, begun, finished, |number, coarser| {
        // Prepare the exemplar of the level.
        let is_coarsest = number + 1 == plan.levels;
        let level = VariantLevel::new(inputs, (number, plan.k, is_coarsest), options);
        let mut controls = controls[number].clone();
        if number > 0 {
            level.band.clamp(&mut controls.transition);
        }
        let run = LevelRun::<N, S> {
            level: &level,
            number,
            sites: &inputs.sites.levels[number],
            controls: &controls,
            options,
            searched: AtomicU64::new(0),
            progress,
        };
        run.check_coverage()?;
        // Go on from the level above.
        let coarser = coarser.map(|map| {
            let above = &inputs.space.levels[number + 1];
            let labels = level.coarser.as_ref().map(|coarser| &coarser.labels[..]);
            State::of(
                Texels::on(above, map.coords),
                labels.unwrap_or_default(),
                above.grid,
            )
        });
        run.synthesize(coarser.as_ref())
    })
}

/// Controls of a texture that changes nowhere.
fn still<const N: usize, S: Sites<N>>(sites: &SiteHierarchy<S>) -> Vec<SiteControls> {
    let of_level = |level: &S| SiteControls {
        transition: vec![0.0; level.count()],
        mask: None,
    };
    sites.levels.iter().map(of_level).collect()
}

/// The work on one level.
struct LevelRun<'a, const N: usize, S> {
    level: &'a VariantLevel<'a>,
    number: usize,
    sites: &'a S,
    controls: &'a SiteControls,
    options: &'a SynthesisOptions,
    searched: AtomicU64,
    progress: Progress<'a>,
}

impl<const N: usize, S: Sites<N>> LevelRun<'_, N, S> {
    /// Refuses a value of the surface that no texel comes near. On coarser levels, whose windows leave fewer whole
    /// texels, values beyond those are taken for the nearest.
    fn check_coverage(&self) -> Result<()> {
        let band = &self.level.band;
        let values = self.controls.transition.iter().enumerate();
        let mut uncovered = values.filter(|(_, value)| band.texels(**value).is_empty());
        let Some((site, value)) = uncovered.next() else {
            return Ok(());
        };
        let [least, most] = band.range();
        Err(Error::data(
            format!("transition of the surface, level {}, site {site}", self.number),
            value.to_string(),
        )
        .expected(format!(
            "less than {} from that of a texel of the exemplar, {least} to {most}",
            band.tolerance()
        ))
        .advice("cover the range in the exemplar, or build the table with a larger knn --transition-tolerance"))
    }

    fn synthesize(&self, coarser: Option<&State>) -> Result<LevelContent> {
        // Count the visits.
        let asked = &self.options.progressive;
        let refines = self.number == 0 && asked.refine_window > 0;
        let sweeps = match coarser {
            None => START_SWEEPS,
            Some(_) => self.options.passes - 1,
        };
        let visits = u64::from(sweeps + u32::from(refines)) * self.sites.count() as u64;
        self.progress
            .begin(format!("synthesis, level {}", self.number), visits);
        // Compare labels and colours.
        let both = Pass {
            mask_window: Some(asked.mask_window),
            color_window: asked.color_window,
        };
        let mut state = match coarser {
            None => self.grown(both)?,
            Some(coarser) => self.refined(coarser, both)?,
        };
        // Compare colours alone in a small window.
        if refines {
            let small = Pass {
                mask_window: None,
                color_window: Widths::constant(asked.refine_window),
            };
            let rule = self.rule(coarser, small);
            let classes = color_classes(self.sites, self.progress)?;
            class_by_class(&rule, self.sites, &mut state, (&classes, 1), self.progress)?;
        }
        // Write texel centres on the finest level.
        self.progress.end();
        let coords = match self.number {
            0 => state.texels.at_centres(self.level.exemplar.grid),
            _ => state.texels.coords,
        };
        Ok(LevelContent {
            coords,
            searched: self.searched.load(Memory::Relaxed),
        })
    }

    fn rule<'s>(&'s self, coarser: Option<&'s State>, pass: Pass) -> Varied<'s, N, S> {
        Varied {
            level: self.level,
            sites: self.sites,
            controls: self.controls,
            coarser,
            pass,
            searched: &self.searched,
        }
    }

    /// The coarsest level, grown along the field and swept again.
    fn grown(&self, pass: Pass) -> Result<State> {
        let rule = self.rule(None, pass);
        let mut state = self.random_in_band();
        state.texels.done = Some(vec![false; self.sites.count()]);
        let draw = (self.options.seed, self.number as u32);
        let orders = growing_orders(self.sites, Order::Field, START_SWEEPS, draw, self.progress)?;
        for order in orders {
            one_by_one(&rule, &mut state, &order, self.progress)?;
            state.texels.done = None;
        }
        Ok(state)
    }

    /// A finer level: its parents' coordinates, refined with windows on both levels.
    fn refined(&self, coarser: &State, pass: Pass) -> Result<State> {
        let exemplar = &self.level.exemplar;
        let guess = |parent: &Parent| self.level.first_guess(&coarser.texels.coords, parent);
        let coords = self.sites.parents().par_iter().map(guess).collect();
        let texels = Texels::of_coords(exemplar, coords);
        let mut state = State::of(texels, &self.level.labels, exemplar.grid);
        let rule = self.rule(Some(coarser), pass);
        let classes = color_classes(self.sites, self.progress)?;
        let visits = (&classes[..], self.options.passes - 1);
        class_by_class(&rule, self.sites, &mut state, visits, self.progress)?;
        Ok(state)
    }

    /// A random texel at every site, of those that may stand there.
    fn random_in_band(&self) -> State {
        let exemplar = &self.level.exemplar;
        let mut stream = random::stream(self.options.seed, "random start", self.number as u32, 0);
        let values = self.controls.transition.iter();
        let texels = values.map(|&value| {
            let within = self.level.band.texels(value);
            within[stream.gen_range(0..within.len())]
        });
        let texels = Texels::of_texels(exemplar, texels);
        State::of(texels, &self.level.labels, exemplar.grid)
    }
}

#[cfg(test)]
mod tests;
