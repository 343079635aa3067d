//! `mesotex export` of image sets.

use std::path::Path;

use crate::btf::image_sets::{ImageSet, export_set};
use crate::btf::sample::Sample;
use crate::cli::outcome::Outcome;
use crate::cli::session::Session;
use crate::error::Result;

/// Writes a sample as an image set.
pub(super) fn run(sample: &Path, set: ImageSet, out: &Path, session: &Session) -> Result<Outcome> {
    let sample = Sample::open(sample)?;
    let exported = export_set(&sample, set, out, session.progress())?;
    let clipped = exported.clipped;
    if clipped > 0 {
        session.progress().warn(format!(
            "{clipped} values are brighter than white (above 1) and are clipped, as 8 bits cannot hold them (--to \
             folder or utia-exr keeps them)"
        ));
    }
    Ok(Outcome::default()
        .line(format!(
            "{} images of `{}`",
            exported.images,
            sample.description().name
        ))
        .figure("images", exported.images)
        .figure("clipped", clipped)
        .wrote(out)
        .next(format!("mesotex import {} -o NAME.sample", out.display())))
}
