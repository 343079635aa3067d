//! What procedural materials are made of: a square tile that wraps, random numbers by place, smooth
//! noise, scattered cells.

use std::f32::consts::TAU;

use glam::{IVec2, Vec2, Vec3};

/// A square piece of material, `size` texels wide, that continues itself on all sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    pub(super) size: f32,
    seed: u64,
}

/// What a material is at one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// In texels.
    pub(super) height: f32,
    /// Linear.
    pub(super) albedo: Vec3,
    pub(super) roughness: f32,
}

/// A place relative to one cell of a scattered pattern.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// From the cell's centre, in texels.
    pub(super) offset: Vec2,
    /// Distance to the border with the next cell, in texels.
    pub(super) border: f32,
    /// The cell, for [`Tile::random`].
    pub(super) cell: IVec2,
}

impl Tile {
    pub(super) fn new(size: u32, seed: u64) -> Self {
        Self {
            size: size as f32,
            seed,
        }
    }

    /// How often a feature of about `period` texels fits round the tile: at least `least`, and a multiple
    /// of it.
    pub(super) fn repeats(&self, period: f32, least: i32) -> i32 {
        ((self.size / period / least as f32).round() as i32).max(1) * least
    }

    /// A number in [0, 1) that belongs to a cell of a grid of `repeats` cells; `salt` tells uses apart.
    pub(super) fn random(&self, cell: IVec2, repeats: IVec2, salt: u64) -> f32 {
        let wrapped = cell.rem_euclid(repeats);
        let mut key = self.seed ^ salt.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        for part in [wrapped.x as u64, wrapped.y as u64] {
            key = mix(key ^ part.wrapping_mul(0xD6E8_FEB8_6659_FD93));
        }
        (key >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// Smooth noise of about `period` texels along x and y, in [−1, 1].
    pub(super) fn noise(&self, at: Vec2, period: Vec2, salt: u64) -> f32 {
        let repeats = IVec2::new(self.repeats(period.x, 1), self.repeats(period.y, 1));
        let place = at / self.size * repeats.as_vec2();
        let cell = place.floor();
        let fade = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        let within = place - cell;
        let (u, v) = (fade(within.x), fade(within.y));
        let corner = |dx: i32, dy: i32| {
            let corner = IVec2::new(dx, dy);
            let angle = TAU * self.random(cell.as_ivec2() + corner, repeats, salt);
            Vec2::from_angle(angle).dot(within - corner.as_vec2())
        };
        let low = mix_numbers(corner(0, 0), corner(1, 0), u);
        let high = mix_numbers(corner(0, 1), corner(1, 1), u);
        (1.5 * mix_numbers(low, high, v)).clamp(-1.0, 1.0)
    }

    /// Noise of several periods, each half as large and half as strong, in about [−1, 1].
    pub(super) fn rough(&self, at: Vec2, period: Vec2, octaves: u32, salt: u64) -> f32 {
        (0..octaves)
            .map(|octave| {
                let scale = 0.5_f32.powi(octave as i32);
                scale * self.noise(at, period * scale, salt + u64::from(octave))
            })
            .sum()
    }

    /// The nearest of randomly shifted cell centres about `period` texels apart (Worley 1996), each at
    /// most `shift` (0 to 1) of a cell off its place.
    pub(super) fn nearest_cell(&self, at: Vec2, period: Vec2, shift: f32, salt: u64) -> Near {
        let repeats = IVec2::new(self.repeats(period.x, 1), self.repeats(period.y, 1));
        let side = Vec2::splat(self.size) / repeats.as_vec2();
        let home = (at / side).floor().as_ivec2();
        let offset = |cell: IVec2| {
            let jitter = Vec2::new(
                self.random(cell, repeats, salt),
                self.random(cell, repeats, salt + 1),
            ) - 0.5;
            at - (cell.as_vec2() + 0.5 + shift * jitter) * side
        };
        let around = || (-2..=2).flat_map(move |y| (-2..=2).map(move |x| home + IVec2::new(x, y)));
        let nearest = around()
            .min_by(|&a, &b| offset(a).length().total_cmp(&offset(b).length()))
            .unwrap_or(home);
        let own = offset(nearest);
        let border = around()
            .filter(|&cell| cell != nearest)
            .map(|cell| {
                let other = offset(cell);
                // Distance to the line half way between the two centres.
                0.5 * (other.length_squared() - own.length_squared()) / (own - other).length()
            })
            .fold(f32::INFINITY, f32::min);
        Near {
            offset: own,
            border,
            cell: nearest.rem_euclid(repeats),
        }
    }
}

fn mix(mut key: u64) -> u64 {
    key = (key ^ (key >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    key = (key ^ (key >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    key ^ (key >> 31)
}

fn mix_numbers(a: f32, b: f32, share: f32) -> f32 {
    a + (b - a) * share
}

/// 0 below `low`, 1 above `high`, smooth between.
pub(super) fn smooth_step(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The profile of a round thread: 1 on its middle line (0), 0 at its sides (±1).
pub(super) fn round(across: f32) -> f32 {
    (1.0 - across * across).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_wraps() {
        let tile = Tile::new(48, 7);
        let period = Vec2::new(13.0, 9.0);
        for (dx, dy) in [(48.0, 0.0), (0.0, -48.0)] {
            for at in [Vec2::new(0.3, 47.6), Vec2::new(20.0, 31.0)] {
                let moved = at + Vec2::new(dx, dy);
                assert!(
                    (tile.rough(at, period, 3, 1) - tile.rough(moved, period, 3, 1)).abs() < 1e-4
                );
                let (a, b) = (
                    tile.nearest_cell(at, period, 0.8, 2),
                    tile.nearest_cell(moved, period, 0.8, 2),
                );
                assert_eq!(a.cell, b.cell);
                assert!((a.border - b.border).abs() < 1e-3 && a.border >= 0.0);
            }
        }
    }

    #[test]
    fn cells_are_numbered_once_and_random() {
        let tile = Tile::new(64, 1);
        let repeats = IVec2::splat(16);
        let numbers: Vec<f32> = (0..256)
            .map(|i| tile.random(IVec2::new(i % 16, i / 16), repeats, 3))
            .collect();
        let mean = numbers.iter().sum::<f32>() / 256.0;
        assert!((mean - 0.5).abs() < 0.06, "{mean}");
        assert_eq!(
            tile.random(IVec2::new(-1, 5), repeats, 3),
            tile.random(IVec2::new(15, 5), repeats, 3)
        );
        assert_ne!(numbers[0], tile.random(IVec2::ZERO, repeats, 4));
    }
}
