//! `mesotex gram`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::cli::info::kind::Kind;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::Result;
use crate::exemplar::space::{Features, space_of_vocabulary};
use crate::format::ours::Format;
use crate::texton::vocabulary::StoredVocabulary;

/// Make the surface texton space of a vocabulary: dot products in place of appearance vectors.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Example:
  mesotex gram weave.textons.npz -o weave.space.npz")]
pub struct Arguments {
    /// The vocabulary, NAME.textons.npz.
    pub textons: PathBuf,
    /// The space to write, NAME.space.npz.
    #[arg(long, short)]
    pub output: PathBuf,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn files(&self) -> Result<Files> {
        let archive = Product::File(Format::Archive);
        Ok(Files::default()
            .read_as(&[Kind::Archive], &self.textons)
            .write("output", [&self.output], archive))
    }

    fn run(&self, _session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        let vocabulary = StoredVocabulary::open(&self.textons)?;
        let mut space =
            space_of_vocabulary(&vocabulary).map_err(|error| error.in_file(&self.textons))?;
        space.write(&self.output, Some(&vocabulary.id))?;
        let mut outcome = Outcome::default();
        let mut levels = Vec::new();
        for (at, level) in space.levels.iter().enumerate() {
            let Features::Textons { gram, .. } = &level.features else {
                continue;
            };
            let textons = gram.nrows() - 1;
            outcome = outcome.line(format!(
                "level {at}: {} × {} texels, {textons} textons and the default texton",
                level.grid.width, level.grid.height
            ));
            levels.push(json!({
                "width": level.grid.width, "height": level.grid.height, "textons": textons,
            }));
        }
        Ok(outcome
            .figure("levels", levels)
            .figure("id", space.id.to_string())
            .wrote(&self.output)
            .next(format!(
                "mesotex knn {} -o NAME.knn.npz",
                self.output.display()
            )))
    }
}
