//! The chapter of the sample: what it is, and the relief it was baked from.

use crate::btf::sample::Sample;
use crate::cli::Command;
use crate::cli::report::products::Products;
use crate::cli::session::Session;
use crate::error::{Error, Result};
use crate::format::rgb_image::RgbImage;
use crate::report::embedded::Embedded;
use crate::report::summary::Chapter;

/// What is known of the sample.
pub(super) fn chapter(
    products: &Products,
    sample: Option<&Sample>,
    session: &Session,
) -> Result<Chapter> {
    let mut chapter = Chapter::default();
    let Some(sample) = sample else {
        chapter.note("no sample is there yet: bake or import one");
        return Ok(chapter);
    };
    // State the facts of its description.
    let of = sample.description();
    chapter.fact("name", &of.name);
    chapter.fact("size", format!("{} × {} texels", of.width, of.height));
    chapter.fact(
        "images",
        match &of.pairs {
            None => format!("{} views × {} lights", of.views.len(), of.lights.len()),
            Some(pairs) => format!("{} pairs of a view and a light", pairs.len()),
        },
    );
    chapter.fact("tileable", if of.tileable { "yes" } else { "no" });
    if let Some(millimetres) = of.texel_mm {
        chapter.fact("side of a texel", format!("{millimetres} mm"));
    }
    if let Some(factors) = of.factors() {
        chapter.fact("stored as", format!("factors of rank {}", factors.rank));
    }
    chapter.fact("id", &of.id);
    // Show its relief.
    match relief(products, sample, session)? {
        Some(picture) => chapter.pictures.push(Embedded::new(
            &picture,
            "above: the flat texture, and the relief it was baked from; below: images, a row per view, a column per light",
        )?),
        None => chapter.note("no relief to show: the sample was not baked by this scene"),
    }
    Ok(chapter)
}

/// The relief that a scene's `[bake]` stage traced.
fn relief(products: &Products, sample: &Sample, session: &Session) -> Result<Option<RgbImage>> {
    let stages = products
        .overview
        .iter()
        .flat_map(|overview| &overview.stages);
    let bake = stages.into_iter().find_map(|stage| match &stage.command {
        Command::Bake(arguments) => Some((arguments, stage.seed)),
        _ => None,
    });
    let Some((arguments, seed)) = bake else {
        return Ok(None);
    };
    let folder = tempfile::tempdir().map_err(Error::io(
        std::path::Path::new("a temporary folder"),
        "make",
    ))?;
    let path = folder.path().join("relief.png");
    arguments.draw_relief(sample, &path, &session.with_seed(Some(seed)))?;
    RgbImage::read(&path).map(Some)
}
