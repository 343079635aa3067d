//! The error of a sample between its directions, in words and figures.

use std::path::Path;

use clap::ValueEnum;
use serde_json::{Value, json};

use crate::btf::sample::Sample;
use crate::cli::outcome::Outcome;
use crate::error::Result;
use crate::progress::Progress;
use crate::render::held_out::{
    AngleError, ErrorSum, HeldOutPart, HeldOutReport, LeaveOut, MOST_HELD, measure,
};
use crate::render::nearest::Weighting;
use crate::render::parallax::Trial;

/// Leaves directions of a sample out and adds what came of it to an outcome.
pub fn add(
    outcome: Outcome,
    path: &Path,
    leave_out: LeaveOut,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Outcome> {
    let sample = Sample::open(path)?;
    let report = measure(&sample, leave_out, seed, progress)?;
    let outcome = match report.parts.is_empty() {
        true => {
            outcome.line("left out: nothing, as one direction has no others to be predicted from")
        }
        false => outcome.line(headline(&report, leave_out)),
    };
    let outcome = report
        .parts
        .iter()
        .fold(outcome, |outcome, part| outcome.line(line(part)));
    let outcome = with_parallax(outcome, &sample, progress)?;
    let parts: Vec<Value> = report.parts.iter().map(figures).collect();
    Ok(outcome.figure(
        "leave_out",
        json!({ "directions": name(leave_out), "texels": report.texels.0, "parts": parts }),
    ))
}

/// Adds what parallax changes, where the sample has heights.
fn with_parallax(outcome: Outcome, sample: &Sample, progress: Progress<'_>) -> Result<Outcome> {
    let Some(heights) = sample.heights()? else {
        return Ok(outcome);
    };
    let weighting = Weighting::default();
    let Some(trial) = Trial::of(sample, &heights, weighting, MOST_HELD, progress)? else {
        return Ok(outcome);
    };
    Ok(outcome
        .line(format!(
            "  with parallax, under a few lights: {}",
            trial.describe()
        ))
        .figure(
            "parallax",
            json!({ "views": trial.views, "relative_error": trial.parallax.relative(),
                "relative_error_plain": trial.plain.relative() }),
        ))
}

fn name(leave_out: LeaveOut) -> String {
    leave_out
        .to_possible_value()
        .map_or(String::new(), |value| value.get_name().to_owned())
}

fn headline(report: &HeldOutReport, leave_out: LeaveOut) -> String {
    let (compared, all) = report.texels;
    let texels = match compared == all {
        true => "all texels".to_owned(),
        false => format!("{compared} of {all} texels"),
    };
    let manner = match leave_out {
        LeaveOut::Each => "each left out in turn",
        LeaveOut::Tenth => "a tenth left out at once",
    };
    format!(
        "between its directions: {manner} and predicted from the others, over {texels} (peak signal-to-noise ratio; \
         the peak is white facing the light)"
    )
}

fn line(part: &HeldOutPart) -> String {
    let (held, all) = part.directions;
    let count = match held == all {
        true => format!("{held}"),
        false if held == MOST_HELD => format!("{held} of {all}, the most that are tried,"),
        false => format!("{held} of {all}"),
    };
    let whole = part.errors.whole();
    let angle = |bin: AngleError| {
        let (from, to) = (bin.from_deg, bin.to_deg());
        format!("{from:.0}–{to:.0}° {}", decibels(&bin.sum))
    };
    let angles: Vec<String> = part.errors.by_angle().map(angle).collect();
    format!(
        "  {count} {}, {}: {} (relative error {:.1} %); by the angle from the normal: {}",
        part.held,
        weighting(part),
        decibels(&whole),
        100.0 * whole.relative(),
        angles.join(", ")
    )
}

fn weighting(part: &HeldOutPart) -> String {
    let value = part.weighting.to_possible_value();
    value.map_or(String::new(), |value| value.get_name().to_owned())
}

fn decibels(sum: &ErrorSum) -> String {
    match sum.psnr() {
        psnr if psnr.is_finite() => format!("{psnr:.1} dB"),
        _ => "exact".into(),
    }
}

/// The figures of a sum; the ratio of exact predictions is null.
fn figures_of(sum: &ErrorSum) -> (Value, f64) {
    (
        json!(Some(sum.psnr()).filter(|psnr| psnr.is_finite())),
        sum.relative(),
    )
}

fn figures(part: &HeldOutPart) -> Value {
    let (psnr, relative) = figures_of(&part.errors.whole());
    let angle = |bin: AngleError| {
        let (psnr, relative) = figures_of(&bin.sum);
        json!({ "from_deg": bin.from_deg, "to_deg": bin.to_deg(), "directions": bin.directions,
            "psnr": psnr, "relative_error": relative })
    };
    let angles: Vec<Value> = part.errors.by_angle().map(angle).collect();
    json!({ "held": part.held, "weighting": weighting(part), "directions": part.directions.0,
        "psnr": psnr, "relative_error": relative, "by_angle": angles })
}
