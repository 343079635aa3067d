//! Which options are given on a command line.

use std::collections::BTreeSet;

use clap::ArgMatches;
use clap::parser::ValueSource;

/// The options that were given, by their long names; defaults are not among them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::cli) struct Given {
    names: BTreeSet<String>,
}

impl Given {
    /// What was given of the options of a command and its subcommands.
    pub(in crate::cli) fn of(command: &clap::Command, matches: &ArgMatches) -> Self {
        let mut names = BTreeSet::new();
        let mut level = Some((command, matches));
        while let Some((command, matches)) = level {
            let typed = command.get_arguments().filter(|argument| {
                let source = matches.value_source(argument.get_id().as_str());
                source == Some(ValueSource::CommandLine)
            });
            names.extend(typed.filter_map(|argument| argument.get_long().map(str::to_owned)));
            level = matches
                .subcommand()
                .and_then(|(name, inner)| Some((command.find_subcommand(name)?, inner)));
        }
        Self { names }
    }

    /// Whether an option was given.
    pub(super) fn has(&self, option: &str) -> bool {
        self.names.contains(option)
    }
}
