//! Synthesis: options of one method beside another, of one kind of target beside another.

use crate::cli::synth::Arguments;
use crate::cli::unused_options::combination::{Combination, found};
use crate::cli::unused_options::given::Given;
use crate::error::Result;
use crate::synthesis::Effort;
use crate::synthesis::options::{CandidateSearch, MetricKind};

/// Refuses options that the method does not use.
pub(super) fn refuse_by_method(arguments: &Arguments, given: &Given) -> Result<()> {
    let options = &arguments.options;
    options.refuse_foreign(|name| given.has(name))?;
    options.refuse_replaced(|name| given.has(name))
}

/// What belongs to metrics and searches.
pub(super) const SEARCHES: &[Combination<Arguments>] = &[
    Combination {
        options: &["spectrum"],
        unused: |arguments| {
            let options = &arguments.options;
            let is_exact = options.metric == MetricKind::Gram
                && options.k_coherence.polish == Effort::Rounds(0);
            found(is_exact, "given with --metric gram")
        },
        expected: "--metric embedded, which leaves part of the spectrum out",
    },
    Combination {
        options: &["k", "repair-rounds", "reuse-penalty"],
        unused: |arguments| {
            let tries_all = arguments.options.k_coherence.search == CandidateSearch::Full;
            found(tries_all, "given with --search full")
        },
        expected: "--search k-coherence: a full search tries every texel at every site",
    },
    Combination {
        options: &["start-passes"],
        unused: |arguments| found(arguments.options.levels == Some(1), "given with --levels 1"),
        expected: "--levels 2 or more: a single level grows from one site",
    },
];

/// What belongs to kinds of targets.
pub(super) const TARGETS: &[Combination<Arguments>] = &[
    Combination {
        options: &["texel", "mesh-unit"],
        unused: |arguments| {
            let target = &arguments.target;
            given_for(arguments, target.grid.is_some() || target.is_atlas())
        },
        expected: "the vertices of a mesh; an atlas has --texture-scale, and a grid none",
    },
    Combination {
        options: &["border"],
        unused: |arguments| given_for(arguments, arguments.target.grid.is_none()),
        expected: "--grid WxH as well: a mesh has borders of its own",
    },
    Combination {
        options: &["direction", "guide", "align", "field-energy"],
        unused: |arguments| given_for(arguments, arguments.target.grid.is_some()),
        expected: "a mesh; on a grid every site is one texel, and s runs along its rows",
    },
    Combination {
        options: &["direction", "guide", "align", "field-energy"],
        unused: |arguments| given_for(arguments, arguments.is_onto_faces()),
        expected: "another --method: faces have no orientation",
    },
    Combination {
        options: &["keys"],
        unused: |arguments| {
            let method = arguments.options.method.description();
            given_for(arguments, !method.follows_controls)
        },
        expected: "--method progressive; directions alone are for --guide",
    },
    Combination {
        options: &["crease"],
        unused: |arguments| {
            let target = &arguments.target;
            let has_one_mesh = target.is_atlas() || !arguments.options.method.retiles();
            given_for(arguments, target.grid.is_some() || has_one_mesh)
        },
        expected: "a mesh and a method that retiles it: creases are lines of coarser levels",
    },
    Combination {
        options: &[
            "resolution",
            "texture-scale",
            "unwrap",
            "charts",
            "sampling",
        ],
        unused: |arguments| given_for(arguments, !arguments.target.is_atlas()),
        expected: "--onto atlas as well",
    },
    Combination {
        options: &["base-faces", "subdivisions"],
        unused: |arguments| given_for(arguments, !arguments.is_onto_faces()),
        expected: "--onto faces as well",
    },
];

fn given_for(arguments: &Arguments, is_unused: bool) -> Option<String> {
    let target = arguments.target.named(arguments.options.method);
    found(is_unused, format!("given for {target}"))
}

/// What belongs to products.
pub(super) const PRODUCTS: &[Combination<Arguments>] = &[
    Combination {
        options: &["resume"],
        unused: for_faces,
        expected: "no --resume: nothing unfinished is kept",
    },
    Combination {
        options: &["pictures"],
        unused: for_faces,
        expected: "mesotex render, or --vertex-colors and --glb",
    },
    Combination {
        options: &["force"],
        unused: |arguments| match arguments.table_path() {
            None => for_faces(arguments),
            Some(_) => None,
        },
        expected: "a table of another space, between space and mesh",
    },
    Combination {
        options: &["glb", "levels-out"],
        unused: |arguments| {
            found(
                !arguments.is_onto_faces(),
                "given for sites that are not faces",
            )
        },
        expected: "--onto faces as well",
    },
    Combination {
        options: &["displace", "transparency", "surface-color"],
        unused: |arguments| {
            let text = format!("given for {}", arguments.output.display());
            found(!arguments.has_model(), text)
        },
        expected: "-o NAME.atlas, which holds a model",
    },
    Combination {
        options: &["sample"],
        unused: |arguments| {
            let pictures = &arguments.pictures;
            let is_drawn = pictures.pictures.is_some() || pictures.vertex_colors.is_some();
            found(
                !is_drawn && !arguments.is_onto_faces(),
                "nothing to draw in its colours",
            )
        },
        expected: "--pictures or --vertex-colors as well",
    },
];

fn for_faces(arguments: &Arguments) -> Option<String> {
    found(arguments.is_onto_faces(), "given for --onto faces")
}
