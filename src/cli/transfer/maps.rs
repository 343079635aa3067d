//! `--maps` of `mesotex transfer`: files, each with what it is where that is said, read as channels of the
//! sample.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::btf::bake::maps::shown_by_names;
use crate::cli::exemplar::channels::{alpha_image, read_one, shaped};
use crate::cli::exemplar::option_values::ImageEncoding;
use crate::cli::exemplar::reading::ImageReader;
use crate::error::{Error, Result};
use crate::exemplar::channels::ChannelKind;
use crate::format::image::FloatImage;
use crate::grid::TexelGrid;
use crate::textures::channel::SampleChannel;

/// One entry of `--maps`: `FILE`, or `KIND:FILE`.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFile {
    /// What the file is, where the entry says so.
    pub kind: Option<ChannelKind>,
    /// The file.
    pub path: PathBuf,
}

impl FromStr for MapFile {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let stated = text.split_once(':').and_then(|(word, file)| {
            let kind = ChannelKind::ALL
                .into_iter()
                .find(|kind| kind.name() == word)?;
            Some((kind, file))
        });
        let (kind, file) = match stated {
            Some((kind, file)) => (Some(kind), file),
            None => (None, text),
        };
        match file.is_empty() {
            true => Err(format!(
                "`{text}` names no file; expected FILE or KIND:FILE"
            )),
            false => Ok(Self {
                kind,
                path: file.into(),
            }),
        }
    }
}

/// Reads maps as channels of a sample's grid, each named after its file, with so much detail per texel as is
/// wanted.
pub(super) fn read(
    maps: &[MapFile],
    (grid, detail): (TexelGrid, u32),
    encoding: ImageEncoding,
    reader: &mut ImageReader,
) -> Result<Vec<SampleChannel>> {
    // Name each channel after its file.
    let paths: Vec<PathBuf> = maps.iter().map(|map| map.path.clone()).collect();
    let shown = shown_by_names(&paths);
    let mut named = Names::default();
    let mut channels = Vec::new();
    // Read each map, and its alpha as a channel of its own.
    for (map, shown) in maps.iter().zip(shown) {
        let path = &map.path;
        let (kind, read) = read_one(path, (map.kind, shown), encoding, reader)?;
        let alpha = alpha_image(&read.image, read.alpha, path)?;
        let image = shaped(read.image, kind, path)?;
        let name = named.take(&stem_of(path));
        let made = |name: String, kind, image: FloatImage| {
            let channel = SampleChannel::of_image(name, kind, image, grid, detail);
            channel.map_err(|error| error.in_file(path))
        };
        let alpha = alpha.map(|alpha| {
            made(
                named.take(&format!("{name}-alpha")),
                ChannelKind::Alpha,
                alpha,
            )
        });
        channels.push(made(name, kind, image)?);
        channels.extend(alpha.transpose()?);
    }
    Ok(channels)
}

/// Refuses maps that are one file twice, which would be a slip.
pub(super) fn check(maps: &[MapFile]) -> Result<()> {
    let mut seen = BTreeSet::new();
    match maps.iter().find(|map| !seen.insert(&map.path)) {
        None => Ok(()),
        Some(map) => Err(Error::option(
            "maps",
            format!("{} twice", map.path.display()),
            "each file once",
        )),
    }
}

fn stem_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    stem.chars().filter(|sign| !sign.is_control()).collect()
}

/// Names that were given.
#[derive(Default)]
struct Names(BTreeSet<String>);

impl Names {
    /// A name, numbered where it was given before.
    fn take(&mut self, name: &str) -> String {
        let numbered = |number: usize| match number {
            1 => name.to_owned(),
            _ => format!("{name}-{number}"),
        };
        let mut names = (1..=self.0.len()).map(numbered);
        let free = names.find(|name| !self.0.contains(name));
        let free = free.unwrap_or_else(|| numbered(self.0.len() + 1));
        self.0.insert(free.clone());
        free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_stand_before_a_colon() {
        let parsed = |text: &str| text.parse::<MapFile>().unwrap();
        let map = parsed("normal:maps/n.png");
        assert_eq!(
            (map.kind, map.path),
            (Some(ChannelKind::Normal), "maps/n.png".into())
        );
        for plain in ["n.png", "c:/n.png", "normals:n.png"] {
            let map = parsed(plain);
            assert_eq!((map.kind, map.path), (None, plain.into()));
        }
        assert!("mask:".parse::<MapFile>().is_err() && "".parse::<MapFile>().is_err());
    }

    #[test]
    fn names_differ() {
        let mut names = Names::default();
        let taken = ["a", "a", "a-2", "a"].map(|name| names.take(name));
        assert_eq!(taken, ["a", "a-2", "a-2-2", "a-3"]);
    }
}
