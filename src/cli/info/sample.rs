//! A sample: its directions, its values, its hash, its factors.

use std::fs;
use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::btf::HeightMap;
use crate::btf::direction::Direction;
use crate::btf::factored::products::Values as Multiplied;
use crate::btf::sample::{Description, Pixels, RADIANCE, Sample, files_of};
use crate::byte_size::ByteSize;
use crate::cli::outcome::Outcome;
use crate::error::{Error, Result};
use crate::format::id::check_same;
use crate::progress::Progress;

/// Reads a whole sample and describes its content.
pub fn describe(path: &Path, progress: Progress<'_>) -> Result<Outcome> {
    let sample = Sample::open(path)?;
    let description = sample.description();
    // Check the arrays against their hash, and every value.
    let id = sample.content_id()?;
    let arrays = match sample.factors() {
        Some(_) => path.to_path_buf(),
        None => path.join(RADIANCE),
    };
    check_same("id of the arrays", &id, sample.id(), false)
        .map_err(|error| error.in_file(&arrays))?;
    let heights = sample.heights()?;
    let values = Values::of(&sample, progress)?;
    // Tell what the sample holds.
    let outcome = Outcome::default()
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
        .figure("mean", values.mean.to_vec());
    let outcome = with_heights(outcome, heights.as_ref());
    match sample.factors() {
        Some(_) => factored(outcome, path, description, &values),
        None => Ok(outcome),
    }
}

/// Adds how high the surface lies, if the sample states it.
fn with_heights(outcome: Outcome, heights: Option<&HeightMap>) -> Outcome {
    let Some(heights) = heights else {
        return outcome
            .line("no heights: `mesotex heights` estimates them")
            .figure("heights", Value::Null);
    };
    let ([least, most], deviation) = (heights.range(), heights.deviation());
    outcome
        .line(format!(
            "heights {least:.2} to {most:.2} texels above z = 0, standard deviation {deviation:.2}"
        ))
        .figure(
            "heights",
            json!({"least": least, "most": most, "deviation": deviation}),
        )
}

/// Adds what is special to factored samples: rank, size on disk, values that come out negative.
fn factored(
    outcome: Outcome,
    path: &Path,
    description: &Description,
    values: &Values,
) -> Result<Outcome> {
    // Compare sizes on disk with those of whole images.
    let files = files_of(path).into_iter();
    let sizes = files.map(|file| fs::metadata(&file).map_err(Error::io(&file, "read")));
    let bytes = sizes.map(|size| Ok(size?.len())).sum::<Result<u64>>()?;
    let numbers = (description.image_count() * description.grid().len()) as u64 * 3;
    let whole = numbers * description.dtype.size() as u64;
    let (rank, shared) = description.factors().map_or((0, false), |factors| {
        (factors.rank, factors.shared_eigentextures)
    });
    let of = if shared {
        "shared by the channels"
    } else {
        "per channel"
    };
    let share = values.negative as f64 / numbers as f64;
    // Tell rank, size and values below zero.
    Ok(outcome
        .line(format!(
            "factored: rank {rank} ({rank} eigentextures {of}), {} on disk in place of {}",
            ByteSize(bytes),
            ByteSize(whole)
        ))
        .line(format!(
            "{:.3} % of the values come out negative, down to {:.4}; they are read as 0",
            100.0 * share,
            values.most_negative
        ))
        .figure("rank", rank)
        .figure("shared_eigentextures", shared)
        .figure("bytes_on_disk", bytes)
        .figure("bytes_of_whole_images", whole)
        .figure("negative_share", share)
        .figure("most_negative", values.most_negative))
}

fn headline(description: &Description) -> String {
    let layout = match description.pairs {
        None => "every view with every light",
        Some(_) => "scattered pairs",
    };
    let tile = if description.tileable {
        "tileable"
    } else {
        "not tileable"
    };
    let side = description
        .texel_mm
        .map_or(String::new(), |mm| format!(", {mm} mm per texel"));
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
        Some("factored") => return origin_of_factors(source),
        Some(other) => format!("made from {other}"),
        None => "origin".into(),
    };
    let said = |(name, value): (&String, &Value)| match value {
        Value::Object(part) if name == "part" => part.get("shard")?.as_str().map(shard_of),
        Value::Null => None,
        Value::String(text) => Some(format!("{name} {text}")),
        Value::Array(list) => Some(format!("{} {name}", list.len())),
        other => Some(format!("{name} {other}")),
    };
    let fields = fields.iter().filter(|(name, _)| *name != "kind");
    let list: Vec<String> = fields.filter_map(said).collect();
    format!("{kind}: {}", list.join(", "))
}

/// Which part of a sample it is.
fn shard_of(shard: &str) -> String {
    format!("the part of shard {shard}")
}

/// What was factored, and the error left.
fn origin_of_factors(source: &Value) -> String {
    let error = source["error"]["relative"].as_f64().unwrap_or(f64::NAN);
    let (sample, before) = (&source["of"]["sample"], &source["of"]["source"]);
    let of = match (sample.as_str(), before) {
        (Some(id), before) => format!("sample {id}, {}", origin(before)),
        (None, _) => origin(&source["of"]),
    };
    format!(
        "factored with an error of {:.3} %, from {of}",
        100.0 * error
    )
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
    /// Of factored samples: products below 0, and the least of them.
    negative: u64,
    most_negative: f32,
}

/// Images read at once by one task.
const GROUP: usize = 8;

impl Values {
    /// Reads every image once, each summed alone and the sums added in order.
    fn of(sample: &Sample, progress: Progress<'_>) -> Result<Self> {
        let images = sample.image_count();
        progress.begin("reading images", images as u64);
        // Read groups of images in parallel.
        let numbers: Vec<u32> = (0..images as u32).collect();
        let groups: Vec<Vec<Self>> = numbers
            .par_chunks(GROUP)
            .map(|group| {
                let values = match sample.factors() {
                    Some(_) => Self::of_products(sample, group)?,
                    None => Self::of_images(sample, group)?,
                };
                progress.advance(group.len() as u64)?;
                Ok(values)
            })
            .collect::<Result<_>>()?;
        progress.end();
        // Add up in the order of the images, so that sums do not depend on threads.
        let mut all = Self {
            least: f32::INFINITY,
            most: 0.0,
            mean: [0.0; 3],
            negative: 0,
            most_negative: 0.0,
        };
        for one in groups.iter().flatten() {
            all.least = all.least.min(one.least);
            all.most = all.most.max(one.most);
            all.negative += one.negative;
            all.most_negative = all.most_negative.min(one.most_negative);
            for (mean, part) in all.mean.iter_mut().zip(one.mean) {
                *mean += part / images as f64;
            }
        }
        Ok(all)
    }

    fn of_images(sample: &Sample, images: &[u32]) -> Result<Vec<Self>> {
        let mut held = vec![Pixels::of_type(sample.description().dtype); images.len()];
        sample.read_texels_of(images, 0..sample.grid().len(), &mut held)?;
        let read = images.iter().zip(&held);
        read.map(|(&image, pixels)| {
            let mut numbers = vec![0.0; pixels.len()];
            pixels.copy_to(&mut numbers);
            sample.check_image(image as usize, &numbers)?;
            Ok(Self::of_image(&numbers))
        })
        .collect()
    }

    /// Of images expanded, with the values below 0 counted before they become 0.
    fn of_products(sample: &Sample, images: &[u32]) -> Result<Vec<Self>> {
        let texels = sample.grid().len();
        let mut numbers = vec![0.0; images.len() * texels * 3];
        if let Some(factors) = sample.factors() {
            factors.multiply(images, 0..texels, Multiplied::Signed, &mut numbers);
        }
        let each = images.iter().zip(numbers.chunks_exact_mut(texels * 3));
        each.map(|(&image, numbers)| {
            let negative = numbers.iter().filter(|value| **value < 0.0).count();
            let most_negative = numbers.iter().copied().fold(0.0, f32::min);
            numbers.iter_mut().for_each(|value| *value = value.max(0.0));
            sample.check_image(image as usize, numbers)?;
            Ok(Self {
                negative: negative as u64,
                most_negative,
                ..Self::of_image(numbers)
            })
        })
        .collect()
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
            negative: 0,
            most_negative: 0.0,
        }
    }
}
