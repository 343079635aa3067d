//! `atlas.json`: what an atlas' folder holds, and where it comes from.

use std::collections::BTreeSet;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::json;
use crate::format::own_folder::is_plain_name;
use crate::format::polygon_mesh::FARTHEST;
use crate::grid::TexelGrid;
use crate::maps::header::{LONGEST, is_method_name};
use crate::mesh::atlas::MOST_TEXELS;

/// The file's name.
pub const DESCRIPTION: &str = "atlas.json";
/// `format` in it.
pub const FORMAT: &str = "mesotex-atlas";
/// The version written, and the only one read.
pub const VERSION: u32 = 1;

/// The most columns and rows of an atlas.
pub const LARGEST: u32 = 16384;

/// The kinds of channels.
const KINDS: [&str; 5] = ["color", "height", "mask", "alpha", "normal"];

/// `atlas.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    pub(super) format: String,
    pub(super) version: u32,
    /// Columns of the atlas.
    pub width: u32,
    /// Rows of the atlas.
    pub height: u32,
    /// Columns and rows of the sample.
    pub exemplar: [u32; 2],
    /// Whether opposite borders of the sample continue each other.
    pub tileable: bool,
    /// Mesh units that a texel of the sample covers.
    pub texel: f64,
    /// What the positions count from.
    pub origin: [f64; 3],
    /// The seed.
    pub seed: u64,
    /// The method, as `--method` names it.
    pub method: String,
    /// Rounds of polish that ended it; absent where there were none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub polish: u32,
    /// Where the atlas comes from, and what its files are.
    #[serde(flatten)]
    pub ids: AtlasIds,
    /// The images of the folder.
    pub channels: Vec<ChannelFile>,
}

fn is_zero(rounds: &u32) -> bool {
    *rounds == 0
}

/// The ids of what an atlas was made of, and of its files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AtlasIds {
    /// The id of the sample.
    pub sample: ContentId,
    /// The id of the space.
    pub space: ContentId,
    /// BLAKE3 of `coords.npy`.
    pub coords: ContentId,
    /// BLAKE3 of `texton.npy`, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texton: Option<ContentId>,
    /// The id of `surface.npz`.
    pub surface: ContentId,
}

/// An image of a folder of textures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelFile {
    /// The channel's name, no other's.
    pub name: String,
    /// `color`, `height`, `mask`, `alpha` or `normal`.
    pub kind: String,
    /// The file's name in the folder.
    pub file: String,
    /// What a stored 0 stands for in a PNG.
    pub low: f64,
    /// What the largest stored integer stands for in a PNG.
    pub high: f64,
}

/// The part of a description that every folder of textures has.
#[derive(Deserialize)]
struct Listing {
    width: u32,
    height: u32,
    channels: Vec<ChannelFile>,
}

/// Reads the size and the images that the description of a folder of textures states.
pub fn read_channels(path: &Path) -> Result<([u32; 2], Vec<ChannelFile>)> {
    let listing: Listing = json::read(path)?;
    check_channels(&listing.channels).map_err(|error| error.in_file(path))?;
    Ok(([listing.width, listing.height], listing.channels))
}

impl Description {
    /// Reads and checks the description in a folder; the other files are not looked at.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(DESCRIPTION);
        let head: Value = json::read(&path)?;
        let format = head.get("format").and_then(Value::as_str).unwrap_or("none");
        if format != FORMAT {
            return Err(Error::data("format", format!("`{format}`"))
                .expected(format!(
                    "{FORMAT}, as `mesotex synth --onto atlas` writes it"
                ))
                .in_file(&path));
        }
        let description: Self = json::read(&path)?;
        description.check().map_err(|error| error.in_file(&path))?;
        Ok(description)
    }

    /// The sample's grid at level 0.
    pub fn grid(&self) -> TexelGrid {
        TexelGrid {
            width: self.exemplar[0],
            height: self.exemplar[1],
            tileable: self.tileable,
        }
    }

    /// Texels in all, those outside charts included.
    pub fn texels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    pub(super) fn check(&self) -> Result<()> {
        let fault = |field: &str, found: String, expected: &str| {
            Err(Error::data(field, found).expected(expected))
        };
        // Check the version.
        if self.version != VERSION {
            return fault("version", self.version.to_string(), "1");
        }
        // Check sizes.
        let sides = |[width, height]: [u32; 2]| format!("{width} × {height}");
        let within =
            |sides: [u32; 2], most: u32| sides.iter().all(|side| (1..=most).contains(side));
        if !within([self.width, self.height], LARGEST) {
            let found = sides([self.width, self.height]);
            return fault("width, height", found, "1 to 16384 each");
        }
        if self.texels() > MOST_TEXELS {
            let expected = format!("at most {MOST_TEXELS} texels");
            return fault("width, height", sides([self.width, self.height]), &expected);
        }
        if !within(self.exemplar, LONGEST) {
            return fault("exemplar", sides(self.exemplar), "two sides, 1 to 65535");
        }
        // Check scale, origin and method.
        if !(1.0 / FARTHEST..=FARTHEST).contains(&self.texel) {
            return fault(
                "texel",
                self.texel.to_string(),
                "a number from 1e-15 to 1e15",
            );
        }
        if !self.origin.iter().all(|value| value.abs() <= FARTHEST) {
            let found = format!("{:?}", self.origin);
            return fault("origin", found, "three numbers, none beyond 1e15");
        }
        if !is_method_name(&self.method) {
            let found = format!("`{}`", self.method);
            return fault("method", found, "a name of small letters and hyphens");
        }
        check_channels(&self.channels)
    }
}

/// Refuses files that lie elsewhere, names that repeat, and ranges that are none.
fn check_channels(channels: &[ChannelFile]) -> Result<()> {
    let mut names = BTreeSet::new();
    for (at, channel) in channels.iter().enumerate() {
        let fault = |field: &str, found: String, expected: &str| {
            Err(Error::data(format!("channels[{at}]: {field}"), found).expected(expected))
        };
        if !is_plain_name(&channel.file) {
            let found = format!("`{}`", channel.file);
            return fault("file", found, "the name of a file in the folder");
        }
        if !names.insert(&channel.name) {
            let found = format!("`{}` again", channel.name);
            return fault("name", found, "names that differ");
        }
        if !KINDS.contains(&channel.kind.as_str()) {
            let found = format!("`{}`", channel.kind);
            return fault("kind", found, "color, height, mask, alpha or normal");
        }
        if !(channel.low < channel.high && (channel.high - channel.low).is_finite()) {
            let found = format!("{}, {}", channel.low, channel.high);
            return fault("low, high", found, "low below high");
        }
    }
    Ok(())
}
