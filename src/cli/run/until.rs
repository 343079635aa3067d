//! Where a run stops before the end of its scene.

use crate::cli::failure::likely_names::suggestion;
use crate::cli::run::check::Stage;
use crate::error::{Error, Result};

/// The stages of every run up to the last of a name: a command, or what a rendering is called.
pub(super) fn up_to(mut stages: Vec<Stage>, name: Option<&str>) -> Result<Vec<Stage>> {
    let Some(name) = name else {
        return Ok(stages);
    };
    let is_named = |stage: &Stage| {
        stage.words[0] == name || stage.name == name || rendering(stage) == Some(name)
    };
    let named = stages.iter().filter(|stage| is_named(stage));
    match named.map(|stage| stage.place).max() {
        Some(last) => {
            stages.retain(|stage| stage.place <= last);
            Ok(stages)
        }
        None => Err(unknown(name, &stages)),
    }
}

/// What a rendering is called.
fn rendering(stage: &Stage) -> Option<&str> {
    stage.name.strip_prefix("render ")
}

fn unknown(name: &str, stages: &[Stage]) -> Error {
    let mut known: Vec<&str> = Vec::new();
    for stage in stages {
        let words = [Some(stage.words[0].as_str()), rendering(stage)];
        for word in words.into_iter().flatten() {
            if !known.contains(&word) {
                known.push(word);
            }
        }
    }
    let meant = suggestion(name, known.iter().copied());
    let expected = format!("a stage of the scene: {}{meant}", known.join(", "));
    Error::option("until", name, expected)
}
