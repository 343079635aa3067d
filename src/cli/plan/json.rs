//! A plan for programs: JSON, a task per line (docs/cluster.md has the fields).

use serde_json::{Value, json};

use crate::cli::plan::graph::{Graph, Task};
use crate::cli::plan::stage_tasks::Made;

/// What a plan calls itself.
const FORMAT: &str = "mesotex-plan";
const VERSION: u32 = 1;

/// The text of a plan.
pub(super) fn text(graph: &Graph) -> String {
    let head = json!({
        "format": FORMAT,
        "version": VERSION,
        "program": env!("CARGO_PKG_VERSION"),
        "threads": graph.threads,
        "steps": graph.steps(),
        "folders": graph.folders,
    });
    let tasks: Vec<String> = graph
        .tasks
        .iter()
        .map(|task| fields(graph, task).to_string())
        .collect();
    let head = head.to_string();
    let head = head.trim_end_matches('}');
    format!("{head},\"tasks\":[\n{}\n]}}\n", tasks.join(",\n"))
}

fn fields(graph: &Graph, task: &Task) -> Value {
    let after = task.after.iter().map(|at| graph.tasks[*at].id.as_str());
    let outputs = task.makes.iter().filter_map(Made::path);
    let seconds = graph.seconds_of(task);
    let mut command = vec!["mesotex".to_owned()];
    command.extend(task.words.iter().cloned());
    json!({
        "id": task.id,
        "stage": task.stage,
        "step": task.step + 1,
        "folder": task.folder,
        "command": command,
        "inputs": task.inputs,
        "outputs": outputs.collect::<Vec<_>>(),
        "frames": task.makes.iter().find_map(frames),
        "after": after.collect::<Vec<_>>(),
        "seconds": seconds.map(|seconds| (seconds * 1e3).round() / 1e3),
        "bytes": task.cost.map(|cost| cost.bytes as u64),
    })
}

fn frames(made: &Made) -> Option<Value> {
    let Made::Frames(frames) = made else {
        return None;
    };
    let [first, last] = frames.ends;
    Some(json!({
        "folder": frames.folder,
        "pattern": frames.pattern,
        "first": first,
        "last": last,
        "step": frames.step,
    }))
}
