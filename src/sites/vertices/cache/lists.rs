//! Files of sealed lists of numbers: what the caches of a mesh are made of.
//!
//! Every list is bytes in an archive's member. The [seal](crate::format::seal) takes each by its checksum:
//! reading compares that with the bytes, and to hash hundreds of megabytes once more would take longer than
//! all else that reading does.

use std::fs;
use std::io;
use std::path::Path;

use bytemuck::Pod;
use ndarray::{Array1, ArrayView1};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};
use crate::format::atomic::leftovers;
use crate::format::npz;
use crate::format::seal::Seal;

/// Makes the folder of a file if need be, and removes what killed runs left in it.
pub fn make_folder(path: &Path) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
        leftovers::remove(folder, &[]);
    }
    Ok(())
}

/// Adds lists to a seal, in order.
pub fn seal(seal: &mut Seal, lists: &[(String, &[u8])]) -> io::Result<()> {
    for (name, bytes) in lists {
        add(seal, name, bytes.len(), npz::checksum_of_list(bytes)?);
    }
    Ok(())
}

fn add(seal: &mut Seal, name: &str, length: usize, checksum: u32) {
    seal.text(name, &format!("{length} {checksum}"));
}

/// Writes a file of lists with its `meta.json`.
pub fn write(path: &Path, meta: &impl Serialize, lists: &[(String, &[u8])]) -> Result<()> {
    let meta = serde_json::to_value(meta).map_err(super::not_json)?;
    let serde_json::Value::Object(meta) = meta else {
        return Err(Error::data("meta.json", "no object"));
    };
    let written = npz::write(path, meta, |writer| {
        lists
            .iter()
            .try_for_each(|(name, bytes)| writer.array(name, ArrayView1::from(*bytes)))
    });
    written.map(drop)
}

/// The lists of a file, sealed as they are read.
pub struct Lists {
    reader: npz::Reader,
    seal: Seal,
}

impl Lists {
    /// Opens a file that should have the seal begun.
    pub fn open(path: &Path, seal: Seal) -> Result<Self> {
        if !path.is_file() {
            return Err(Error::data("cache", "not a regular file").in_file(path));
        }
        Ok(Self {
            reader: npz::Reader::open(path)?,
            seal,
        })
    }

    /// The file's `meta.json`.
    pub fn meta<T: DeserializeOwned>(&mut self) -> Result<T> {
        self.reader.meta()
    }

    /// Reads the next list; lists are read in the order in which they were sealed.
    pub fn list<T: Pod>(&mut self, name: &str) -> Result<Vec<T>> {
        let bytes: Array1<u8> = self.reader.array(name)?;
        let bytes = bytes.as_slice().unwrap_or_default();
        if !bytes.len().is_multiple_of(size_of::<T>()) {
            return Err(self
                .reader
                .fault(name, format!("{} bytes", bytes.len()))
                .expected(format!("numbers of {} bytes", size_of::<T>())));
        }
        let checksum = self.reader.checksum(name).unwrap_or_default();
        add(&mut self.seal, name, bytes.len(), checksum);
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }

    /// The seal over all lists read.
    pub fn finish(self) -> Seal {
        self.seal
    }
}
