//! The names of a channel's numbers as properties of a PLY.

use crate::exemplar::channels::ChannelKind;
use crate::textures::channel::SampleChannel;

/// Names that the geometry and its colours have.
const TAKEN: [&str; 15] = [
    "x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "alpha", "r", "g", "b", "source",
    "phase",
];

/// A name for each number of a channel: the channel's own, with an ending where it has several.
pub fn property_names(channel: &SampleChannel) -> Vec<String> {
    let name = property_name(&channel.name);
    let endings = match channel.kind {
        ChannelKind::Normal => ["x", "y", "z"],
        _ if channel.count == 3 => ["red", "green", "blue"],
        _ => return vec![name],
    };
    endings.map(|ending| format!("{name}_{ending}")).to_vec()
}

/// A name without blanks, none of those that the geometry and its colours have.
fn property_name(name: &str) -> String {
    let is_fine = |sign: char| sign.is_ascii_alphanumeric() || sign == '_';
    let plain: String = name
        .chars()
        .map(|sign| if is_fine(sign) { sign } else { '_' })
        .collect();
    match TAKEN.contains(&plain.as_str()) {
        true => format!("map_{plain}"),
        false => plain,
    }
}
