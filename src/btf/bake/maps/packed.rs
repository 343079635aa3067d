//! Images that hold a map per channel: occlusion, roughness and metalness in one file.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// What a channel of a packed image holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PackedChannel {
    /// Ambient occlusion; not used.
    Occlusion,
    /// Roughness.
    Roughness,
    /// Gloss: 1 − roughness.
    Gloss,
    /// Metalness.
    Metallic,
    /// Nothing that is known.
    Unused,
}

impl PackedChannel {
    const ALL: [(char, Self, &'static str); 5] = [
        ('o', Self::Occlusion, "occlusion"),
        ('r', Self::Roughness, "roughness"),
        ('g', Self::Gloss, "gloss"),
        ('m', Self::Metallic, "metalness"),
        ('x', Self::Unused, "nothing"),
    ];

    /// What a report calls it.
    pub fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(_, channel, _)| *channel == self)
            .map_or("", |(_, _, name)| name)
    }
}

/// What red, green and blue of a packed image hold: three of the letters o (occlusion), r (roughness),
/// g (gloss), m (metalness) and x (nothing); `orm` by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct PackedOrder([PackedChannel; 3]);

impl Default for PackedOrder {
    fn default() -> Self {
        Self([
            PackedChannel::Occlusion,
            PackedChannel::Roughness,
            PackedChannel::Metallic,
        ])
    }
}

impl PackedOrder {
    /// The channel that holds something, counted from 0.
    pub fn place_of(self, wanted: PackedChannel) -> Option<usize> {
        self.0.iter().position(|&channel| channel == wanted)
    }

    /// "red occlusion, green roughness, blue metalness".
    pub fn describe(self) -> String {
        let [red, green, blue] = self.0.map(PackedChannel::name);
        format!("red {red}, green {green}, blue {blue}")
    }
}

impl FromStr for PackedOrder {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || {
            format!(
                "`{text}`: expected three of the letters o, r, g, m and x, none but x twice, r or g or m among them"
            )
        };
        let channel = |letter: char| {
            let found = PackedChannel::ALL
                .iter()
                .find(|(known, _, _)| *known == letter);
            found.map(|&(_, channel, _)| channel).ok_or_else(fault)
        };
        let channels: Vec<PackedChannel> = text.chars().map(channel).collect::<Result<_, _>>()?;
        let [red, green, blue] = channels[..] else {
            return Err(fault());
        };
        let twice = |a: PackedChannel, b| a == b && a != PackedChannel::Unused;
        let order = Self([red, green, blue]);
        let rough = [PackedChannel::Roughness, PackedChannel::Gloss]
            .iter()
            .filter(|&&channel| order.place_of(channel).is_some())
            .count();
        let holds_any = rough == 1 || order.place_of(PackedChannel::Metallic).is_some();
        if twice(red, green) || twice(red, blue) || twice(green, blue) || rough > 1 || !holds_any {
            return Err(fault());
        }
        Ok(order)
    }
}

impl TryFrom<String> for PackedOrder {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl fmt::Display for PackedOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for channel in self.0 {
            let letter = PackedChannel::ALL
                .iter()
                .find(|(_, known, _)| *known == channel);
            write!(f, "{}", letter.map_or('x', |&(letter, _, _)| letter))?;
        }
        Ok(())
    }
}

impl From<PackedOrder> for String {
    fn from(order: PackedOrder) -> Self {
        order.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_three_letters() {
        let order: PackedOrder = "mrx".parse().unwrap();
        assert_eq!(order.place_of(PackedChannel::Roughness), Some(1));
        assert_eq!(order.place_of(PackedChannel::Occlusion), None);
        assert_eq!(order.to_string(), "mrx");
        assert_eq!(
            order.describe(),
            "red metalness, green roughness, blue nothing"
        );
        assert_eq!("orm".parse(), Ok(PackedOrder::default()));
        for bad in ["", "or", "ormx", "orr", "rgm", "oxx", "abc"] {
            assert!(bad.parse::<PackedOrder>().is_err(), "{bad}");
        }
    }
}
