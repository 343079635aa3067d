//! `mesotex vary`: a progressively-variant exemplar from homogeneous ones (Zhang 2003 §4.1 and §4.3).
//!
//! | file | what it does |
//! | --- | --- |
//! | [`distort`], [`warp`], [`blend`] | the three ways |
//! | [`inputs`], [`fields`] | textures and masks, transition and orientation, as options name them |
//! | [`product`] | what is written |

pub(in crate::cli) mod blend;
mod distort;
mod fields;
mod inputs;
mod product;
mod warp;

pub(in crate::cli) use crate::cli::vary::fields::FieldOptions;

use clap::{Args, Subcommand};

use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::error::Result;

/// Make a progressively-variant exemplar: a texture whose pattern changes gradually.
///
/// Writes NAME.sample, NAME.space.npz with the controls mask, transition and orientation, NAME.knn.npz whose
/// neighbours are alike in transition, and the pictures NAME.color.png, NAME.mask.png and NAME.transition.png.
#[derive(Debug, Args)]
pub struct Arguments {
    /// How it is made
    #[command(subcommand)]
    pub way: Way,
}

/// How it is made.
#[derive(Debug, Subcommand)]
pub enum Way {
    Distort(distort::Arguments),
    Warp(warp::Arguments),
    Blend(blend::Arguments),
}

impl Arguments {
    /// The options of every command.
    pub fn common(&self) -> &Common {
        match &self.way {
            Way::Distort(arguments) => &arguments.common,
            Way::Warp(arguments) => &arguments.common,
            Way::Blend(arguments) => &arguments.common,
        }
    }

    /// What the command reads and writes.
    pub fn files(&self) -> Files {
        match &self.way {
            Way::Distort(arguments) => arguments.files(),
            Way::Warp(arguments) => arguments.files(),
            Way::Blend(arguments) => arguments.files(),
        }
    }

    /// Refuses options that no input could satisfy.
    pub fn check(&self) -> Result<()> {
        match &self.way {
            Way::Distort(arguments) => arguments.check(),
            Way::Warp(arguments) => arguments.check(),
            Way::Blend(arguments) => arguments.check(),
        }
    }

    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files().claim()?;
        match &self.way {
            Way::Distort(arguments) => arguments.run(session),
            Way::Warp(arguments) => arguments.run(session),
            Way::Blend(arguments) => arguments.run(session),
        }
    }
}
