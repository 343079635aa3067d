//! Stocking stitch: each loop shows two slanted legs that form a V, overlapping the loop above.

use std::f32::consts::PI;

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::brdf::Diffuse;
use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile};

/// The preset.
pub(super) const PRESET: Procedural = Procedural {
    diffuse: Diffuse::OrenNayar(0.35),
    ..Procedural::new(facet)
};

fn facet(tile: &Tile, at: Vec2) -> Facet {
    let repeats = IVec2::new(tile.repeats(15.0, 1), tile.repeats(11.0, 1));
    let side = Vec2::splat(tile.size) / repeats.as_vec2();
    let wander = Vec2::new(
        tile.noise(at, Vec2::splat(22.0), 41),
        tile.noise(at, Vec2::splat(22.0), 42),
    );
    let place = (at + 0.9 * wander) / side;
    let home = place.floor().as_ivec2();
    let mut best = Facet {
        height: -0.1 * side.x,
        albedo: Vec3::new(0.015, 0.03, 0.06),
        roughness: 0.8,
    };
    for row in -1..=1 {
        for leg in [-1.0, 1.0] {
            let cell = IVec2::new(home.x, home.y + row);
            let from_centre = (place - cell.as_vec2() - 0.5) * side;
            let stitch = leg_of_loop(tile, from_centre, leg, side, cell, repeats);
            if let Some(facet) = stitch.filter(|facet| facet.height > best.height) {
                best = facet;
            }
        }
    }
    best
}

/// One leg, an ellipsoid of yarn leaning to its side (`leg` −1 left, 1 right).
fn leg_of_loop(
    tile: &Tile,
    from_centre: Vec2,
    leg: f32,
    side: Vec2,
    cell: IVec2,
    repeats: IVec2,
) -> Option<Facet> {
    let middle = Vec2::new(0.245 * side.x * leg, 0.0);
    let lean = Vec2::new(0.42 * leg, 1.0).normalize();
    let offset = from_centre - middle;
    let along = offset.dot(lean) / (0.98 * side.y);
    let across = offset.perp_dot(lean) / (0.27 * side.x);
    let inside = 1.0 - along * along - across * across;
    if inside <= 0.0 {
        return None;
    }
    let strands = (2.0 * PI * (2.2 * along + 1.1 * across * leg)).sin();
    let tint = tile.random(cell, repeats, 43);
    Some(Facet {
        // The lower end lies on the loop below, the upper end goes under the loop above.
        height: 0.30 * side.x * inside.sqrt() - 0.14 * side.y * along + 0.22 * strands * inside,
        albedo: Vec3::new(0.07, 0.19, 0.36) * (0.80 + 0.25 * tint + 0.15 * strands * inside),
        roughness: 0.75,
    })
}
