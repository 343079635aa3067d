//! Corduroy: ribs of cut pile along y, with furrows between.

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::brdf::Diffuse;
use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, round};

/// The preset.
pub(super) const PRESET: Procedural = Procedural {
    diffuse: Diffuse::OrenNayar(0.35),
    ..Procedural::new(facet)
};

fn facet(tile: &Tile, at: Vec2) -> Facet {
    let count = tile.repeats(11.0, 1);
    let pitch = tile.size / count as f32;
    let wander = 0.10 * pitch * tile.noise(at, Vec2::new(4.0 * pitch, 3.0 * pitch), 31);
    let place = (at.x + wander) / pitch;
    let across = 2.0 * (place - place.floor()) - 1.0;
    let rib = tile.random(
        IVec2::new(place.floor() as i32, 0),
        IVec2::new(count, 1),
        32,
    );
    let pile = tile.rough(at, Vec2::new(3.0, 4.0), 2, 33);
    let worn = tile.noise(at, Vec2::splat(26.0), 35);
    let profile = round(across / 0.92).powf(0.8);
    Facet {
        height: 0.34 * pitch * profile * (1.0 + 0.10 * worn) + 0.35 * pile * profile,
        albedo: Vec3::new(0.30, 0.145, 0.055)
            * (0.25 + 0.75 * profile)
            * (0.9 + 0.2 * rib + 0.12 * pile + 0.12 * worn),
        roughness: 0.9,
    }
}
