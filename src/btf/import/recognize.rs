//! What a path holds that `import` reads, told by its content: a file's first bytes, or what lies in a folder.
//!
//! Binary formats have a signature. Lists of images are text without one; they go by the ends of their
//! names (`.lp`, `.csv`, `.tsv`).

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::btf::import::lists::{extension, is_list, only_list_in};
use crate::error::{Error, Result};

/// How many of a file's first bytes are looked at.
const START: u64 = 64;
/// How many of them an error shows.
const SHOWN: usize = 12;

/// What is read, for errors.
const KNOWN: &str = "a zip archive of images (`PK`), a Bonn .btf file (`!DFMF`, `!FMF`, `!PVF`, `!BDI`), a PTM \
    (`PTM_`), an HSH .rti file (`#HSH`), an array (.npy), a list of images (.lp, .csv), or a folder that holds images or one list";

/// A source of measured images, and the path to read it from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// A `.lp` or `.csv` file that lists images.
    List(PathBuf),
    /// Folders and zip archives of one set of images, whose names state their directions.
    ImageSet(Vec<PathBuf>),
    /// A `.btf` file of the University of Bonn: DFMF, FMF, PVF or BDI.
    Bonn(PathBuf),
    /// A polynomial texture map.
    Ptm(PathBuf),
    /// Hemispherical harmonics, a `.rti` file.
    Hsh(PathBuf),
    /// An array of numpy, `.npy`.
    Array(PathBuf),
}

/// Says what is at `path`; refuses what is not read, with its first bytes and what would be.
pub(crate) fn recognize(path: &Path) -> Result<Source> {
    if path.is_dir() {
        return of_folder(path);
    }
    let start = start_of(path)?;
    let path = path.to_path_buf();
    Ok(match start.as_slice() {
        [b'P', b'K', 3, 4, ..] | [b'P', b'K', 5, 6, ..] => Source::ImageSet(vec![path]),
        [b'!', b'D' | b'F' | b'P' | b'B', ..] if is_bonn(&start) => Source::Bonn(path),
        [b'P', b'T', b'M', b'_', ..] => Source::Ptm(path),
        [b'#', b'H', b'S', b'H', ..] => Source::Hsh(path),
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Source::Array(path),
        _ if is_list(&path) => Source::List(path),
        _ if extension(&path) == "rti" && is_text(&start) => Source::Hsh(path),
        _ => return Err(unknown(&path, &start)),
    })
}

/// A folder that holds lists is read by its list; any other by the names of its images.
fn of_folder(folder: &Path) -> Result<Source> {
    Ok(match only_list_in(folder)? {
        Some(list) => Source::List(list),
        None => Source::ImageSet(vec![folder.to_path_buf()]),
    })
}

fn is_bonn(start: &[u8]) -> bool {
    let signatures: [&[u8]; 4] = [b"!DFMF", b"!FMF", b"!PVF", b"!BDI"];
    signatures
        .iter()
        .any(|signature| start.starts_with(signature))
}

fn is_text(start: &[u8]) -> bool {
    start
        .iter()
        .all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace())
}

fn start_of(path: &Path) -> Result<Vec<u8>> {
    let mut start = Vec::new();
    let file = File::open(path).map_err(Error::io(path, "read"))?;
    file.take(START)
        .read_to_end(&mut start)
        .map_err(Error::io(path, "read"))?;
    Ok(start)
}

/// Says what a file begins with, as bytes and as text.
fn unknown(path: &Path, start: &[u8]) -> Error {
    let shown = &start[..start.len().min(SHOWN)];
    let found = match shown {
        [] => "an empty file".into(),
        _ => {
            let bytes: Vec<String> = shown.iter().map(|byte| format!("{byte:02x}")).collect();
            format!(
                "first bytes {} (`{}`)",
                bytes.join(" "),
                shown.escape_ascii()
            )
        }
    };
    Error::data("source", found).expected(KNOWN).in_file(path)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn signatures_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).unwrap();
            recognize(&path).map_err(|error| error.to_string())
        };
        let at = |name: &str| folder.path().join(name);
        assert_eq!(
            of("a.x", b"PK\x03\x04...."),
            Ok(Source::ImageSet(vec![at("a.x")]))
        );
        assert_eq!(of("b.x", b"!DFMF08FCR..."), Ok(Source::Bonn(at("b.x"))));
        assert_eq!(of("c.x", b"PTM_1.2\n"), Ok(Source::Ptm(at("c.x"))));
        assert_eq!(of("d.x", b"#HSH1.2\n3\n"), Ok(Source::Hsh(at("d.x"))));
        assert_eq!(
            of("d.npy", b"\x93NUMPY\x01"),
            Ok(Source::Array(at("d.npy")))
        );
        assert_eq!(of("e.rti", b"3\n512 512 3\n"), Ok(Source::Hsh(at("e.rti"))));
        assert_eq!(
            of("f.LP", b"1\na.jpg 0 0 1\n"),
            Ok(Source::List(at("f.LP")))
        );
        let refused = of("g.btf", b"\x89HDF\r\n\x1a\n").unwrap_err();
        for says in ["g.btf", "89 48 44 46", "\\x89HDF", "!DFMF", "PTM_", ".lp"] {
            assert!(refused.contains(says), "{says}: {refused}");
        }
        assert!(of("h.rti", b"\x00\x01").unwrap_err().contains("00 01"));
        assert!(of("i.x", b"").unwrap_err().contains("empty"));
    }

    #[test]
    fn folders_go_by_what_they_hold() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().to_path_buf();
        let set = Source::ImageSet(vec![path.clone()]);
        assert_eq!(recognize(&path).unwrap(), set);
        fs::write(path.join("a.csv"), "").unwrap();
        assert_eq!(recognize(&path).unwrap(), Source::List(path.join("a.csv")));
        fs::write(path.join("b.lp"), "").unwrap();
        assert!(
            recognize(&path)
                .unwrap_err()
                .to_string()
                .contains("just one")
        );
    }
}
