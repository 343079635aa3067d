//! What a run of an import writes: a sample, or the part of a shard, with the ids of what it is made from.

use std::ops::Range;
use std::path::Path;

use serde_json::{Map, Value, json};

use crate::btf::import::options::ImportOptions;
use crate::btf::import::photographs::PhotographOptions;
use crate::btf::parts::{Maker, NewPart};
use crate::error::Result;
use crate::format::id::ContentId;
use crate::shard::Shard;

/// Options that are fields of every sample's description, and need not be stated beside it.
const DESCRIBED: [&str; 4] = ["name", "texel-mm", "tileable", "dtype"];

/// The id of the source among what parts are made from.
const SOURCE: &str = "source";

/// What a run writes, and where.
#[derive(Clone, Copy, Debug)]
pub struct Destination<'a> {
    /// The folder of the sample, or of the part.
    pub path: &'a Path,
    /// Which of the runs it is, where several share the work.
    pub shard: Option<Shard>,
}

/// A whole sample.
impl<'a, P: AsRef<Path> + ?Sized> From<&'a P> for Destination<'a> {
    fn from(path: &'a P) -> Self {
        Self {
            path: path.as_ref(),
            shard: None,
        }
    }
}

/// The ids of what a part is made from.
pub(in crate::btf) struct InputIds {
    /// That of the source, which is the same for all parts.
    pub(in crate::btf) source: ContentId,
    /// What this part alone is made from.
    pub(in crate::btf) own: Option<ContentId>,
}

impl Destination<'_> {
    /// The part that the run makes of a sample of `count` images; `None` where it makes the whole. `ids` is asked with
    /// the images of the part.
    pub(in crate::btf) fn part(
        &self,
        count: usize,
        options: &ImportOptions,
        ids: impl FnOnce(Range<usize>) -> Result<InputIds>,
    ) -> Result<Option<NewPart>> {
        let Some(shard) = self.shard else {
            return Ok(None);
        };
        shard.check(count, "images")?;
        let images = shard.range(count);
        let InputIds { source, own } = ids(images.clone())?;
        let mut made_from = stated(options)?;
        made_from.insert(SOURCE.into(), json!(source));
        Ok(Some(NewPart {
            maker: Maker::Import,
            shard,
            images,
            made_from,
            own,
        }))
    }
}

/// The options that the description of a sample does not hold, by the names of the command line.
fn stated(options: &ImportOptions) -> Result<Map<String, Value>> {
    let mut fields = Map::new();
    let groups = [json!(options), of_photographs(&options.photographs)?];
    for (name, value) in groups.into_iter().flat_map(fields_of) {
        match value {
            Value::Object(group) => fields.extend(group),
            value => {
                fields.insert(name, value);
            }
        }
    }
    fields.retain(|name, value| !value.is_null() && !DESCRIBED.contains(&name.as_str()));
    Ok(fields)
}

fn fields_of(group: Value) -> Map<String, Value> {
    match group {
        Value::Object(fields) => fields,
        _ => Map::new(),
    }
}

/// What is said of photographs; of the table of corners its id.
fn of_photographs(options: &PhotographOptions) -> Result<Value> {
    let Some(corners) = &options.corners else {
        return Ok(Value::Null);
    };
    let lens = &options.lens;
    Ok(json!({
        "corners": ContentId::of_file(corners)?,
        "size": options.size,
        "distortion": lens.distortion,
        "focal": lens.focal,
        "center": lens.center,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::import::prepare::Preparation;

    #[test]
    fn options_are_stated_by_their_names() {
        let options = ImportOptions {
            name: Some("felt".into()),
            preparation: Preparation {
                hot_pixels: Some(4.0),
                ..Preparation::default()
            },
            ..ImportOptions::default()
        };
        let fields = stated(&options).unwrap();
        assert_eq!(fields["hot-pixels"], json!(4.0));
        assert_eq!(fields["alpha"], json!(options.alpha));
        for absent in ["name", "dtype", "crop", "preparation", "corners"] {
            assert!(!fields.contains_key(absent), "{absent}");
        }
    }

    #[test]
    fn a_shard_has_its_share_of_the_images() {
        let destination = Destination {
            path: Path::new("a.1of2"),
            shard: Some("1/2".parse().unwrap()),
        };
        let id = ContentId::of_bytes(b"set");
        let part = |count| {
            destination.part(count, &ImportOptions::default(), |images| {
                assert_eq!(images, 2..5);
                Ok(InputIds {
                    source: id.clone(),
                    own: None,
                })
            })
        };
        let found = part(5).unwrap().unwrap();
        assert_eq!(
            (found.images, &found.made_from["source"]),
            (2..5, &json!(id))
        );
        let few = part(1).unwrap_err().to_string();
        assert!(few.contains("1/2, of 1 images"), "{few}");
        let whole = Destination::from(Path::new("a.sample"));
        let none = whole.part(5, &ImportOptions::default(), |_| unreachable!());
        assert!(none.unwrap().is_none());
    }
}
