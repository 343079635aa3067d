//! Papers, a file each, the list of them, and the parts that they share.
//!
//! A recipe has a `DESCRIPTION`, which answers every question about the method, and a function `synthesize`, which does
//! the work. It becomes a method of `synth` by a row of the list.
//!
//! Parts: the [`k_coherence`] rule, [`distance_floor`], [`reuse_penalty`], [`seam_repair`].

pub(crate) mod distance_floor;
pub(crate) mod k_coherence;
pub(crate) mod reuse_penalty;
pub(crate) mod seam_repair;

use crate::error::Result;
use crate::progress::Progress;
use crate::sites::level::Sites;
use crate::synthesis::inputs::{Inputs, LevelMap};

/// Registers the methods: one row per recipe. It declares the file's module and makes the variant of [`Method`].
macro_rules! methods {
    ($($(#[$attribute:meta])? $method:ident => $visible:vis $recipe:ident,)+) => {
        $($visible mod $recipe;)+

        /// The method of synthesis, by its paper.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum Method {
            $(
                #[doc = concat!("The recipe `", stringify!($recipe), "`.")]
                $(#[$attribute])?
                $method,
            )+
        }

        impl Method {
            /// All methods, in the order of the list.
            pub const ALL: &'static [Self] = &[$(Self::$method),+];

            /// What the method answers about itself.
            pub fn description(self) -> &'static crate::synthesis::MethodDescription {
                match self {
                    $(Self::$method => &$recipe::DESCRIPTION,)+
                }
            }

            /// Synthesizes all levels by a plan, as [`synthesize`](crate::synthesis::synthesize) does.
            pub(crate) fn synthesize<const N: usize, S: Sites<N>>(
                self,
                inputs: Inputs<'_, S>,
                completed: (&crate::synthesis::SynthesisOptions, &crate::synthesis::check::Plan),
                begun: Option<LevelMap>,
                finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
                progress: Progress<'_>,
            ) -> Result<LevelMap> {
                match self {
                    $(Self::$method => {
                        $recipe::synthesize(inputs, completed, begun, finished, progress)
                    })+
                }
            }
        }
    };
}

methods! {
    #[default]
    KCoherence => pub(crate) tong,
    WeiLevoy => wei_levoy,
    Adaptive => pub(crate) adaptive,
    Multiscale => pub(crate) multiscale,
    Coherent => coherent,
    Progressive => pub(crate) progressive,
    Choosy => pub choosy,
}
