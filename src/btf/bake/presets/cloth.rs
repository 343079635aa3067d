//! Woven, ribbed and knitted materials.

use std::f32::consts::PI;

use glam::{IVec2, Vec2, Vec2Swizzles, Vec3};

use crate::btf::bake::presets::tile::{Facet, Tile, round, smooth_step};

/// Plain weave: warp and weft pass over each other in turn, as 1 − |sin| waves in opposite phase.
pub(super) fn weave(tile: &Tile, at: Vec2) -> Facet {
    let count = tile.repeats(10.5, 2);
    let pitch = tile.size / count as f32;
    let warp = Thread::new(tile, at, count, pitch, 11);
    let weft = Thread::new(tile, at.yx(), count, pitch, 23);
    // Where both cross, the warp is up in the even fields of the checkerboard.
    let wave = |thread: &Thread, up: f32| up * (PI * thread.along).cos() * thread.parity();
    let warp_height = pitch * (0.20 * wave(&warp, 1.0) + 0.30 * round(warp.across));
    let weft_height = pitch * (0.20 * wave(&weft, -1.0) + 0.30 * round(weft.across));
    let (top, height, color) = if warp_height >= weft_height {
        (warp, warp_height, Vec3::new(0.32, 0.045, 0.035))
    } else {
        (weft, weft_height, Vec3::new(0.62, 0.50, 0.30))
    };
    Facet {
        height: height + 0.25 * top.fibre,
        albedo: color * (0.85 + 0.25 * top.tint + 0.18 * top.fibre),
        roughness: 0.55,
    }
}

/// One thread at a place.
struct Thread {
    index: i32,
    /// −1 to 1 across the thread.
    across: f32,
    /// In pitches along it, whole numbers at the crossings.
    along: f32,
    /// −½ to ½, one a thread.
    tint: f32,
    /// −1 to 1, the twist of its fibres.
    fibre: f32,
}

impl Thread {
    /// The thread along y at `at`.
    fn new(tile: &Tile, at: Vec2, count: i32, pitch: f32, salt: u64) -> Self {
        let wander = 0.06 * pitch * tile.noise(at, Vec2::new(2.0 * pitch, 3.0 * pitch), salt);
        let place = (at.x + wander) / pitch;
        let index = place.floor() as i32;
        let across = 2.0 * (place - index as f32) - 1.0;
        let turns = tile.repeats(3.2, 1) as f32;
        let twist = turns * at.y / tile.size + 0.35 * across;
        Self {
            index,
            across: across / 0.94,
            along: at.y / pitch - 0.5,
            tint: tile.random(IVec2::new(index, 0), IVec2::new(count, 1), salt) - 0.5,
            fibre: (2.0 * PI * twist).sin() * round(across),
        }
    }

    fn parity(&self) -> f32 {
        if self.index.rem_euclid(2) == 0 {
            1.0
        } else {
            -1.0
        }
    }
}

/// Ribs of cut pile along y, with furrows between.
pub(super) fn corduroy(tile: &Tile, at: Vec2) -> Facet {
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

/// Stocking stitch: each loop shows two slanted legs that form a V, overlapping the loop above.
pub(super) fn knit(tile: &Tile, at: Vec2) -> Facet {
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

/// Rods along x, woven before and behind upright stakes.
pub(super) fn wicker(tile: &Tile, at: Vec2) -> Facet {
    let rods = tile.repeats(8.0, 2);
    let stakes = tile.repeats(18.0, 2);
    let pitch = tile.size / rods as f32;
    let place = at.y / pitch + 0.08 * tile.noise(at, Vec2::new(24.0, 9.0), 51);
    let rod = place.floor() as i32;
    let across = 2.0 * (place - rod as f32) - 1.0;
    let parity = if rod.rem_euclid(2) == 0 { 1.0 } else { -1.0 };
    let swing = parity * (PI * stakes as f32 * at.x / tile.size).cos();
    let grain = tile.rough(at, Vec2::new(18.0, 2.2), 2, 53);
    let tint = tile.random(IVec2::new(rod, 0), IVec2::new(rods, 1), 54);
    let rod_height = pitch * (0.34 * swing + 0.42 * round(across / 0.97)) + 0.14 * grain;
    let stake_place = stakes as f32 * at.x / tile.size;
    let from_stake = 2.0 * (stake_place - stake_place.round());
    let stake_height = pitch * (0.45 * round(from_stake / 0.42) - 0.25);
    if stake_height > rod_height {
        return Facet {
            height: stake_height,
            albedo: Vec3::new(0.20, 0.105, 0.045) * (1.0 + 0.25 * grain),
            roughness: 0.6,
        };
    }
    let worn = smooth_step(-0.5, 1.2, swing);
    Facet {
        height: rod_height,
        albedo: Vec3::new(0.46, 0.27, 0.105) * (0.62 + 0.35 * tint + 0.22 * grain + 0.18 * worn),
        roughness: 0.38 + 0.12 * tint,
    }
}
