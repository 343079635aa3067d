//! Scales, leather and bark.

use glam::{IVec2, Vec2, Vec3};

use crate::btf::bake::presets::tile::{Facet, Tile, round, smooth_step};

/// Overlapping rows of scales that rise towards their round tips (downwards in the image).
pub(super) fn scales(tile: &Tile, at: Vec2) -> Facet {
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

/// Pebbled grain with creases between, shiny on the bumps.
pub(super) fn leather(tile: &Tile, at: Vec2) -> Facet {
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

/// Deep ridges along y that wave and split.
pub(super) fn bark(tile: &Tile, at: Vec2) -> Facet {
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
