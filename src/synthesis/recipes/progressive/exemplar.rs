//! A level of a progressively-variant exemplar (T, M, F, V) as the method reads it: colours and masks in windows
//! rotated by the orientation, and texels by transition (Zhang 2003 §3).

use glam::Vec2;

use crate::exemplar::dense_windows::{DenseFeatures, flat_vectors, whole_texels};
use crate::exemplar::embedding::Embedding;
use crate::exemplar::level::{ExemplarLevel, default_row, feature_rows};
use crate::exemplar::space::{Space, SpaceLevel};
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TexelIndex;
use crate::neighborhood::{Template, window_width};
use crate::sites::level::Parent;
use crate::synthesis::inputs::Inputs;
use crate::synthesis::options::SynthesisOptions;
use crate::synthesis::recipes::progressive::band::Band;
use crate::synthesis::recipes::progressive::label_vectors::{LabelVectors, label_vectors, spread};
use crate::synthesis::recipes::progressive::ring_metric::RingMetric;
use crate::synthesis::state::first_guess;

/// A level with everything that the method compares.
pub struct VariantLevel<'a> {
    /// Its texels, the nearest of each, and which may be picked.
    pub exemplar: ExemplarLevel<'a>,
    /// Texels by transition.
    pub band: Band,
    /// Where the pattern's x axis points at each texel; `None` for s everywhere.
    pub turns: Option<Vec<Vec2>>,
    /// The label of each texel; empty where masks are left out.
    pub labels: Vec<u32>,
    /// Windows of this level.
    pub own: Windows,
    /// The coarser level, where there is one.
    pub coarser: Option<Coarser>,
}

/// What is compared on the coarser level.
pub struct Coarser {
    /// Its windows.
    pub windows: Windows,
    /// The parent of each texel of this level.
    pub parents: Vec<u32>,
    /// The label of each of its texels; empty where masks are left out.
    pub labels: Vec<u32>,
    turns: Option<Vec<Vec2>>,
    grid: TexelGrid,
}

/// Windows of one level.
pub struct Windows {
    /// In features.
    pub colors: RingMetric,
    /// In labels, where masks count.
    pub masks: Option<RingMetric>,
}

/// A kind of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Features.
    Colors,
    /// Labels.
    Masks,
}

impl Windows {
    /// Those in one kind of numbers.
    #[inline(always)]
    pub fn of(&self, kind: Kind) -> Option<&RingMetric> {
        match kind {
            Kind::Colors => Some(&self.colors),
            Kind::Masks => self.masks.as_ref(),
        }
    }
}

/// What windows of a level are made of.
struct WindowFeatures {
    rows: Vec<u32>,
    colors: Vec<f32>,
    dimensions: usize,
    labels: Vec<u32>,
    /// Vectors of labels; none where masks are left out.
    label_vectors: LabelVectors,
    turns: Option<Vec<Vec2>>,
}

impl<'a> VariantLevel<'a> {
    /// Level `level` of the inputs' exemplar, of whose table `k` neighbours per texel are used.
    pub fn new<S>(
        inputs: Inputs<'a, S>,
        (level, k, is_coarsest): (usize, usize, bool),
        options: &SynthesisOptions,
    ) -> Self {
        let (space, table) = (inputs.space, inputs.table);
        let asked = &options.progressive;
        // Find the texels that all windows fit.
        let features = WindowFeatures::new(space, level, options);
        let mut exemplar = ExemplarLevel::new(space, table, level, k, false);
        let turns = features.turns.as_deref();
        let widest = Template::square(asked.widest());
        let fits = whole_texels((exemplar.grid, table.k), table.margin, &widest, turns);
        let both = exemplar.whole.iter().zip(&fits).map(|(a, b)| *a && *b);
        exemplar.whole = both.collect();
        exemplar.whole_texels.retain(|&texel| fits[texel as usize]);
        // Take the transition.
        let controls = space.controls.get(level);
        let transition = controls.and_then(|controls| controls.transition.as_ref());
        let values = transition.map_or_else(
            || vec![0.0; exemplar.grid.len()],
            |transition| transition.iter().copied().collect(),
        );
        let tolerance = table
            .transition_tolerance
            .map_or(f32::INFINITY, |of| of as f32);
        // Resample the windows, those on the coarser level too.
        let widths = [asked.color_window.widest(), asked.widest()];
        let own = features.windows(&space.levels[level], widths, asked.widest());
        let offsets = &table.levels[level].neighborhood.coarse_offsets;
        let coarser = (!is_coarsest).then(|| {
            let width = window_width(offsets);
            let above = WindowFeatures::new(space, level + 1, options);
            let texels = (0..exemplar.grid.len() as u32).map(TexelIndex);
            Coarser {
                windows: above.windows(&space.levels[level + 1], [width; 2], width),
                parents: texels.map(|texel| exemplar.grid.parent(texel).0).collect(),
                labels: above.labels,
                turns: above.turns,
                grid: exemplar.grid.coarser(),
            }
        });
        // Sort the texels by transition.
        Self {
            band: Band::new(values, &exemplar.whole_texels, tolerance),
            turns: features.turns,
            labels: features.labels,
            own,
            coarser,
            exemplar,
        }
    }

    /// Where an offset (x, y) in the pattern's frame at a coordinate points, along s and t.
    #[inline(always)]
    pub fn turned(&self, at: TexCoord, x: f32, y: f32) -> Vec2 {
        turned(
            self.turns.as_deref(),
            self.exemplar.grid,
            at,
            Vec2::new(x, y),
        )
    }

    /// The coordinate that a site takes from its parent.
    pub fn first_guess(&self, coarser: &[TexCoord], parent: &Parent) -> TexCoord {
        let (at, offset) = (coarser[parent.site as usize], Vec2::new(parent.x, parent.y));
        let offset = self.coarser.as_ref().map_or(offset, |coarser| {
            turned(coarser.turns.as_deref(), coarser.grid, at, offset)
        });
        let parent = Parent {
            x: offset.x,
            y: offset.y,
            ..*parent
        };
        first_guess(self.exemplar.grid, coarser, &parent)
    }
}

/// An offset in the pattern's frame at a coordinate, along s and t.
#[inline(always)]
fn turned(turns: Option<&[Vec2]>, grid: TexelGrid, at: TexCoord, offset: Vec2) -> Vec2 {
    turns.map_or(offset, |turns| {
        turns[grid.texel_nearest(at).index()].rotate(offset)
    })
}

impl WindowFeatures {
    fn new(space: &Space, level: usize, options: &SynthesisOptions) -> Self {
        // Take the colours.
        let of_level = &space.levels[level];
        let embedding = Embedding::new(of_level, options.spectrum);
        let colors = flat_vectors(&embedding);
        let rows = feature_rows(of_level);
        // Take the labels, weighted by the spread of the colours.
        let controls = space.controls.get(level);
        let weight = options.progressive.mask_weight;
        let mask = controls.and_then(|controls| controls.mask.as_ref());
        let labels: Vec<u32> = match mask {
            Some(mask) if weight > 0.0 => mask.iter().map(|&label| u32::from(label)).collect(),
            _ => Vec::new(),
        };
        let spread = spread(&rows, &colors, embedding.dimensions);
        let label_vectors = match labels.is_empty() {
            true => LabelVectors::default(),
            false => label_vectors(&labels, weight * spread),
        };
        // Take the orientation.
        let turns = controls.and_then(|controls| controls.orientation.as_ref());
        let turns = turns.map(|turns| {
            let vectors = turns.rows().into_iter();
            vectors
                .map(|vector| Vec2::new(vector[0], vector[1]).normalize_or(Vec2::X))
                .collect()
        });
        Self {
            rows,
            dimensions: embedding.dimensions,
            colors,
            labels,
            label_vectors,
            turns,
        }
    }

    /// The windows of a level, of the widths of colours and masks.
    fn windows(&self, level: &SpaceLevel, widths: [u32; 2], site_width: u32) -> Windows {
        let turns = self.turns.as_deref();
        let colors = DenseFeatures {
            grid: level.grid,
            rows: &self.rows,
            default: default_row(level),
            vectors: &self.colors,
            dimensions: self.dimensions,
        };
        let masks = DenseFeatures {
            grid: level.grid,
            rows: &self.labels,
            default: self.label_vectors.mean(),
            vectors: &self.label_vectors.vectors,
            dimensions: self.label_vectors.dimensions,
        };
        Windows {
            colors: RingMetric::new(colors, widths[0], site_width, turns),
            masks: (!self.labels.is_empty())
                .then(|| RingMetric::new(masks, widths[1], site_width, turns)),
        }
    }
}
