//! `mesotex knn`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::cli::info::kind::Kind;
use crate::cli::machine::Need;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::Result;
use crate::exemplar::KnnOptions;
use crate::exemplar::knn_options::NeighborSearch;
use crate::exemplar::neighbor_table::{self, LevelSearch, NeighborTable, bytes_to_build};
use crate::exemplar::space::Space;
use crate::format::ours::Format;

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

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        self.options.validate()
    }

    fn files(&self) -> Result<Files> {
        let archive = Product::File(Format::Archive);
        Ok(Files::default()
            .read_as(&[Kind::Archive], &self.space)
            .write("output", [&self.output], archive))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let space = Space::read(&self.space)?;
        let need = Need {
            bytes: bytes_to_build(&space, &self.options, rayon::current_num_threads()),
            work: format!("tables of {} neighbours", self.options.k),
            option: "k",
            advice: "a smaller --k, or fewer --threads".into(),
        };
        need.check()?;
        let (mut table, searches) =
            neighbor_table::build_and_measure(&space, &self.options, session.progress())?;
        table.write(&self.output, &self.options)?;
        Ok(self.outcome(&space, &table, &searches))
    }
}

impl Arguments {
    fn outcome(&self, space: &Space, table: &NeighborTable, searches: &[LevelSearch]) -> Outcome {
        let mut outcome = Outcome::default();
        let mut levels = Vec::new();
        let all = table.levels.iter().zip(&space.levels).zip(searches);
        // Tell what each level searched.
        for (at, ((level, source), found)) in all.enumerate() {
            let whole = table
                .whole_texels(at, source.grid)
                .iter()
                .filter(|&&whole| whole)
                .count();
            let search = match found.search {
                NeighborSearch::TwoLevel => {
                    format!(
                        "two-level search, recall at {} is {:.3}",
                        table.k, found.recall
                    )
                }
                NeighborSearch::Auto | NeighborSearch::Exact => "exact search".into(),
            };
            outcome = outcome.line(format!(
                "level {at}: {} × {} texels, {whole} of them whole, neighbours at least {} texels apart, {search}",
                source.grid.width, source.grid.height, level.min_separation
            ));
            levels.push(json!({
                "width": source.grid.width,
                "height": source.grid.height,
                "whole": whole,
                "min_separation": level.min_separation,
                "search": found.search,
                "recall": found.recall,
            }));
        }
        // Tell the table's own figures and what to do next.
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
