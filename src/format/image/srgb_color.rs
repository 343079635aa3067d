//! A colour as people write it: 8-bit sRGB, `R,G,B` or `#RRGGBB`.

use std::fmt;
use std::str::FromStr;

use crate::format::image::srgb::decode_srgb;

/// A colour as 8-bit sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SrgbColor(pub [u8; 3]);

impl SrgbColor {
    /// Linear Rec. 709.
    pub fn linear(self) -> [f32; 3] {
        self.0.map(|value| decode_srgb(f32::from(value) / 255.0))
    }
}

impl FromStr for SrgbColor {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parsed = match text.strip_prefix('#') {
            Some(digits) => hexadecimal(digits),
            None => decimal(text),
        };
        parsed.map(Self).ok_or_else(|| {
            format!("`{text}` is not a colour R,G,B of three numbers from 0 to 255, nor #RRGGBB")
        })
    }
}

fn hexadecimal(digits: &str) -> Option<[u8; 3]> {
    let is_whole = digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| is_whole)?;
    let [_, red, green, blue] = number.to_be_bytes();
    Some([red, green, blue])
}

fn decimal(text: &str) -> Option<[u8; 3]> {
    let numbers = text.split(',').map(|part| part.trim().parse().ok());
    let numbers: Option<Vec<u8>> = numbers.collect();
    numbers?.try_into().ok()
}

impl fmt::Display for SrgbColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [red, green, blue] = self.0;
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read_in_two_forms() {
        let read = |text: &str| text.parse::<SrgbColor>();
        assert_eq!(read("#00ff80"), Ok(SrgbColor([0, 255, 128])));
        assert_eq!(read("0, 255,128"), read("#00FF80"));
        assert_eq!(read("#00ff80").unwrap().to_string(), "#00ff80");
        for wrong in [
            "",
            "#",
            "#12345",
            "#+12345",
            "green",
            "1,2",
            "1,2,3,4",
            "0.2,0.5,0.1",
            "0,0,256",
        ] {
            let text = read(wrong).unwrap_err();
            assert!(text.contains("0 to 255") && text.contains(wrong), "{text}");
        }
    }
}
