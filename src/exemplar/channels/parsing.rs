//! The field `channels` of a space's `meta.json`: a fault names the entry and its field, what is there and
//! what should be.

use serde_json::Value;

use crate::error::{Error, Result};
use crate::exemplar::channels::{Channel, ChannelKind, error_at};

/// Reads the field `channels` of a `meta.json` of `depth` numbers per texel.
pub(in crate::exemplar) fn parse(value: &Value, depth: usize) -> Result<Vec<Channel>> {
    let entries = value.as_array().filter(|entries| !entries.is_empty());
    let entries = entries.ok_or_else(|| {
        Error::data("channels", shown(value)).expected("a list of one channel or more")
    })?;
    if entries.len() > depth {
        return Err(Error::data("channels", entries.len().to_string())
            .expected(format!("at most {depth}, one for each number of a texel")));
    }
    let entry = |(at, entry): (usize, &Value)| {
        parse_channel(entry).map_err(|error| error_at(&format!("channels[{at}]"), error))
    };
    entries.iter().enumerate().map(entry).collect()
}

fn parse_channel(entry: &Value) -> Result<Channel> {
    let fault = |field: &str, expected: String| {
        let found = entry.get(field).map_or("missing".into(), shown);
        Error::data(field, found).expected(expected)
    };
    let text = |field: &str, expected: String| {
        let found = entry.get(field).and_then(Value::as_str);
        found.ok_or_else(|| fault(field, expected))
    };
    let whole = |field: &str| {
        let found = entry.get(field).and_then(Value::as_u64);
        let found = found.and_then(|value| u32::try_from(value).ok());
        found.ok_or_else(|| fault(field, "a whole number, 0 or more".into()))
    };
    let real = |field: &str| {
        let found = entry.get(field).and_then(Value::as_f64);
        found.ok_or_else(|| fault(field, "a number".into()))
    };
    let kind = text("kind", ChannelKind::all_names())?;
    Ok(Channel {
        name: text("name", "text".into())?.into(),
        kind: ChannelKind::named(kind).ok_or_else(|| fault("kind", ChannelKind::all_names()))?,
        first: whole("first")?,
        count: whole("count")?,
        weight: real("weight")?,
        low: real("low")?,
        high: real("high")?,
    })
}

/// A JSON value, cut to what an error can hold.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
