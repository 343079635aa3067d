//! Bark: deep ridges along y that wave and split.

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, smooth_step};

/// The preset.
pub(super) const PRESET: Procedural = Procedural::new(facet);

fn facet(tile: &Tile, at: Vec2) -> Facet {
    let bend = Vec2::new(
        5.0 * tile.rough(at, Vec2::new(26.0, 30.0), 2, 121),
        3.0 * tile.noise(at, Vec2::splat(20.0), 124),
    );
    let plate = tile.nearest_cell(at + bend, Vec2::new(13.0, 34.0), 0.9, 125);
    let repeats = IVec2::new(tile.repeats(13.0, 1), tile.repeats(34.0, 1));
    let tall = tile.random(plate.cell, repeats, 127);
    let ridge = smooth_step(0.1, 2.9, plate.border).powf(0.8);
    let fibre = tile.rough(at + bend, Vec2::new(4.0, 15.0), 3, 128);
    let crack = smooth_step(0.25, 0.75, tile.noise(at + bend, Vec2::new(10.0, 5.0), 132)) * ridge;
    let lichen = smooth_step(0.25, 0.7, tile.rough(at, Vec2::splat(22.0), 3, 134)) * ridge;
    let wood = Vec3::new(0.045, 0.027, 0.017).lerp(Vec3::new(0.23, 0.155, 0.105), ridge);
    Facet {
        height: ridge * (3.4 + 1.6 * tall) + 0.8 * fibre * (0.3 + 0.7 * ridge) - 1.3 * crack,
        albedo: (wood * (0.85 + 0.3 * tall + 0.3 * fibre) * (1.0 - 0.5 * crack))
            .lerp(Vec3::new(0.24, 0.27, 0.16), 0.6 * lichen),
        roughness: 0.88,
    }
}
