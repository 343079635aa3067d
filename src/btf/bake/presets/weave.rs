//! Plain weave: warp and weft pass over each other in turn, as 1 − |sin| waves in opposite phase.

use std::f32::consts::PI;

use glam::{IVec2, Vec2, Vec2Swizzles, Vec3};

use crate::btf::bake::brdf::Diffuse;
use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile, round};

/// The preset.
pub(super) const PRESET: Procedural = Procedural {
    diffuse: Diffuse::OrenNayar(0.35),
    ..Procedural::new(facet)
};

fn facet(tile: &Tile, at: Vec2) -> Facet {
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
    /// −½ to ½, one per thread.
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
