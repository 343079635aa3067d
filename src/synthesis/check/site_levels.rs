//! Whether sites have the neighbourhoods that a method compares.

use crate::error::{Error, Result};
use crate::neighborhood::Neighborhood;
use crate::sites::level::{SiteHierarchy, Sites};

/// Checks the sites against the neighbourhoods of as many levels, finest first.
pub fn check_sites<const N: usize, S: Sites<N>>(
    sites: &SiteHierarchy<S>,
    neighborhoods: &[Neighborhood],
) -> Result<()> {
    let (levels, wanted) = (&sites.levels, neighborhoods.len());
    if levels.len() < wanted {
        return Err(Error::option(
            "levels",
            format!("{wanted}, but the target has {}", levels.len()),
            format!("at most {}", levels.len()),
        ));
    }
    for (index, neighborhood) in neighborhoods.iter().enumerate() {
        let coarser = levels.get(index + 1).filter(|_| index + 1 < wanted);
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
    // Check that there are enough sites.
    if count < samples {
        let few = format!("{count} sites, fewer than the neighbourhood's {samples} samples");
        return Err(match index {
            0 => Error::data("target", few)
                .advice("take a finer one (mesh --vertices, --resolution)"),
            _ => Error::option(
                "levels",
                format!("level {index} of the target has {few}"),
                format!("at most {index}, or a finer target"),
            ),
        });
    }
    // Check their samples.
    if sites.samples_per_site() != samples {
        let found = format!("{} samples per site", sites.samples_per_site());
        return Err(Error::data(place, found)
            .expected(format!("{samples}, as the table's neighbourhood has")));
    }
    // Check their parents and the samples on the coarser level.
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
