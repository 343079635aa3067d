//! An image: what its file says, how that is read, and what the numbers come to.

use std::path::Path;

use serde_json::json;

use crate::cli::outcome::Outcome;
use crate::error::Result;
use crate::format::image::{
    self, Alpha, Facts, FloatImage, Gamut, Missing, Orientation, Part, ReadOptions,
};

/// Reads an image and describes its content. Transparent and missing texels are counted, not refused.
pub fn describe(path: &Path) -> Result<Outcome> {
    let options = ReadOptions {
        alpha: Alpha::Ignore,
        missing: Missing::Black,
        gamut: Gamut::Keep,
        orientation: Orientation::Upright,
        ..ReadOptions::default()
    };
    let found = image::inspect(path, &options)?;
    let outcome = says(Outcome::default().figure("kind", "image"), &found.facts);
    Ok(match found.read {
        Ok(read) => {
            let outcome = read
                .notes
                .iter()
                .filter(|note| note.subject != "alpha")
                .fold(outcome, |outcome, note| outcome.line(note.text.clone()));
            numbers(outcome, read.image)
        }
        Err(error) => outcome
            .line(format!("as colour: refused: {error}"))
            .figure("refused", error.to_string()),
    })
}

/// What the file says.
fn says(outcome: Outcome, facts: &Facts) -> Outcome {
    let [width, height] = facts.size;
    let mut outcome = outcome.line(format!(
        "{} image of {width} × {height} pixels",
        facts.format
    ));
    // Tell the parts of the file.
    for part in &facts.parts {
        outcome = part_lines(part)
            .into_iter()
            .fold(outcome, |outcome, line| outcome.line(line));
    }
    // Tell how the numbers are read.
    let said = match facts.color.as_str() {
        "" => "not stated",
        said => said,
    };
    if !facts.reading.is_empty() {
        outcome = outcome.line(format!("colour: {said}; read {}", facts.reading));
    }
    if facts.orientation != 1 {
        outcome = outcome.line(format!(
            "orientation {}: turned upright below; import reads it as stored",
            facts.orientation
        ));
    }
    if (facts.pixel_aspect - 1.0).abs() > 1e-6 {
        outcome = outcome.line(format!("pixel aspect ratio {}", facts.pixel_aspect));
    }
    if let Some(alpha) = &facts.alpha {
        let kind = if alpha.premultiplied {
            "premultiplied"
        } else {
            "straight"
        };
        outcome = outcome.line(format!(
            "alpha ({kind}): {} texels not opaque, {} of them invisible",
            alpha.transparent, alpha.invisible
        ));
    }
    if facts.pictures > 1 {
        outcome = outcome.line("more than one image; the first is read");
    }
    outcome
        .figure("format", facts.format.as_str())
        .figure("stored_size", json!(facts.size))
        .figure("color", facts.color.as_str())
        .figure("reading", facts.reading.as_str())
        .figure("orientation", facts.orientation)
        .figure("pixel_aspect", facts.pixel_aspect)
        .figure("alpha", json!(facts.alpha))
        .figure("pictures", facts.pictures)
        .figure("parts", json!(facts.parts))
}

fn part_lines(part: &Part) -> Vec<String> {
    // Tell the channels and how they are stored.
    let channels: Vec<String> = part
        .channels
        .iter()
        .map(|channel| match channel.sampling {
            [1, 1] => format!("{} {}", channel.name, channel.numbers),
            [x, y] => format!("{} {} ({x} × {y})", channel.name, channel.numbers),
        })
        .collect();
    let mut lines = vec![format!(
        "channels {}; {}",
        channels.join(", "),
        part.compression
    )];
    // Name the part, its layers and its windows.
    let names = [("part", &part.name), ("view", &part.view)];
    for (word, name) in names.into_iter().filter(|(_, name)| !name.is_empty()) {
        lines.insert(0, format!("{word} `{name}`"));
    }
    if !part.layers.is_empty() {
        lines.push(format!("layers {}", part.layers.join(", ")));
    }
    if let (Some(data), Some(display)) = (part.data_window, part.display_window)
        && data != display
    {
        lines.push(format!(
            "data window {}, display window {}",
            corners(data),
            corners(display)
        ));
    }
    // List its attributes.
    let attributes = part.attributes.iter();
    lines.extend(attributes.map(|(name, value)| format!("  {name}: {value}")));
    lines
}

fn corners([left, top, right, bottom]: [i64; 4]) -> String {
    format!("({left}, {top}) to ({right}, {bottom})")
}

/// What the numbers come to, in linear Rec. 709.
fn numbers(outcome: Outcome, picture: FloatImage) -> Outcome {
    let picture = picture.into_linear();
    // Measure range and means.
    let data = &picture.data;
    let channels = picture.channels as usize;
    let least = data.iter().copied().fold(f32::INFINITY, f32::min);
    let most = data.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let strange = data.iter().filter(|value| !value.is_finite()).count();
    let texels = (data.len() / channels) as f64;
    let means: Vec<f64> = (0..channels)
        .map(|channel| {
            let numbers = data.iter().skip(channel).step_by(channels);
            numbers.map(|&v| f64::from(v)).sum::<f64>() / texels
        })
        .collect();
    // Tell them.
    let shown: Vec<String> = means.iter().map(|mean| format!("{mean:.4}")).collect();
    outcome
        .line(format!(
            "read as {} × {} texels of {channels} channels, linear: {least} to {most}, mean {}, \
             {strange} not finite",
            picture.width,
            picture.height,
            shown.join(" ")
        ))
        .figure("width", picture.width)
        .figure("height", picture.height)
        .figure("channels", picture.channels)
        .figure("least", least)
        .figure("most", most)
        .figure("mean", means)
        .figure("not_finite", strange)
}
