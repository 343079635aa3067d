//! Papers, a file each, and the parts that they share.
//!
//! | recipe | method |
//! | --- | --- |
//! | [`tong`] | `k-coherence`: Tong 2002 §5 |
//! | [`wei_levoy`] | `wei-levoy`: Wei and Levoy 2001 |
//! | [`adaptive`] | `adaptive`: Chen and Dong 2008 |
//! | [`multiscale`] | `multiscale`: Ying 2001 §4 |
//! | [`coherent`] | `coherent`: Ying 2001 §5 |
//! | [`progressive`] | `progressive`: Zhang 2003 §5 |
//! | [`choosy`] | Castellanos and Williams: faces in place of vertices, with an entry of its own |
//!
//! Parts: the [`k_coherence`] rule, [`distance_floor`], [`reuse_penalty`], [`seam_repair`].

pub(crate) mod adaptive;
pub mod choosy;
mod coherent;
pub(crate) mod distance_floor;
pub(crate) mod k_coherence;
pub(crate) mod multiscale;
pub(crate) mod progressive;
pub(crate) mod reuse_penalty;
pub(crate) mod seam_repair;
pub(crate) mod tong;
mod wei_levoy;

use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::sites::level::{SiteHierarchy, Sites};
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::options::{Method, SynthesisOptions, needs_faces};

/// Synthesizes all levels and returns the finest.
///
/// `finished` is handed every level when it is done; `begun` is one that an earlier run of the same
/// inputs and options finished. Errors: inputs and options that do not fit
/// ([`check`](super::check)), and [`Error::Interrupted`].
pub fn synthesize<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
    begun: Option<LevelMap>,
    finished: &mut dyn FnMut(&LevelMap) -> Result<()>,
    progress: Progress<'_>,
) -> Result<LevelMap> {
    if let Some(map) = &begun {
        check_begun(inputs.sites, map)?;
    }
    let recipe = match options.method {
        Method::KCoherence => tong::tong,
        Method::WeiLevoy => wei_levoy::wei_levoy,
        Method::Adaptive => adaptive::adaptive,
        Method::Multiscale => multiscale::multiscale,
        Method::Coherent => coherent::coherent,
        Method::Progressive => progressive::progressive,
        Method::Choosy => return Err(needs_faces()),
    };
    recipe(inputs, options, begun, finished, progress)
}

/// Refuses a finished level that these sites do not have.
fn check_begun<const N: usize, S: Sites<N>>(
    sites: &SiteHierarchy<S>,
    map: &LevelMap,
) -> Result<()> {
    let level = map.level.index();
    let wanted = sites.levels.get(level).map(Sites::count);
    if wanted == Some(map.coords.len()) {
        return Ok(());
    }
    let expected = wanted.map_or("a level of the target".into(), |count| {
        format!("{count} sites")
    });
    let found = format!("{} coordinates", map.coords.len());
    Err(Error::data(format!("finished level {level}"), found).expected(expected))
}
