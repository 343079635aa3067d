//! False colours: what a texture coordinate, a texton label or an energy looks like in a picture.
//!
//! In: the numbers of texels or sites. Out: one 8-bit sRGB colour each; drawing them is for the caller. By texture
//! coordinate, copied patches are smooth and their seams are edges.

use crate::grid::{TexCoord, TexelGrid};
use crate::index::TextonLabel;

/// Red is s/W, green t/H: a copied patch looks like a piece of one smooth gradient.
pub fn coordinate_colors(grid: TexelGrid, coords: &[TexCoord]) -> Vec<[u8; 3]> {
    let color = |at: &TexCoord| {
        let (u, v) = (at.s / grid.width as f32, at.t / grid.height as f32);
        [byte(u), byte(v), byte(0.5)]
    };
    coords.iter().map(color).collect()
}

/// The colours of labels, each by [`label_color`].
pub fn label_colors(labels: &[TextonLabel]) -> Vec<[u8; 3]> {
    labels.iter().map(|&label| label_color(label)).collect()
}

/// A label's own colour, the same in every picture. Hues of consecutive labels are a golden section apart, in three
/// brightnesses; no label is grey.
pub fn label_color(label: TextonLabel) -> [u8; 3] {
    const GOLDEN_SECTION: f32 = 0.618_034;
    match label {
        TextonLabel::NONE => [128; 3],
        TextonLabel(index) => hue(
            (f32::from(index) * GOLDEN_SECTION).fract(),
            0.55 + 0.4 * f32::from(index % 3) / 2.0,
        ),
    }
}

/// From black for nothing over red and yellow to white for the largest hundredth.
pub fn energy_colors(energies: &[f64]) -> Vec<[u8; 3]> {
    let mut ranked: Vec<f64> = energies.to_vec();
    let place = ranked.len().saturating_sub(1) * 99 / 100;
    let top = (!ranked.is_empty()).then(|| *ranked.select_nth_unstable_by(place, f64::total_cmp).1);
    let top = top.filter(|&top| top > 0.0).unwrap_or(1.0);
    let color = |&energy: &f64| {
        let heat = 3.0 * (energy / top).min(1.0) as f32;
        [byte(heat), byte(heat - 1.0), byte(heat - 2.0)]
    };
    energies.iter().map(color).collect()
}

fn byte(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// A saturated colour: red at 0, green at ⅓, blue at ⅔.
fn hue(turn: f32, value: f32) -> [u8; 3] {
    [0.0, 2.0, 4.0].map(|shift| {
        let place = (6.0 * turn - shift).rem_euclid(6.0);
        let distance = place.min(6.0 - place);
        byte(value * (2.0 - distance).clamp(0.1, 1.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_show_as_a_gradient() {
        let grid = TexelGrid {
            width: 4,
            height: 2,
            tileable: true,
        };
        let colors = coordinate_colors(
            grid,
            &[TexCoord { s: 0.0, t: 2.0 }, TexCoord { s: 4.0, t: 0.0 }],
        );
        assert_eq!(colors, [[0, 255, 128], [255, 0, 128]]);
    }

    #[test]
    fn hues_turn_from_red_through_green_to_blue() {
        assert_eq!(hue(0.0, 1.0), [255, 26, 26]);
        assert_eq!(hue(1.0 / 3.0, 1.0), [26, 255, 26]);
        assert_eq!(hue(2.0 / 3.0, 1.0), [26, 26, 255]);
    }

    #[test]
    fn consecutive_labels_differ_in_colour_and_none_is_grey() {
        let labels: Vec<TextonLabel> = (0..500).map(TextonLabel).collect();
        let colors = label_colors(&labels);
        assert!(colors.windows(2).all(|pair| pair[0] != pair[1]));
        assert_eq!(label_color(TextonLabel::NONE), [128; 3]);
    }

    #[test]
    fn energies_are_black_where_there_is_none() {
        let mut energies = vec![0.0; 50];
        energies.extend([1.0; 50]);
        let colors = energy_colors(&energies);
        assert_eq!((colors[0], colors[99]), ([0; 3], [255; 3]));
        assert_eq!(energy_colors(&[0.0; 3]), [[0; 3]; 3]);
    }
}
