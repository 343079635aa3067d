//! Wicker: rods along x, woven before and behind upright stakes.

use std::f32::consts::PI;

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, round, smooth_step};

/// The preset.
pub(super) const PRESET: Procedural = Procedural::new(facet);

fn facet(tile: &Tile, at: Vec2) -> Facet {
    let rods = tile.repeats(8.0, 2);
    let stakes = tile.repeats(18.0, 2);
    let pitch = tile.size / rods as f32;
    let place = at.y / pitch + 0.08 * tile.noise(at, Vec2::new(24.0, 9.0), 51);
    let rod = place.floor() as i32;
    let across = 2.0 * (place - rod as f32) - 1.0;
    let parity = if rod.rem_euclid(2) == 0 { 1.0 } else { -1.0 };
    let swing = parity * (PI * stakes as f32 * at.x / tile.size).cos();
    let grain = tile.rough(at, Vec2::new(18.0, 2.2), 2, 53);
    let tint = tile.random(IVec2::new(rod, 0), IVec2::new(rods, 1), 54);
    let rod_height = pitch * (0.34 * swing + 0.42 * round(across / 0.97)) + 0.14 * grain;
    let stake_place = stakes as f32 * at.x / tile.size;
    let from_stake = 2.0 * (stake_place - stake_place.round());
    let stake_height = pitch * (0.45 * round(from_stake / 0.42) - 0.25);
    if stake_height > rod_height {
        return Facet {
            height: stake_height,
            albedo: Vec3::new(0.20, 0.105, 0.045) * (1.0 + 0.25 * grain),
            roughness: 0.6,
        };
    }
    let worn = smooth_step(-0.5, 1.2, swing);
    Facet {
        height: rod_height,
        albedo: Vec3::new(0.46, 0.27, 0.105) * (0.62 + 0.35 * tint + 0.22 * grain + 0.18 * worn),
        roughness: 0.38 + 0.12 * tint,
    }
}
