//! A `.btf` file: what its header says, and how it will be imported.

use std::path::Path;

use serde_json::Value;

use crate::btf::bonn::BonnFile;
use crate::cli::info::sample::directions;
use crate::cli::outcome::Outcome;
use crate::error::Result;

/// Reads the header of a file and checks all sizes.
pub fn describe(path: &Path) -> Result<Outcome> {
    let file = BonnFile::open(path, &std::env::temp_dir())?;
    let mut outcome = with_header(Outcome::default(), &file);
    if let Some((model, rank)) = file.factors() {
        outcome = outcome.line(format!(
            "{rank} components per channel, colour model {model}"
        ));
    }
    if file.heights().is_some() {
        outcome = outcome.line("with a height per texel");
    }
    for note in file.notes() {
        outcome = outcome.line(note.as_str());
    }
    if let Value::Object(facts) = file.facts() {
        let facts = facts.into_iter().filter(|(name, _)| name != "kind");
        for (name, value) in facts {
            outcome = outcome.figure(&name, value);
        }
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(outcome.next(format!(
        "mesotex import {} -o {name}.sample",
        path.display()
    )))
}

fn with_header(outcome: Outcome, file: &BonnFile) -> Outcome {
    let header = file.header();
    let cosine = match header.meta.has_cosine {
        true => "with the light's cosine",
        false => "without the light's cosine",
    };
    outcome
        .line(format!(
            "{} (Bonn .btf): {} × {} texels, {} views × {} lights, values {cosine}",
            file.format().name(),
            header.width,
            header.height,
            header.sampling.views.len(),
            header.sampling.lights.len()
        ))
        .line(directions("views", &header.sampling.views))
        .line(directions("lights", &header.sampling.lights))
        .figure("kind", "bonn")
        .figure("format", file.format().name())
        .figure("width", header.width)
        .figure("height", header.height)
        .figure("views", header.sampling.views.len())
        .figure("lights", header.sampling.lights.len())
        .figure("heights", file.heights().is_some())
        .figure("notes", file.notes())
}
