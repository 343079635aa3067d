//! What is lost where colours are written as bytes.

use crate::cli::outcome::Outcome;

/// Says how many numbers of linear colours are brighter than white.
pub(in crate::cli) fn describe_clipped(outcome: Outcome, colors: &[[f32; 3]]) -> Outcome {
    let numbers = colors.iter().flatten();
    let clipped = numbers.filter(|&&value| value > 1.0).count();
    let outcome = match clipped {
        0 => outcome,
        _ => outcome.line(format!(
            "{clipped} colour values are brighter than white and are clipped to 1 in the file"
        )),
    };
    outcome.figure("clipped", clipped)
}
