//! A plan as a Snakefile: a rule per task, its files and what it asks of a machine.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use crate::cli::plan::graph::{Graph, Task};
use crate::cli::plan::shell;
use crate::cli::plan::stage_tasks::{Frames, Made, PartKind};
use crate::format::ours::PLAN_MARK;

/// How much more memory and time is asked for than the model says: it is within a factor of two where it was measured,
/// and other machines are slower.
const MEMORY_MARGIN: f64 = 2.0;
const TIME_MARGIN: f64 = 4.0;
/// What Snakemake itself takes where a task runs, in megabytes.
const ENGINE: f64 = 200.0;

/// The text of a plan.
pub(super) fn text(graph: &Graph) -> String {
    let names = names(graph);
    let mut text = format!("{PLAN_MARK}: {}\n", graph.describe());
    for (task, name) in graph.tasks.iter().zip(&names) {
        let _ = writeln!(text, "\nrule {name}:");
        list(
            &mut text,
            "input",
            task.inputs.iter().map(|path| literal(path)),
        );
        list(&mut text, "output", task.makes.iter().map(output));
        if is_analysis(task) {
            let _ = writeln!(text, "    group: \"analysis\"");
        }
        let _ = writeln!(text, "    threads: {}", graph.threads);
        resources(&mut text, graph, task);
        let command = shell::line(task).replace('{', "{{").replace('}', "}}");
        let _ = writeln!(text, "    shell: {}", Value::from(command));
    }
    let _ = writeln!(text, "\nrule all:\n    default_target: True");
    let needed: Vec<bool> = (0..graph.tasks.len())
        .map(|at| graph.tasks.iter().any(|task| task.after.contains(&at)))
        .collect();
    let last = names.iter().zip(needed).filter(|(_, needed)| !needed);
    list(
        &mut text,
        "input",
        last.map(|(name, _)| format!("rules.{name}.output")),
    );
    text
}

/// Whether a task is one of the short ones between sample and table, which follow each other on one machine.
fn is_analysis(task: &Task) -> bool {
    let is_part = |made: &Made| matches!(made, Made::Part(..));
    ["textons", "gram", "knn"].contains(&task.stage.as_str()) && !task.makes.iter().any(is_part)
}

/// The names of rules: letters, digits and underscores.
fn names(graph: &Graph) -> Vec<String> {
    let mut counts: HashMap<String, usize> = HashMap::new();
    let named = graph.tasks.iter().map(|task| {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let name: String = task.id.chars().map(plain).collect();
        let name = match name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            true => name,
            false => format!("task_{name}"),
        };
        let count = counts.entry(name.clone()).or_default();
        *count += 1;
        match *count {
            1 => name,
            count => format!("{name}__{count}"),
        }
    });
    named.collect()
}

fn list(text: &mut String, name: &str, values: impl Iterator<Item = String>) {
    let lines: Vec<String> = values.map(|value| format!("        {value},\n")).collect();
    if !lines.is_empty() {
        let _ = write!(text, "    {name}:\n{}", lines.concat());
    }
}

/// What a task asks for; more at every further attempt.
fn resources(text: &mut String, graph: &Graph, task: &Task) {
    let (Some(cost), Some(seconds)) = (task.cost, graph.seconds_of(task)) else {
        return;
    };
    let megabytes = (ENGINE + MEMORY_MARGIN * cost.bytes / 1e6).ceil() as u64;
    let minutes = (TIME_MARGIN * seconds / 60.0).ceil() as u64 + 1;
    let values = [("mem_mb", megabytes), ("runtime", minutes)];
    let values =
        values.map(|(name, value)| format!("{name}=lambda wildcards, attempt: {value} * attempt"));
    list(text, "resources", values.into_iter());
}

/// A path as a string of Python in which braces stand for themselves.
fn literal(path: &Path) -> String {
    let text = path.to_string_lossy().replace('{', "{{").replace('}', "}}");
    Value::from(text).to_string()
}

fn output(made: &Made) -> String {
    match made {
        Made::File(path) => literal(path),
        Made::Part(path, PartKind::File) => format!("temp({})", literal(path)),
        Made::Part(path, PartKind::Folder) => format!("temp(directory({}))", literal(path)),
        Made::Folder(path) => format!("directory({})", literal(path)),
        Made::Frames(frames) => frame_list(frames),
    }
}

/// The files of frames: a list that Python makes.
fn frame_list(frames: &Frames) -> String {
    let [first, last] = frames.ends;
    let digits = frames.pattern.matches('#').count();
    let run = "#".repeat(digits);
    let file = frames.folder.join(format!("{}.exr", frames.pattern));
    // Braces are doubled for Snakemake, and once more for Python's own.
    let text = literal(&file).replace('{', "{{").replace('}', "}}");
    match digits {
        0 => literal(&file),
        _ => {
            let text = text.replacen(&run, &format!("{{n:0{digits}d}}"), 1);
            let end = last + 1;
            format!("[f{text} for n in range({first}, {end}, {})]", frames.step)
        }
    }
}
