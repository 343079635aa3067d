//! Parts of a sample: some of its images, made by one of several runs, and how they are joined to the sample of all.
//!
//! In: the description of a whole sample and what a shard makes of it, or the folders of all parts. Out: the
//! description of a part, or the sample that one run makes, byte for byte. A part is a sample folder with the
//! directions of the whole sample and the list of its own images; its `source` has one field more, `part`, which is a
//! [`Record`].

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::btf::height_map::HeightMap;
use crate::btf::sample::{DESCRIPTION, Description, Layout, Sample};
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::seal::ENGINE;
use crate::progress::Progress;
use crate::shard::{self, Shard};

/// The field of `source` that parts alone have.
const PART: &str = "part";

/// The commands that make parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Maker {
    Bake,
    Import,
}

impl Maker {
    fn name(self) -> &'static str {
        match self {
            Self::Bake => "bake",
            Self::Import => "import",
        }
    }
}

/// The part that a shard makes: its images, and what they are made from.
#[derive(Clone, Debug)]
pub(super) struct NewPart {
    pub(super) maker: Maker,
    pub(super) shard: Shard,
    /// The images, of those of the whole sample.
    pub(super) images: Range<usize>,
    /// What every part is made from and with, beyond what the description says: all parts have the same.
    pub(super) made_from: Map<String, Value>,
    /// The id of what this part alone is made from, where there is such.
    pub(super) own: Option<ContentId>,
}

/// What a part's description says beyond that of the whole sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Record {
    maker: Maker,
    shard: Shard,
    /// The first image, and the one after the last.
    images: [usize; 2],
    /// How many images all parts have.
    images_in_all: usize,
    /// Whether the whole sample has every view with every light.
    is_product: bool,
    /// The version of the program.
    program: String,
    #[serde(default)]
    made_from: Map<String, Value>,
    #[serde(default)]
    own: Option<ContentId>,
}

impl NewPart {
    /// The description of the part, from that of the whole sample.
    pub(super) fn described_in(&self, whole: &Description) -> Description {
        let pair = |image: usize| {
            let (view, light) = whole.view_and_light(image);
            [view as u32, light as u32]
        };
        let record = Record {
            maker: self.maker,
            shard: self.shard,
            images: [self.images.start, self.images.end],
            images_in_all: whole.image_count(),
            is_product: whole.pairs.is_none(),
            program: ENGINE.into(),
            made_from: self.made_from.clone(),
            own: self.own.clone(),
        };
        let mut part = whole.clone();
        part.layout = Layout::Pairs;
        part.pairs = Some(self.images.clone().map(pair).collect());
        part.source[PART] = json!(record);
        part
    }
}

/// What a run wrote.
#[derive(Clone, Debug)]
pub struct WrittenSample {
    /// The description of the sample, or of the part of a shard.
    pub description: Description,
    /// Images that an interrupted run had written already.
    pub resumed: usize,
    /// Whether the part was there, whole, and nothing was done.
    pub is_kept: bool,
}

impl WrittenSample {
    /// A sample that was made from the start.
    pub(super) fn anew(description: Description) -> Self {
        Self {
            description,
            resumed: 0,
            is_kept: false,
        }
    }

    /// A part that stays as it is.
    pub(super) fn kept(description: Description) -> Self {
        Self {
            resumed: description.image_count(),
            description,
            is_kept: true,
        }
    }
}

/// Writes a sample, or the part `new_part` of it. `write` adds the images of a range of the whole sample. An existing
/// part is kept, and one that was interrupted is continued.
pub(super) fn write_sample_or_part(
    target: &Path,
    whole: Description,
    new_part: Option<&NewPart>,
    heights: Option<HeightMap>,
    write: impl FnOnce(&mut SampleWriter, Range<usize>) -> Result<()>,
) -> Result<WrittenSample> {
    let Some(new_part) = new_part else {
        let images = 0..whole.image_count();
        let mut writer = SampleWriter::create(target, whole)?;
        writer.set_heights(heights);
        write(&mut writer, images)?;
        return writer.finish().map(WrittenSample::anew);
    };
    let part = new_part.described_in(&whole);
    if let Some(found) = find(target, |_| part.clone(), heights.as_ref()) {
        return Ok(WrittenSample::kept(found));
    }
    let mut writer = SampleWriter::resume(target, part)?;
    writer.set_heights(heights);
    let resumed = writer.images_written();
    let images = new_part.images.start + resumed..new_part.images.end;
    let written = write(&mut writer, images);
    finish(writer, written, resumed)
}

/// Finishes a part. What an interruption leaves stays, to be continued; what a failure leaves is removed.
pub(super) fn finish(
    writer: SampleWriter,
    written: Result<()>,
    resumed: usize,
) -> Result<WrittenSample> {
    match written {
        Ok(()) => Ok(WrittenSample {
            description: writer.finish()?,
            resumed,
            is_kept: false,
        }),
        Err(Error::Interrupted) => Err(Error::Interrupted),
        Err(error) => {
            writer.discard();
            Err(error)
        }
    }
}

/// The description of `target` where that is the whole sample that is expected, its id aside: every byte is hashed.
/// `expected` is asked with what is found.
pub(super) fn find(
    target: &Path,
    expected: impl FnOnce(&Description) -> Description,
    heights: Option<&HeightMap>,
) -> Option<Description> {
    let sample = Sample::open(target).ok()?;
    let found = sample.description();
    let expected = Description {
        id: found.id.clone(),
        ..expected(found)
    };
    let is_whole = *found == expected
        && sample.heights().ok()?.as_ref() == heights
        && sample.content_id().ok()? == found.id;
    is_whole.then(|| found.clone())
}

/// One part, open for reading.
struct Part<'a> {
    folder: &'a Path,
    sample: Sample,
    record: Record,
    /// What the whole sample is described by, without the list of images and the id.
    whole: Description,
}

impl<'a> Part<'a> {
    fn open(folder: &'a Path, maker: Maker) -> Result<Self> {
        let sample = Sample::open(folder)?;
        let mut whole = sample.description().clone();
        let field = match &mut whole.source {
            Value::Object(fields) => fields.shift_remove(PART),
            _ => None,
        };
        let expected = || format!("a part, as `mesotex {} --shard` writes it", maker.name());
        let Some(field) = field else {
            return Err(Error::data("source: part", "missing")
                .expected(expected())
                .in_file(&folder.join(DESCRIPTION)));
        };
        let record: Record = serde_json::from_value(field).map_err(|error| {
            Error::data("source: part", error.to_string())
                .expected(expected())
                .in_file(&folder.join(DESCRIPTION))
        })?;
        whole.pairs = None;
        whole.layout = Layout::Product;
        whole.id = ContentId::of_bytes(b"");
        let part = Self {
            folder,
            sample,
            record,
            whole,
        };
        part.check(maker)?;
        Ok(part)
    }

    fn shard(&self) -> Shard {
        self.record.shard
    }

    /// Refuses parts of another command or version, and those that have not the images they state.
    fn check(&self, maker: Maker) -> Result<()> {
        let Record {
            images: [start, end],
            images_in_all: all,
            ..
        } = self.record;
        let in_file = |error: Error| Err(error.in_file(&self.folder.join(DESCRIPTION)));
        if self.record.maker != maker {
            let own = self.record.maker.name();
            return in_file(
                Error::data("source: part", format!("made by `mesotex {own}`")).expected(format!(
                    "a part, as `mesotex {} --shard` writes it",
                    maker.name()
                )),
            );
        }
        if self.record.program != ENGINE {
            let found = format!("version {}", self.record.program);
            return in_file(
                Error::data("source: part", found)
                    .expected(format!("version {ENGINE} of the program"))
                    .advice("make the part again with this version"),
            );
        }
        let held = self.sample.description().pairs.as_ref().map(Vec::len);
        match start <= end && end <= all && held == Some(end - start) {
            true => Ok(()),
            false => in_file(
                Error::data("pairs", format!("{}", held.unwrap_or(0)))
                    .expected(format!("images {start} to {end} of {all}")),
            ),
        }
    }

    /// How a part differs from the first; `None` where both belong to one sample.
    fn difference(&self, first: &Self) -> Option<String> {
        let [own, other] = [self, first].map(Self::common);
        let differing = own
            .iter()
            .map(|(name, value)| (name, value, other.get(name).unwrap_or(&Value::Null)))
            .filter(|(_, own, other)| own != other);
        let listed: Vec<String> = differing
            .map(|(name, own, other)| format!("{name} {own}, not {other}"))
            .collect();
        let has_other_directions =
            self.whole.views != first.whole.views || self.whole.lights != first.whole.lights;
        match (listed.is_empty(), has_other_directions) {
            (true, false) => None,
            (true, true) => Some(format!("{} has other directions", self.folder.display())),
            (false, _) => Some(format!(
                "{} has {}",
                self.folder.display(),
                listed.join(", ")
            )),
        }
    }

    /// What all parts of one sample have in common, by name; the directions are compared beside it.
    fn common(&self) -> BTreeMap<String, Value> {
        let (whole, record) = (&self.whole, &self.record);
        let fields = [
            ("name", json!(whole.name)),
            ("width", json!(whole.width)),
            ("height", json!(whole.height)),
            ("dtype", json!(whole.dtype)),
            ("tileable", json!(whole.tileable)),
            ("texel_mm", json!(whole.texel_mm)),
            ("views", json!(whole.views.len())),
            ("lights", json!(whole.lights.len())),
            ("images", json!(record.images_in_all)),
            ("every view with every light:", json!(record.is_product)),
        ];
        let fields = fields.map(|(name, value)| (name.to_owned(), value));
        let source = whole.source.as_object().cloned().unwrap_or_default();
        let more = source.into_iter().chain(record.made_from.clone());
        fields.into_iter().chain(more).collect()
    }
}

/// Joins the parts of all shards to the sample `target`, as one run makes it; returns its description. Refuses parts of
/// other samples than the first, and shards that are missing or there twice.
pub(super) fn join(
    parts: &[PathBuf],
    maker: Maker,
    target: &Path,
    progress: Progress<'_>,
) -> Result<Description> {
    // Open the parts, and put them in order.
    let opened = parts.iter().map(|path| Part::open(path, maker));
    let mut parts: Vec<Part<'_>> = opened.collect::<Result<_>>()?;
    check_alike(&parts)?;
    let shards: Vec<_> = parts
        .iter()
        .map(|part| (part.folder, part.shard()))
        .collect();
    shard::in_order(&shards)?;
    parts.sort_by_key(Part::shard);
    check_seamless(&parts)?;
    // Copy their images.
    let whole = whole_of(&parts);
    progress.begin("join", whole.image_count() as u64);
    let mut writer = SampleWriter::create(target, whole)?;
    writer.set_heights(parts[0].sample.heights()?);
    for part in &parts {
        writer.append(part.folder, part.sample.description(), progress)?;
    }
    progress.end();
    writer.finish()
}

/// The description of the sample of all parts, in order.
fn whole_of(parts: &[Part<'_>]) -> Description {
    let whole = parts[0].whole.clone();
    if parts[0].record.is_product {
        return whole;
    }
    let pairs = parts
        .iter()
        .flat_map(|part| part.sample.description().pairs.iter().flatten());
    Description {
        pairs: Some(pairs.copied().collect()),
        layout: Layout::Pairs,
        ..whole
    }
}

/// Refuses parts of another sample than the first, naming each.
fn check_alike(parts: &[Part<'_>]) -> Result<()> {
    let Some(first) = parts.first() else {
        return Err(Error::option("reduce", "no part", "all parts"));
    };
    let others = parts.iter().filter_map(|part| part.difference(first));
    let others: Vec<String> = others.collect();
    match others.is_empty() {
        true => Ok(()),
        false => Err(Error::data("parts", others.join("; "))
            .expected(format!(
                "parts of one sample, as {}",
                first.folder.display()
            ))
            .advice("give every shard the same input and options")),
    }
}

/// Refuses parts of which one does not begin where the part before ends.
fn check_seamless(parts: &[Part<'_>]) -> Result<()> {
    let mut end = 0;
    for part in parts {
        let [first, next] = part.record.images;
        if first != end {
            return Err(
                Error::data("source: part", format!("images from {first} on"))
                    .expected(format!("images from {end} on"))
                    .in_file(&part.folder.join(DESCRIPTION)),
            );
        }
        end = next;
    }
    let all = parts.first().map_or(0, |part| part.record.images_in_all);
    match end == all {
        true => Ok(()),
        false => Err(Error::data("parts", format!("{end} images")).expected(format!("{all}"))),
    }
}
