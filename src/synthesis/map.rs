//! The entry point of the engine: from a space, a neighbour table and a target to a surface texton map.

use crate::error::Result;
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space};
use crate::grid::TexCoord;
use crate::index::TextonLabel;
use crate::maps::header::MapHeader;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::progress::Progress;
use crate::sites::controls::SiteControls;
use crate::sites::level::{SiteHierarchy, Sites};
use crate::sites::target::{Target, WithSites};
use crate::synthesis::all_levels::synthesize;
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::options::{Method, SynthesisOptions};
use crate::synthesis::pattern_controls::PatternControls;

/// Synthesizes a map on a target. Errors: inputs and options that do not fit, and
/// [`Error::Interrupted`](crate::error::Error::Interrupted).
pub fn synthesize_map(
    space: &Space,
    table: &NeighborTable,
    target: &Target,
    options: &SynthesisOptions,
    progress: Progress<'_>,
) -> Result<SurfaceTextonMap> {
    let work = AllLevels {
        space,
        table,
        controls: target.controls.as_ref(),
        options,
        progress,
    };
    let finest = target.sites.with(work)?;
    Ok(surface_map(space, target, finest.coords, options))
}

struct AllLevels<'a> {
    space: &'a Space,
    table: &'a NeighborTable,
    controls: Option<&'a SiteControls>,
    options: &'a SynthesisOptions,
    progress: Progress<'a>,
}

impl WithSites for AllLevels<'_> {
    type Found = Result<LevelMap>;

    fn run<const N: usize, S: Sites<N>>(self, sites: &SiteHierarchy<S>) -> Result<LevelMap> {
        let inputs = Inputs {
            space: self.space,
            table: self.table,
            sites,
            controls: self.controls,
        };
        synthesize(inputs, self.options, None, &mut |_| Ok(()), self.progress)
    }
}

/// The map of finished coordinates on the target's surface; vertices in no face hold nothing.
pub fn surface_map(
    space: &Space,
    target: &Target,
    coords: Vec<TexCoord>,
    options: &SynthesisOptions,
) -> SurfaceTextonMap {
    let (surface, grid) = (&target.surface, space.levels[0].grid);
    let controls = target.controls.as_ref();
    let pattern = PatternControls::of(space, options.method);
    let mut map = SurfaceTextonMap {
        mesh: surface.mesh.clone(),
        normals: surface.normals.clone(),
        orientations: pattern.turned(&surface.orientations, &surface.normals, &coords),
        transition: pattern
            .varies
            .then(|| controls.map(|of| of.transition.clone()))
            .flatten(),
        mask: pattern.labels(&coords),
        scale: surface.scale.clone(),
        textons: textons(space, &coords),
        coords,
        header: MapHeader {
            exemplar: [grid.width, grid.height],
            texel: surface.texel,
            origin: surface.origin,
            seed: options.seed,
            method: options.method.name().into(),
            polish: polish_rounds(options, grid.tileable),
            sample: space.sample.clone(),
            space: space.id.clone(),
        },
    };
    if surface.atlas.is_some() {
        // A texel need not have four of its chart round it.
        return map;
    }
    let in_face = map.mesh.referenced();
    for vertex in (0..in_face.len()).filter(|&vertex| !in_face[vertex]) {
        map.coords[vertex] = TexCoord { s: 0.5, t: 0.5 };
        map.textons[vertex] = TextonLabel::NONE;
    }
    map
}

/// The rounds of polish that end a map; only one method has any.
fn polish_rounds(options: &SynthesisOptions, tileable: bool) -> u32 {
    match options.method {
        Method::KCoherence => options.k_coherence.polish.rounds(tileable),
        _ => 0,
    }
}

/// The texton of every coordinate of level 0; [`TextonLabel::NONE`] for plain images.
pub fn textons(space: &Space, coords: &[TexCoord]) -> Vec<TextonLabel> {
    let level = &space.levels[0];
    let label = |&at: &TexCoord| match &level.features {
        Features::Textons { labels, .. } => {
            TextonLabel(labels[level.grid.texel_nearest(at).index()])
        }
        Features::Plain(_) => TextonLabel::NONE,
    };
    coords.iter().map(label).collect()
}
