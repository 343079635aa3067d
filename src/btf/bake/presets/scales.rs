//! Scales: overlapping rows that rise towards their round tips (downwards in the image).

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, round, smooth_step};

/// The preset.
pub(super) const PRESET: Procedural = Procedural::new(facet);

fn facet(tile: &Tile, at: Vec2) -> Facet {
    let repeats = IVec2::new(tile.repeats(16.0, 1), tile.repeats(9.5, 2));
    let side = Vec2::splat(tile.size) / repeats.as_vec2();
    let wander = 0.5 * tile.noise(at, Vec2::splat(18.0), 101);
    let place = (at + wander) / side;
    let row = place.y.floor() as i32;
    // The scales that reach here hang from this row and the three above: the highest is seen.
    (0..=3)
        .flat_map(|up| [-1, 0, 1].map(|beside| (row + up, beside)))
        .filter_map(|(row, beside)| scale(tile, place, (row, beside), side, repeats))
        .max_by(|a, b| a.height.total_cmp(&b.height))
        .unwrap_or(Facet {
            height: -0.5,
            albedo: Vec3::splat(0.02),
            roughness: 0.6,
        })
}

/// One scale at a place, if it covers it.
fn scale(
    tile: &Tile,
    place: Vec2,
    (row, beside): (i32, i32),
    side: Vec2,
    repeats: IVec2,
) -> Option<Facet> {
    let shifted = place.x + 0.5 * row.rem_euclid(2) as f32;
    let cell = IVec2::new(shifted.floor() as i32 + beside, row);
    let random = |salt| tile.random(cell, repeats, salt);
    // From the root of the scale: across in [−1, 1], down from 0 at the root to 1 at the tip.
    let across = 2.0 * (shifted - cell.x as f32 - 0.5) / (1.12 + 0.08 * random(103));
    let down = (row as f32 + 1.0 - place.y) / (2.35 + 0.2 * random(104));
    let tip = 0.45 + 0.55 * round(across.clamp(-1.0, 1.0));
    if !(0.0..tip).contains(&down) || across.abs() >= 1.0 {
        return None;
    }
    let rim = smooth_step(0.0, 0.16, tip - down);
    let rise = down * (4.6 + 1.0 * random(105)) / 16.0 * side.x;
    let dome = 1.5 * (1.0 - across * across) / 16.0 * side.x;
    let keel = (-(across / 0.16).powi(2)).exp() * 0.5 * (1.0 - down);
    let hue = random(106);
    let color = Vec3::new(0.02, 0.20, 0.13).lerp(Vec3::new(0.03, 0.14, 0.24), hue);
    let edge = Vec3::new(0.45, 0.42, 0.16);
    Some(Facet {
        height: rise + dome + keel - 0.35 * (1.0 - rim),
        albedo: edge.lerp(color * (0.6 + 0.9 * down), 0.3 + 0.7 * rim),
        roughness: 0.26 + 0.12 * hue,
    })
}
