//! What the file of a preset states.

use glam::Vec2;

use crate::btf::bake::brdf::Diffuse;
use crate::btf::bake::presets::tile::{Facet, Tile};

/// A procedural material.
#[derive(Clone, Copy, Debug)]
pub(super) struct Procedural {
    /// The material at a position on the tile, in texels; periodic in both directions.
    pub(super) facet: fn(&Tile, Vec2) -> Facet,
    /// How its diffuse base reflects.
    pub(super) diffuse: Diffuse,
    /// Whether it is bare metal, whose albedo is the colour of its reflection.
    pub(super) is_metal: bool,
}

impl Procedural {
    /// A Lambertian material that is no metal.
    pub(super) const fn new(facet: fn(&Tile, Vec2) -> Facet) -> Self {
        Self {
            facet,
            diffuse: Diffuse::Lambert,
            is_metal: false,
        }
    }
}
