//! Whether the combinations are refused, and whether every one of the lists has a command line.

mod combinations;

use std::collections::BTreeSet;

use clap::CommandFactory;

use self::combinations::{COMBINATIONS, NEIGHBORS};
use super::combination::Combination;
use super::*;
use crate::cli::CommandLine;
use crate::cli::subcommand::Subcommand;
use crate::error::Error;
use crate::synthesis::{OwnOptions, SynthesisOptions};

fn words(line: &str) -> impl Iterator<Item = &str> {
    std::iter::once("mesotex").chain(line.split(' '))
}

/// The option that a command line is refused for.
fn refused_for(line: &str) -> Option<String> {
    let (command, given) = match CommandLine::read(words(line)) {
        Ok(read) => read,
        Err(error) => {
            let typed: Vec<String> = words(line).map(str::to_owned).collect();
            let refusal = crate::cli::failure::refusal::Refusal::of(&error, &typed);
            return refusal.and_then(|refusal| refusal.option);
        }
    };
    match command.check().and_then(|()| check(&command, &given)) {
        Err(Error::Option { option, .. }) => Some(option),
        Err(other) => panic!("{line}: {other}"),
        Ok(()) => None,
    }
}

#[test]
fn options_without_effect_are_refused_by_name() {
    let is_named = |options: &str, found: &str| options.split('|').any(|name| name == found);
    let faults: Vec<String> = COMBINATIONS
        .iter()
        .map(|(line, options)| (line, options, refused_for(line)))
        .filter(|(_, options, found)| !found.as_ref().is_some_and(|found| is_named(options, found)))
        .map(|(line, options, found)| format!("{line}: {found:?}, not {options}"))
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn options_with_an_effect_are_not() {
    for line in NEIGHBORS {
        assert_eq!(refused_for(line), None, "{line}");
    }
}

/// The options that single methods of synthesis have, method by method.
fn own_options() -> Vec<Vec<(&'static str, &'static str)>> {
    let options = SynthesisOptions::default();
    let of_method = |own: &dyn OwnOptions| {
        let names = own.changed().into_iter().map(|(name, _)| ("synth", name));
        names.collect()
    };
    options
        .own_options()
        .map(|(_, own)| of_method(own))
        .collect()
}

/// The options of every combination, each with the command it belongs to.
fn listed_options() -> Vec<(&'static str, &'static str)> {
    fn of<A>(
        command: &'static str,
        combinations: &[Combination<A>],
    ) -> Vec<(&'static str, &'static str)> {
        let options = combinations
            .iter()
            .flat_map(|combination| combination.options);
        options.map(|option| (command, *option)).collect()
    }
    [
        of("bake", samples::BAKE),
        of("import", samples::IMPORT),
        of("textons", samples::TEXTONS),
        of("knn", samples::KNN),
        of("exemplar", samples::EXEMPLAR),
        of("mesh", surfaces::MESH),
        own_options().concat(),
        of("synth", synth::SEARCHES),
        of("synth", synth::TARGETS),
        of("synth", synth::PRODUCTS),
        of("render", render::ATLAS),
        of("render", render::FRAMES),
        of("bake-maps", bake_maps::COMBINATIONS),
        of("transfer", surfaces::TRANSFER),
        of("export", surfaces::EXPORT),
        of("run", surfaces::RUN),
    ]
    .concat()
}

#[test]
fn every_combination_names_options_that_there_are() {
    let root = CommandLine::command();
    let unknown: BTreeSet<_> = listed_options()
        .into_iter()
        .filter(|(command, option)| {
            let command = root.find_subcommand(command).unwrap();
            let mut options = command.get_arguments();
            !options.any(|argument| argument.get_long() == Some(option))
        })
        .collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}

#[test]
fn every_combination_has_a_line() {
    let is_listed = |options: &[&str], command: &str| {
        COMBINATIONS
            .iter()
            .any(|(line, option)| line.starts_with(command) && options.contains(option))
    };
    for options in own_options() {
        let names: Vec<&str> = options.iter().map(|(_, name)| *name).collect();
        assert!(is_listed(&names, "synth"), "{names:?}");
    }
    let lists: [(&str, Vec<&[&str]>); 4] = [
        (
            "render",
            render::FRAMES
                .iter()
                .map(|combination| combination.options)
                .collect(),
        ),
        (
            "synth",
            synth::SEARCHES
                .iter()
                .map(|combination| combination.options)
                .collect(),
        ),
        (
            "synth",
            synth::TARGETS
                .iter()
                .map(|combination| combination.options)
                .collect(),
        ),
        (
            "synth",
            synth::PRODUCTS
                .iter()
                .map(|combination| combination.options)
                .collect(),
        ),
    ];
    for (command, combinations) in lists {
        for options in combinations {
            assert!(is_listed(options, command), "{command}: {options:?}");
        }
    }
}

/// Options of commands that join parts, which have an effect on that.
const OF_JOINING: [&str; 12] = [
    "output",
    "reduce",
    "shard",
    "report",
    "montage",
    "label-map",
    "once",
    "seed",
    "threads",
    "quiet",
    "verbose",
    "json",
];

#[test]
fn what_joins_parts_takes_no_option_of_them() {
    let root = CommandLine::command();
    let listed = listed_options();
    for command in ["bake", "import", "textons"] {
        let of_command = root.find_subcommand(command).unwrap();
        let missing: Vec<&str> = of_command
            .get_arguments()
            .filter_map(|argument| argument.get_long())
            .filter(|option| !OF_JOINING.contains(option))
            .filter(|option| !listed.contains(&(command, option)))
            .collect();
        assert!(missing.is_empty(), "{command}: {missing:?}");
    }
}
