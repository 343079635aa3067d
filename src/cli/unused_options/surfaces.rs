//! Meshes, and what is transferred to them; scenes.

use crate::cli::unused_options::combination::{Combination, found};
use crate::cli::{export, mesh, run, transfer};

pub(super) const MESH: &[Combination<mesh::Arguments>] = &[
    Combination {
        options: &[
            "direction",
            "align",
            "guide",
            "keys",
            "field-energy",
            "texel",
        ],
        unused: |arguments| found(!arguments.wants_field(), "alone"),
        expected: "--orient, --report or --pictures as well: without a field it changes nothing",
    },
    Combination {
        options: &["levels"],
        unused: |arguments| found(!arguments.is_measured(), "alone"),
        expected: "--report or --pictures as well: it sets how many levels are measured and drawn",
    },
    Combination {
        options: &["crease"],
        unused: |arguments| {
            let retiles = arguments.is_measured() || arguments.options.vertices.is_some();
            found(!retiles, "alone")
        },
        expected: "--vertices, --report or --pictures as well: it sets which edges retiling keeps",
    },
];

pub(super) const TRANSFER: &[Combination<transfer::Arguments>] = &[
    Combination {
        options: &["tile"],
        unused: |arguments| given_for(arguments, arguments.is_atlas()),
        expected: "no such option: an atlas states it",
    },
    Combination {
        options: &["displace", "transparency", "surface-color"],
        unused: |arguments| given_for(arguments, !arguments.is_atlas()),
        expected: "an atlas; a surface texton map becomes a PLY",
    },
];

fn given_for(arguments: &transfer::Arguments, is_unused: bool) -> Option<String> {
    found(
        is_unused,
        format!("given for {}", arguments.input.display()),
    )
}

pub(super) const EXPORT: &[Combination<export::Arguments>] = &[
    Combination {
        options: &["sample", "view", "light"],
        unused: |arguments| {
            found(
                !arguments.to.is_mesh(),
                "given for a format that is not a mesh",
            )
        },
        expected: "--to glb, obj, usda or ply",
    },
    Combination {
        options: &["view", "light"],
        unused: |arguments| found(arguments.colors.sample.is_none(), "given without a sample"),
        expected: "--sample as well",
    },
];

pub(super) const RUN: &[Combination<run::Arguments>] = &[Combination {
    options: &["no-pages"],
    unused: |arguments| match (arguments.dry_run, arguments.plan, &arguments.until) {
        (true, ..) => Some("given with --dry-run".into()),
        (_, true, _) => Some("given with --plan".into()),
        (.., Some(_)) => Some("given with --until, which ends before the pages".into()),
        _ => None,
    },
    expected: "a run of the whole scene",
}];
