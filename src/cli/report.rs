//! `mesotex report`: everything that a scene made, or that lies in a folder, on one page.

mod frames;
mod products;
mod quality;
mod sample;
mod stages;
mod surface;
mod textons;

use std::path::{Path, PathBuf};

use clap::Args;

use crate::btf::sample::Sample;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::report::products::Products;
use crate::cli::run::quality::Quality;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::error::{Error, Result};
use crate::format::ours::Format;
use crate::report::page;
use crate::report::summary::Summary;

/// Make a page of everything that a scene made: sample, textons, mesh, map, quality, frames, times.
///
/// The page needs nothing from the network. The page names what is missing.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  mesotex report scene.toml -o scene.html
  mesotex report demo -o demo.html")]
pub struct Arguments {
    /// A scene, or a folder that holds one or the files that commands wrote.
    #[arg(value_name = "SCENE.toml|DIR")]
    pub input: PathBuf,
    /// The page to write, NAME.html.
    #[arg(short, long, value_name = "PAGE.html")]
    pub output: PathBuf,
    /// For a scene: show the products of this quality, as `mesotex run --quality` makes them.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    /// For a scene with a [matrix]: the run to show, named by the varied values in the names of its outputs.
    #[arg(long, value_name = "RUN")]
    pub only: Option<String>,
    #[command(flatten)]
    pub common: Common,
}

impl Subcommand for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn check(&self) -> Result<()> {
        page::check_ending(&self.output)
    }

    fn files(&self) -> Result<Files> {
        Ok(Files::default().read([&self.input]).write(
            "output",
            [&self.output],
            Product::File(Format::Page),
        ))
    }

    fn run(&self, session: &Session) -> Result<Outcome> {
        let _locks = self.files()?.claim()?;
        // A scene's paths are relative to its folder, which is entered.
        let output = std::path::absolute(&self.output).map_err(Error::io(&self.output, "find"))?;
        let products = Products::find(&self.input, (self.quality, self.only.as_deref()), session)?;
        let (html, outcome) = page_of(&products, session)?;
        page::write(&output, &html)?;
        Ok(outcome.wrote(&self.output))
    }
}

/// The page, and what a person reads of it.
fn page_of(products: &Products, session: &Session) -> Result<(String, Outcome)> {
    // Make the page.
    let sample = products.sample.as_deref().map(Sample::open).transpose()?;
    let summary = summary_of(products, sample.as_ref(), session)?;
    let html = summary.page(sample.as_ref(), session.progress())?;
    // Gather what it could not show.
    let missing: Vec<String> = [
        &summary.sample,
        &summary.textons,
        &summary.mesh,
        &summary.map,
    ]
    .into_iter()
    .flat_map(|chapter| &chapter.notes)
    .chain(&summary.frame_notes)
    .chain(&summary.stage_notes)
    .cloned()
    .collect();
    // Tell what it holds.
    let pictures = summary
        .sequences
        .iter()
        .map(|sequence| sequence.frames.len())
        .sum::<usize>();
    let mut outcome = Outcome::default().line(format!(
        "{} stages, {pictures} frames; a page of {:.1} MB, open it in a browser",
        summary.stages.len(),
        html.len() as f64 / 1e6
    ));
    for note in &missing {
        outcome = outcome.line(note.as_str());
    }
    let outcome = outcome
        .figure("bytes", html.len())
        .figure("frames", pictures)
        .figure("missing", missing);
    Ok((html, outcome))
}

fn summary_of(products: &Products, sample: Option<&Sample>, session: &Session) -> Result<Summary> {
    let mut summary = Summary {
        title: products.title.clone(),
        ..Summary::default()
    };
    summary.sample = sample::chapter(products, sample, session)?;
    summary.textons = textons::chapter(products.textons.as_deref(), sample)?;
    surface::fill(&mut summary, products, session)?;
    (summary.sequences, summary.frame_notes) = frames::sequences(&products.frames)?;
    (summary.stages, summary.stage_notes) = stages::list(products);
    Ok(summary)
}

/// A file's name, for a reader who knows the folder.
fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
