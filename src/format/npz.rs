//! `.npz` archives: several arrays and one `meta.json`, as `numpy.load` opens them.
//!
//! Written members are stored uncompressed and dated 1980-01-01, so that the same content is the
//! same bytes. Stored members are read where they lie, in pieces. Members may be deflated; an archive that expands
//! beyond what deflate does to real data is refused before it fills the memory.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use ndarray::{Array, ArrayD, ArrayView, Dimension, IxDyn};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::error::{Error, Result};
use crate::format::atomic::{self, Sink};
use crate::format::guard::guarded;
use crate::format::id::ContentId;
use crate::format::positioned::{PIECE, PositionedFile};
use crate::format::stored_array::{Bytes, StoredArray};
use crate::format::zip_sink::ZipSink;
use crate::format::{json, npy, zip_directory};

const META: &str = "meta.json";

/// Expanded bytes allowed for each byte of the file, beside [`EXPANSION_BASE`].
const EXPANSION_FACTOR: u64 = 256;
/// Expanded bytes allowed in any case.
const EXPANSION_BASE: u64 = 32 << 20;
/// The largest `meta.json` read, in bytes; a real one is a few kilobytes.
const MOST_META: u64 = 16 << 20;
/// Bytes in which the header of an array is looked for.
const HEADER: u64 = 1 << 16;

/// Bytes written and hashed at once.
const WRITTEN: usize = 4 << 20;
/// Fewer bytes are hashed sooner than another thread wakes up.
const FEW: usize = 1 << 19;

/// An archive open for reading.
#[derive(Debug)]
pub struct Reader {
    file: PositionedFile,
    archive: ZipArchive<BufReader<File>>,
    /// Bytes that may still be expanded.
    allowance: u64,
}

impl Reader {
    /// Opens an archive and checks its directory: no name stands in it twice, no two members share bytes.
    pub fn open(path: &Path) -> Result<Self> {
        let file = PositionedFile::open(path)?;
        let opened = file.file().try_clone().map_err(Error::io(path, "read"))?;
        let archive = guarded(path, || zip_directory::open(opened, "an .npz file"))?;
        let allowance = file
            .length()
            .saturating_mul(EXPANSION_FACTOR)
            .saturating_add(EXPANSION_BASE);
        Ok(Self {
            file,
            archive,
            allowance,
        })
    }

    /// Whether the archive has an array of this name.
    pub fn has(&self, name: &str) -> bool {
        self.archive.index_for_name(&member_name(name)).is_some()
    }

    /// The names of all arrays, sorted.
    pub fn names(&self) -> Vec<String> {
        let files = self.archive.file_names();
        let mut names: Vec<String> = files
            .filter_map(|name| Some(name.ok()?.strip_suffix(".npy")?.to_owned()))
            .collect();
        names.sort();
        names
    }

    /// Reads `meta.json`.
    pub fn meta<T: DeserializeOwned>(&mut self) -> Result<T> {
        let bytes = match self.member(META)? {
            Member::Stored(_, length, _) if length > MOST_META => {
                return Err(self
                    .fault(META, format!("{length} bytes"))
                    .expected(format!("at most {MOST_META}")));
            }
            Member::Stored(start, length, checksum) => {
                let mut bytes = vec![0; length as usize];
                self.read_checked(META, start, &mut bytes, checksum)?;
                bytes
            }
            Member::Expanded(bytes) => bytes,
        };
        guarded(self.file.path(), || json::parse(&bytes)).map_err(|error| self.at(META, error))
    }

    /// Reads an array of `T` with `D`'s number of sides.
    pub fn array<T: npy::Element, D: Dimension>(&mut self, name: &str) -> Result<Array<T, D>> {
        let array = self.whole::<T>(name)?;
        let shape = array.shape().to_vec();
        array.into_dimensionality().map_err(|_| {
            let expected = D::NDIM.map_or("another".into(), |n| n.to_string());
            self.fault(name, format!("shape {shape:?}"))
                .expected(format!("{expected} sides"))
        })
    }

    /// Reads a whole array, its checksum compared on the way.
    fn whole<T: npy::Element>(&mut self, name: &str) -> Result<ArrayD<T>> {
        let file = member_name(name);
        let (start, length, checksum) = match self.member(&file)? {
            Member::Stored(start, length, checksum) => (start, length, checksum),
            Member::Expanded(bytes) => {
                let read = guarded(self.file.path(), || npy::decode(&bytes));
                return read.map_err(|error| self.at(name, error));
            }
        };
        let mut head = vec![0; length.min(HEADER) as usize];
        self.file.read_at(start, &mut head)?;
        let header = guarded(self.file.path(), || {
            let header = npy::parse_header(&head, length)?;
            header.expect::<T>().map(|()| header)
        });
        let header = header.map_err(|error| self.at(name, error))?;
        head.truncate(header.data_offset);
        let mut numbers = vec![T::zeroed(); header.shape.iter().product()];
        let bytes = bytemuck::cast_slice_mut(&mut numbers);
        let found = self.read_hashed(start + head.len() as u64, bytes, crc_of(&head))?;
        self.compare(&file, found, checksum)?;
        ArrayD::from_shape_vec(IxDyn(&header.shape), numbers)
            .map_err(|error| self.fault(name, error.to_string()))
    }

    /// An array of `T` that stays in the file, where that holds it uncompressed.
    pub fn stored<T: npy::Element>(&mut self, name: &str) -> Result<StoredArray<T>> {
        let file = member_name(name);
        let bytes = match self.member(&file)? {
            Member::Stored(start, length, checksum) => {
                self.check(&file, start, length, checksum)?;
                Bytes::InFile(self.file.clone(), start..start + length)
            }
            Member::Expanded(bytes) => Bytes::Expanded(bytes),
        };
        let array = guarded(self.file.path(), || StoredArray::new(bytes));
        array.map_err(|error| self.at(name, error))
    }

    /// The checksum that the archive states for an array's member; reading the array compares it.
    pub fn checksum(&mut self, name: &str) -> Option<u32> {
        let member = self.archive.by_name(&member_name(name)).ok()?;
        Some(member.crc32())
    }

    /// A fault in member `name` of this archive.
    pub fn fault(&self, name: &str, found: impl Into<String>) -> Error {
        Error::data(name, found).in_file(self.file.path())
    }

    /// The same fault of data in member `name` of this archive.
    pub fn at(&self, name: &str, error: Error) -> Error {
        match error {
            Error::Data(mut fault) => {
                fault.place = format!("{name}: {}", fault.place);
                Error::Data(fault).in_file(self.file.path())
            }
            other => other,
        }
    }

    /// Finds a member; a compressed one is expanded.
    fn member(&mut self, name: &str) -> Result<Member> {
        let path = self.file.path().to_path_buf();
        let (archive, length, allowance) = (&mut self.archive, self.file.length(), self.allowance);
        let member = guarded(&path, || find(archive, name, length, allowance))?;
        if let Member::Expanded(bytes) = &member {
            self.allowance -= bytes.len() as u64;
        }
        Ok(member)
    }

    /// Compares a stored member's checksum.
    fn check(&self, name: &str, start: u64, length: u64, checksum: u32) -> Result<()> {
        let pieces = length.div_ceil(PIECE as u64);
        let parts: Vec<_> = (0..pieces)
            .into_par_iter()
            .map_init(Vec::new, |bytes: &mut Vec<u8>, piece| {
                let at = piece * PIECE as u64;
                bytes.resize((length - at).min(PIECE as u64) as usize, 0);
                self.file.read_at(start + at, bytes)?;
                Ok(crc_of(bytes))
            })
            .collect::<Result<_>>()?;
        let mut whole = crc32fast::Hasher::new();
        parts.iter().for_each(|part| whole.combine(part));
        self.compare(name, whole.finalize(), checksum)
    }

    /// Fills `bytes` from the place `at` of the file, and compares the checksum of all of them.
    fn read_checked(&self, name: &str, at: u64, bytes: &mut [u8], checksum: u32) -> Result<()> {
        let found = self.read_hashed(at, bytes, crc32fast::Hasher::new())?;
        self.compare(name, found, checksum)
    }

    /// Fills `bytes` from the place `at` of the file, on all threads; the checksum of what was `before`
    /// and of them.
    fn read_hashed(&self, at: u64, bytes: &mut [u8], before: crc32fast::Hasher) -> Result<u32> {
        let parts: Vec<_> = bytes
            .par_chunks_mut(PIECE)
            .enumerate()
            .map(|(piece, bytes)| {
                self.file.read_at(at + (piece * PIECE) as u64, bytes)?;
                Ok(crc_of(bytes))
            })
            .collect::<Result<_>>()?;
        let mut whole = before;
        parts.iter().for_each(|part| whole.combine(part));
        Ok(whole.finalize())
    }

    fn compare(&self, name: &str, found: u32, checksum: u32) -> Result<()> {
        if found == checksum {
            return Ok(());
        }
        Err(self
            .fault(name, "its checksum does not match")
            .advice("the file is damaged; make it again"))
    }
}

/// The bytes of a member, or where they are.
enum Member {
    /// In the file: first byte, length, CRC-32.
    Stored(u64, u64, u32),
    /// Expanded in memory, its checksum compared.
    Expanded(Vec<u8>),
}

/// Finds a member in a file of `file_length` bytes, and expands a compressed one to at most `allowance`
/// bytes.
fn find(
    archive: &mut ZipArchive<BufReader<File>>,
    name: &str,
    file_length: u64,
    allowance: u64,
) -> Result<Member> {
    let Ok(member) = archive.by_name(name) else {
        return Err(Error::data(name, "missing").expected("a member of this name"));
    };
    if let (CompressionMethod::Stored, Some(start)) = (member.compression(), member.data_start()) {
        let (length, checksum) = (member.size(), member.crc32());
        return match start.checked_add(length) {
            Some(end) if end <= file_length => Ok(Member::Stored(start, length, checksum)),
            _ => Err(Error::data(name, "the file ends within it")),
        };
    }
    let mut bytes = Vec::new();
    let read = member.take(allowance + 1).read_to_end(&mut bytes);
    read.map_err(|error| Error::data(name, error.to_string()))?;
    if bytes.len() as u64 > allowance {
        return Err(Error::data(name, "it expands too far").expected(format!(
            "at most {EXPANSION_FACTOR} bytes per byte of the file"
        )));
    }
    Ok(Member::Expanded(bytes))
}

/// A CRC-32 under way.
fn crc_of(bytes: &[u8]) -> crc32fast::Hasher {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(bytes);
    hasher
}

/// The checksum that the member of a list has once it is written.
pub fn checksum_of_list<T: npy::Element>(list: &[T]) -> io::Result<u32> {
    let mut header = Vec::new();
    npy::write_header::<T>(&mut header, &[list.len()])?;
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&header);
    hasher.update(bytemuck::cast_slice(list));
    Ok(hasher.finalize())
}

fn member_name(array: &str) -> String {
    format!("{array}.npy")
}

/// An archive under construction; [`write()`] makes one.
pub struct Writer<'a> {
    zip: ZipWriter<ZipSink<&'a mut Sink>>,
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
            zip: ZipWriter::new(ZipSink::new(sink)),
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
        let counts = checksum_of_list(&[1_u32, 2]).unwrap();
        assert_eq!(reader.checksum("counts"), Some(counts));
        assert_eq!(reader.checksum("gram"), None);
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
                .contains("truncated")
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
        assert!(error.contains("too far"), "{error}");
    }
}
