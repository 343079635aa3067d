//! A combination of options, and how a list of them is compared with a command line.

use crate::cli::unused_options::given::Given;
use crate::error::{Error, Result};

/// Options that change nothing in some combination.
pub(super) struct Combination<A> {
    /// Their long names.
    pub(super) options: &'static [&'static str],
    /// Says what makes them change nothing, where it does: what is found, behind the option's name.
    pub(super) unused: fn(&A) -> Option<String>,
    /// What they need, or what to give in place of them.
    pub(super) expected: &'static str,
}

/// Refuses the first option that was given and is unused.
pub(super) fn refuse<A>(
    combinations: &[Combination<A>],
    arguments: &A,
    given: &Given,
) -> Result<()> {
    for combination in combinations {
        let Some(option) = combination.options.iter().find(|option| given.has(option)) else {
            continue;
        };
        if let Some(found) = (combination.unused)(arguments) {
            return Err(Error::option(*option, found, combination.expected));
        }
    }
    Ok(())
}

/// What is found, where something is unused.
pub(super) fn found(is_unused: bool, text: impl Into<String>) -> Option<String> {
    is_unused.then(|| text.into())
}
