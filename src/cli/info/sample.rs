//! A sample: its directions, its values, its hash.

use std::path::Path;

use rayon::prelude::*;
use serde_json::Value;

use crate::btf::direction::Direction;
use crate::btf::sample::{Description, Layout, RADIANCE, Sample};
use crate::cli::outcome::Outcome;
use crate::error::Result;
use crate::format::id::{ContentId, check_same};
use crate::progress::Progress;

/// Reads a whole sample and says what it holds.
pub fn describe(path: &Path, progress: Progress<'_>) -> Result<Outcome> {
    let sample = Sample::open(path)?;
    let description = sample.description();
    let id = ContentId::of_file(&path.join(RADIANCE))?;
    check_same("id of radiance.npy", &id, sample.id(), false)
        .map_err(|error| error.in_file(path))?;
    let values = Values::of(&sample, progress)?;
    Ok(Outcome::default()
        .line(headline(description))
        .line(origin(&description.source))
        .line(directions("views", &description.views))
        .line(directions("lights", &description.lights))
        .line(format!(
            "radiance {:.4} to {:.4}, mean {:.4} {:.4} {:.4} (R G B; white facing the light: 0.3183)",
            values.least, values.most, values.mean[0], values.mean[1], values.mean[2]
        ))
        .line("sound: every value is finite and not negative, the hash is right")
        .figure("kind", "sample")
        .figure("name", description.name.as_str())
        .figure("width", description.width)
        .figure("height", description.height)
        .figure("views", description.views.len())
        .figure("lights", description.lights.len())
        .figure("images", description.image_count())
        .figure("tileable", description.tileable)
        .figure("id", id.to_string())
        .figure("source", description.source.clone())
        .figure("least", values.least)
        .figure("most", values.most)
        .figure("mean", values.mean.to_vec()))
}

fn headline(description: &Description) -> String {
    let layout = match description.layout {
        Layout::Product => "every view with every light",
        Layout::Pairs => "scattered pairs",
    };
    let tile = if description.tileable {
        "tileable"
    } else {
        "not tileable"
    };
    let side = description
        .texel_mm
        .map_or(String::new(), |mm| format!(", {mm} mm a texel"));
    format!(
        "sample `{}`: {} × {} texels{side}, {tile}, {} images ({layout})",
        description.name,
        description.width,
        description.height,
        description.image_count(),
    )
}

/// How a sample was made, from the `source` of its description.
fn origin(source: &Value) -> String {
    let Some(fields) = source.as_object().filter(|fields| !fields.is_empty()) else {
        return "its origin is not recorded".into();
    };
    let kind = match fields.get("kind").and_then(Value::as_str) {
        Some("bake") => "baked".to_owned(),
        Some("rti") => "imported from an RTI capture".into(),
        Some(other) => format!("made from {other}"),
        None => "origin".into(),
    };
    let said = |(name, value): (&String, &Value)| match value {
        Value::Null => None,
        Value::String(text) => Some(format!("{name} {text}")),
        Value::Array(list) => Some(format!("{} {name}", list.len())),
        other => Some(format!("{name} {other}")),
    };
    let fields = fields.iter().filter(|(name, _)| *name != "kind");
    let list: Vec<String> = fields.filter_map(said).collect();
    format!("{kind}: {}", list.join(", "))
}

pub(super) fn directions(kind: &str, directions: &[Direction]) -> String {
    let degrees = directions
        .iter()
        .map(|direction| direction.theta().to_degrees());
    let least = degrees.clone().fold(f64::INFINITY, f64::min);
    let most = degrees.fold(0.0, f64::max);
    let kind = match directions.len() {
        1 => kind.trim_end_matches('s'),
        _ => kind,
    };
    format!(
        "{} {kind}, {least:.1}° to {most:.1}° from the normal",
        directions.len()
    )
}

/// Statistics over all numbers of a sample.
struct Values {
    least: f32,
    most: f32,
    mean: [f64; 3],
}

impl Values {
    /// Reads every image once, each summed alone and the sums added in order.
    fn of(sample: &Sample, progress: Progress<'_>) -> Result<Self> {
        let images = sample.image_count();
        progress.begin("reading images", images as u64);
        let each: Vec<Self> = (0..images)
            .into_par_iter()
            .map(|image| {
                let pixels = sample.image(image)?;
                let mut numbers = vec![0.0; pixels.len()];
                pixels.copy_to(&mut numbers);
                sample.check_image(image, &numbers)?;
                progress.advance(1)?;
                Ok(Self::of_image(&numbers))
            })
            .collect::<Result<_>>()?;
        progress.end();
        let mut all = Self {
            least: f32::INFINITY,
            most: 0.0,
            mean: [0.0; 3],
        };
        for one in &each {
            all.least = all.least.min(one.least);
            all.most = all.most.max(one.most);
            for (mean, part) in all.mean.iter_mut().zip(one.mean) {
                *mean += part / images as f64;
            }
        }
        Ok(all)
    }

    fn of_image(numbers: &[f32]) -> Self {
        let mut sums = [0.0; 3];
        for texel in numbers.chunks_exact(3) {
            for (sum, &value) in sums.iter_mut().zip(texel) {
                *sum += f64::from(value);
            }
        }
        Self {
            least: numbers.iter().copied().fold(f32::INFINITY, f32::min),
            most: numbers.iter().copied().fold(0.0, f32::max),
            mean: sums.map(|sum| sum / (numbers.len() / 3) as f64),
        }
    }
}
