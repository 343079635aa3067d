//! Options that would change nothing are refused, by one rule: an option that was given must have an effect beside the
//! others.
//!
//! Every command has a list of combinations ([`Combination`]). Whether an option was given is asked of the parser
//! ([`Given`]): stating a default counts. What depends on the content of files is checked where they are read, and
//! what a library's caller could get wrong too by its options. `tests` lists the combinations as command lines.

mod bake_maps;
mod combination;
mod given;
mod render;
mod samples;
mod surfaces;
mod synth;
#[cfg(test)]
mod tests;
mod vary;

pub(in crate::cli) use given::Given;

use crate::cli::Command;
use crate::cli::unused_options::combination::refuse;
use crate::cli::vary::Way;
use crate::error::Result;

/// Refuses an option that was given and would change nothing.
pub(in crate::cli) fn check(command: &Command, given: &Given) -> Result<()> {
    match command {
        Command::Bake(arguments) => refuse(samples::BAKE, arguments, given),
        Command::Import(arguments) => refuse(samples::IMPORT, arguments, given),
        Command::Textons(arguments) => refuse(samples::TEXTONS, arguments, given),
        Command::Knn(arguments) => refuse(samples::KNN, &arguments.options, given),
        Command::Exemplar(arguments) => {
            refuse(samples::EXEMPLAR, arguments, given)?;
            refuse(samples::KNN, &arguments.knn, given)
        }
        Command::Vary(arguments) => match &arguments.way {
            Way::Distort(arguments) => {
                refuse(vary::FIELDS, &arguments.fields, given)?;
                refuse(samples::KNN, &arguments.outputs.knn, given)
            }
            Way::Warp(arguments) => {
                refuse(vary::FIELDS, &arguments.fields, given)?;
                refuse(samples::KNN, &arguments.outputs.knn, given)
            }
            Way::Blend(arguments) => {
                refuse(vary::BLEND, arguments, given)?;
                refuse(vary::FIELDS, &arguments.fields, given)?;
                refuse(samples::KNN, &arguments.outputs.knn, given)
            }
        },
        Command::Mesh(arguments) => refuse(surfaces::MESH, arguments, given),
        Command::Synth(arguments) => {
            synth::refuse_by_method(arguments, given)?;
            refuse(synth::SEARCHES, arguments.as_ref(), given)?;
            refuse(synth::TARGETS, arguments.as_ref(), given)?;
            refuse(synth::PRODUCTS, arguments.as_ref(), given)
        }
        Command::Render(arguments) => {
            refuse(render::ATLAS, arguments, given)?;
            refuse(render::FRAMES, &arguments.options, given)
        }
        Command::BakeMaps(arguments) => {
            refuse(bake_maps::COMBINATIONS, arguments, given)?;
            refuse(render::FRAMES, &arguments.options, given)
        }
        Command::Transfer(arguments) => refuse(surfaces::TRANSFER, arguments, given),
        Command::Export(arguments) => refuse(surfaces::EXPORT, arguments, given),
        Command::Run(arguments) => refuse(surfaces::RUN, arguments, given),
        // Every option of the others has an effect.
        _ => Ok(()),
    }
}
