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

use clap::Args;

use crate::cli::outcome::Outcome;
use crate::cli::outputs::Files;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
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
#[derive(Debug, clap::Subcommand)]
pub enum Way {
    Distort(distort::Arguments),
    Warp(warp::Arguments),
    Blend(blend::Arguments),
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        match &self.way {
            Way::Distort(arguments) => &arguments.common,
            Way::Warp(arguments) => &arguments.common,
            Way::Blend(arguments) => &arguments.common,
        }
    }

    fn check(&self) -> Result<()> {
        match &self.way {
            Way::Distort(arguments) => arguments.check(),
            Way::Warp(arguments) => arguments.check(),
            Way::Blend(arguments) => arguments.check(),
        }
    }

    fn files(&self) -> Result<Files> {
        Ok(match &self.way {
            Way::Distort(arguments) => arguments.files(),
            Way::Warp(arguments) => arguments.files(),
            Way::Blend(arguments) => arguments.files(),
        })
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        match &self.way {
            Way::Distort(arguments) => arguments.run(session),
            Way::Warp(arguments) => arguments.run(session),
            Way::Blend(arguments) => arguments.run(session),
        }
    }
}
