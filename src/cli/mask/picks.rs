//! `--pick` of `mesotex mask`: a colour, of a pixel or by value, and a tolerance.

use std::str::FromStr;

use crate::vary::color_mask::{LARGEST_TOLERANCE, Pick, PickedColor};

/// The tolerance where none is given.
const TOLERANCE: f32 = 0.2;

/// One `--pick`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickOption(pub Pick);

impl FromStr for PickOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (color, tolerance) = match text.split_once(':') {
            None => (text, TOLERANCE),
            Some((color, tolerance)) => match tolerance.parse::<f32>() {
                Ok(number) if (0.0..=LARGEST_TOLERANCE).contains(&number) => (color, number),
                _ => {
                    return Err(format!(
                        "`{tolerance}`; expected a tolerance of 0 to {LARGEST_TOLERANCE}"
                    ));
                }
            },
        };
        let color = match color.strip_prefix('#') {
            Some(digits) => value(digits),
            None => pixel(color),
        };
        let color = color.ok_or("expected COL,ROW or #RRGGBB, as 40,12 or #2a2018")?;
        Ok(Self(Pick { color, tolerance }))
    }
}

fn value(digits: &str) -> Option<PickedColor> {
    if digits.len() != 6 || !digits.is_ascii() {
        return None;
    }
    let number = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).ok();
    let bytes = [number(0)?, number(2)?, number(4)?];
    Some(PickedColor::Value(
        bytes.map(|byte| f32::from(byte) / 255.0),
    ))
}

fn pixel(text: &str) -> Option<PickedColor> {
    let (col, row) = text.split_once(',')?;
    Some(PickedColor::Pixel {
        col: col.trim().parse().ok()?,
        row: row.trim().parse().ok()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picks_are_pixels_or_values() {
        let read = |text: &str| text.parse::<PickOption>().unwrap().0;
        let at = read("40,12");
        assert_eq!(at.color, PickedColor::Pixel { col: 40, row: 12 });
        assert_eq!(at.tolerance, TOLERANCE);
        let red = read("#ff0033:0.5");
        assert_eq!(red.color, PickedColor::Value([1.0, 0.0, 0.2]));
        assert_eq!(red.tolerance, 0.5);
        for wrong in [
            "", "40", "40,-1", "#ff00", "#ff00gg", "#ü000", "1,2:3", "1,2:nan",
        ] {
            assert!(wrong.parse::<PickOption>().is_err(), "{wrong}");
        }
    }
}
