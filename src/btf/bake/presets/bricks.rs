//! Bricks in running bond, with rounded edges, chips and recessed joints.

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, smooth_step};

/// The preset.
pub(super) const PRESET: Procedural = Procedural::new(facet);

fn facet(tile: &Tile, at: Vec2) -> Facet {
    let repeats = IVec2::new(tile.repeats(21.0, 1), tile.repeats(10.6, 2));
    let side = Vec2::splat(tile.size) / repeats.as_vec2();
    let edge = 0.5
        * Vec2::new(
            tile.noise(at, Vec2::splat(7.0), 81),
            tile.noise(at, Vec2::splat(7.0), 82),
        );
    let mut place = (at + edge) / side;
    let course = place.y.floor() as i32;
    place.x += 0.5 * (course.rem_euclid(2)) as f32;
    let cell = place.floor().as_ivec2();
    let within = (place - cell.as_vec2() - 0.5) * side;
    let random = |salt| tile.random(cell, repeats, salt);
    let to_edge = (0.5 * side - within.abs()).min_element();
    let body = smooth_step(0.7, 2.6, to_edge);
    let grain = tile.rough(at, Vec2::splat(5.0), 3, 84);
    let pits = smooth_step(0.35, 0.8, tile.noise(at, Vec2::splat(4.0), 88));
    let clay = Vec3::new(0.34, 0.095, 0.05).lerp(Vec3::new(0.42, 0.20, 0.10), random(85));
    let fired = 0.65 + 0.5 * random(86);
    let mortar = Vec3::new(0.40, 0.38, 0.34) * (0.85 + 0.2 * grain);
    let tilt = (random(87) - 0.5) * 0.06 * within.x;
    Facet {
        height: body * (2.4 + 0.5 * random(89) + tilt - 0.7 * pits) + 0.3 * grain,
        albedo: mortar.lerp(clay * (fired + 0.2 * grain - 0.15 * pits), body),
        roughness: 0.8,
    }
}
