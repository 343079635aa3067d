//! Built-in procedural materials: small, readable, tileable at any size, with relief one sees.
//!
//! Each is one file with a function from a place on the [`Tile`] to height, colour and roughness there; features
//! span about 8 to 24 texels, and vary at random so that a tile does not repeat inside itself. Sizes in
//! texels; one texel is taken as ½ mm.

mod procedural;
mod tile;

use clap::ValueEnum;
use glam::Vec2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::btf::bake::material::Material;
use crate::btf::bake::presets::procedural::Procedural;
use crate::btf::bake::presets::tile::{Facet, Tile};
use crate::error::{Error, Result};
use crate::grid::TexelGrid;
use crate::progress::Progress;

/// Side of a preset's texel, in millimetres.
const TEXEL_MM: f64 = 0.5;

/// Registers the presets: one row per file. It declares the file's module and makes the variant of [`Preset`], whose
/// name in kebab case is the preset's name on the command line and whose comment is its help text. `PRESET` of the file
/// says the rest.
macro_rules! presets {
    ($($variant:ident => $file:ident, $help:literal;)*) => {
        $(mod $file;)*

        /// A built-in material.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
        #[serde(rename_all = "kebab-case")]
        pub enum Preset {
            $(#[doc = $help] $variant,)*
        }

        impl Preset {
            fn procedural(self) -> Procedural {
                match self {
                    $(Self::$variant => $file::PRESET,)*
                }
            }
        }
    };
}

presets! {
    Weave => weave, "Plain weave of thick two-coloured threads.";
    Corduroy => corduroy, "Velvety ribs.";
    Knit => knit, "Stocking stitch: columns of V-shaped loops.";
    Wicker => wicker, "Willow rods woven round stakes.";
    Cobbles => cobbles, "Rounded stones in dark mortar.";
    Bricks => bricks, "Bricks in running bond.";
    Scales => scales, "Overlapping glossy scales.";
    Leather => leather, "Pebbled, creased, waxed.";
    Hammered => hammered, "Sheet metal beaten with a round hammer.";
    Bark => bark, "Deep wavy ridges along the trunk.";
}

impl Preset {
    /// The material on size × size texels.
    pub fn material(self, size: u32, seed: u64, progress: Progress<'_>) -> Result<Material> {
        if !(16..=8192).contains(&size) {
            return Err(Error::option("size", size.to_string(), "16 to 8192 texels"));
        }
        let Procedural {
            facet,
            diffuse,
            is_metal,
        } = self.procedural();
        let tile = Tile::new(size, seed);
        let facets: Vec<Facet> = (0..size * size)
            .into_par_iter()
            .map(|texel| {
                progress.check()?;
                // Texel centres, y upwards.
                let (col, up) = (texel % size, size - 1 - texel / size);
                Ok(facet(&tile, Vec2::new(col as f32 + 0.5, up as f32 + 0.5)))
            })
            .collect::<Result<_>>()?;
        Ok(Material {
            name: self.name(),
            grid: TexelGrid {
                width: size,
                height: size,
                tileable: true,
            },
            texel_mm: Some(TEXEL_MM),
            heights: facets.iter().map(|facet| facet.height).collect(),
            albedo: facets.iter().map(|facet| facet.albedo).collect(),
            roughness: Some(facets.iter().map(|facet| facet.roughness).collect()),
            metallic: is_metal.then(|| vec![1.0; facets.len()]),
            reflectance: 0.04,
            diffuse,
        })
    }

    /// Its name on the command line.
    pub fn name(self) -> String {
        self.to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_sound_tileable_and_has_relief() {
        for &preset in Preset::value_variants() {
            for size in [16, 61, 96] {
                let material = preset.material(size, 5, Progress::silent()).unwrap();
                material.check().unwrap();
                let (low, high) = material
                    .heights
                    .iter()
                    .fold((f32::MAX, f32::MIN), |(l, h), &v| (l.min(v), h.max(v)));
                assert!(
                    (1.0..20.0).contains(&(high - low)),
                    "{preset:?}: {low} {high}"
                );
            }
            // Across the border the surface continues as it does inside.
            let tile = Tile::new(61, 5);
            for y in 0..61 {
                let at = |x: f32| (preset.procedural().facet)(&tile, Vec2::new(x, y as f32 + 0.5));
                let (a, b) = (at(0.25), at(61.25));
                assert!((a.height - b.height).abs() < 0.02, "{preset:?} {y}");
                assert!((a.albedo - b.albedo).length() < 0.02, "{preset:?} {y}");
            }
        }
    }

    #[test]
    fn the_seed_decides_the_details() {
        let heights = |seed| {
            Preset::Cobbles
                .material(32, seed, Progress::silent())
                .unwrap()
                .heights
        };
        assert_eq!(heights(1), heights(1));
        assert_ne!(heights(1), heights(2));
        assert!(Preset::Weave.material(8, 0, Progress::silent()).is_err());
    }
}
