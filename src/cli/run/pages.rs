//! The pages of a scene: made after its last stage, where anything they show has changed.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::btf::sample;
use crate::cli::outcome::Outcome;
use crate::cli::outputs::{Files, Product};
use crate::cli::run::check::{Stage, title};
use crate::cli::run::quality::Quality;
use crate::cli::run::record::Record;
use crate::cli::run::scene::Scene;
use crate::cli::session::{Common, Session};
use crate::cli::subcommand::Subcommand;
use crate::cli::{report, view};
use crate::error::{Error, Result};
use crate::format::ours::Format;

/// Where the pages of a scene go.
pub(super) struct Pages<'a> {
    /// The scene.
    pub(super) scene: &'a Scene,
    /// The scene's file, in the folder that was entered.
    pub(super) file: PathBuf,
    /// How finely the scene is run.
    pub(super) quality: Quality,
    /// The options of all commands.
    pub(super) common: &'a Common,
}

/// A page of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Page {
    /// The surface to turn.
    View,
    /// Everything that was made.
    Report,
}

impl Page {
    fn name(self) -> &'static str {
        match self {
            Self::View => "view",
            Self::Report => "report",
        }
    }
}

impl Pages<'_> {
    /// Makes what is not as it would be made now. A page that cannot be made is a warning: the stages are done.
    pub(super) fn make(
        &self,
        stages: &[&Stage],
        record: &mut Record,
        session: &Session,
    ) -> Result<Vec<PathBuf>> {
        let begun = Instant::now();
        let (mut paths, mut has_news) = (Vec::new(), false);
        for page in [Page::View, Page::Report] {
            let path = self.scene.page(page.name());
            match self.renew(page, &path, (stages, &mut *record), session) {
                Ok(is_new) => has_news |= is_new,
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                Err(error) => session
                    .progress()
                    .warn(format!("a page was not made: {error}")),
            }
            paths.extend(path.exists().then_some(path));
        }
        if has_news {
            let seconds = begun.elapsed().as_secs_f64();
            let name = title("pages", &self.scene.variant());
            session.say(&format!("{name:<10} {seconds:.1} s"))?;
        }
        Ok(paths)
    }

    /// Makes a page where anything it shows has changed; says whether it did.
    fn renew(
        &self,
        page: Page,
        path: &PathBuf,
        (stages, record): (&[&Stage], &mut Record),
        session: &Session,
    ) -> Result<bool> {
        let files = match page {
            Page::View => self.files_of_view(path),
            Page::Report => self.files_of_report(path, (stages, record), session.seed()),
        };
        let up = format!("{:?}", self.scene.up());
        let name = path.display().to_string();
        let words = ["page".into(), page.name().into(), up, name];
        let key = Record::key(&words, session.seed());
        if record.is_done(&key, &files)? {
            return Ok(false);
        }
        let begun = Instant::now();
        match page {
            Page::View => self.view(path, session)?,
            Page::Report => self.report(path, session)?,
        };
        record.note(&key, (&files, &[]), begun.elapsed().as_secs_f64())?;
        Ok(true)
    }

    /// The viewer shows the sample on the map.
    fn files_of_view(&self, page: &PathBuf) -> Files {
        let [sample, map] = self.scene.sample_and_map();
        Files::default()
            .read(&sample::files_of(&sample))
            .read([&map])
            .write("output", [page], Product::File(Format::Page))
    }

    /// The report shows everything that stages wrote.
    fn files_of_report(
        &self,
        page: &PathBuf,
        (stages, record): (&[&Stage], &Record),
        seed: u64,
    ) -> Files {
        let written = stages.iter().filter_map(|stage| {
            let key = Record::key(&stage.words, stage.seed_or(seed));
            let finished = record.finished(&key)?;
            Some(finished.outputs.into_keys())
        });
        let mut files = Files {
            reads: written.flatten().collect(),
            ..Files::default()
        };
        files.reads.push(self.file.clone());
        files.write("output", [page], Product::File(Format::Page))
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
        arguments.check()?;
        arguments.run(session)
    }

    fn report(&self, output: &Path, session: &Session) -> Result<Outcome> {
        let arguments = report::Arguments {
            input: self.file.clone(),
            output: output.to_path_buf(),
            quality: self.quality,
            only: Some(self.scene.variant()).filter(|variant| !variant.is_empty()),
            common: self.common.clone(),
        };
        arguments.check()?;
        arguments.run(session)
    }
}
