//! Stone, brick and metal.

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::tile::{Facet, Tile, smooth_step};

/// Rounded stones, each with its own height, tilt and colour, in dark mortar.
pub(super) fn cobbles(tile: &Tile, at: Vec2) -> Facet {
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

/// Bricks in running bond, with rounded edges, chips and recessed joints.
pub(super) fn bricks(tile: &Tile, at: Vec2) -> Facet {
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

/// Beaten sheet metal: round dents that cut into each other, polished on the crests.
pub(super) fn hammered(tile: &Tile, at: Vec2) -> Facet {
    let period = Vec2::splat(12.5);
    let dent = tile.nearest_cell(at, period, 0.75, 91);
    let repeats = IVec2::splat(tile.repeats(12.5, 1));
    let strength = 0.75 + 0.5 * tile.random(dent.cell, repeats, 93);
    let radius = 8.0 * strength.sqrt();
    let bowl = 2.6 * strength * ((dent.offset / radius).length_squared() - 1.0);
    // Blunt the crest where two dents meet.
    let crest = smooth_step(0.0, 1.6, dent.border);
    let tarnish = tile.rough(at, Vec2::splat(15.0), 3, 94);
    let scratches = tile.noise(at, Vec2::new(9.0, 1.8), 98);
    let copper = Vec3::new(0.90, 0.54, 0.32);
    Facet {
        height: bowl - 0.25 * (1.0 - crest) + 0.04 * scratches,
        albedo: copper * (0.85 + 0.12 * tarnish).clamp(0.5, 1.0),
        roughness: (0.34 + 0.10 * tarnish + 0.04 * scratches).clamp(0.2, 0.6),
    }
}
