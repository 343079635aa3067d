//! What a scene's earlier runs have done: `run.json` beside the outputs.
//!
//! A stage is done when it was run with the same words by the same version, on inputs of the same
//! content, and its outputs still hold what it wrote. The record is written after every stage, so
//! that a killed run loses none. Contents are compared by [`known_files`](super::known_files).

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::btf::sample;
use crate::cli::outputs::{Files, Output, Product};
use crate::cli::run::known_files::KnownFiles;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::json;
use crate::format::ours::{Format, is_ours};

/// What a record calls itself.
pub const FORMAT: &str = "mesotex-run";
const VERSION: u32 = 2;

/// The record of one scene.
#[derive(Debug)]
pub struct Record {
    path: PathBuf,
    ledger: Ledger,
    /// Whether the record was there but could not be read.
    pub is_damaged: bool,
}

#[derive(Debug, Serialize, Deserialize)]
struct Ledger {
    format: String,
    version: u32,
    files: KnownFiles,
    stages: BTreeMap<String, Done>,
}

/// A finished stage: the content of every file and folder it read, and of every file it wrote.
#[derive(Debug, Serialize, Deserialize)]
struct Done {
    inputs: BTreeMap<PathBuf, ContentId>,
    outputs: BTreeMap<PathBuf, ContentId>,
    /// How long it took; records of earlier versions do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
}

/// What is known of a finished stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finished {
    /// How long it took.
    pub seconds: Option<f64>,
    /// What it wrote, by file.
    pub outputs: BTreeMap<PathBuf, ContentId>,
}

impl Default for Ledger {
    fn default() -> Self {
        Self {
            format: FORMAT.into(),
            version: VERSION,
            files: KnownFiles::default(),
            stages: BTreeMap::new(),
        }
    }
}

impl Record {
    /// Opens the record at `path`. A scene that was never run has an empty one; one that is damaged or of
    /// another version is begun anew. A file that is no record is an error: it would be written over.
    pub fn open(path: &Path) -> Result<Self> {
        let mut record = Self {
            path: path.to_path_buf(),
            ledger: Ledger::default(),
            is_damaged: false,
        };
        if !path.exists() {
            return Ok(record);
        }
        match json::read::<Ledger>(path) {
            Ok(ledger) if ledger.format == FORMAT && ledger.version == VERSION => {
                record.ledger = ledger;
            }
            _ if is_record(path)? => record.is_damaged = true,
            _ => {
                return Err(Error::data("record", "no record of `mesotex run`")
                    .expected("the record of earlier runs, or no file")
                    .advice("move the file away, or name another: by the scene's `output`, or by --once")
                    .in_file(path));
            }
        }
        Ok(record)
    }

    /// What a stage is told apart by: version, seed and command line.
    pub fn key(words: &[String], seed: u64) -> String {
        let version = env!("CARGO_PKG_VERSION");
        format!("{version} --seed {seed} {}", words.join(" "))
    }

    /// Whether nothing changed since the stage was run.
    pub fn is_done(&mut self, key: &str, files: &Files) -> Result<bool> {
        let Ledger {
            files: known,
            stages,
            ..
        } = &mut self.ledger;
        let Some(done) = stages.get(key) else {
            return Ok(false);
        };
        let mut reads = files.reads.clone();
        reads.sort();
        reads.dedup();
        if !reads.iter().eq(done.inputs.keys()) {
            return Ok(false);
        }
        for (path, id) in done.inputs.iter().chain(&done.outputs) {
            if !path.exists() || known.content_of(path)? != *id {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether an earlier run wrote `path`, or the sample there.
    pub fn wrote(&self, path: &Path) -> bool {
        let description = path.join(sample::DESCRIPTION);
        let mut stages = self.ledger.stages.values();
        stages.any(|done| {
            [path, &description]
                .iter()
                .any(|path| done.outputs.contains_key(*path))
        })
    }

    /// Removes what earlier runs wrote for a stage and what was changed since beyond recognition: no
    /// command would write over it.
    pub fn make_way(&self, files: &Files) -> Result<()> {
        for output in &files.writes {
            let stages = self.ledger.stages.values();
            let written = stages.flat_map(|done| done.outputs.keys());
            let written = written.filter(|path| path.starts_with(&output.path) && path.is_file());
            for path in written {
                if is_strange(output, path)? {
                    fs::remove_file(path).map_err(Error::io(path, "remove"))?;
                }
            }
        }
        Ok(())
    }

    /// What is known of a finished stage.
    pub fn finished(&self, key: &str) -> Option<Finished> {
        let done = self.ledger.stages.get(key)?;
        Some(Finished {
            seconds: done.seconds,
            outputs: done.outputs.clone(),
        })
    }

    /// Notes that the stage is done in `seconds`: it read and wrote `files`, and put `inside` into the folders among
    /// them. Forgets older runs that wrote the same outputs.
    pub fn note(
        &mut self,
        key: &str,
        (files, inside): (&Files, &[PathBuf]),
        seconds: f64,
    ) -> Result<()> {
        let outputs = written(files, inside);
        self.ledger.files.let_settle(&outputs);
        let done = Done {
            inputs: self.contents_of(&files.reads)?,
            outputs: self.contents_of(&outputs)?,
            seconds: Some(seconds),
        };
        let main = files.writes.first().map(|output| output.path.clone());
        self.ledger.stages.retain(|_, old| {
            let writes_same =
                |main: &PathBuf| old.outputs.keys().any(|path| path.starts_with(main));
            !main.as_ref().is_some_and(writes_same)
        });
        self.ledger.stages.insert(key.to_owned(), done);
        self.write()
    }

    /// Writes down what was learned of files by looking at them, where that saves the next run work.
    pub fn close(&mut self) -> Result<()> {
        match self.ledger.files.has_news() {
            true => self.write(),
            false => Ok(()),
        }
    }

    fn write(&mut self) -> Result<()> {
        let Ledger { files, stages, .. } = &mut self.ledger;
        let named = |path: &Path| {
            let mut all = stages
                .values()
                .flat_map(|done| [&done.inputs, &done.outputs]);
            all.any(|list| list.contains_key(path))
        };
        files.forget_but(named);
        json::write(&self.path, &self.ledger)
    }

    fn contents_of(&mut self, paths: &[PathBuf]) -> Result<BTreeMap<PathBuf, ContentId>> {
        let known = &mut self.ledger.files;
        paths
            .iter()
            .map(|path| Ok((path.clone(), known.content_of(path)?)))
            .collect()
    }
}

/// Every file a stage wrote.
fn written(files: &Files, inside: &[PathBuf]) -> Vec<PathBuf> {
    let own = files.writes.iter().flat_map(|output| match output.product {
        Product::Folder(kind) => kind.files(&output.path),
        Product::Frames | Product::NewFolder => Vec::new(),
        Product::File(_) => vec![output.path.clone()],
    });
    own.chain(inside.iter().cloned()).collect()
}

/// Whether a file that is an output, or lies in one, could not be told from a user's.
fn is_strange(output: &Output, path: &Path) -> Result<bool> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    let format = match (output.product, ending) {
        (Product::File(format), _) => format,
        (Product::Frames, Some("exr")) => Format::Frame,
        (Product::Frames, Some("png")) => Format::Picture,
        (Product::Frames | Product::NewFolder, _) => return Ok(false),
        (Product::Folder(kind), _) => {
            // A folder that holds more than its kind stays whole; the command refuses it.
            let folder = &output.path;
            let look =
                || Ok(kind.foreign_member(folder)?.is_none() && kind.objection(folder)?.is_some());
            return look().map_err(Error::io(folder, "read"));
        }
    };
    let is_ours = is_ours(path, format).map_err(Error::io(path, "read"))?;
    Ok(!is_ours)
}

/// Whether a file says that it is a record, of whatever version and in whatever state.
fn is_record(path: &Path) -> Result<bool> {
    let text = fs::read(path).map_err(Error::io(path, "read"))?;
    let says = |mark: &str| {
        text.windows(mark.len())
            .any(|window| window == mark.as_bytes())
    };
    // The first version had no name for itself; its keys began with version and seed.
    Ok(text.is_empty() || says(FORMAT) || says("\"0.1.0 --seed "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_is_done_until_its_words_inputs_or_outputs_change() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for (name, text) in [("in", "1"), ("out", "2"), ("frame", "3")] {
            fs::write(at(name), text).unwrap();
        }
        let files = Files::default().read([&at("in")]).write(
            "output",
            [&at("out")],
            Product::File(Format::Json),
        );
        let words = ["gram".to_owned()];
        let key = Record::key(&words, 0);
        let mut record = Record::open(&at("run.json")).unwrap();
        assert!(!record.is_done(&key, &files).unwrap());
        record.note(&key, (&files, &[at("frame")]), 1.0).unwrap();
        let reopened = || Record::open(&at("run.json")).unwrap();
        assert!(reopened().is_done(&key, &files).unwrap());
        assert!(!reopened().is_done(&Record::key(&words, 1), &files).unwrap());
        for name in ["in", "out", "frame"] {
            let kept = fs::read(at(name)).unwrap();
            fs::write(at(name), "changed").unwrap();
            assert!(!reopened().is_done(&key, &files).unwrap(), "{name}");
            fs::write(at(name), kept).unwrap();
        }
        assert!(reopened().is_done(&key, &files).unwrap());
        let more = files.clone().read([&at("frame")]);
        assert!(!reopened().is_done(&key, &more).unwrap());
        fs::remove_file(at("out")).unwrap();
        assert!(!reopened().is_done(&key, &files).unwrap());
    }

    #[test]
    fn a_damaged_record_is_begun_anew_and_a_foreign_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.json");
        for text in [
            "{\"format\": \"mesotex-run\", \"ver",
            "{\"0.1.0 --seed 0 gram\": {}}",
            "",
        ] {
            fs::write(&path, text).unwrap();
            assert!(Record::open(&path).unwrap().is_damaged, "{text}");
        }
        fs::write(&path, "{\"distance\": \"10 km\"}").unwrap();
        let refused = Record::open(&path).unwrap_err().to_string();
        assert!(
            refused.contains("run.json") && refused.contains("move the file away"),
            "{refused}"
        );
    }
}
