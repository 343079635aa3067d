//! The pages of a scene: made after its last stage, where anything they show has changed.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::run::check::Stage;
use crate::cli::run::record::Record;
use crate::cli::run::scene::Scene;
use crate::cli::session::{Common, Session};
use crate::cli::{report, view};
use crate::error::{Error, Result};
use crate::format::ours::Format;

/// Where the pages of a scene go.
pub(super) struct Pages<'a> {
    /// The scene.
    pub(super) scene: &'a Scene,
    /// The scene's file, in the folder that was entered.
    pub(super) file: PathBuf,
    /// The options of all commands.
    pub(super) common: &'a Common,
}

impl Pages<'_> {
    /// Makes what is not as it would be made now. A page that cannot be made is a warning: the stages are done.
    pub(super) fn make(
        &self,
        stages: &[Stage],
        record: &mut Record,
        session: &Session,
    ) -> Result<Vec<PathBuf>> {
        let files = self.files(stages, record, session.seed());
        let key = Record::key(&["pages".to_owned()], session.seed());
        let paths: Vec<PathBuf> = files
            .writes
            .iter()
            .map(|output| output.path.clone())
            .collect();
        if record.is_done(&key, &files)? {
            return Ok(paths);
        }
        let begun = Instant::now();
        for made in [
            self.view(&paths[0], session),
            self.report(&paths[1], session),
        ] {
            match made {
                Ok(_) => {}
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Err(error) => {
                    session
                        .progress()
                        .warn(format!("a page was not made: {error}"));
                    return Ok(paths.into_iter().filter(|path| path.exists()).collect());
                }
            }
        }
        let seconds = begun.elapsed().as_secs_f64();
        record.note(&key, (&files, &[]), seconds)?;
        session.say(&format!("{:<10} {seconds:.1} s", "pages"))?;
        Ok(paths)
    }

    /// The pages show everything that stages wrote.
    fn files(&self, stages: &[Stage], record: &Record, seed: u64) -> Files {
        let written = stages.iter().filter_map(|stage| {
            let finished = record.finished(&Record::key(&stage.words, seed))?;
            Some(finished.outputs.into_keys())
        });
        let mut files = Files {
            reads: written.flatten().collect(),
            ..Files::default()
        };
        files.reads.push(self.file.clone());
        let product = Product::File(Format::Page);
        files
            .write("output", [&self.scene.page("view")], product)
            .write("output", [&self.scene.page("report")], product)
    }

    fn view(&self, output: &Path, session: &Session) -> Result<Outcome> {
        let [sample, map] = self.scene.sample_and_map();
        let arguments = view::Arguments {
            sample,
            map,
            output: output.to_path_buf(),
            error: view::DEFAULT_ERROR,
            up: self.scene.up(),
            front: self.scene.front(),
            force: false,
            common: self.common.clone(),
        };
        arguments.run(session)
    }

    fn report(&self, output: &Path, session: &Session) -> Result<Outcome> {
        let arguments = report::Arguments {
            input: self.file.clone(),
            output: output.to_path_buf(),
            common: self.common.clone(),
        };
        arguments.run(session)
    }
}
