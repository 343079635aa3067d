//! Progressively-variant exemplars.

use crate::cli::unused_options::combination::{Combination, found};
use crate::cli::vary::FieldOptions;
use crate::cli::vary::blend;

pub(super) const FIELDS: &[Combination<FieldOptions>] = &[Combination {
    options: &["ramp", "ramp-begin", "ramp-end"],
    unused: |fields| {
        let has_another = fields.transition.is_some() || !fields.transition_key.is_empty();
        found(has_another, "given beside another transition")
    },
    expected: "one of --ramp, --transition, --transition-key",
}];

pub(super) const BLEND: &[Combination<blend::Arguments>] = &[Combination {
    options: &["blur", "threshold", "mask-window", "mask-weight"],
    unused: |arguments| {
        found(
            arguments.by == blend::By::Mixture,
            "given with --by mixture",
        )
    },
    expected: "--by slice or average, which join masks",
}];
