//! OpenEXR images with a table of angles, `angles.csv`: 32-bit floats, so that halves come back as they were.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use rayon::prelude::*;

use crate::btf::direction::Direction;
use crate::btf::image_sets::exported::Exported;
use crate::btf::image_sets::reflectance::reflectance;
use crate::btf::sample::{Layout, Sample};
use crate::error::Result;
use crate::format::atomic;
use crate::format::exr::{self, Compression, ExrImage, Numbers};
use crate::progress::Progress;

/// The table's name.
const TABLE: &str = "angles.csv";
/// Its columns.
const HEADER: &str = "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\n";

/// Writes all images of a sample and their table into `folder`.
pub(super) fn write_with_table(
    sample: &Sample,
    folder: &Path,
    progress: Progress<'_>,
) -> Result<Exported> {
    let description = sample.description();
    let count = sample.image_count();
    let mut table = HEADER.to_owned();
    for image in 0..count {
        let (view, light) = description.view_and_light(image);
        let (view, light) = (description.views[view], description.lights[light]);
        // A `String` takes whatever is written to it.
        let _ = writeln!(
            table,
            "{},{},{}",
            name(sample, image),
            angles(view),
            angles(light)
        );
    }
    atomic::write_file(&folder.join(TABLE), |sink| sink.write_all(table.as_bytes()))?;
    (0..count).into_par_iter().try_for_each(|image| {
        write_image(sample, image, &folder.join(name(sample, image)))?;
        progress.advance(1)
    })?;
    Ok(Exported {
        images: count,
        clipped: 0,
    })
}

fn name(sample: &Sample, image: usize) -> String {
    let description = sample.description();
    let (view, light) = description.view_and_light(image);
    match description.layout {
        Layout::Product => format!("view{view:03}_light{light:03}.exr"),
        _ => format!("image{image:05}.exr"),
    }
}

/// θ and φ in degrees, all digits.
fn angles(direction: Direction) -> String {
    format!(
        "{},{}",
        direction.theta().to_degrees(),
        direction.phi().to_degrees()
    )
}

fn write_image(sample: &Sample, image: usize, path: &Path) -> Result<()> {
    let numbers = reflectance(sample, image)?;
    let plane = |channel: usize| {
        let values = numbers.iter().skip(channel).step_by(3).copied();
        Numbers::Float(Cow::Owned(values.collect()))
    };
    let channels: BTreeMap<String, Numbers<'_>> = ["R", "G", "B"]
        .into_iter()
        .enumerate()
        .map(|(channel, name)| (name.to_owned(), plane(channel)))
        .collect();
    let image = ExrImage {
        size: [sample.grid().width, sample.grid().height],
        channels,
        attributes: BTreeMap::new(),
    };
    exr::write(path, &exr::encode(&image, Compression::Zip)?)
}
