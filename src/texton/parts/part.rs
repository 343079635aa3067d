//! One part, read and checked.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::Result;
use crate::format::id::ContentId;
use crate::format::npz;
use crate::format::stored_array::StoredArray;
use crate::shard::Shard;
use crate::texton::parts::job::{FORMAT, Meta, VERSION};

/// One part, open for reading.
pub(super) struct Part {
    pub(super) path: PathBuf,
    pub(super) file: npz::Reader,
    pub(super) meta: Meta,
}

impl Part {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let mut file = npz::Reader::open(path)?;
        let told: Value = file.meta()?;
        if told["format"] != FORMAT {
            let found = format!("`{}`", told["format"].as_str().unwrap_or("no format"));
            return Err(file
                .fault("meta.json: format", found)
                .expected(format!("{FORMAT}, as `mesotex textons --shard` writes it")));
        }
        if told["version"] != VERSION {
            return Err(file
                .fault("meta.json: version", told["version"].to_string())
                .expected(VERSION.to_string()));
        }
        let meta = file.meta()?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            meta,
        })
    }

    /// An array of one shape, its checksum compared.
    pub(super) fn stored(&mut self, name: &str, shape: &[usize]) -> Result<StoredArray<f32>> {
        let stored = self.file.stored::<f32>(name)?;
        match stored.shape() == shape {
            true => Ok(stored),
            false => Err(self
                .file
                .fault(name, format!("shape {:?}", stored.shape()))
                .expected(format!(
                    "{shape:?}, as the sample and the options determine"
                ))),
        }
    }
}

/// What a part says of itself.
pub struct PartFile {
    /// Which share of the work it holds.
    pub shard: Shard,
    /// The options it was made with.
    pub options: Value,
    /// The id of its sample.
    pub sample: ContentId,
    /// The version of the program that made it.
    pub program: String,
    /// How many numbers it holds.
    pub numbers: usize,
}

impl PartFile {
    /// Reads a part and compares all its checksums.
    pub fn read(path: &Path) -> Result<Self> {
        let Part { mut file, meta, .. } = Part::open(path)?;
        let arrays = file.names().into_iter();
        let lengths = arrays.map(|name| Ok(file.stored::<f32>(&name)?.len()));
        let numbers = lengths.sum::<Result<usize>>()?;
        Ok(Self {
            shard: meta.shard,
            options: meta.job.options,
            sample: meta.job.sample,
            program: meta.job.program,
            numbers,
        })
    }
}
