//! JSON files: descriptions beside the numbers.

use std::fs;
use std::io::Write;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::error::{Error, Result};
use crate::format::atomic;
use crate::format::guard::guarded;
use crate::format::text;

/// The largest description read, in bytes; a real one is a few kilobytes.
const LIMIT: u64 = 64 << 20;

/// Reads a JSON file; a fault names file, line and column.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let size = fs::metadata(path).map_err(Error::io(path, "read"))?.len();
    if size > LIMIT {
        return Err(Error::data("size", format!("{size} bytes of JSON"))
            .expected(format!("at most {LIMIT}"))
            .in_file(path));
    }
    let text = fs::read(path).map_err(Error::io(path, "read"))?;
    guarded(path, || parse(&text))
}

/// Parses JSON bytes; a fault names line and column.
pub fn parse<T: DeserializeOwned>(text: &[u8]) -> Result<T> {
    serde_json::from_str(&text::decode(text)?.text).map_err(|error| {
        Error::data(
            format!("line {} column {}", error.line(), error.column()),
            error.to_string(),
        )
        .advice("the file is JSON of the form described in docs/formats.md")
    })
}

/// Writes a JSON file, indented, with a final newline.
pub fn write<T: Serialize>(path: &Path, value: &T) -> Result<()> {
    atomic::write_file(path, |sink| {
        serde_json::to_writer_pretty(&mut *sink, value)?;
        sink.write_all(b"\n")
    })
}

/// A description as the map that [`npz::write`](crate::format::npz::write) takes.
pub fn as_map(meta: &impl Serialize) -> Result<Map<String, Value>> {
    match serde_json::to_value(meta) {
        Ok(Value::Object(map)) => Ok(map),
        Ok(other) => Err(Error::data("meta.json", other.to_string())),
        Err(error) => Err(Error::data("meta.json", error.to_string())),
    }
}
