//! JSON files that this program writes or reads: records of scenes, reports, descriptions, guides, paths.

use std::path::Path;

use serde_json::{Map, Value};

use crate::btf::sample;
use crate::cli::info::{self, unknown};
use crate::cli::outcome::Outcome;
use crate::cli::run::RECORD_FORMAT;
use crate::cli::synth::REPORT_FORMAT;
use crate::error::Result;
use crate::format::json;
use crate::mesh::field::guides::GuideFile;
use crate::progress::Progress;
use crate::render::path_file;

/// Reads a JSON file and describes its content.
pub fn describe(path: &Path, progress: Progress<'_>) -> Result<Outcome> {
    let value: Value = json::read(path)?;
    let format = value["format"].as_str().unwrap_or_default();
    match (format, &value) {
        (sample::FORMAT, _) => {
            info::sample::describe(path.parent().unwrap_or(Path::new("")), progress)
        }
        (RECORD_FORMAT, _) => Ok(record(&value)),
        (REPORT_FORMAT, Value::Object(fields)) => Ok(report(fields, "report of a synthesis")),
        (_, Value::Object(fields)) if fields.contains_key("guides") => guides(path),
        (_, Value::Object(fields)) if fields.contains_key("wrote") => {
            Ok(report(fields, "report of a command"))
        }
        (_, Value::Array(_)) => camera_path(path),
        _ => Err(unknown(path)),
    }
}

fn record(value: &Value) -> Outcome {
    let none = Map::new();
    let stages = value["stages"].as_object().unwrap_or(&none);
    let mut outcome =
        Outcome::default().line(format!("record of a scene: {} stages done", stages.len()));
    let count = |stage: &Value, files: &str| stage[files].as_object().map_or(0, Map::len);
    for (words, stage) in stages {
        outcome = outcome.line(format!(
            "{words}: {} files read, {} written",
            count(stage, "inputs"),
            count(stage, "outputs")
        ));
    }
    let words: Vec<&String> = stages.keys().collect();
    outcome
        .figure("kind", "record of a scene")
        .figure("stages", serde_json::json!(words))
}

/// The fields of a report that are no lists.
fn report(fields: &Map<String, Value>, kind: &str) -> Outcome {
    let mut outcome = Outcome::default().line(kind);
    for (name, value) in fields {
        if !value.is_object() && !value.is_array() {
            outcome = outcome.line(format!("{name}: {value}"));
        }
    }
    outcome
        .figure("kind", kind)
        .figure("report", Value::Object(fields.clone()))
}

fn guides(path: &Path) -> Result<Outcome> {
    let file: GuideFile = json::read(path)?;
    Ok(Outcome::default()
        .line(format!(
            "guides of an orientation field: {}",
            file.guides.len()
        ))
        .figure("kind", "guides")
        .figure("guides", file.guides.len()))
}

/// A sweep or camera path, JSON or CSV.
pub fn camera_path(path: &Path) -> Result<Outcome> {
    let rows = path_file::read(path)?;
    Ok(Outcome::default()
        .line(format!("sweep or camera path: {} frames", rows.len()))
        .figure("kind", "camera path")
        .figure("frames", rows.len()))
}
