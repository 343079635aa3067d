//! Beaten sheet metal: round dents that cut into each other, polished on the crests.

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, smooth_step};

/// The preset.
pub(super) const PRESET: Procedural = Procedural {
    is_metal: true,
    ..Procedural::new(facet)
};

fn facet(tile: &Tile, at: Vec2) -> Facet {
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
