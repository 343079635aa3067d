//! `--weights` of `mesotex exemplar`: one number for each image, or numbers of channels by name.

use std::str::FromStr;

use crate::error::{Error, Result};
use crate::exemplar::channels::MOST_WEIGHT;
use crate::exemplar::plain_images::ChannelImage;

/// One entry of `--weights`.
#[derive(Clone, Debug, PartialEq)]
pub enum Weight {
    /// The weight of the image at the entry's place.
    OfImage(f64),
    /// The weight of the channel of a name.
    OfChannel(String, f64),
}

impl FromStr for Weight {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = |text: &str| match text.trim().parse::<f64>() {
            Ok(weight) if (0.0..=MOST_WEIGHT).contains(&weight) => Ok(weight),
            _ => Err(format!("`{text}`; expected a number, 0 to {MOST_WEIGHT:e}")),
        };
        match text.split_once('=') {
            None => number(text).map(Self::OfImage),
            Some((name, weight)) => Ok(Self::OfChannel(name.trim().into(), number(weight)?)),
        }
    }
}

impl Weight {
    fn number(&self) -> f64 {
        match self {
            Self::OfImage(weight) | Self::OfChannel(_, weight) => *weight,
        }
    }
}

/// Refuses weights that fit no channels of this many images.
pub(super) fn check(weights: &[Weight], images: usize) -> Result<()> {
    let of_images = weights
        .iter()
        .filter(|weight| matches!(weight, Weight::OfImage(_)));
    let count = of_images.count();
    if count > 0 && (count != weights.len() || count != images) {
        return Err(Error::option(
            "weights",
            format!("{count} numbers among {} weights", weights.len()),
            format!("a number for each of {images} images, or names only, as height=0.5"),
        ));
    }
    let named = names(weights);
    if let Some(twice) = (1..named.len()).find(|&at| named[..at].contains(&named[at])) {
        return Err(Error::option(
            "weights",
            format!("two for `{}`", named[twice]),
            "one for each channel",
        ));
    }
    if count > 0 && weights.iter().all(|weight| weight.number() == 0.0) {
        return Err(weightless());
    }
    Ok(())
}

fn names(weights: &[Weight]) -> Vec<&str> {
    weights
        .iter()
        .filter_map(|weight| match weight {
            Weight::OfChannel(name, _) => Some(name.as_str()),
            Weight::OfImage(_) => None,
        })
        .collect()
}

fn weightless() -> Error {
    Error::option("weights", "0 for every channel", "one above 0")
}

/// The weight of an image; 1 where none is given.
pub(super) fn of_image(weights: &[Weight], image: usize) -> f64 {
    match weights.get(image) {
        Some(Weight::OfImage(weight)) => *weight,
        _ => 1.0,
    }
}

/// Gives channels the weights that name them.
pub(super) fn give_named(weights: &[Weight], channels: &mut [ChannelImage]) -> Result<()> {
    for weight in weights {
        let Weight::OfChannel(name, weight) = weight else {
            continue;
        };
        match channels.iter_mut().find(|channel| channel.name == *name) {
            Some(channel) => channel.weight = *weight,
            None => {
                let known: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
                return Err(Error::option(
                    "weights",
                    format!("channel `{name}`, which does not exist"),
                    known.join(", "),
                ));
            }
        }
    }
    match channels.iter().any(|channel| channel.weight > 0.0) {
        true => Ok(()),
        false => Err(weightless()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Vec<Weight> {
        text.split(',')
            .map(|entry| entry.parse().unwrap())
            .collect()
    }

    #[test]
    fn weights_are_numbers_or_names_with_numbers() {
        assert_eq!(
            parsed("1,0.5"),
            [Weight::OfImage(1.0), Weight::OfImage(0.5)]
        );
        assert_eq!(
            parsed("height=0.1"),
            [Weight::OfChannel("height".into(), 0.1)]
        );
        for wrong in ["-1", "nan", "inf", "1e13", "height", "height=", "height=-2"] {
            let said = wrong.parse::<Weight>().unwrap_err();
            assert!(said.contains("expected a number, 0 to 1e12"), "{said}");
        }
        assert_eq!(of_image(&parsed("1,0.5"), 1), 0.5);
        assert_eq!(of_image(&parsed("height=3"), 0), 1.0);
    }

    #[test]
    fn weights_that_fit_no_images_are_refused() {
        let said = |text: &str, images| check(&parsed(text), images).unwrap_err().to_string();
        assert!(said("1", 2).contains("each of 2 images"));
        assert!(said("1,height=2", 2).contains("names only"));
        assert!(said("0,0", 2).contains("one above 0"));
        assert!(said("a=1,b=1,a=2", 2).contains("two for `a`"));
        assert!(check(&parsed("a=1"), 2).is_ok() && check(&[], 3).is_ok());
    }
}
