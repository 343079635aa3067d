//! What the headers of an OpenEXR file say, in words.

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, ChannelDescription, IntegerBounds, SampleType};
use exr::meta::header::Header;

use crate::format::image::facts::{Channel, Facts, Part};
use crate::format::image::openexr_layers::Layers;

/// The longest value shown, in characters.
const LONGEST_VALUE: usize = 200;
/// Attributes that are shown as something else.
const SHOWN_ELSEWHERE: [&str; 10] = [
    "channels",
    "chromaticities",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "name",
    "pixelAspectRatio",
    "preview",
    "type",
];

/// Parts, layers and channels of a file; what depends on the chosen layer is filled in by the caller.
pub(super) fn of(meta: &MetaData, layers: &Layers) -> Facts {
    let parts = meta.headers.iter().enumerate();
    let first = meta.headers.first();
    let display = first.map(|header| header.shared_attributes.display_window.size);
    Facts {
        format: "OpenEXR".into(),
        size: display.map_or([0, 0], |size| [size.0 as u64, size.1 as u64]),
        pixel_aspect: first.map_or(1.0, |h| f64::from(h.shared_attributes.pixel_aspect)),
        orientation: 1,
        pictures: 1,
        parts: parts
            .map(|(index, header)| part(header, layers.names(index)))
            .collect(),
        ..Facts::default()
    }
}

fn part(header: &Header, layers: Vec<String>) -> Part {
    let own = &header.own_attributes;
    let text = |text: &Option<exr::meta::attribute::Text>| {
        text.as_ref().map(ToString::to_string).unwrap_or_default()
    };
    let deep = if header.deep { ", deep" } else { "" };
    let mut attributes: Vec<(String, String)> = header
        .all_named_attributes()
        .map(|(name, value)| (String::from_utf8_lossy(name).into_owned(), value))
        .filter(|(name, _)| !SHOWN_ELSEWHERE.contains(&name.as_str()))
        .map(|(name, value)| (name, shown(&value)))
        .collect();
    attributes.sort();
    Part {
        name: text(&own.layer_name),
        view: text(&own.view_name),
        layers,
        channels: header.channels.list.iter().map(channel).collect(),
        data_window: Some(window(&header.data_window())),
        display_window: Some(window(&header.shared_attributes.display_window)),
        compression: format!("{}{deep}", header.compression),
        attributes,
    }
}

fn channel(channel: &ChannelDescription) -> Channel {
    Channel {
        name: channel.name.to_string(),
        numbers: match channel.sample_type {
            SampleType::F16 => "half",
            SampleType::F32 => "float",
            SampleType::U32 => "uint",
        }
        .into(),
        sampling: [channel.sampling.0, channel.sampling.1],
    }
}

/// First column, first row, last column, last row.
fn window(bounds: &IntegerBounds) -> [i64; 4] {
    let (left, top) = (i64::from(bounds.position.0), i64::from(bounds.position.1));
    let (width, height) = (bounds.size.0 as i64, bounds.size.1 as i64);
    [left, top, left + width - 1, top + height - 1]
}

fn shown(value: &AttributeValue) -> String {
    let text = match value {
        AttributeValue::Text(text) => text.to_string(),
        AttributeValue::TextVector(texts) => {
            let texts: Vec<String> = texts.iter().map(ToString::to_string).collect();
            texts.join(", ")
        }
        AttributeValue::F32(number) => number.to_string(),
        AttributeValue::F64(number) => number.to_string(),
        AttributeValue::I32(number) => number.to_string(),
        AttributeValue::FloatVec2(v) => format!("{} {}", v.0, v.1),
        AttributeValue::IntVec2(v) => format!("{} {}", v.0, v.1),
        AttributeValue::FloatVec3((x, y, z)) => format!("{x} {y} {z}"),
        AttributeValue::IntVec3((x, y, z)) => format!("{x} {y} {z}"),
        AttributeValue::Matrix3x3(m) => joined(m),
        AttributeValue::Matrix4x4(m) => joined(m),
        AttributeValue::Bytes { type_hint, bytes } => {
            format!("{} bytes of type {type_hint}", bytes.len())
        }
        AttributeValue::Custom { kind, bytes } => format!("{} bytes of type {kind}", bytes.len()),
        AttributeValue::Rational((dividend, divisor)) => format!("{dividend}/{divisor}"),
        AttributeValue::LineOrder(order) => format!("{order:?}"),
        other => format!("{other:?}"),
    };
    let plain = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    plain.take(LONGEST_VALUE).collect()
}

fn joined(numbers: &[f32]) -> String {
    let numbers: Vec<String> = numbers.iter().map(f32::to_string).collect();
    numbers.join(" ")
}
