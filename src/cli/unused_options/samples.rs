//! Samples, textons and neighbour tables.

use crate::cli::parts::InShards;
use crate::cli::unused_options::combination::{Combination, found};
use crate::cli::{bake, exemplar, import, textons};
use crate::exemplar::KnnOptions;
use crate::exemplar::knn_options::NeighborSearch;
use crate::texton::options::{ImageCount, Named};

/// What only maps have.
const OF_MAPS: &[&str] = &[
    "height-mm",
    "width-mm",
    "depth",
    "tiling",
    "normal-y",
    "normal-kind",
    "terraces",
    "albedo-encoding",
    "alpha",
    "layer",
];

/// Options that have no effect with --reduce: the parts state them.
const fn stated_by_parts<A: InShards>(options: &'static [&'static str]) -> Combination<A> {
    Combination {
        options,
        unused: |arguments| found(!arguments.parts().is_empty(), "given with --reduce"),
        expected: "none: --reduce takes this option from the parts",
    }
}

pub(super) const BAKE: &[Combination<bake::Arguments>] = &[
    Combination {
        options: OF_MAPS,
        unused: |arguments| found(arguments.preset.is_some(), "given with --preset"),
        expected: "a material with maps; presets have no such options",
    },
    stated_by_parts(OF_MAPS),
    stated_by_parts(&[
        "preset",
        "size",
        "views",
        "lights",
        "dtype",
        "samples",
        "error",
        "bounces",
        "light-diameter",
        "min-roughness",
        "angular-filter",
        "clamp",
    ]),
    Combination {
        options: &["preview", "surface"],
        unused: |arguments| {
            let is_shared = arguments.shard.is_some() || !arguments.reduce.is_empty();
            found(is_shared, "given for a bake in parts")
        },
        expected: "a bake in one run",
    },
];

pub(super) const IMPORT: &[Combination<import::Arguments>] = &[stated_by_parts(&[
    "images",
    "handedness",
    "patch-mm",
    "near-field",
    "collocated",
    "pattern",
    "directions",
    "views",
    "lights",
    "values",
    "encoding",
    "illuminant",
    "size-line",
    "orientation",
    "alpha",
    "layer",
    "tileable",
    "texel-mm",
    "name",
    "dtype",
    "crop",
    "downsample",
    "keep-views",
    "keep-lights",
    "grey-card",
    "hot-pixels",
    "fill",
    "scattered",
    "corners",
    "size",
    "distortion",
    "focal",
    "center",
    "expand",
    "rank",
])];

pub(super) const TEXTONS: &[Combination<textons::Arguments>] = &[
    Combination {
        options: &["image-grid"],
        unused: |arguments| {
            let takes_all = arguments.options.images == Some(ImageCount::Named(Named::All));
            found(takes_all, "given with --images all")
        },
        expected: "--images N: representatives are chosen on that grid",
    },
    stated_by_parts(&[
        "textons",
        "images",
        "levels",
        "luminance",
        "no-tile",
        "restarts",
        "max-iterations",
        "image-grid",
        "memory",
    ]),
    Combination {
        options: &["report", "montage", "label-map"],
        unused: |arguments| found(arguments.shard.is_some(), "given with --shard"),
        expected: "--reduce in place of --shard: the reduction finds the textons",
    },
];

pub(super) const KNN: &[Combination<KnnOptions>] = &[Combination {
    options: &["candidates"],
    unused: |options| {
        found(
            options.search == NeighborSearch::Exact,
            "given with --search exact",
        )
    },
    expected: "--search two-level, which considers them",
}];

pub(super) const EXEMPLAR: &[Combination<exemplar::Arguments>] = &[
    Combination {
        options: &["margin"],
        unused: |arguments| found(arguments.tile, "given with --tile"),
        expected: "images that do not tile; tileable ones have no border",
    },
    Combination {
        options: &["coarse-neighborhood"],
        unused: |arguments| found(arguments.levels == 1, "given with --levels 1"),
        expected: "--levels 2 or more",
    },
    Combination {
        options: &["transition-tolerance"],
        unused: |arguments| {
            found(
                arguments.controls.transition.is_none(),
                "given without a transition",
            )
        },
        expected: "--transition FILE as well",
    },
];
