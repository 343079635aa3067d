//! `.npz` archives: several arrays and one `meta.json`, as `numpy.load` opens them.
//!
//! Written members are stored uncompressed and dated 1980-01-01, so that the same content is the
//! same bytes. Members are read where they lie, mapped. They may be deflated; an archive that expands
//! beyond what deflate does to real data is refused before it fills the memory.

use std::io::{self, Cursor, Read, Write};
use std::path::{Path, PathBuf};

use ndarray::{Array, ArrayView, Dimension};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::error::{Error, Result};
use crate::format::atomic::{self, Sink};
use crate::format::id::ContentId;
use crate::format::stored_array::{Bytes, MappedFile, StoredArray};
use crate::format::{json, npy};

const META: &str = "meta.json";

/// Expanded bytes allowed for each byte of the file, beside [`EXPANSION_BASE`].
const EXPANSION_FACTOR: u64 = 256;
/// Expanded bytes allowed in any case.
const EXPANSION_BASE: u64 = 256 << 20;

/// Bytes checked by one task.
const CHECKED: usize = 1 << 20;
/// Bytes written and hashed at once.
const WRITTEN: usize = 4 << 20;
/// Fewer bytes are hashed sooner than another thread wakes up.
const FEW: usize = 1 << 19;

/// An archive open for reading.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    file: MappedFile,
    archive: ZipArchive<Cursor<MappedFile>>,
    /// Bytes that may still be expanded.
    allowance: u64,
}

impl Reader {
    /// Opens an archive and checks its directory.
    pub fn open(path: &Path) -> Result<Self> {
        let file = MappedFile::open(path)?;
        let length = file.as_ref().len() as u64;
        let archive = ZipArchive::new(Cursor::new(file.clone())).map_err(|error| {
            Error::data("zip directory", error.to_string())
                .expected("an .npz file")
                .advice("the file is cut off or is no .npz")
                .in_file(path)
        })?;
        if archive.has_duplicate_names() {
            return Err(Error::data("zip directory", "a member stands in it twice").in_file(path));
        }
        Ok(Self {
            path: path.to_path_buf(),
            file,
            archive,
            allowance: length
                .saturating_mul(EXPANSION_FACTOR)
                .saturating_add(EXPANSION_BASE),
        })
    }

    /// Whether the archive has an array of this name.
    pub fn has(&self, name: &str) -> bool {
        self.archive.index_for_name(&member_name(name)).is_some()
    }

    /// Reads `meta.json`.
    pub fn meta<T: DeserializeOwned>(&mut self) -> Result<T> {
        let bytes = self.member(META)?;
        json::parse(bytes.as_ref()).map_err(|error| self.at(META, error))
    }

    /// Reads an array of `T` with `D`'s number of sides.
    pub fn array<T: npy::Element, D: Dimension>(&mut self, name: &str) -> Result<Array<T, D>> {
        let stored = self.stored::<T>(name)?;
        let array = stored.to_array().map_err(|error| self.at(name, error))?;
        array.into_dimensionality().map_err(|_| {
            let expected = D::NDIM.map_or("another".into(), |n| n.to_string());
            self.fault(name, format!("shape {:?}", stored.shape()))
                .expected(format!("{expected} sides"))
        })
    }

    /// An array of `T` that stays in the file, where that holds it uncompressed.
    pub fn stored<T: npy::Element>(&mut self, name: &str) -> Result<StoredArray<T>> {
        let bytes = self.member(&member_name(name))?;
        StoredArray::new(bytes).map_err(|error| self.at(name, error))
    }

    /// A fault in member `name` of this archive.
    pub fn fault(&self, name: &str, found: impl Into<String>) -> Error {
        Error::data(name, found).in_file(&self.path)
    }

    fn at(&self, name: &str, error: Error) -> Error {
        match error {
            Error::Data(mut fault) => {
                fault.place = format!("{name}: {}", fault.place);
                Error::Data(fault).in_file(&self.path)
            }
            other => other,
        }
    }

    /// A member's bytes, their checksum compared.
    fn member(&mut self, name: &str) -> Result<Bytes> {
        let Ok(member) = self.archive.by_name(name) else {
            return Err(self
                .fault(name, "missing")
                .expected("a member of this name"));
        };
        if let (CompressionMethod::Stored, Some(start)) =
            (member.compression(), member.data_start())
        {
            let (length, checksum) = (member.size(), member.crc32());
            drop(member);
            let end = usize::try_from(start.saturating_add(length)).unwrap_or(usize::MAX);
            let range = start as usize..end;
            let found = self.file.as_ref().get(range.clone()).map(checksum_of);
            return match found {
                Some(found) if found == checksum => Ok(Bytes::InFile(self.file.clone(), range)),
                Some(_) => Err(self
                    .fault(name, "its checksum is another")
                    .advice("the file is damaged; make it again")),
                None => Err(self.fault(name, "the file ends within it")),
            };
        }
        let mut bytes = Vec::new();
        let read = member.take(self.allowance + 1).read_to_end(&mut bytes);
        read.map_err(|error| self.fault(name, error.to_string()))?;
        if bytes.len() as u64 > self.allowance {
            return Err(self
                .fault(name, "it expands beyond all measure")
                .expected(format!(
                    "at most {EXPANSION_FACTOR} bytes a byte of the file"
                )));
        }
        self.allowance -= bytes.len() as u64;
        Ok(Bytes::Expanded(bytes))
    }
}

/// The CRC-32 of a member, its parts summed on all threads.
fn checksum_of(bytes: &[u8]) -> u32 {
    if bytes.len() <= CHECKED {
        return crc32fast::hash(bytes);
    }
    let hash = |part: &[u8]| {
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(part);
        hasher
    };
    let parts: Vec<_> = bytes.par_chunks(CHECKED).map(hash).collect();
    let mut whole = crc32fast::Hasher::new();
    parts.iter().for_each(|part| whole.combine(part));
    whole.finalize()
}

fn member_name(array: &str) -> String {
    format!("{array}.npy")
}

/// An archive under construction; [`write()`] makes one.
pub struct Writer<'a> {
    zip: ZipWriter<&'a mut Sink>,
    content: blake3::Hasher,
}

impl Writer<'_> {
    /// Adds an array.
    pub fn array<T: npy::Element, D: Dimension>(
        &mut self,
        name: &str,
        array: ArrayView<'_, T, D>,
    ) -> io::Result<()> {
        self.begin::<T>(name, array.shape())?;
        let array = array.as_standard_layout();
        let numbers = array
            .as_slice()
            .ok_or_else(|| io::Error::other("not in C order"))?;
        self.bytes(bytemuck::cast_slice(numbers))
    }

    /// Adds an array that comes in blocks, one after another in C order; each is dropped once it is written.
    pub fn blocks<T: npy::Element>(
        &mut self,
        name: &str,
        shape: &[usize],
        blocks: impl Iterator<Item = impl AsRef<[T]>>,
    ) -> io::Result<()> {
        self.begin::<T>(name, shape)?;
        let mut missing: usize = shape.iter().product();
        for block in blocks {
            let numbers = block.as_ref();
            self.bytes(bytemuck::cast_slice(numbers))?;
            missing = missing.saturating_sub(numbers.len());
        }
        match missing {
            0 => Ok(()),
            _ => Err(io::Error::other(format!("{name} lacks {missing} numbers"))),
        }
    }

    /// Begins the member of an array.
    fn begin<T: npy::Element>(&mut self, name: &str, shape: &[usize]) -> io::Result<()> {
        let bytes = shape.iter().product::<usize>() * size_of::<T>();
        let options = options(bytes as u64);
        self.zip.start_file(member_name(name), options)?;
        self.content.update(name.as_bytes());
        let mut header = Vec::new();
        npy::write_header::<T>(&mut header, shape)?;
        self.bytes(&header)
    }

    /// Writes to the archive and hashes at the same time, while the bytes are near.
    fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        if bytes.len() < FEW {
            self.content.update(bytes);
            return self.zip.write_all(bytes);
        }
        for bytes in bytes.chunks(WRITTEN) {
            let (zip, content) = (&mut self.zip, &mut self.content);
            let (written, _) = rayon::join(|| zip.write_all(bytes), || content.update_rayon(bytes));
            written?;
        }
        Ok(())
    }
}

/// Writes an archive: `fill` adds the arrays, and `meta` becomes `meta.json` with one more
/// field, `id`, the BLAKE3 of the arrays and of `meta`. Returns that id.
pub fn write(
    path: &Path,
    meta: Map<String, Value>,
    fill: impl FnOnce(&mut Writer<'_>) -> io::Result<()>,
) -> Result<ContentId> {
    let mut id = None;
    atomic::write_file(path, |sink| {
        let mut writer = Writer {
            zip: ZipWriter::new(sink),
            content: blake3::Hasher::new(),
        };
        fill(&mut writer)?;
        id = Some(finish(writer, meta)?);
        Ok(())
    })?;
    id.ok_or_else(|| Error::data("npz", "nothing was written").in_file(path))
}

fn finish(mut writer: Writer<'_>, mut meta: Map<String, Value>) -> io::Result<ContentId> {
    writer
        .content
        .update(serde_json::to_string(&meta)?.as_bytes());
    let id = ContentId::of_hash(&writer.content.finalize());
    meta.insert("id".into(), Value::String(id.to_string()));
    let text = serde_json::to_vec_pretty(&meta)?;
    writer.zip.start_file(META, options(text.len() as u64))?;
    writer.zip.write_all(&text)?;
    writer.zip.finish()?;
    Ok(id)
}

/// Stored, dated 1980-01-01, with 64-bit sizes only where they are needed.
fn options(bytes: u64) -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(zip::DateTime::default())
        .unix_permissions(0o644)
        .large_file(bytes > u64::from(u32::MAX) - (1 << 16))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array1, Array2, Ix1, Ix2};
    use serde_json::json;
    use std::fs::File;

    fn meta() -> Map<String, Value> {
        json!({"format": "mesotex-test", "version": 1})
            .as_object()
            .unwrap()
            .clone()
    }

    fn write_sample(path: &Path) -> ContentId {
        write(path, meta(), |w| {
            w.array("L0/labels", Array2::<u16>::from_elem((2, 3), 7).view())?;
            w.array("counts", Array1::<u32>::from(vec![1, 2]).view())
        })
        .unwrap()
    }

    #[test]
    fn archives_round_trip_with_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a.npz"), folder.path().join("b.npz"));
        let id = write_sample(&a);
        assert_eq!(write_sample(&b), id);
        assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
        let mut reader = Reader::open(&a).unwrap();
        let back: Value = reader.meta().unwrap();
        assert_eq!(back["id"], id.to_string());
        assert_eq!(reader.array::<u16, Ix2>("L0/labels").unwrap()[[1, 2]], 7);
        assert!(reader.has("counts") && !reader.has("gram"));
    }

    #[test]
    fn faults_name_file_and_member() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        write_sample(&path);
        let mut reader = Reader::open(&path).unwrap();
        for error in [
            reader.array::<f32, Ix1>("gram").unwrap_err(),
            reader.array::<f32, Ix1>("counts").unwrap_err(),
            reader.array::<u32, Ix2>("counts").unwrap_err(),
        ] {
            let text = error.to_string();
            assert!(text.contains("a.npz"), "{text}");
            assert!(text.contains("gram") || text.contains("counts"), "{text}");
        }
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        assert!(
            Reader::open(&path)
                .unwrap_err()
                .to_string()
                .contains("cut off")
        );
    }

    #[test]
    fn damaged_numbers_are_found_by_their_checksum() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        write_sample(&path);
        let mut bytes = std::fs::read(&path).unwrap();
        let seven = bytes.windows(4).position(|w| w == [7, 0, 7, 0]).unwrap();
        bytes[seven] = 8;
        std::fs::write(&path, bytes).unwrap();
        let mut reader = Reader::open(&path).unwrap();
        let error = reader.array::<u16, Ix2>("L0/labels").unwrap_err();
        assert!(error.to_string().contains("L0/labels"), "{error}");
        assert!(reader.stored::<u32>("counts").is_ok());
    }

    #[test]
    fn a_bomb_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bomb.npz");
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        zip.start_file("x.npy", SimpleFileOptions::default())
            .unwrap();
        npy::write_header::<u8>(&mut zip, &[600 << 20]).unwrap();
        for _ in 0..600 {
            zip.write_all(&vec![0; 1 << 20]).unwrap();
        }
        zip.finish().unwrap();
        let mut reader = Reader::open(&path).unwrap();
        let error = reader.array::<u8, Ix1>("x").unwrap_err().to_string();
        assert!(error.contains("beyond"), "{error}");
    }
}
