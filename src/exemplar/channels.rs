//! Channels of a plain-image exemplar: which numbers of a texel are a colour, a height, a mask, an
//! alpha or a normal, what they weigh in distances, and the range they are drawn and exported in.
//!
//! In: the `channels` of a space's `meta.json`, or those that [`plain_images`](super::plain_images)
//! makes. Out: checked [`Channels`], which weigh the levels of a space and keep the numbers as stored.
//! A file holds the numbers unweighted. A space in memory holds in
//! [`Features::Plain`](super::space_level::Features) what distances compare: each number times the root of
//! its channel's weight. Weights of 1 leave every bit as it is.

pub(super) mod parsing;

use std::collections::BTreeSet;
use std::ops::Range;

use clap::ValueEnum;
use ndarray::{Array3, s};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::exemplar::space_level::{Features, SpaceLevel, is_sound};

/// The largest weight.
pub const MOST_WEIGHT: f64 = 1e12;
/// The largest size of `low` and `high`: the squares of features are at most 10³⁰.
const MOST_RANGE: f64 = 1e15;
/// The longest name, in characters.
const LONGEST_NAME: usize = 64;

/// What the numbers of a channel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum ChannelKind {
    /// Grey or red, green and blue, by the sRGB curve.
    Color,
    /// How high the surface is, in any unit.
    Height,
    /// Any share or label that is no colour: roughness, metal, parts of a pattern.
    Mask,
    /// How opaque a texel is, 0 to 1.
    Alpha,
    /// A normal (x, y, z) or (x, y); `low` to `high` stands for −1 to 1.
    Normal,
}

impl ChannelKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [
        Self::Color,
        Self::Height,
        Self::Mask,
        Self::Alpha,
        Self::Normal,
    ];

    /// The kind's name in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Height => "height",
            Self::Mask => "mask",
            Self::Alpha => "alpha",
            Self::Normal => "normal",
        }
    }

    /// The kind of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// How many numbers a channel of this kind may have.
    pub fn counts(self) -> &'static [u32] {
        match self {
            Self::Color => &[1, 3],
            Self::Normal => &[2, 3],
            Self::Height | Self::Mask | Self::Alpha => &[1],
        }
    }

    /// All kinds, in words.
    fn all_names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }
}

/// One channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Channel {
    /// The name that options use, one channel's alone.
    pub name: String,
    /// What its numbers are.
    pub kind: ChannelKind,
    /// Its first number among those of a texel.
    pub first: u32,
    /// How many numbers it has.
    pub count: u32,
    /// Factor of its squared differences in distances; 0 or more, 0 leaves it out.
    pub weight: f64,
    /// The least stored number.
    pub low: f64,
    /// The greatest stored number; above `low`.
    pub high: f64,
}

impl Channel {
    /// Where its numbers are among those of a texel.
    pub fn numbers(&self) -> Range<usize> {
        let first = self.first as usize;
        first..first + self.count as usize
    }

    /// Checks everything but the other channels.
    fn check(&self, depth: usize) -> Result<()> {
        // Check its name, and its place among a texel's numbers.
        let fault = |field: &str, found: String| Error::data(field, found);
        let length = self.name.chars().count();
        if length == 0 || length > LONGEST_NAME || self.name.chars().any(char::is_control) {
            return Err(fault("name", format!("{length} characters"))
                .expected(format!("1 to {LONGEST_NAME} printable characters")));
        }
        if !self.kind.counts().contains(&self.count) {
            let counts: Vec<String> = self.kind.counts().iter().map(u32::to_string).collect();
            return Err(fault("count", self.count.to_string()).expected(format!(
                "{} for kind {}",
                counts.join(" or "),
                self.kind.name()
            )));
        }
        let end = u64::from(self.first) + u64::from(self.count);
        if end > depth as u64 {
            return Err(fault("first", self.first.to_string()).expected(format!(
                "its {} numbers among the {depth} of a texel",
                self.count
            )));
        }
        // Check weight and range.
        if !(0.0..=MOST_WEIGHT).contains(&self.weight) {
            return Err(
                fault("weight", self.weight.to_string()).expected(format!("0 to {MOST_WEIGHT:e}"))
            );
        }
        let in_bounds = |value: f64| value.abs() <= MOST_RANGE;
        if !(self.low < self.high && in_bounds(self.low) && in_bounds(self.high)) {
            return Err(
                fault("low, high", format!("{}, {}", self.low, self.high)).expected(format!(
                    "low below high, both −{MOST_RANGE:e} to {MOST_RANGE:e}"
                )),
            );
        }
        Ok(())
    }
}

/// The channels of a space, and its numbers as stored.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    list: Vec<Channel>,
    /// The unweighted numbers of each level; empty where all weights are 1, for then the features are these.
    stored: Vec<Array3<f32>>,
}

impl Channels {
    /// Checks channels against the levels they describe, whose vectors are the numbers as stored, and
    /// weighs the levels.
    pub(super) fn weigh(mut list: Vec<Channel>, levels: &mut [SpaceLevel]) -> Result<Self> {
        list.sort_by_key(|channel| channel.first);
        check(&list, depth_of(levels)?)?;
        check_range(&list, levels)?;
        if list.iter().all(|channel| channel.weight == 1.0) {
            let stored = Vec::new();
            return Ok(Self { list, stored });
        }
        let mut stored = Vec::new();
        for level in levels {
            let Features::Plain(features) = &mut level.features else {
                continue;
            };
            let weighted = weighted(features, &list)?;
            stored.push(std::mem::replace(features, weighted));
        }
        Ok(Self { list, stored })
    }

    /// The channels, by their first numbers; none where a space states none.
    pub fn list(&self) -> &[Channel] {
        &self.list
    }

    /// The stored numbers of a level whose features are `features`.
    pub(super) fn stored<'a>(&'a self, level: usize, features: &'a Array3<f32>) -> &'a Array3<f32> {
        self.stored.get(level).unwrap_or(features)
    }
}

/// Numbers per texel, the same on every level.
pub(super) fn depth_of(levels: &[SpaceLevel]) -> Result<usize> {
    let mut depths = levels.iter().filter_map(|level| match &level.features {
        Features::Plain(features) => Some(features.dim().2),
        Features::Textons { .. } => None,
    });
    let first = depths.next().unwrap_or(0);
    match depths.position(|depth| depth != first) {
        None => Ok(first),
        Some(at) => Err(Error::data(
            format!("L{}/features", at + 1),
            "a different number of features",
        )
        .expected(format!("{first} per texel, as on level 0"))),
    }
}

/// Every number belongs to one channel. The list is sorted by the first numbers.
fn check(list: &[Channel], depth: usize) -> Result<()> {
    // Check each channel alone; no two share a name.
    let mut names = BTreeSet::new();
    for channel in list {
        let place = |error| error_at(&format!("channel `{}`", shortened(&channel.name)), error);
        channel.check(depth).map_err(place)?;
        if !names.insert(&channel.name) {
            return Err(
                Error::data("channels", format!("two named `{}`", channel.name))
                    .expected("names that differ"),
            );
        }
    }
    // Check that the channels follow each other without gap or overlap.
    let mut free = 0;
    for (at, channel) in list.iter().enumerate() {
        let numbers = channel.numbers();
        if numbers.start < free {
            return Err(Error::data(
                format!("channel `{}`: first", channel.name),
                format!(
                    "{}, a number of channel `{}`",
                    channel.first,
                    list[at - 1].name
                ),
            )
            .expected(format!("{free}: channels do not overlap")));
        }
        if numbers.start > free {
            return Err(gap(free).expected(format!(
                "a channel that begins there, or {free} as the first of `{}`",
                channel.name
            )));
        }
        free = numbers.end;
    }
    if free < depth {
        return Err(gap(free).expected(format!("channels for all {depth} numbers of a texel")));
    }
    match list.iter().any(|channel| channel.weight > 0.0) {
        true => Ok(()),
        false => Err(Error::data("channels", "every weight is 0").expected("one above 0")),
    }
}

fn gap(number: usize) -> Error {
    Error::data("channels", format!("number {number} is in none"))
}

fn shortened(name: &str) -> String {
    name.chars()
        .take(LONGEST_NAME)
        .filter(|c| !c.is_control())
        .collect()
}

/// The stored numbers of the finest level lie in their channel's range. Means do by themselves, but for
/// rounding.
fn check_range(list: &[Channel], levels: &[SpaceLevel]) -> Result<()> {
    let Some(Features::Plain(features)) = levels.first().map(|level| &level.features) else {
        return Ok(());
    };
    for channel in list {
        let numbers = features.slice(s![.., .., channel.numbers()]);
        let range = channel.low..=channel.high;
        let outside = numbers
            .indexed_iter()
            .find(|(_, value)| !range.contains(&f64::from(**value)));
        if let Some(((row, col, _), value)) = outside {
            return Err(Error::data(
                format!("channel `{}`, row {row}, column {col}", channel.name),
                value.to_string(),
            )
            .expected(format!(
                "{} to {}, its low and high",
                channel.low, channel.high
            )));
        }
    }
    Ok(())
}

/// Each number times the root of its channel's weight.
fn weighted(stored: &Array3<f32>, list: &[Channel]) -> Result<Array3<f32>> {
    let mut features = stored.clone();
    for channel in list {
        let factor = (channel.weight as f32).sqrt();
        let mut numbers = features.slice_mut(s![.., .., channel.numbers()]);
        numbers.mapv_inplace(|value| value * factor);
        if let Some(value) = numbers.iter().find(|value| !is_sound(**value * **value)) {
            return Err(Error::data(
                format!("channel `{}`: weight", channel.name),
                format!("{} makes a number {value}", channel.weight),
            )
            .expected("weighted numbers whose squares are at most 1e30"));
        }
    }
    Ok(features)
}

/// The channels of a file that states none: one of colour where texels have 1 or 3 numbers, else none,
/// for what four or more numbers are cannot be told.
pub(super) fn implied(levels: &[SpaceLevel]) -> Vec<Channel> {
    let Some(Features::Plain(features)) = levels.first().map(|level| &level.features) else {
        return Vec::new();
    };
    let count = features.dim().2 as u32;
    if !ChannelKind::Color.counts().contains(&count) {
        return Vec::new();
    }
    let bounds = features
        .iter()
        .fold((0.0_f32, 1.0_f32), |(low, high), &value| {
            (low.min(value), high.max(value))
        });
    vec![Channel {
        name: ChannelKind::Color.name().into(),
        kind: ChannelKind::Color,
        first: 0,
        count,
        weight: 1.0,
        low: bounds.0.into(),
        high: bounds.1.into(),
    }]
}

/// The same data fault, further in.
fn error_at(place: &str, error: Error) -> Error {
    match error {
        Error::Data(mut fault) => {
            fault.place = format!("{place}: {}", fault.place);
            Error::Data(fault)
        }
        other => other,
    }
}

#[cfg(test)]
mod tests;
