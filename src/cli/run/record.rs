//! What a scene's earlier runs have done: `run.json` beside the outputs.
//!
//! A stage is done when it was run with the same words by the same version, on inputs of the same
//! content, and its outputs still hold what it wrote. The record is written after every stage, so
//! that a killed run loses none.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::btf::sample::DESCRIPTION;
use crate::cli::run::scene::Stage;
use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::json;

/// The record of one scene.
#[derive(Debug)]
pub struct Record {
    path: PathBuf,
    done: BTreeMap<String, Done>,
}

/// A finished stage.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Done {
    inputs: BTreeMap<PathBuf, ContentId>,
    outputs: BTreeMap<PathBuf, ContentId>,
}

impl Record {
    /// Opens the record at `path`; a scene that was never run has an empty one.
    pub fn open(path: &Path) -> Result<Self> {
        let done = if path.exists() {
            json::read(path)?
        } else {
            BTreeMap::new()
        };
        Ok(Self {
            path: path.to_path_buf(),
            done,
        })
    }

    /// What a stage is told apart by: version, seed and command line.
    pub fn key(&self, stage: &Stage, seed: u64) -> String {
        let version = env!("CARGO_PKG_VERSION");
        format!("{version} --seed {seed} {}", stage.words.join(" "))
    }

    /// Whether nothing changed since the stage was run.
    pub fn is_done(&self, stage: &Stage, key: &str) -> Result<bool> {
        let Some(done) = self.done.get(key) else {
            return Ok(false);
        };
        let there = stage
            .inputs
            .iter()
            .chain(&stage.outputs)
            .all(|path| path.exists());
        Ok(there && *done == Self::state_of(stage)?)
    }

    /// Notes that the stage is done, and forgets older runs that wrote the same outputs.
    pub fn note(&mut self, stage: &Stage, key: &str) -> Result<()> {
        let state = Self::state_of(stage)?;
        self.done
            .retain(|_, done| !done.outputs.keys().eq(state.outputs.keys()));
        self.done.insert(key.to_owned(), state);
        json::write(&self.path, &self.done)
    }

    fn state_of(stage: &Stage) -> Result<Done> {
        let ids = |paths: &[PathBuf]| -> Result<BTreeMap<PathBuf, ContentId>> {
            paths
                .iter()
                .map(|path| Ok((path.clone(), content_of(path)?)))
                .collect()
        };
        Ok(Done {
            inputs: ids(&stage.inputs)?,
            outputs: ids(&stage.outputs)?,
        })
    }
}

/// The id of a file's content, of a sample (whose description holds its array's id), of a material
/// with the files it names, or of all files of a folder.
fn content_of(path: &Path) -> Result<ContentId> {
    let description = path.join(DESCRIPTION);
    if description.is_file() {
        return ContentId::of_file(&description);
    }
    if path.is_dir() {
        return content_of_all(&files_of(path)?);
    }
    if path
        .extension()
        .is_some_and(|extension| extension == "toml")
    {
        return content_of_all(&files_named_in(path)?);
    }
    ContentId::of_file(path)
}

fn content_of_all(files: &[PathBuf]) -> Result<ContentId> {
    let mut all = blake3::Hasher::new();
    for file in files {
        all.update(file.to_string_lossy().as_bytes());
        all.update(ContentId::of_file(file)?.to_string().as_bytes());
    }
    Ok(ContentId::of_hash(&all.finalize()))
}

/// The visible files of a folder, sorted.
fn files_of(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(Error::io(folder, "read"))? {
        let entry = entry.map_err(Error::io(folder, "read"))?;
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        if entry.path().is_file() && !hidden {
            files.push(entry.path());
        }
    }
    files.sort();
    Ok(files)
}

/// A TOML file and every file it names, relative to itself.
fn files_named_in(path: &Path) -> Result<Vec<PathBuf>> {
    let text = fs::read_to_string(path).map_err(Error::io(path, "read"))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut files = vec![path.to_path_buf()];
    if let Ok(table) = text.parse::<toml::Table>() {
        let mut values: Vec<&toml::Value> = table.values().collect();
        while let Some(value) = values.pop() {
            match value {
                toml::Value::String(name) if folder.join(name).is_file() => {
                    files.push(folder.join(name))
                }
                toml::Value::Table(inner) => values.extend(inner.values()),
                toml::Value::Array(inner) => values.extend(inner),
                _ => {}
            }
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_is_done_until_its_words_inputs_or_outputs_change() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("in"), "1").unwrap();
        fs::write(at("out"), "2").unwrap();
        let stage = Stage {
            name: "gram".into(),
            words: vec!["gram".into()],
            inputs: vec![at("in")],
            outputs: vec![at("out")],
        };
        let mut record = Record::open(&at("run.json")).unwrap();
        let key = record.key(&stage, 0);
        assert!(!record.is_done(&stage, &key).unwrap());
        record.note(&stage, &key).unwrap();
        let record = Record::open(&at("run.json")).unwrap();
        assert!(record.is_done(&stage, &key).unwrap());
        assert!(!record.is_done(&stage, &record.key(&stage, 1)).unwrap());
        for name in ["in", "out"] {
            let kept = fs::read(at(name)).unwrap();
            fs::write(at(name), "changed").unwrap();
            assert!(!record.is_done(&stage, &key).unwrap(), "{name}");
            fs::write(at(name), kept).unwrap();
        }
        fs::remove_file(at("out")).unwrap();
        assert!(!record.is_done(&stage, &key).unwrap());
    }

    #[test]
    fn a_material_changes_with_its_maps() {
        let folder = tempfile::tempdir().unwrap();
        let material = folder.path().join("m.toml");
        fs::write(&material, "[maps]\nheight = \"h.png\"\n").unwrap();
        fs::write(folder.path().join("h.png"), "1").unwrap();
        let before = content_of(&material).unwrap();
        fs::write(folder.path().join("h.png"), "2").unwrap();
        assert_ne!(content_of(&material).unwrap(), before);
    }
}
