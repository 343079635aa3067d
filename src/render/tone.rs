//! From linear radiance to 8-bit previews: exposure, clipping, the sRGB curve; over a background.

use crate::format::image::encode_srgb8;

/// How a preview shows linear values: out = sRGB(clamp(2^exposure · value)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Stops by which values are brightened before they are clipped to [0, 1].
    pub exposure: f32,
    /// Linear grey behind what is not covered, not exposed.
    pub background: f32,
}

impl Default for Tone {
    fn default() -> Self {
        Self {
            exposure: 0.0,
            background: 0.03,
        }
    }
}

/// Steps of the table that stands for the sRGB curve; fine enough for exact 8-bit results but
/// for one step in 10⁴.
const STEPS: usize = 1 << 14;

/// Turns premultiplied linear RGBA into 8-bit RGB.
pub fn preview(rgba: &[[f32; 4]], tone: Tone) -> Vec<u8> {
    let table: Vec<u8> = (0..=STEPS)
        .map(|step| encode_srgb8(step as f32 / STEPS as f32))
        .collect();
    let gain = tone.exposure.exp2();
    let encode = |linear: f32| table[(linear.clamp(0.0, 1.0) * STEPS as f32 + 0.5) as usize];
    rgba.iter()
        .flat_map(|&[r, g, b, a]| {
            let behind = (1.0 - a) * tone.background;
            [r, g, b].map(|value| encode(value * gain + behind))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_are_srgb_over_the_background() {
        let tone = Tone {
            exposure: 1.0,
            background: 1.0,
        };
        let pixels = [
            [0.5, 0.25, 0.107, 1.0],
            [0.0, 0.0, 0.0, 0.0],
            [9.0, 0.0, 0.0, 1.0],
        ];
        let shown = preview(&pixels, tone);
        assert_eq!(shown[..3], [255, 188, 127]);
        assert_eq!(shown[3..6], [255, 255, 255]);
        assert_eq!(shown[6..], [255, 0, 0]);
    }
}
