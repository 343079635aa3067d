//! `meta.json` of a part: which analysis it belongs to, and which share of it.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::seal::ENGINE;
use crate::shard::Shard;
use crate::texton::parts::work::{Holds, Work};
use crate::texton::representatives::ImageVectors;
use crate::texton::study::{Study, recorded};

/// `format` in the file's `meta.json`.
pub const FORMAT: &str = "mesotex-textons-part";
/// The version written, and the only one read.
pub const VERSION: u32 = 1;

/// What the parts of one analysis share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Job {
    /// The version of the program.
    pub(super) program: String,
    /// The sample's id.
    pub(super) sample: ContentId,
    /// What parts hold.
    pub(super) holds: Holds,
    /// How many of the finest levels are sketched.
    pub(super) sketched_levels: usize,
    /// How image appearance vectors are held.
    pub(super) image_vectors: ImageVectors,
    /// The options, without those that change no number.
    pub(super) options: Value,
}

/// `meta.json`.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Meta {
    pub(super) format: String,
    pub(super) version: u32,
    pub(super) shard: Shard,
    #[serde(flatten)]
    pub(super) job: Job,
}

impl Job {
    pub(super) fn of(study: &Study<'_>, work: &Work) -> Result<Self> {
        Ok(Self {
            program: ENGINE.into(),
            sample: study.stack.sample.id().clone(),
            holds: work.holds(),
            sketched_levels: study.plan.sketched(),
            image_vectors: study.plan.image_vectors,
            options: recorded(study.options)?,
        })
    }

    /// How a part of one sample and version differs from the first; `None` where both belong to one analysis.
    pub(super) fn difference(&self, first: &Self) -> Option<String> {
        if self.options != first.options {
            return Some(format!(
                "made with {}",
                other_options(&self.options, &first.options)
            ));
        }
        let routes = |job: &Self| (job.holds, job.sketched_levels, job.image_vectors);
        (routes(self) != routes(first)).then(|| {
            let (own, first) = (self.routes_in_words(), first.routes_in_words());
            format!("made for another --memory ({own}; the first: {first})")
        })
    }

    /// What its memory leads to.
    fn routes_in_words(&self) -> String {
        let vectors = match self.image_vectors {
            ImageVectors::Exact => "exact",
            ImageVectors::Folded => "folded",
        };
        format!(
            "sketched levels {}, image vectors {vectors}",
            self.sketched_levels
        )
    }
}

/// The options that differ, as they are typed.
fn other_options(own: &Value, first: &Value) -> String {
    let (Some(own), Some(first)) = (own.as_object(), first.as_object()) else {
        return "unreadable options".into();
    };
    let differing = own
        .iter()
        .filter(|(name, value)| first.get(*name) != Some(value));
    let listed = differing.map(|(name, value)| {
        let text = |value: Option<&Value>| match value {
            Some(Value::String(text)) => text.clone(),
            Some(Value::Null) | None => "its default".into(),
            Some(other) => other.to_string(),
        };
        format!(
            "--{name} {}, not {}",
            text(Some(value)),
            text(first.get(name))
        )
    });
    let listed: Vec<String> = listed.collect();
    match listed.is_empty() {
        true => "fewer options".into(),
        false => listed.join(", "),
    }
}

pub(super) fn as_map(meta: &Meta) -> Result<Map<String, Value>> {
    match serde_json::to_value(meta) {
        Ok(Value::Object(map)) => Ok(map),
        Ok(_) => Err(Error::data("meta.json", "no object")),
        Err(error) => Err(Error::data("meta.json", error.to_string())),
    }
}
