//! Whether exemplar, sites and options fit together, before any work is done; and what follows
//! from them.

use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::NeighborTable;
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::format::id;
use crate::neighborhood::{Neighborhood, window_width};
use crate::sites::level::Sites;
use crate::synthesis::inputs::Inputs;
use crate::synthesis::metric::of_level::gram;
use crate::synthesis::options::{MetricKind, SynthesisOptions};

/// Options as the inputs complete them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Levels that are synthesized.
    pub levels: usize,
    /// Neighbours per texel that are used.
    pub k: usize,
}

/// Checks everything and completes the options.
pub fn plan<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<Plan> {
    options.validate()?;
    exemplar(inputs.space, inputs.table)?;
    let plan = complete(inputs.space, inputs.table, options)?;
    if options.metric == MetricKind::Gram {
        inputs
            .space
            .levels
            .iter()
            .try_for_each(|level| gram(level).map(drop))?;
    }
    sites(inputs, &plan)?;
    Ok(plan)
}

/// Checks inputs of a method with round neighbourhoods of its own, and says how many levels it has.
pub fn round<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<usize> {
    options.validate()?;
    let most = inputs.space.levels.len().min(inputs.sites.levels.len());
    let levels = options.levels.map_or(most, |levels| levels as usize);
    for (index, level) in inputs.space.levels.iter().enumerate() {
        space_level(level, index)?;
    }
    if levels > most {
        return Err(Error::option(
            "levels",
            format!("{levels}, but the sample has {most}"),
            format!("at most {most}"),
        ));
    }
    let width = 2 * options.adaptive.rings + 1;
    let grid = inputs.space.levels[levels - 1].grid;
    if width > grid.width.min(grid.height) {
        return Err(Error::option(
            "rings",
            format!(
                "{}: {width} texels wide on the sample's coarsest level of {}×{}",
                options.adaptive.rings, grid.width, grid.height
            ),
            "fewer rings, or fewer --levels",
        ));
    }
    Ok(levels)
}

/// Checks options against the exemplar alone: k, levels, neighbourhood. What `synth` must know
/// before it prepares a surface.
pub fn complete(space: &Space, table: &NeighborTable, options: &SynthesisOptions) -> Result<Plan> {
    options.validate()?;
    let k = options.k_coherence.k.unwrap_or(table.k);
    if k > table.k {
        return Err(Error::option(
            "k",
            format!("{k} neighbours per texel, but the table lists {}", table.k),
            format!("at most {}, or a table made with knn --k {k}", table.k),
        ));
    }
    let most = table.levels.len();
    let levels = options.levels.map_or(most, |levels| levels as usize);
    if levels > most {
        return Err(Error::option(
            "levels",
            format!("{levels}, but the sample has {most}"),
            format!("at most {most}, or a vocabulary made with textons --levels {levels}"),
        ));
    }
    neighborhood_width(table, options)?;
    template_fits_the_sample(space, table, levels)?;
    Ok(Plan { levels, k })
}

fn neighborhood_width(table: &NeighborTable, options: &SynthesisOptions) -> Result<()> {
    let Some(asked) = options.neighborhood else {
        return Ok(());
    };
    let width = window_width(&table.levels[0].neighborhood.offsets);
    if asked == width {
        return Ok(());
    }
    Err(Error::option(
        "neighborhood",
        format!("{asked}, but the table's is {width}"),
        format!("{width}, or a table made with knn --neighborhood {asked}"),
    ))
}

fn template_fits_the_sample(space: &Space, table: &NeighborTable, levels: usize) -> Result<()> {
    let coarsest = levels - 1;
    let grid = space.levels[coarsest].grid;
    let width = window_width(&table.levels[coarsest].neighborhood.offsets);
    if width <= grid.width.min(grid.height) {
        return Ok(());
    }
    let fitting = (0..levels).take_while(|&level| {
        let grid = space.levels[level].grid;
        width <= grid.width.min(grid.height)
    });
    let found = format!(
        "a neighbourhood {width} texels wide on the sample's coarsest level of {}×{}",
        grid.width, grid.height
    );
    Err(match fitting.count() {
        0 => Error::data("neighbour table", found)
            .advice("make it with a smaller knn --neighborhood"),
        count => Error::option(
            "levels",
            format!("{levels}: {found}"),
            format!("at most {count}, or a smaller knn --neighborhood"),
        ),
    })
}

/// Checks that a space and a table are sound and describe the same texels; ids are for
/// [`same_run`].
pub fn exemplar(space: &Space, table: &NeighborTable) -> Result<()> {
    if space.levels.is_empty() || space.levels.len() != table.levels.len() {
        return Err(differ(
            format!("{} levels", table.levels.len()),
            format!("{} levels, as the space has", space.levels.len()),
        ));
    }
    for (index, (level, listed)) in space.levels.iter().zip(&table.levels).enumerate() {
        space_level(level, index)?;
        let (texels, k) = listed.neighbors.dim();
        if texels != level.grid.len() || k != table.k || k == 0 {
            return Err(differ(
                format!("L{index}: neighbours of {texels} texels, {k} each"),
                format!(
                    "{} texels, as the space has, {} each",
                    level.grid.len(),
                    table.k.max(1)
                ),
            ));
        }
        if level.grid.tileable != table.tileable {
            return Err(differ(
                format!("tileable: {}", table.tileable),
                format!("{}, as the space is", level.grid.tileable),
            ));
        }
        let out = listed
            .neighbors
            .iter()
            .find(|&&texel| texel as usize >= texels);
        if let Some(texel) = out {
            return Err(differ(
                format!("L{index}: texel {texel} among the neighbours"),
                format!("texels below {texels}"),
            ));
        }
        neighborhood(&listed.neighborhood, index)?;
    }
    Ok(())
}

fn differ(found: String, expected: String) -> Error {
    Error::data("neighbour table", found)
        .expected(expected)
        .advice("space and table are of different runs: make the table anew with knn")
}

fn space_level(level: &SpaceLevel, index: usize) -> Result<()> {
    let texels = level.grid.len();
    let place = format!("space, L{index}");
    match &level.features {
        Features::Textons { labels, gram } => {
            let textons = gram.nrows();
            if labels.len() != texels || textons < 2 || gram.ncols() != textons {
                return Err(Error::data(
                    place,
                    format!("{} labels and a Gram matrix {:?}", labels.len(), gram.dim()),
                )
                .expected(format!("{texels} labels and a square Gram matrix")));
            }
            match labels
                .iter()
                .find(|&&label| usize::from(label) >= textons - 1)
            {
                Some(label) => Err(Error::data(place, format!("label {label}"))
                    .expected(format!("labels below {}", textons - 1))),
                None => Ok(()),
            }
        }
        Features::Vectors(vectors) => {
            let (height, width, dimensions) = vectors.dim();
            if height * width == texels && dimensions > 0 && texels > 0 {
                return Ok(());
            }
            Err(Error::data(place, format!("features {:?}", vectors.dim()))
                .expected(format!("{texels} vectors of one number or more")))
        }
    }
}

fn neighborhood(neighborhood: &Neighborhood, index: usize) -> Result<()> {
    let Neighborhood {
        offsets,
        weights,
        coarse_offsets,
        coarse_weights,
    } = neighborhood;
    let sound = |weight: &f32| *weight > 0.0 && weight.is_finite();
    let matched = offsets.len() == weights.len() && coarse_offsets.len() == coarse_weights.len();
    if !offsets.is_empty() && matched && weights.iter().chain(coarse_weights).all(sound) {
        return Ok(());
    }
    Err(Error::data(
        format!("neighbour table, L{index}: offsets and weights"),
        format!(
            "{} offsets with {} weights, {} coarse ones with {}",
            offsets.len(),
            weights.len(),
            coarse_offsets.len(),
            coarse_weights.len()
        ),
    )
    .expected("a positive weight per offset"))
}

/// Checks that a table was made from a space, unless forced.
pub fn same_run(space: &Space, table: &NeighborTable, force: bool) -> Result<()> {
    id::check_same(
        "neighbour table, id of its space",
        &table.space,
        &space.id,
        force,
    )
}

/// Checks the sites against the plan and the table.
fn sites<const N: usize, S: Sites<N>>(inputs: Inputs<'_, S>, plan: &Plan) -> Result<()> {
    let levels = &inputs.sites.levels;
    if levels.len() < plan.levels {
        return Err(Error::option(
            "levels",
            format!("{}, but the target has {}", plan.levels, levels.len()),
            format!("at most {}", levels.len()),
        ));
    }
    for index in 0..plan.levels {
        let two_level = index + 1 < plan.levels;
        let neighborhood = &inputs.table.levels[index].neighborhood;
        let coarser = levels.get(index + 1).filter(|_| two_level);
        site_level(&levels[index], coarser, neighborhood, index)?;
    }
    Ok(())
}

fn site_level<const N: usize, S: Sites<N>>(
    sites: &S,
    coarser: Option<&S>,
    neighborhood: &Neighborhood,
    index: usize,
) -> Result<()> {
    let place = format!("sites, level {index}");
    let (count, samples) = (sites.count(), neighborhood.offsets.len());
    if count < samples {
        let few = format!("{count} sites, fewer than the neighbourhood's {samples} samples");
        return Err(match index {
            0 => Error::data("target", few).advice("take a finer one (mesh --vertices)"),
            _ => Error::option(
                "levels",
                format!("level {index} of the target has {few}"),
                format!("at most {index}, or a finer target"),
            ),
        });
    }
    if sites.samples_per_site() != samples {
        let found = format!("{} samples per site", sites.samples_per_site());
        return Err(Error::data(place, found)
            .expected(format!("{samples}, as the table's neighbourhood has")));
    }
    let Some(coarser) = coarser else {
        return Ok(());
    };
    let (per_site, wanted) = (
        sites.parent_samples_per_site(),
        neighborhood.coarse_offsets.len(),
    );
    let parents = sites.parents().iter();
    let sound = parents.filter(|parent| (parent.site as usize) < coarser.count());
    if per_site != wanted || sound.count() != count {
        let parents = sites.parents().len();
        return Err(Error::data(
            place,
            format!("{per_site} coarse samples per site, {parents} parents"),
        )
        .expected(format!("{wanted} coarse samples and a parent per site")));
    }
    Ok(())
}
