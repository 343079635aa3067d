//! An atlas: its size, its charts, its images.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::json;

use crate::cli::info::map::with_header;
use crate::cli::outcome::Outcome;
use crate::error::{Error, Result};
use crate::format::image::{self, ReadOptions};
use crate::format::own_folder::OwnFolder;
use crate::index::TextonLabel;
use crate::maps::atlas_map::description::{Description, read_channels};
use crate::maps::atlas_map::{AtlasMap, ChannelFile};

/// Reads a whole atlas and describes its content.
pub fn describe(path: &Path) -> Result<Outcome> {
    let description = Description::read(path)?;
    let map = AtlasMap::read(path)?;
    // Count what the texels hold.
    let inside = map.chart.iter().filter(|chart| **chart >= 0).count();
    let charts = map
        .chart
        .iter()
        .filter(|chart| **chart >= 0)
        .collect::<BTreeSet<_>>();
    let labelled = map
        .textons
        .iter()
        .filter(|label| **label != TextonLabel::NONE)
        .count();
    let (width, height) = (map.width, map.height);
    // Tell size, scale and origin.
    let outcome = Outcome::default()
        .line(format!(
            "atlas of {width} × {height} texels, {inside} in {} charts; {} triangles, sample of {} × {} texels",
            charts.len(),
            map.mesh.triangles.len(),
            map.header.exemplar[0],
            map.header.exemplar[1],
        ))
        .line(format!(
            "a texel of the sample covers {:.6} mesh units; method {}, seed {}",
            map.header.texel, map.header.method, map.header.seed
        ))
        .line(format!("{labelled} texels have a texton"))
        .figure("kind", "atlas")
        .figure("width", width)
        .figure("height", height)
        .figure("texels", inside)
        .figure("charts", charts.len())
        .figure("triangles", map.mesh.triangles.len())
        .figure("exemplar", map.header.exemplar.to_vec())
        .figure("tileable", map.tileable);
    let outcome = with_header(outcome, &map.header);
    images(outcome, path, [width, height], &description.channels)
}

/// Reads the images of a folder of textures and says what they are.
pub fn describe_textures(path: &Path, kind: &OwnFolder) -> Result<Outcome> {
    let (size, channels) = read_channels(&path.join(kind.description))?;
    let outcome = Outcome::default()
        .line(format!("textures of {} × {} texels", size[0], size[1]))
        .figure("kind", "textures")
        .figure("width", size[0])
        .figure("height", size[1]);
    images(outcome, path, size, &channels)
}

/// Reads every image; all are of one size.
fn images(
    outcome: Outcome,
    folder: &Path,
    size: [u32; 2],
    channels: &[ChannelFile],
) -> Result<Outcome> {
    let mut outcome = outcome;
    for channel in channels {
        let path = folder.join(&channel.file);
        let image = image::read_with(&path, &ReadOptions::data())?.image;
        image.check_finite().map_err(|error| error.in_file(&path))?;
        if [image.width, image.height] != size {
            return Err(
                Error::data("size", format!("{} × {}", image.width, image.height))
                    .expected(format!("{} × {}, as the folder states", size[0], size[1]))
                    .in_file(&path),
            );
        }
        outcome = outcome.line(format!(
            "channel `{}`: {}, {}, {} to {}",
            channel.name, channel.kind, channel.file, channel.low, channel.high
        ));
    }
    Ok(outcome.figure("channels", json!(channels)))
}
