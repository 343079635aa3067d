//! Leather: pebbled grain with creases between, shiny on the bumps.

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, smooth_step};

/// The preset.
pub(super) const PRESET: Procedural = Procedural::new(facet);

fn facet(tile: &Tile, at: Vec2) -> Facet {
    let wander = Vec2::new(
        tile.noise(at, Vec2::splat(12.0), 111),
        tile.noise(at, Vec2::splat(12.0), 112),
    );
    let coarse = tile.nearest_cell(at + 1.6 * wander, Vec2::new(14.0, 11.0), 0.9, 113);
    let fine = tile.nearest_cell(at + 0.8 * wander, Vec2::new(6.5, 5.5), 0.9, 116);
    let repeats = IVec2::new(tile.repeats(14.0, 1), tile.repeats(11.0, 1));
    let plump = 0.7 + 0.6 * tile.random(coarse.cell, repeats, 115);
    let bump = smooth_step(0.0, 2.6, coarse.border).powf(0.8);
    let grain = smooth_step(0.0, 1.5, fine.border);
    let blotch = tile.rough(at, Vec2::splat(30.0), 2, 118);
    let high = bump * (0.6 + 0.4 * grain);
    Facet {
        height: 1.9 * plump * bump + 0.55 * grain * (0.4 + 0.6 * bump),
        albedo: Vec3::new(0.05, 0.018, 0.009).lerp(Vec3::new(0.24, 0.095, 0.04), high)
            * (1.0 + 0.22 * blotch),
        roughness: 0.62 - 0.26 * high,
    }
}
