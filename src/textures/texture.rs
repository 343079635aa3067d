//! An image of numbers on an atlas.

use crate::exemplar::channels::ChannelKind;
use crate::format::image::Precision;

/// A channel on the texels of an atlas: colours in linear light, normals as unit vectors of tangent space, all
/// else as it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The channel's name.
    pub name: String,
    /// What its numbers are.
    pub kind: ChannelKind,
    /// Numbers per texel: 1 or 3.
    pub count: usize,
    /// The least number, colours by the sRGB curve.
    pub low: f64,
    /// The greatest number, colours by the sRGB curve.
    pub high: f64,
    /// What the channel's file stored.
    pub precision: Precision,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// height · width · count numbers, row 0 on top.
    pub numbers: Vec<f32>,
}

impl Texture {
    /// The numbers of a texel.
    pub fn texel(&self, texel: usize) -> &[f32] {
        &self.numbers[texel * self.count..][..self.count]
    }

    /// Copies texels to others: pairs of where to and where from.
    pub fn copy(&mut self, pairs: &[(u32, u32)]) {
        for &(to, from) in pairs {
            let from = from as usize * self.count;
            let to = to as usize * self.count;
            self.numbers.copy_within(from..from + self.count, to);
        }
    }

    /// Gives the texels that are neither inside charts nor padded the mean of those that are, as
    /// [`fill_rest`](Self::fill_rest) does; `padding` are pairs of a padded texel and the one it repeats.
    pub fn fill_beyond(&mut self, padding: &[(u32, u32)], is_inside: impl Fn(usize) -> bool) {
        let texels = self.numbers.len() / self.count;
        let mut filled: Vec<bool> = (0..texels).map(is_inside).collect();
        for &(outside, _) in padding {
            filled[outside as usize] = true;
        }
        self.fill_rest(&filled);
    }

    /// Gives the texels that are not `filled` the mean of those that are, so that coarser levels of the image
    /// keep its colours; normals stand upright there.
    pub fn fill_rest(&mut self, filled: &[bool]) {
        let fill = match self.kind {
            ChannelKind::Normal => vec![0.0, 0.0, 1.0],
            _ => self.mean_of(filled),
        };
        let texels = self.numbers.chunks_exact_mut(self.count).zip(filled);
        texels
            .filter(|(_, filled)| !**filled)
            .for_each(|(texel, _)| texel.copy_from_slice(&fill));
    }

    fn mean_of(&self, chosen: &[bool]) -> Vec<f32> {
        let mut sums = vec![0.0_f64; self.count];
        let texels = self.numbers.chunks_exact(self.count).zip(chosen);
        for (texel, _) in texels.filter(|(_, chosen)| **chosen) {
            sums.iter_mut()
                .zip(texel)
                .for_each(|(sum, &number)| *sum += f64::from(number));
        }
        let count = chosen.iter().filter(|chosen| **chosen).count().max(1) as f64;
        sums.iter().map(|sum| (sum / count) as f32).collect()
    }

    /// The first number at a texture coordinate, v upwards, mixed from the four texels round it; the image's
    /// border is repeated.
    pub fn at_uv(&self, uv: glam::Vec2) -> f32 {
        let column = uv.x * self.width as f32 - 0.5;
        let row = (1.0 - uv.y) * self.height as f32 - 0.5;
        let (left, top) = (column.floor(), row.floor());
        let (right, down) = (column - left, row - top);
        let at = |row: f32, col: f32| {
            let side = |at: f32, side: u32| (at.max(0.0) as u32).min(side - 1) as usize;
            let texel = side(row, self.height) * self.width as usize + side(col, self.width);
            self.numbers[texel * self.count]
        };
        let above = at(top, left) * (1.0 - right) + at(top, left + 1.0) * right;
        let below = at(top + 1.0, left) * (1.0 - right) + at(top + 1.0, left + 1.0) * right;
        above * (1.0 - down) + below * down
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::Vec2;

    pub(in crate::textures) fn texture(
        kind: ChannelKind,
        count: usize,
        numbers: Vec<f32>,
    ) -> Texture {
        let texels = numbers.len() / count;
        Texture {
            name: kind.name().into(),
            kind,
            count,
            low: 0.0,
            high: 1.0,
            precision: Precision::Bits8,
            width: 2,
            height: texels as u32 / 2,
            numbers,
        }
    }

    #[test]
    fn rows_count_from_the_top() {
        let texture = texture(ChannelKind::Height, 1, vec![1.0, 2.0, 3.0, 4.0]);
        for (uv, value) in [
            ((0.25, 0.75), 1.0),
            ((0.75, 0.75), 2.0),
            ((0.25, 0.25), 3.0),
            ((0.0, 1.0), 1.0),
            ((1.0, 0.0), 4.0),
            ((0.5, 0.5), 2.5),
        ] {
            assert_eq!(texture.at_uv(Vec2::from(uv)), value, "{uv:?}");
        }
    }

    #[test]
    fn what_is_not_filled_gets_the_mean() {
        let mut texture = texture(ChannelKind::Mask, 1, vec![1.0, 2.0, 9.0, 9.0]);
        texture.copy(&[(2, 0)]);
        texture.fill_rest(&[true, true, true, false]);
        assert_eq!(texture.numbers, [1.0, 2.0, 1.0, 4.0 / 3.0]);
    }
}
