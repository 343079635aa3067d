//! The whole method (Castellanos and Williams §4, algorithm 1).

use rand::Rng;
use rand::seq::SliceRandom;

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::random;
use crate::sites::faces::neighborhood::FaceTemplate;
use crate::sites::faces::pyramid::FacePyramid;
use crate::synthesis::drive::run_by_run;
use crate::synthesis::own_options::OwnOptions;
use crate::synthesis::recipes::choosy::face_values::FaceValues;
use crate::synthesis::recipes::choosy::kernel::{FaceKernel, distance_ratio, kernels};
use crate::synthesis::recipes::choosy::options::ChoosyOptions;
use crate::synthesis::recipes::choosy::sample::{AnalysisSample, SquareImage};
use crate::synthesis::recipes::choosy::sampling::{ChoosyRule, LevelState, RunChanges};
use crate::synthesis::recipes::choosy::source_faces::{Source, SourceFaces};
use crate::synthesis::recipes::choosy::value_pyramid::{ValuePyramid, expanded};

/// The largest ratio of σ and the mean distance of adjacent faces. Kernels reach three times as far, and the number of
/// faces below them grows with its square.
const LARGEST_RATIO: f64 = 8.0;
/// Numbers per texel, at most: the principal components of 36 times as many are found.
pub const MOST_CHANNELS: usize = 48;

/// A texture on the faces of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct ChoosyResult {
    /// The analysed sample.
    pub sample: AnalysisSample,
    /// The values of all levels of the surface. A Laplacian level is what the next coarser level was given with its
    /// sources; a Gaussian level has been sampled.
    pub pyramid: ValuePyramid,
    /// The source of every face of the finest level.
    pub sources: Vec<Source>,
    /// The colour of every face of the finest level: the texel of the sample under the centre of its source.
    ///
    /// Deviation: the paper shows G of the finest level, whose bilinear means have less contrast than the sample.
    pub colors: FaceValues,
    /// Eigenvalues of the neighbourhoods of every level, the largest first (Table 1).
    pub eigenvalues: Vec<Vec<f64>>,
}

/// Synthesizes a sample's texture on all levels of a surface; both have as many levels.
///
/// Level 0 starts from random faces of the sample, every other one from project(G_(k−1)) + L_k. Then its faces are
/// visited in random order, as often as asked, each time in another order and with counts from 0.
///
/// Errors: options outside their ranges; a sample that does not fit the number of levels, or is larger than the
/// surface at the coarsest one; a surface whose faces differ too much in size; [`Error::Interrupted`].
pub fn synthesize_faces(
    image: SquareImage<'_>,
    surface: &FacePyramid,
    options: &ChoosyOptions,
    progress: Progress<'_>,
) -> Result<ChoosyResult> {
    // Check the options, and prepare sample and kernels.
    options.validate()?;
    check_channels(image.channels)?;
    let ratios = distance_ratios(surface, progress);
    let sample = AnalysisSample::new(image, &ratios, progress)?;
    check_coarsest(&sample, surface)?;
    let kernels = kernels(surface, &ratios);
    let mut run = Run {
        sample: &sample,
        surface,
        options,
        template: FaceTemplate::new(),
        pyramid: ValuePyramid {
            gaussian: Vec::new(),
            laplacian: vec![FaceValues::default()],
        },
        sources: Vec::new(),
        eigenvalues: Vec::new(),
    };
    // Synthesize level after level.
    for (level, ratio) in ratios.iter().enumerate() {
        run.synthesize_level(level, *ratio, &kernels[level], progress)?;
    }
    let Run {
        pyramid,
        sources,
        eigenvalues,
        ..
    } = run;
    // Take the colours of the sources.
    let mut colors = FaceValues::zeros(sources.len(), image.channels);
    for (face, source) in sources.iter().enumerate() {
        let texel = sample.texels[usize::from(source.turn)].row(source.face as usize);
        colors.row_mut(face).copy_from_slice(texel);
    }
    Ok(ChoosyResult {
        sample,
        colors,
        pyramid,
        sources,
        eigenvalues,
    })
}

/// What is there between two levels.
struct Run<'a> {
    sample: &'a AnalysisSample,
    surface: &'a FacePyramid,
    options: &'a ChoosyOptions,
    template: FaceTemplate,
    /// The levels so far, and the Laplacian of the next.
    pyramid: ValuePyramid,
    /// The sources of the level before.
    sources: Vec<Source>,
    eigenvalues: Vec<Vec<f64>>,
}

impl Run<'_> {
    fn synthesize_level(
        &mut self,
        level: usize,
        ratio: f64,
        kernel: &FaceKernel<'_>,
        progress: Progress<'_>,
    ) -> Result<()> {
        // Prepare the sample's faces.
        let dimensions = self.options.dimensions;
        let faces = SourceFaces::new((self.sample, level), &self.template, ratio, dimensions);
        let faces = faces.ok_or_else(|| no_source(self.sample, level))?;
        // Start at random, or from the level above.
        let (values, sources) = match level.checked_sub(1) {
            None => self.random_start(),
            Some(coarser) => {
                let coarser = &self.pyramid.gaussian[coarser];
                let values = expanded(kernel, &self.pyramid.laplacian[level], coarser);
                (values, self.sources_of_parents())
            }
        };
        // Visit every face.
        progress.check()?;
        let has_finer = level + 1 < self.surface.levels.len();
        let children = match has_finer {
            true => FaceValues::zeros(4 * values.count(), values.channels),
            false => FaceValues::default(),
        };
        let own = &self.surface.levels[level];
        let state = LevelState {
            changes: RunChanges::new(values.count(), faces.count()),
            values,
            children,
            sources,
            uses: faces.tree(),
        };
        let neighborhoods = self.template.around_all(&own.topology);
        let rule = ChoosyRule {
            level: own,
            neighborhoods: &neighborhoods,
            sample: (self.sample, level),
            faces: &faces,
        };
        let state = self.visit(&rule, state, progress)?;
        // Hand on to the finer level.
        self.eigenvalues
            .push(faces.components().eigenvalues.clone());
        self.pyramid.gaussian.push(state.values);
        if has_finer {
            self.pyramid.laplacian.push(state.children);
        }
        self.sources = state.sources;
        Ok(())
    }

    /// Visits the faces of a level in random orders.
    fn visit(
        &self,
        rule: &ChoosyRule<'_>,
        mut state: LevelState,
        progress: Progress<'_>,
    ) -> Result<LevelState> {
        let (_, level) = rule.sample;
        let iterations = self.options.iterations_of(level);
        let mut order: Vec<u32> = (0..state.sources.len() as u32).collect();
        let visits = order.len() as u64 * u64::from(iterations);
        progress.begin(format!("synthesis, level {level}"), visits);
        for iteration in 0..iterations {
            let key = (level as u32, u64::from(iteration));
            let mut stream = random::stream(self.options.seed, "choosy order", key.0, key.1);
            order.shuffle(&mut stream);
            state.uses.forget_uses();
            run_by_run(rule, &mut state, &order, progress)?;
        }
        progress.end();
        Ok(state)
    }

    /// The values of random faces of the sample's coarsest level, and the faces.
    fn random_start(&self) -> (FaceValues, Vec<Source>) {
        let levels = self
            .sample
            .pyramids
            .each_ref()
            .map(|pyramid| &pyramid.gaussian[0]);
        let count = self.surface.levels[0].count();
        let mut stream = random::stream(self.options.seed, "choosy start", 0, 0);
        let mut values = FaceValues::zeros(count, levels[0].channels);
        let sources = (0..count).map(|site| {
            let turn = stream.gen_range(0..2u8);
            let level = levels[usize::from(turn)];
            let face = stream.gen_range(0..level.count());
            values.row_mut(site).copy_from_slice(level.row(face));
            Source {
                face: face as u32,
                turn,
                phase: 0,
            }
        });
        let sources = sources.collect();
        (values, sources)
    }

    /// What the children of every face have of its source.
    fn sources_of_parents(&self) -> Vec<Source> {
        let children = |source: &Source| [0, 1, 2, 3].map(|child| source.child(child));
        self.sources.iter().flat_map(children).collect()
    }
}

/// σ over the mean distance of adjacent faces, level after level.
///
/// Deviation: [`LARGEST_RATIO`] at most. Farther faces have little weight in each other's means, and levels are rebuilt
/// exactly all the same.
fn distance_ratios(surface: &FacePyramid, progress: Progress<'_>) -> Vec<f64> {
    let ratio = |(number, level)| {
        let ratio = distance_ratio(level);
        if ratio > LARGEST_RATIO {
            progress.warn(format!(
                "level {number}: adjacent faces are up to {ratio:.1} times as far apart as the mean; kernels are widened for \
                 {LARGEST_RATIO} times at most. More --base-faces make faces more even, and so does --crease 90, which keeps no edges"
            ));
        }
        ratio.min(LARGEST_RATIO)
    };
    surface.levels.iter().enumerate().map(ratio).collect()
}

fn check_channels(channels: usize) -> Result<()> {
    if channels <= MOST_CHANNELS {
        return Ok(());
    }
    let found = format!("{channels} numbers per texel");
    Err(Error::data("sample", found)
        .expected(format!("at most {MOST_CHANNELS}"))
        .advice("keep its leading principal components only"))
}

/// Refuses surfaces with fewer faces than the sample at the coarsest level.
fn check_coarsest(sample: &AnalysisSample, surface: &FacePyramid) -> Result<()> {
    let [own, wanted] = [surface, &sample.grid.pyramid].map(|pyramid| pyramid.levels[0].count());
    if own >= wanted {
        return Ok(());
    }
    let found = format!("{own} faces at the coarsest level");
    Err(Error::data("surface", found)
        .expected(format!("at least the {wanted} of the sample's grid"))
        .advice("use more levels, a base mesh of more faces, or a smaller sample"))
}

fn no_source(sample: &AnalysisSample, level: usize) -> Error {
    let faces = sample.grid.pyramid.levels[level].count();
    let found = format!("no whole neighbourhood among its {faces} triangles at level {level}");
    Error::data("sample", found)
        .expected("5 rows of triangles or more at the coarsest level")
        .advice("use fewer levels, or a larger sample")
}
