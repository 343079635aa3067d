//! Chen and Dong 2008.

pub mod options;

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::sites::level::Sites;
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::options::SynthesisOptions;

/// Synthesizes all levels and returns the finest.
pub fn adaptive<const N: usize, S: Sites<N>>(
    _inputs: Inputs<'_, S>,
    _options: &SynthesisOptions,
    _begun: Option<LevelMap>,
    _finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    _progress: Progress<'_>,
) -> Result<LevelMap> {
    Err(Error::option("method", "adaptive", "k-coherence"))
}
