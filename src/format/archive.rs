//! Zip archives that users bring: any member, read on any thread, expanded in memory by itself.
//!
//! The directory is read once. Names that climb out of the archive, links, encrypted members and packings
//! other than deflate are refused, all of them named. A member that expands beyond what packed images do is
//! refused before it fills the memory.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use flate2::bufread::DeflateDecoder;
use zip::read::ZipFile;
use zip::{CompressionMethod, ZipArchive};

use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::positioned::PositionedFile;
use crate::format::zip_directory;

/// Expanded bytes allowed for each packed byte of a member, beside [`EXPANSION_BASE`].
const EXPANSION_FACTOR: u64 = 256;
/// Expanded bytes allowed for any member.
const EXPANSION_BASE: u64 = 32 << 20;
/// The most members looked at.
const MOST_MEMBERS: usize = 1_000_000;

/// An archive open for reading.
#[derive(Clone, Debug)]
pub struct Archive {
    file: PositionedFile,
    /// Sorted by name.
    members: Vec<Member>,
}

/// A file in the archive.
#[derive(Clone, Debug)]
struct Member {
    name: String,
    /// Its first byte in the archive.
    start: u64,
    packed: u64,
    length: u64,
    checksum: u32,
    is_deflated: bool,
}

impl Archive {
    /// Opens an archive and checks its directory.
    pub fn open(path: &Path) -> Result<Self> {
        let file = PositionedFile::open(path)?;
        let opened = file.file().try_clone().map_err(Error::io(path, "read"))?;
        let length = file.length();
        let members = guarded(path, || members(opened, length, path))?;
        Ok(Self { file, members })
    }

    /// The archive's own path.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The names of its files, sorted, with `/` between folders.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.members.iter().map(|member| member.name.as_str())
    }

    /// The length and the checksum (CRC-32) that the directory states of a file.
    pub fn stated(&self, name: &str) -> Result<(u64, u32)> {
        let member = self.member(name)?;
        Ok((member.length, member.checksum))
    }

    fn member(&self, name: &str) -> Result<&Member> {
        let place = self
            .members
            .binary_search_by(|member| member.name.as_str().cmp(name));
        match place {
            Ok(place) => Ok(&self.members[place]),
            Err(_) => Err(self.fault(name, "not in the archive")),
        }
    }

    /// Reads and expands a file; its length and checksum are compared.
    pub fn read(&self, name: &str) -> Result<Vec<u8>> {
        let member = self.member(name)?;
        let most = member
            .packed
            .saturating_mul(EXPANSION_FACTOR)
            .saturating_add(EXPANSION_BASE);
        if member.length > most {
            let found = format!("{} bytes packed into {}", member.length, member.packed);
            return Err(self
                .fault(name, found)
                .expected(format!("an image: at most {most} bytes")));
        }
        let mut packed = vec![0; member.packed as usize];
        self.file.read_at(member.start, &mut packed)?;
        let bytes = match member.is_deflated {
            false => packed,
            true => inflated(&packed, member.length)
                .map_err(|error| self.fault(name, error.to_string()))?,
        };
        let sound =
            bytes.len() as u64 == member.length && crc32fast::hash(&bytes) == member.checksum;
        match sound {
            true => Ok(bytes),
            false => Err(self
                .fault(name, "its length or checksum differs from the stated one")
                .advice("the archive is damaged; get it again")),
        }
    }

    fn fault(&self, name: &str, found: impl Into<String>) -> Error {
        Error::data(name, found).in_file(self.path())
    }
}

/// Expands deflated bytes, to one more than `length` at most.
fn inflated(packed: &[u8], length: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(length as usize);
    DeflateDecoder::new(packed)
        .take(length + 1)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The files of an archive of `length` bytes, sorted; all that cannot be read are told.
fn members(file: File, length: u64, path: &Path) -> Result<Vec<Member>> {
    let mut archive = zip_directory::open(file, "a zip archive of images")?;
    if archive.len() > MOST_MEMBERS {
        return Err(
            Error::data("zip directory", format!("{} members", archive.len()))
                .expected(format!("at most {MOST_MEMBERS}")),
        );
    }
    let (mut members, mut faults) = (Vec::new(), Vec::new());
    for place in 0..archive.len() {
        match member(&mut archive, place, length) {
            Ok(found) => members.extend(found),
            Err(fault) => faults.push(fault),
        }
    }
    if !faults.is_empty() {
        return Err(Error::Faults {
            path: path.to_path_buf(),
            lines: faults,
            usage: false,
        });
    }
    members.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(members)
}

/// A member that is a file; what is wrong with it in words.
fn member(
    archive: &mut ZipArchive<BufReader<File>>,
    place: usize,
    file_length: u64,
) -> std::result::Result<Option<Member>, String> {
    let file = archive
        .by_index_raw(place)
        .map_err(|error| format!("member {place}: {error}"))?;
    let name = file
        .name()
        .map_err(|error| format!("member {place}: {error}"))?
        .replace('\\', "/");
    if climbs(&name) || file.is_symlink() {
        return Err(format!("{name}: leads out of the archive"));
    }
    if file.is_dir() || name.ends_with('/') {
        return Ok(None);
    }
    let is_deflated = packing(&file).map_err(|fault| format!("{name}: {fault}"))?;
    let start = file.data_start().unwrap_or(u64::MAX);
    let packed = file.compressed_size();
    if start
        .checked_add(packed)
        .is_none_or(|end| end > file_length)
    {
        return Err(format!("{name}: the archive ends within it"));
    }
    Ok(Some(Member {
        start,
        packed,
        length: file.size(),
        checksum: file.crc32(),
        is_deflated,
        name,
    }))
}

/// Whether a member is deflated, else stored as it is.
fn packing<R: Read>(file: &ZipFile<'_, R>) -> std::result::Result<bool, String> {
    if file.encrypted() {
        return Err("encrypted; unpack the archive first".into());
    }
    match file.compression() {
        CompressionMethod::Stored => Ok(false),
        CompressionMethod::Deflated => Ok(true),
        other => Err(format!(
            "packed by {other}, not by deflate; unpack the archive first"
        )),
    }
}

/// Whether a name leads anywhere but into the archive.
fn climbs(name: &str) -> bool {
    let mut parts = name.split('/');
    name.starts_with('/') || name.contains([':', '\0']) || parts.any(|part| part == "..")
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;

    fn archive(members: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
        let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(method);
        for (name, bytes) in members {
            zip.start_file(*name, options).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    fn open(bytes: &[u8]) -> (tempfile::TempDir, Result<Archive>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.zip");
        std::fs::write(&path, bytes).unwrap();
        let opened = Archive::open(&path);
        (folder, opened)
    }

    fn refused(bytes: &[u8]) -> String {
        open(bytes).1.unwrap_err().to_string()
    }

    #[test]
    fn members_are_read_whatever_their_packing() {
        let long = vec![7; 100_000];
        for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
            let bytes = archive(&[("b/x.bmp", &long), ("a.txt", b"hello")], method);
            let (_folder, opened) = open(&bytes);
            let opened = opened.unwrap();
            assert_eq!(opened.names().collect::<Vec<_>>(), ["a.txt", "b/x.bmp"]);
            assert_eq!(opened.read("b/x.bmp").unwrap(), long);
            assert_eq!(opened.read("a.txt").unwrap(), b"hello");
            assert!(opened.read("c").unwrap_err().to_string().contains("not in"));
        }
    }

    #[test]
    fn cut_and_damaged_archives_are_refused() {
        let bytes = archive(&[("a.bmp", &[9; 1000])], CompressionMethod::Stored);
        assert!(refused(&bytes[..bytes.len() / 2]).contains("truncated"));
        assert!(refused(b"PK\x03\x04").contains("a zip archive"));
        let mut damaged = bytes.clone();
        damaged[200] ^= 1;
        let (_folder, opened) = open(&damaged);
        let error = opened.unwrap().read("a.bmp").unwrap_err().to_string();
        assert!(error.contains("a.bmp: its length or checksum"), "{error}");
    }

    #[test]
    fn every_name_that_climbs_is_told() {
        let bytes = archive(
            &[
                ("../up.jpg", b"x"),
                ("a/../../b.jpg", b"x"),
                ("fine.jpg", b"x"),
            ],
            CompressionMethod::Stored,
        );
        let error = refused(&bytes);
        assert!(
            error.contains("../up.jpg") && error.contains("a/../../b.jpg"),
            "{error}"
        );
        assert!(!error.contains("fine.jpg"));
        assert!(
            refused(&archive(&[("/etc/x", b"x")], CompressionMethod::Stored)).contains("leads out")
        );
    }

    #[test]
    fn bombs_do_not_go_off() {
        let zeros = vec![0; 48 << 20];
        let bytes = archive(&[("a.bmp", &zeros)], CompressionMethod::Deflated);
        let (_folder, opened) = open(&bytes);
        let error = opened.unwrap().read("a.bmp").map(|bytes| bytes.len());
        assert!(error.unwrap_err().to_string().contains("packed into"));
    }
}
