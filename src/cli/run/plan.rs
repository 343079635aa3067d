//! What a run will take, before it begins: seconds and memory per stage, of the [`cost`](super::cost) model.
//!
//! What is not known yet, as the size of a data set that is not imported, is said to be unknown.

use std::path::PathBuf;

use serde_json::{Value, json};

use crate::cli::machine::available_memory;
use crate::cli::run::check::{Stage, title};
use crate::cli::run::cost::Cost;
use crate::cli::run::sizes::Sizes;
use crate::error::Result;
use crate::progress::Progress;

/// A stage of a plan.
pub(super) struct PlannedStage {
    /// Its name.
    name: String,
    /// The values of `[matrix]` that reach it.
    variant: String,
    /// What it takes; `None` where that is not known yet.
    cost: Option<Cost>,
    /// Whether nothing is to be done.
    is_done: bool,
}

/// What a run takes.
pub(super) struct Plan {
    stages: Vec<PlannedStage>,
    threads: usize,
}

impl Plan {
    /// The plan of stages, of which some are done; `pages` are the runs whose pages follow: the values of `[matrix]`
    /// that tell each apart, its sample and its map.
    pub(super) fn of(
        stages: &[Stage],
        done: &[bool],
        pages: &[(String, [PathBuf; 2])],
        progress: Progress<'_>,
    ) -> Result<Self> {
        let mut sizes = Sizes::new(progress, true);
        let mut planned = Vec::new();
        for (stage, &is_done) in stages.iter().zip(done) {
            progress.check()?;
            planned.push(PlannedStage {
                name: stage.name.clone(),
                variant: stage.variant.clone(),
                cost: sizes.cost_of(stage, is_done),
                is_done,
            });
        }
        for (variant, files) in pages {
            planned.push(PlannedStage {
                name: "pages".into(),
                variant: variant.clone(),
                cost: sizes.cost_of_pages(files),
                is_done: done.iter().all(|is_done| *is_done),
            });
        }
        Ok(Self {
            stages: planned,
            threads: rayon::current_num_threads(),
        })
    }

    /// What a person reads: the sum, then a line per stage.
    pub(super) fn lines(&self) -> Vec<String> {
        let to_run: Vec<&PlannedStage> =
            self.stages.iter().filter(|stage| !stage.is_done).collect();
        if to_run.is_empty() {
            return vec!["nothing to do: no stage has changed".into()];
        }
        let seconds = to_run.iter().filter_map(|stage| self.seconds(stage)).sum();
        let peak = to_run
            .iter()
            .filter_map(|stage| stage.cost)
            .map(|cost| cost.bytes)
            .fold(0.0, f64::max);
        let at_least = match to_run.iter().all(|stage| stage.cost.is_some()) {
            true => "about",
            false => "at least",
        };
        let threads = match self.threads {
            1 => "1 thread".to_owned(),
            count => format!("{count} threads"),
        };
        let mut lines = vec![format!(
            "plan: {at_least} {} and {} at the peak, on {threads}",
            duration(seconds),
            memory(peak)
        )];
        lines.extend(self.lines_of_stages());
        let free = available_memory().filter(|free| peak > free.0 as f64);
        lines.extend(free.map(|free| format!("this machine has {free} free now")));
        lines
    }

    /// A line per stage; stages of one name, with other values of `[matrix]`, are one line.
    fn lines_of_stages(&self) -> Vec<String> {
        let mut names: Vec<&str> = Vec::new();
        for stage in &self.stages {
            if !names.contains(&stage.name.as_str()) {
                names.push(&stage.name);
            }
        }
        let group = |name: &str| -> Vec<&PlannedStage> {
            let stages = self.stages.iter();
            stages.filter(|stage| stage.name == name).collect()
        };
        let groups: Vec<_> = names.iter().map(|name| group(name)).collect();
        let titles: Vec<String> = names
            .iter()
            .zip(&groups)
            .map(|(name, stages)| match stages.len() {
                1 => (*name).to_owned(),
                count => format!("{name} ×{count}"),
            })
            .collect();
        let widths = titles.iter().map(|title| title.chars().count());
        let width = widths.max().unwrap_or(0);
        let lines = titles.iter().zip(&groups);
        lines
            .map(|(title, stages)| format!("  {title:<width$}  {}", self.takes(stages)))
            .collect()
    }

    /// What stages of one name take together.
    fn takes(&self, stages: &[&PlannedStage]) -> String {
        let to_run: Vec<_> = stages.iter().filter(|stage| !stage.is_done).collect();
        if to_run.is_empty() {
            return "nothing changed".into();
        }
        if to_run.iter().any(|stage| stage.cost.is_none()) {
            return "not known yet: it depends on data that is not there".into();
        }
        let seconds = to_run.iter().filter_map(|stage| self.seconds(stage)).sum();
        let costs = to_run.iter().filter_map(|stage| stage.cost);
        let peak = costs.map(|cost| cost.bytes).fold(0.0, f64::max);
        format!("{:>8}  {:>8}", duration(seconds), memory(peak))
    }

    fn seconds(&self, stage: &PlannedStage) -> Option<f64> {
        Some(stage.cost?.seconds_on(self.threads))
    }

    /// What a program reads.
    pub(super) fn figures(&self) -> Value {
        let stages = self.stages.iter().map(|stage| {
            json!({
                "stage": title(&stage.name, &stage.variant),
                "skipped": stage.is_done,
                "seconds": self.seconds(stage),
                "bytes": stage.cost.map(|cost| cost.bytes as u64),
            })
        });
        json!({"threads": self.threads, "stages": stages.collect::<Vec<_>>()})
    }
}

/// A time as a person says it.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 5970.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// A size as a person says it.
fn memory(bytes: f64) -> String {
    let mebibytes = bytes / f64::from(1 << 20);
    match mebibytes < 999.5 {
        true => format!("{mebibytes:.0} MiB"),
        false => format!("{:.1} GiB", mebibytes / 1024.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_said_in_fitting_units() {
        let said = [0.04, 9.94, 9.96, 99.0, 120.0, 7200.0].map(duration);
        assert_eq!(said, ["0.0 s", "9.9 s", "10 s", "99 s", "2 min", "2.0 h"]);
        assert_eq!([3e7, 3e9].map(memory), ["29 MiB", "2.8 GiB"]);
    }
}
