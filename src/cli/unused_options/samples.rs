//! Samples, textons and neighbour tables.

use crate::cli::parts::InShards;
use crate::cli::unused_options::rule::{Rule, found};
use crate::cli::{bake, exemplar, import, textons};
use crate::exemplar::KnnOptions;
use crate::exemplar::knn_options::Search;
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
const fn stated_by_parts<A: InShards>(options: &'static [&'static str]) -> Rule<A> {
    Rule {
        options,
        unused: |arguments| found(!arguments.parts().is_empty(), "given with --reduce"),
        expected: "parts made with it: they say all options",
    }
}

pub(super) const BAKE: &[Rule<bake::Arguments>] = &[
    Rule {
        options: OF_MAPS,
        unused: |arguments| found(arguments.preset.is_some(), "given with --preset"),
        expected: "a material with maps; a preset is as it is",
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
    Rule {
        options: &["preview", "surface"],
        unused: |arguments| {
            let is_shared = arguments.shard.is_some() || !arguments.reduce.is_empty();
            found(is_shared, "given for a bake in parts")
        },
        expected: "a bake in one run",
    },
];

pub(super) const IMPORT: &[Rule<import::Arguments>] = &[stated_by_parts(&[
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

pub(super) const TEXTONS: &[Rule<textons::Arguments>] = &[
    Rule {
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
    Rule {
        options: &["report", "montage", "label-map"],
        unused: |arguments| found(arguments.shard.is_some(), "given with --shard"),
        expected: "it beside --reduce, which finds the textons",
    },
];

pub(super) const KNN: &[Rule<KnnOptions>] = &[Rule {
    options: &["candidates"],
    unused: |options| found(options.search == Search::Exact, "given with --search exact"),
    expected: "--search two-level, which considers them",
}];

pub(super) const EXEMPLAR: &[Rule<exemplar::Arguments>] = &[
    Rule {
        options: &["margin"],
        unused: |arguments| found(arguments.tile, "given with --tile"),
        expected: "images that do not tile: others have no border",
    },
    Rule {
        options: &["coarse-neighborhood"],
        unused: |arguments| found(arguments.levels == 1, "given with --levels 1"),
        expected: "--levels 2 or more",
    },
    Rule {
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
