//! A plan as a list of commands: a line each, step after step. `sh` runs it as it is; GNU parallel runs the lines of a
//! step side by side.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::cli::plan::graph::{Graph, Task};
use crate::cli::plan::stage_tasks::joined;
use crate::cli::run::overview::{quoted, quoted_word};
use crate::format::ours::PLAN_MARK;

/// The text of a plan.
pub(super) fn text(graph: &Graph) -> String {
    // The first step makes the folders.
    let steps = graph.steps() + 1;
    let mut text = format!("{PLAN_MARK}: {}\nset -e\n", graph.describe());
    let folders = folders(graph);
    let folders: Vec<_> = folders
        .iter()
        .map(|folder| quoted(&folder.to_string_lossy()))
        .collect();
    let folders = folders.join(" ");
    let _ = writeln!(text, "# step 1 of {steps}: folders\nmkdir -p {folders}");
    for step in 0..graph.steps() {
        let takes = takes(graph, step);
        let _ = writeln!(text, "# step {} of {steps}: {takes}", step + 2);
        for task in graph.of_step(step) {
            let _ = writeln!(text, "{}", line_run_once(task));
        }
    }
    text
}

/// What the tasks of a step take; the largest counts, and what is not known is left out.
fn takes(graph: &Graph, step: usize) -> String {
    let largest = |value: &dyn Fn(&Task) -> Option<f64>| {
        let values = graph.of_step(step).filter_map(value);
        values.fold(0.0, f64::max).ceil()
    };
    format!(
        "{} tasks, the largest {} s and {} MiB",
        graph.of_step(step).count(),
        largest(&|task| graph.seconds_of(task)),
        largest(&|task| Some(task.cost?.bytes / f64::from(1 << 20))),
    )
}

/// The folders that tasks write into, those of their records among them.
fn folders(graph: &Graph) -> BTreeSet<PathBuf> {
    let records = graph.tasks.iter().filter_map(|task| {
        let record = task.record.as_deref()?;
        Some(joined(
            &task.folder,
            record.parent().unwrap_or(Path::new("")),
        ))
    });
    graph.folders.iter().cloned().chain(records).collect()
}

/// The command of a task, run in its folder.
pub(super) fn line(task: &Task) -> String {
    in_folder(task, &task.words)
}

/// The same, skipped where the task is done.
fn line_run_once(task: &Task) -> String {
    let once = task
        .record
        .iter()
        .map(|record| format!("--once={}", record.display()));
    let words: Vec<String> = task.words.iter().cloned().chain(once).collect();
    in_folder(task, &words)
}

fn in_folder(task: &Task, words: &[String]) -> String {
    let words: Vec<_> = words.iter().map(|word| quoted_word(word)).collect();
    let command = format!("mesotex {}", words.join(" "));
    match task.folder.as_os_str().is_empty() {
        true => command,
        false => {
            let folder = quoted(&task.folder.to_string_lossy());
            format!("(cd {folder} && {command})")
        }
    }
}
