//! What a report states about the channels and controls of a plain-image exemplar.

use std::collections::BTreeSet;

use serde_json::json;

use crate::cli::outcome::Outcome;
use crate::exemplar::channels::Channel;
use crate::exemplar::controls::{ControlKind, Controls};
use crate::exemplar::space::Space;

/// Adds one line for each channel and control, and the fields `channels` and `controls`.
pub fn describe_channels(outcome: Outcome, space: &Space) -> Outcome {
    let none = Controls::default();
    let finest = space.controls.first().unwrap_or(&none);
    let outcome = space
        .channels
        .list()
        .iter()
        .fold(outcome, |outcome, channel| {
            outcome.line(channel_line(channel))
        });
    let outcome = finest.kinds().fold(outcome, |outcome, kind| {
        outcome.line(control_line(finest, kind))
    });
    let names: Vec<&str> = finest.kinds().map(ControlKind::name).collect();
    outcome
        .figure("channels", json!(space.channels.list()))
        .figure("controls", names)
}

fn channel_line(channel: &Channel) -> String {
    let numbers = match channel.count {
        1 => format!("number {}", channel.first),
        count => format!("numbers {} to {}", channel.first, channel.first + count - 1),
    };
    format!(
        "channel `{}`: {}, {numbers}, weight {}, {} to {}",
        channel.name,
        channel.kind.name(),
        channel.weight,
        channel.low,
        channel.high
    )
}

fn control_line(controls: &Controls, kind: ControlKind) -> String {
    let detail = match kind {
        ControlKind::Mask => {
            let labels: BTreeSet<u8> = controls.mask.iter().flatten().copied().collect();
            let labels: Vec<String> = labels.iter().map(u8::to_string).collect();
            format!("labels {}", labels.join(", "))
        }
        ControlKind::Transition => {
            let values = controls.transition.iter().flatten();
            let (least, most) = values.fold((1.0_f32, 0.0_f32), |(least, most), &value| {
                (least.min(value), most.max(value))
            });
            format!("{least} to {most}")
        }
        ControlKind::Orientation => "unit vectors (s, t)".into(),
    };
    format!("control `{}`: {detail}", kind.name())
}
