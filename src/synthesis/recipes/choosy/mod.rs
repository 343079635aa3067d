//! Castellanos and Williams, *Automatic Synthesis of Isotropic Textures on Surfaces from Sample Images*: faces are
//! pixels, and no orientation is needed.
//!
//! The sample lies on two triangular grids at 90° to each other, and has a Gaussian and a Laplacian pyramid on each.
//! A surface has the same pyramids on its subdivided faces. Level after level, from the coarsest on, every face takes
//! the values of the sample's face whose neighbourhood is most similar, at the best of three rotations. The more
//! often a face is used, the worse it scores. A face takes the Laplacian values of that face's children too, from
//! which the next level starts.
//!
//! Deviations; the reasons are where they are made: the sample continues beyond its border as its mirror image
//! ([`source_faces`]); a use of a face costs more than in the paper ([`counted_tree`]); a face of the finest level
//! shows a texel instead of a bilinear mean ([`recipe`]). Histograms of 131,072 faces of a sphere are 0.014 to 0.036
//! from the sample's in L1 with them (five samples of 96 × 96 and 128 × 128 texels, 50 bins per channel), 0.085 to
//! 0.20 without (three of them). The weights of a neighbourhood are those of the regular lattice, also where the
//! surface is not regular. At the same score the face that is used less often is taken, then the one of the smaller
//! number; the paper leaves this open.
//!
//! Visits follow one another, since each sees the uses before. A run of them is decided side by side all the same, and
//! decisions are made again where an earlier one of the run matters to them ([`sampling`]).
//!
//! | file | what it does |
//! | --- | --- |
//! | [`face_values`] | numbers on faces |
//! | [`kernel`] | Gaussian convolution on faces: reduce and project |
//! | [`value_pyramid`] | Gaussian and Laplacian pyramids |
//! | [`sample`] | the pyramids of the sample on its two grids |
//! | [`principal_components`] | vectors on their leading directions |
//! | [`counted_tree`] | the nearest vector, weighted by how often it was used |
//! | [`source_faces`] | the neighbourhoods of the sample's faces, weighted and projected |
//! | [`sampling`] | choosy sampling of one level |
//! | [`options`], [`recipe`] | the whole method |

pub(crate) mod counted_tree;
pub(crate) mod face_values;
pub(crate) mod kernel;
pub(crate) mod options;
pub(crate) mod principal_components;
pub(crate) mod recipe;
pub(crate) mod sample;
mod sampling;
pub(crate) mod source_faces;
pub(crate) mod value_pyramid;

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::sites::level::Sites;
use crate::synthesis::check::Plan;
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::method::{MethodDescription, MethodSites, SharedOption};
use crate::synthesis::options::SynthesisOptions;

pub use counted_tree::{Choice, CountedTree};
pub use face_values::FaceValues;
pub use kernel::distance_ratio;
pub use options::ChoosyOptions;
pub use recipe::{ChoosyResult, synthesize_faces};
pub use sample::{AnalysisSample, SquareImage};
pub use source_faces::{Source, SourceFaces};
pub use value_pyramid::ValuePyramid;

/// The method, as the rest of the program sees it.
pub(crate) const DESCRIPTION: MethodDescription = MethodDescription {
    name: "choosy",
    help: "Castellanos and Williams: isotropic textures on faces, without an orientation",
    sites: MethodSites::Faces,
    plan: |_, _, _| Err(needs_faces()),
    chooses_levels: false,
    unused: &[
        (SharedOption::Levels, "--subdivisions, one less than levels"),
        (SharedOption::Metric, "a metric of its own"),
        (SharedOption::Neighborhood, "neighbourhoods of its own"),
        (SharedOption::Passes, "--iterations"),
    ],
    own_options: Some(|options| &options.choosy),
    microseconds: |_, _| 220.0,
    ..MethodDescription::PLAIN
};

/// Refuses sites that are no faces: [`synthesize_faces`] is the way in.
pub(crate) fn synthesize<const N: usize, S: Sites<N>>(
    _: Inputs<'_, S>,
    _: (&SynthesisOptions, &Plan),
    _: Option<LevelMap>,
    _: &mut dyn FnMut(&LevelMap) -> Result<()>,
    _: Progress<'_>,
) -> Result<LevelMap> {
    Err(needs_faces())
}

fn needs_faces() -> Error {
    let found = "choosy, which writes on faces";
    Error::option("method", found, "--onto faces as well")
}

#[cfg(test)]
mod tests;
