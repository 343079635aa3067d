//! `mesotex knn`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::cli::outcome::Outcome;
use crate::cli::session::{Common, Session};
use crate::error::Result;
use crate::exemplar::KnnOptions;
use crate::exemplar::neighbor_table::{self, NeighborTable};
use crate::exemplar::space::Space;

/// Find the k nearest neighbours of every texel, by the distance of their neighbourhoods.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex knn weave.space.npz -o weave.knn.npz
  mesotex knn weave.space.npz -o weave.knn.npz --k 5 --neighborhood 5 --min-separation 2")]
pub struct Arguments {
    /// The space, NAME.space.npz.
    pub space: PathBuf,
    /// The table to write, NAME.knn.npz.
    #[arg(long, short)]
    pub output: PathBuf,
    #[command(flatten)]
    pub options: KnnOptions,
    #[command(flatten)]
    pub common: Common,
}

impl Arguments {
    /// Runs the command.
    pub fn run(&self, session: &Session) -> Result<Outcome> {
        let _lock = session.claim(&self.output, &[&self.space])?;
        let space = Space::read(&self.space)?;
        let mut table = neighbor_table::build(&space, &self.options, session.progress())?;
        table.write(&self.output, &self.options)?;
        Ok(self.outcome(&space, &table))
    }

    fn outcome(&self, space: &Space, table: &NeighborTable) -> Outcome {
        let mut outcome = Outcome::default();
        let mut levels = Vec::new();
        for (at, (level, source)) in table.levels.iter().zip(&space.levels).enumerate() {
            let whole = level
                .whole(source.grid)
                .iter()
                .filter(|&&whole| whole)
                .count();
            outcome = outcome.line(format!(
                "level {at}: {} × {} texels, {whole} whole, separation {}",
                source.grid.width, source.grid.height, level.min_separation
            ));
            levels.push(json!({
                "width": source.grid.width,
                "height": source.grid.height,
                "whole": whole,
                "min_separation": level.min_separation,
            }));
        }
        outcome
            .figure("k", table.k)
            .figure("levels", levels)
            .figure("id", table.id.to_string())
            .wrote(&self.output)
            .next(format!(
                "mesotex synth {} {} MESH -o NAME.map.ply",
                self.space.display(),
                self.output.display()
            ))
    }
}
