//! Texture maps: options of frames that maps do not have.

use crate::cli::atlas::is_atlas;
use crate::cli::bake_maps::{Arguments, OPTIONS_OF_FRAMES};
use crate::cli::unused_options::combination::{Combination, found};

pub(super) const COMBINATIONS: &[Combination<Arguments>] = &[
    Combination {
        options: &OPTIONS_OF_FRAMES,
        unused: |_| {
            Some("given for texture maps, which have one view and light and a --resolution".into())
        },
        expected: "options of camera, light, weights, texels and shadows",
    },
    Combination {
        options: &["surface-color"],
        unused: |arguments| {
            let text = format!("given for {}", arguments.map.display());
            found(!is_atlas(&arguments.map), text)
        },
        expected: "an atlas; other maps have no channel of alpha",
    },
    Combination {
        options: &["mesh", "unwrap", "resolution"],
        unused: |arguments| {
            let text = format!("given for {}", arguments.map.display());
            found(is_atlas(&arguments.map), text)
        },
        expected: "a surface texton map; an atlas has a mesh, texture coordinates and a size",
    },
];
