//! Cobbles: rounded stones, each with its own height, tilt and colour, in dark mortar.

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, smooth_step};

/// The preset.
pub(super) const PRESET: Procedural = Procedural::new(facet);

fn facet(tile: &Tile, at: Vec2) -> Facet {
    let wander = Vec2::new(
        tile.noise(at, Vec2::splat(9.0), 61),
        tile.noise(at, Vec2::splat(9.0), 62),
    );
    let stone = tile.nearest_cell(at + 0.8 * wander, Vec2::new(19.0, 17.0), 0.62, 63);
    let repeats = IVec2::new(tile.repeats(19.0, 1), tile.repeats(17.0, 1));
    let random = |salt| tile.random(stone.cell, repeats, salt);
    let body = smooth_step(0.2, 3.4, stone.border).powf(0.7);
    let grain = tile.rough(at, Vec2::splat(6.0), 3, 70);
    let tilt = Vec2::new(random(66) - 0.5, random(67) - 0.5).dot(stone.offset) * 0.16;
    let dome = 1.1 * (1.0 - stone.offset.length_squared() / 100.0).max(-0.5);
    let warmth = random(68);
    let color = Vec3::new(0.25, 0.25, 0.27).lerp(Vec3::new(0.36, 0.27, 0.19), warmth);
    let mortar = Vec3::new(0.055, 0.05, 0.045) * (1.0 + 0.4 * grain);
    let shown = smooth_step(0.02, 0.3, body);
    Facet {
        height: body * (3.0 + 1.2 * random(65) + tilt + dome) + 0.3 * grain,
        albedo: mortar.lerp(color * (0.75 + 0.4 * random(69) + 0.3 * grain), shown),
        roughness: 0.85 - 0.35 * body,
    }
}
