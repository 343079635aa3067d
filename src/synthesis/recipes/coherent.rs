//! Ying 2001 §5, *Texture and Shape Synthesis on Surfaces*: coherent synthesis, after Ashikhmin 2001.
//!
//! One level and one pass, along [scan lines or breadth first](crate::sites::scan_order). A site holds a real source
//! coordinate and the value that the [continuous exemplar](exemplar) has there. With x′ᵢ what a finished neighbour at
//! offset eᵢ holds, the candidates are yᵢ = x′ᵢ − eᵢ. Each is compared by reading the exemplar at yᵢ + eⱼ for every
//! finished neighbour j: the pattern is the site's own, so no window is needed and any target will do.
//!
//! Deviations: a candidate's squared distance is divided by the number of neighbours that were compared, as
//! the sum favours candidates at the exemplar's border, where most are undefined. A candidate off the exemplar is
//! left out, and where all are, the site begins a new patch at a random texel, as the first site does. An atlas is
//! visited breadth first by texel and not chart by chart along scan lines, whose patches would all end at the borders
//! of charts and show them.

mod exemplar;

use rand::Rng;

use crate::error::{Error, Result};
use crate::exemplar::embedding::Embedding;
use crate::exemplar::space::Space;
use crate::grid::TexCoord;
use crate::index::{Level, TexelIndex};
use crate::neighborhood::Neighborhood;
use crate::progress::Progress;
use crate::random;
use crate::sites::level::{Neighbor, Sites};
use crate::sites::scan_order::one_pass_order;
use crate::synthesis::candidates::forward::shifted;
use crate::synthesis::check::{Plan, space_level};
use crate::synthesis::drive::one_by_one;
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::method::{MethodDescription, MethodSites, SharedOption};
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::recipes::coherent::exemplar::ContinuousExemplar;
use crate::synthesis::rule::Rule;

/// The width of the window inside which the neighbours of a site lie, at most 2 texels away each way.
const WINDOW: u32 = 5;

/// The method, as the rest of the program sees it.
pub const DESCRIPTION: MethodDescription = MethodDescription {
    name: "coherent",
    help: "Ying 2001 §5: continues the patches of finished sites at real coordinates; one level, one pass, fast",
    sites: MethodSites::Windows(|_, _, _| vec![Neighborhood::square(WINDOW, 0)]),
    plan: |space, _, options| one_level(space, options),
    chooses_levels: false,
    unused: &[
        (SharedOption::SeveralLevels, "one level"),
        (SharedOption::Metric, "a metric of its own"),
        (SharedOption::Neighborhood, "neighbourhoods of its own"),
        (SharedOption::Passes, "a fixed number of passes"),
    ],
    microseconds: |_, _| 31.0,
    ..MethodDescription::PLAIN
};

/// Checks the options and the finest level of the exemplar.
fn one_level(space: &Space, options: &SynthesisOptions) -> Result<Plan> {
    options.validate()?;
    let Some(level) = space.levels.first() else {
        return Err(Error::data("space", "no level").expected("one or more"));
    };
    space_level(level, 0)?;
    Ok(Plan::of_levels(1))
}

/// Synthesizes the one level.
pub fn synthesize<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    (options, _): (&SynthesisOptions, &Plan),
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    if inputs.sites.levels.first().map_or(0, Sites::count) == 0 {
        return Err(Error::data("target", "no sites").expected("one or more"));
    }
    // Take what an earlier run has finished.
    if let Some(map) = begun.filter(|map| map.level == Level(0)) {
        return Ok(map);
    }
    // Prepare the exemplar.
    let (sites, level) = (&inputs.sites.levels[0], &inputs.space.levels[0]);
    let embedding = Embedding::new(level, options.spectrum);
    let exemplar = ContinuousExemplar::new(level, &embedding);
    // Visit every site once.
    progress.begin("synthesis", sites.count() as u64);
    let mut stream = random::stream(options.seed, "growth start", 0, 0);
    let order = one_pass_order(sites, stream.gen_range(0..sites.count()), progress)?;
    let mut state = Copied::nothing(sites.count(), &exemplar);
    let rule = Continued {
        exemplar: &exemplar,
        sites,
        seed: options.seed,
    };
    one_by_one(&rule, &mut state, &order, progress)?;
    progress.end();
    // Hand on the map.
    let map = LevelMap {
        level: Level(0),
        coords: state.coords,
        searched: 0,
    };
    finished(&map)?;
    Ok(map)
}

/// What the sites hold.
#[derive(Clone, Debug, PartialEq)]
struct Copied {
    /// Source coordinates, in texels, anywhere on the exemplar.
    coords: Vec<TexCoord>,
    /// The exemplar's values there, as many numbers per site as it has.
    values: Vec<f32>,
    done: Vec<bool>,
}

impl Copied {
    fn nothing(sites: usize, exemplar: &ContinuousExemplar) -> Self {
        Self {
            coords: vec![TexCoord::default(); sites],
            values: vec![0.0; sites * exemplar.numbers()],
            done: vec![false; sites],
        }
    }
}

/// The rule: of the continuations of what finished neighbours copied, the one whose surroundings in the exemplar
/// are most like them.
struct Continued<'a, const N: usize, S> {
    exemplar: &'a ContinuousExemplar,
    sites: &'a S,
    seed: u64,
}

/// Working memory of one thread.
#[derive(Default)]
struct Scratch {
    /// The finished neighbours.
    near: Vec<Neighbor>,
    candidates: Vec<TexCoord>,
}

impl<const N: usize, S: Sites<N>> Rule for Continued<'_, N, S> {
    type State = Copied;
    type Take = TexCoord;
    type Scratch = Scratch;

    fn held(&self, state: &Copied, site: usize) -> TexCoord {
        state.coords[site]
    }

    fn choose(&self, state: &Copied, site: usize, scratch: &mut Scratch) -> TexCoord {
        let Scratch { near, candidates } = scratch;
        near.clear();
        let neighbors = self.sites.neighbors(site);
        near.extend(neighbors.filter(|near| state.done[near.site as usize]));
        candidates.clear();
        for neighbor in &*near {
            let at = shifted(state.coords[neighbor.site as usize], neighbor.x, neighbor.y);
            // Inside a copied patch most neighbours propose the same.
            if let Some(at) = self.exemplar.place(at)
                && !candidates.contains(&at)
            {
                candidates.push(at);
            }
        }
        match &candidates[..] {
            [] => self.random_texel(site),
            [one] => *one,
            several => self.exemplar.most_alike(several, near, &state.values),
        }
    }

    fn set(&self, state: &mut Copied, site: usize, at: TexCoord) {
        let numbers = self.exemplar.numbers();
        let value = &mut state.values[site * numbers..][..numbers];
        self.exemplar.read(at, value);
        state.coords[site] = at;
        state.done[site] = true;
    }
}

impl<const N: usize, S: Sites<N>> Continued<'_, N, S> {
    fn random_texel(&self, site: usize) -> TexCoord {
        let grid = self.exemplar.grid();
        let mut stream = random::stream(self.seed, "new patch", 0, site as u64);
        grid.centre(TexelIndex(stream.gen_range(0..grid.len() as u32)))
    }
}

#[cfg(test)]
mod tests;
