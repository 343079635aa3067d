//! Parts of a bake: samples of some of its views, and how they are joined to the sample of all.
//!
//! In: the description of a whole bake and a shard, or the folders of all parts. Out: the description of a part, or
//! the sample that one run bakes, byte for byte. A part is a sample folder whose `source` has three fields more:
//! the shard, how many views there are in all, and the version of the program.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::btf::sample::{DESCRIPTION, Description, Sample};
use crate::btf::writer::SampleWriter;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::seal::ENGINE;
use crate::progress::Progress;
use crate::shard::{self, Shard};

/// The fields of `source` that parts alone have.
const SHARD: &str = "shard";
const ALL_VIEWS: &str = "views-in-all";
const PROGRAM: &str = "program";

/// The description of a shard's part, from that of the whole.
pub(super) fn of_shard(whole: &Description, shard: Shard) -> Description {
    let mut part = whole.clone();
    part.views = whole.views[shard.range(whole.views.len())].to_vec();
    part.source[SHARD] = json!(shard);
    part.source[ALL_VIEWS] = json!(whole.views.len());
    part.source[PROGRAM] = json!(ENGINE);
    part
}

/// Whether `target` is the whole sample that `description` speaks of, its id aside: every byte is hashed.
pub(super) fn is_there(target: &Path, description: &Description) -> bool {
    let Ok(sample) = Sample::open(target) else {
        return false;
    };
    let expected = Description {
        id: sample.id().clone(),
        ..description.clone()
    };
    *sample.description() == expected
        && sample.heights().is_ok_and(|heights| heights.is_some())
        && sample.content_id().is_ok_and(|id| id == *sample.id())
}

/// One part, open for reading.
struct Part<'a> {
    folder: &'a Path,
    sample: Sample,
    shard: Shard,
    all_views: usize,
    /// What the whole is described by, without views and id.
    whole: Description,
}

impl<'a> Part<'a> {
    fn open(folder: &'a Path) -> Result<Self> {
        let sample = Sample::open(folder)?;
        let mut whole = Description {
            views: Vec::new(),
            id: ContentId::of_bytes(b""),
            ..sample.description().clone()
        };
        let mut take = |name: &str| match &mut whole.source {
            Value::Object(fields) => fields.shift_remove(name),
            _ => None,
        };
        let (shard, all_views, program) = (take(SHARD), take(ALL_VIEWS), take(PROGRAM));
        let shard = shard.and_then(|shard| serde_json::from_value::<Shard>(shard).ok());
        let all_views = all_views.and_then(|count| Some(count.as_u64()? as usize));
        let (Some(shard), Some(all_views)) = (shard, all_views) else {
            return Err(Error::data("source: shard", "missing")
                .expected("a part, as `mesotex bake --shard` writes it")
                .in_file(&folder.join(DESCRIPTION)));
        };
        let part = Self {
            folder,
            sample,
            shard,
            all_views,
            whole,
        };
        part.check(program)?;
        Ok(part)
    }

    /// Refuses parts of another version, and those that have not the views of their shard.
    fn check(&self, program: Option<Value>) -> Result<()> {
        let program = program.unwrap_or_default();
        if program != ENGINE {
            return Err(Error::data("source: program", program.to_string())
                .expected(format!("\"{ENGINE}\""))
                .advice("bake the part again with this version")
                .in_file(&self.folder.join(DESCRIPTION)));
        }
        let (held, own) = (
            self.sample.description().views.len(),
            self.shard.range(self.all_views).len(),
        );
        match held == own {
            true => Ok(()),
            false => Err(Error::data("views", held.to_string())
                .expected(format!(
                    "{own}: shard {} of {} views",
                    self.shard, self.all_views
                ))
                .in_file(&self.folder.join(DESCRIPTION))),
        }
    }

    /// How a part differs from the first; `None` where both belong to one bake.
    fn difference(&self, first: &Self) -> Option<String> {
        if self.whole == first.whole && self.all_views == first.all_views {
            return None;
        }
        let (own, other) = (&self.whole, &first.whole);
        let fields = [
            ("name", json!(own.name), json!(other.name)),
            ("width", json!(own.width), json!(other.width)),
            ("height", json!(own.height), json!(other.height)),
            ("dtype", json!(own.dtype), json!(other.dtype)),
            ("views", json!(self.all_views), json!(first.all_views)),
        ];
        let sources = [&own.source, &other.source].map(Value::as_object);
        let of_source = match sources {
            [Some(own), Some(other)] => own
                .iter()
                .map(|(name, value)| {
                    let other = other.get(name).cloned().unwrap_or_default();
                    (name.as_str(), value.clone(), other)
                })
                .collect(),
            _ => Vec::new(),
        };
        let all = fields.into_iter().chain(of_source);
        let differing = all.filter(|(_, own, other)| own != other);
        let listed: Vec<String> = differing
            .map(|(name, own, other)| format!("{name} {own}, not {other}"))
            .collect();
        let what = match listed.is_empty() {
            true => "other lights or another texel size".into(),
            false => listed.join(", "),
        };
        Some(format!("{} has {what}", self.folder.display()))
    }
}

/// Joins the parts of all shards to the sample `target`, as one run bakes it; returns its description. Refuses parts
/// of other bakes than the first, and shards that are missing or there twice.
pub fn join(parts: &[PathBuf], target: &Path, progress: Progress<'_>) -> Result<Description> {
    let opened = parts.iter().map(|path| Part::open(path));
    let mut parts: Vec<Part<'_>> = opened.collect::<Result<_>>()?;
    check_alike(&parts)?;
    let shards: Vec<_> = parts.iter().map(|part| (part.folder, part.shard)).collect();
    shard::in_order(&shards)?;
    parts.sort_by_key(|part| part.shard);
    let views = parts
        .iter()
        .flat_map(|part| part.sample.description().views.iter().copied());
    let whole = Description {
        views: views.collect(),
        ..parts[0].whole.clone()
    };
    progress.begin("join", whole.image_count() as u64);
    let mut writer = SampleWriter::create(target, whole)?;
    writer.set_heights(parts[0].sample.heights()?);
    for part in &parts {
        writer.append(part.folder, part.sample.description(), progress)?;
    }
    progress.end();
    writer.finish()
}

/// Refuses parts of another bake than the first, naming each.
fn check_alike(parts: &[Part<'_>]) -> Result<()> {
    let Some(first) = parts.first() else {
        return Err(Error::option("reduce", "no part", "all parts"));
    };
    let others = parts.iter().filter_map(|part| part.difference(first));
    let others: Vec<String> = others.collect();
    match others.is_empty() {
        true => Ok(()),
        false => Err(Error::data("parts", others.join("; "))
            .expected(format!("parts of one bake, as {}", first.folder.display()))
            .advice("give every shard the same material and options")),
    }
}
