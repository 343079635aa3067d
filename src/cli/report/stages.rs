//! The stages that were run: times, options and ids.

use crate::cli::report::products::Products;
use crate::report::summary::{OutputFacts, StageFacts};

/// The stages of a scene, and what is not known of them.
pub(super) fn list(products: &Products) -> (Vec<StageFacts>, Vec<String>) {
    let Some(overview) = &products.overview else {
        let note = "times and options are known of scenes only: mesotex run SCENE.toml keeps them in run.json";
        return (Vec::new(), vec![note.to_owned()]);
    };
    // List what each stage took and made.
    let stages = overview.stages.iter().map(|stage| StageFacts {
        name: stage.name.clone(),
        seconds: stage
            .seconds
            .map_or("–".to_owned(), |seconds| format!("{seconds:.1}")),
        command: stage.command_line.clone(),
        outputs: stage
            .ids
            .iter()
            .map(|(path, id)| OutputFacts {
                path: path.display().to_string(),
                id: id.to_string(),
            })
            .collect(),
    });
    // Name those that are still to run.
    let waiting: Vec<&str> = overview
        .stages
        .iter()
        .filter(|stage| stage.ids.is_empty())
        .map(|stage| stage.name.as_str())
        .collect();
    let notes = match waiting.is_empty() {
        true => Vec::new(),
        false => vec![format!(
            "not run yet, or changed since: {}",
            waiting.join(", ")
        )],
    };
    (stages.collect(), notes)
}
