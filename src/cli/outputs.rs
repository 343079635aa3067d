//! What a command reads and writes, declared before it touches anything; and the claim of its outputs.
//!
//! Nothing that a user owns is replaced: an output must be a free name, an empty file or folder, or
//! something of its kind that this program made. A folder is never replaced when it holds an input, or
//! lies in one.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::cli::endings;
use crate::cli::info::kind::Kind;
use crate::error::{Error, Result};
use crate::format::atomic::folder::repair;
use crate::format::atomic::standing::Standing;
use crate::format::atomic::{leftovers, parent};
use crate::format::lock::OutputLock;
use crate::format::ours::{Format, is_ours};
use crate::format::own_folder::OwnFolder;

/// Files and folders of one command.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Files {
    /// What it reads: every file whose bytes count, and folders of which the list of files counts.
    pub reads: Vec<PathBuf>,
    /// What it writes.
    pub writes: Vec<Output>,
    /// Inputs that must be of one kind.
    pub kinds: Vec<(PathBuf, &'static [Kind])>,
}

/// One output of a command.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// The option that names it.
    pub option: &'static str,
    /// Where it goes.
    pub path: PathBuf,
    /// What it is.
    pub product: Product,
    /// What its lock is named after; `None` where several runs may write it side by side.
    pub lock: Option<PathBuf>,
}

/// What is written at a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Product {
    /// A folder of one kind, replaced as a whole.
    Folder(&'static OwnFolder),
    /// A folder that appears as a whole, and replaces nothing but an empty one.
    NewFolder,
    /// A folder that frames are put into, one by one.
    Frames,
    /// A file.
    File(Format),
}

impl Output {
    /// An output that one run at a time writes.
    pub fn new(option: &'static str, path: &Path, product: Product) -> Self {
        Self {
            option,
            path: path.to_path_buf(),
            product,
            lock: Some(path.to_path_buf()),
        }
    }

    /// Refuses a name that promises something else than is written.
    fn check_ending(&self) -> Result<()> {
        match self.product {
            Product::File(format) => endings::check_file(self.option, &self.path, format),
            Product::Folder(kind) => endings::check_folder(self.option, &self.path, kind.ending),
            Product::NewFolder | Product::Frames => {
                endings::check_folder(self.option, &self.path, None)
            }
        }
    }

    /// Refuses to replace a file that this program did not write, or that the user edits.
    fn check_replaced(&self, format: Format, file: &Path) -> Result<()> {
        if is_ours(file, format).map_err(Error::io(file, "read"))? {
            return Ok(());
        }
        let found = match format {
            Format::Scene => "the file exists, and scenes are made to be edited".into(),
            _ => format!("an existing file, not a {} of this program", format.name()),
        };
        Err(self.refusal(found, "a free name (or delete the file first)"))
    }

    fn refusal(&self, found: impl Into<String>, expected: &str) -> Error {
        Error::option(
            self.option,
            format!("{}: {}", self.path.display(), found.into()),
            expected,
        )
    }
}

impl Files {
    /// Files that are read.
    #[must_use]
    pub fn read<'a>(mut self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        self.reads.extend(paths.into_iter().cloned());
        self
    }

    /// A file or folder that is read and must be of one of these kinds.
    #[must_use]
    pub fn read_as(mut self, kinds: &'static [Kind], path: &Path) -> Self {
        self.reads.push(path.to_path_buf());
        self.kinds.push((path.to_path_buf(), kinds));
        self
    }

    /// An output, where the option was given.
    #[must_use]
    pub fn write<'a>(
        mut self,
        option: &'static str,
        paths: impl IntoIterator<Item = &'a PathBuf>,
        product: Product,
    ) -> Self {
        let outputs = paths
            .into_iter()
            .map(|path| Output::new(option, path, product));
        self.writes.extend(outputs);
        self
    }

    /// Refuses outputs that would cost the user something, or that lie in a folder which neither exists
    /// nor is `made_first`; writes nothing. What stands at a path that is `vouched` for is known to be ours.
    pub fn check(&self, made_first: Option<&Path>, vouched: impl Fn(&Path) -> bool) -> Result<()> {
        for (place, output) in self.writes.iter().enumerate() {
            let folder = parent(&output.path);
            if !folder.is_dir() {
                if made_first == Some(folder) {
                    continue;
                }
                let found = format!("the folder {} does not exist", folder.display());
                return Err(Error::option(output.option, found, "an existing folder"));
            }
            if self.writes[..place]
                .iter()
                .any(|other| same(&other.path, &output.path))
            {
                return Err(output.refusal("given for two outputs", "another path"));
            }
            if self.reads.iter().any(|input| same(input, &output.path)) {
                return Err(output.refusal("is also an input", "another path"));
            }
            output.check_ending()?;
            if !vouched(&output.path) {
                self.check_standing(output)?;
            }
        }
        Ok(())
    }

    /// Checks what stands where an output goes.
    fn check_standing(&self, output: &Output) -> Result<()> {
        let standing = Standing::of(&output.path).map_err(Error::io(&output.path, "write"))?;
        match (output.product, standing) {
            (_, Standing::Nothing(_)) | (Product::Frames, Standing::Folder(_)) => Ok(()),
            (Product::Folder(kind), Standing::Folder(folder)) => {
                let objection = kind.objection(&folder);
                if let Some(found) = objection.map_err(Error::io(&folder, "read"))? {
                    let expected =
                        format!("a free name, an empty folder, or {} to replace", kind.name);
                    return Err(output.refusal(found, &expected));
                }
                self.check_apart(output, &folder)
            }
            (Product::NewFolder, Standing::Folder(folder)) => {
                let is_empty = fs::read_dir(&folder).map(|mut entries| entries.next().is_none());
                match is_empty.map_err(Error::io(&folder, "read"))? {
                    true => self.check_apart(output, &folder),
                    false => Err(output.refusal(
                        "a folder that is not empty",
                        "a free name (or delete the folder first)",
                    )),
                }
            }
            (Product::File(format), Standing::File(file)) => output.check_replaced(format, &file),
            (Product::File(_), standing) => {
                Err(output.refusal(standing.describe(), "the name of a file"))
            }
            (Product::Folder(_) | Product::NewFolder | Product::Frames, standing) => {
                Err(output.refusal(standing.describe(), "the name of a folder"))
            }
        }
    }

    /// Refuses to replace a folder that holds an input or lies in one.
    fn check_apart(&self, output: &Output, folder: &Path) -> Result<()> {
        let Ok(folder) = fs::canonicalize(folder) else {
            return Ok(());
        };
        for input in &self.reads {
            let Ok(read) = fs::canonicalize(input) else {
                continue;
            };
            let found = if read.starts_with(&folder) {
                format!("contains the input {}", input.display())
            } else if folder.starts_with(&read) {
                format!("is inside the input {}", input.display())
            } else {
                continue;
            };
            return Err(output.refusal(found, "a folder that is separate from all inputs"));
        }
        Ok(())
    }

    /// Refuses inputs of another kind than is asked for. What is not there, or of no known kind, is left to its
    /// reader, which knows more to say; and so are pipes, which can be read once.
    fn check_kinds(&self) -> Result<()> {
        let looked_at = self
            .kinds
            .iter()
            .filter(|(path, _)| path.is_file() || path.is_dir());
        for (path, expected) in looked_at {
            match Kind::of(path) {
                Ok(found) if !expected.contains(&found) => {
                    let names: Vec<_> = expected.iter().map(|kind| kind.name()).collect();
                    return Err(Error::data("", found.name())
                        .expected(names.join(" or "))
                        .in_file(path));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Claims every output for this run: checks them, removes what killed runs left beside them, and
    /// locks them.
    pub fn claim(&self) -> Result<Vec<OutputLock>> {
        self.check_kinds()?;
        self.check(None, |_| false)?;
        let mut locks = Vec::new();
        for output in &self.writes {
            if let Some(lock) = &output.lock {
                locks.push(OutputLock::acquire(&end_of_link(lock))?);
            }
            let target = end_of_link(&output.path);
            if matches!(output.product, Product::Folder(_) | Product::NewFolder) {
                repair(&target)?;
            }
            self.clear(&target, output.product);
        }
        Ok(locks)
    }

    fn clear(&self, target: &Path, product: Product) {
        let names: Vec<&OsStr> = self
            .writes
            .iter()
            .filter_map(|w| w.path.file_name())
            .collect();
        leftovers::remove(parent(target), &names);
        if product == Product::Frames {
            leftovers::remove(target, &[]);
        }
    }
}

/// Whether two paths name the same thing, there or not yet.
fn same(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        (Err(_), Err(_)) => placed(a) == placed(b),
        _ => false,
    }
}

/// A path whose folder is free of links.
fn placed(path: &Path) -> PathBuf {
    let folder = fs::canonicalize(parent(path)).unwrap_or_else(|_| parent(path).to_path_buf());
    folder.join(path.file_name().unwrap_or_default())
}

/// Where a link leads; any other path as it is.
fn end_of_link(path: &Path) -> PathBuf {
    match Standing::of(path) {
        Ok(Standing::File(end) | Standing::Folder(end)) => end,
        _ => path.to_path_buf(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::writer::SAMPLE_FOLDER;

    fn sample_at(folder: &Path) {
        fs::create_dir_all(folder).unwrap();
        fs::write(folder.join("btf.json"), "{\"format\": \"mesotex-btf\"}").unwrap();
    }

    fn refused(files: &Files) -> String {
        files.claim().unwrap_err().to_string()
    }

    #[test]
    fn a_folder_is_replaced_only_apart_from_all_inputs() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        sample_at(&at("x.sample"));
        let into = |reads: PathBuf| {
            Files::default().read([&reads]).write(
                "output",
                [&at("x.sample")],
                Product::Folder(&SAMPLE_FOLDER),
            )
        };
        into(at("elsewhere.lp")).claim().unwrap();
        assert!(refused(&into(at("x.sample/btf.json"))).contains("contains the input"));
        assert!(refused(&into(root.path().to_path_buf())).contains("is inside the input"));
        let roundabout = at("x.sample/../x.sample/btf.json");
        assert!(refused(&into(roundabout)).contains("contains the input"));
    }

    #[test]
    fn a_free_name_in_an_input_folder_will_do() {
        let root = tempfile::tempdir().unwrap();
        let new = root.path().join("x.sample");
        let files = Files::default().read([&root.path().to_path_buf()]);
        files
            .write("output", [&new], Product::Folder(&SAMPLE_FOLDER))
            .claim()
            .unwrap();
    }

    #[test]
    fn files_of_others_and_repeated_outputs_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        fs::write(at("scan.ply"), "ply\nformat ascii 1.0\nend_header\n").unwrap();
        let mesh = Product::File(Format::Mesh);
        let files = Files::default().write("output", [&at("scan.ply")], mesh);
        assert!(refused(&files).contains("not a mesh of this program"));
        let twice = Files::default().write("output", [&at("a"), &at("./a")], mesh);
        assert!(refused(&twice).contains("two outputs"));
        let folder = Files::default().write(
            "report",
            [&root.path().to_path_buf()],
            Product::File(Format::Json),
        );
        assert!(refused(&folder).contains("--report"));
        let device = Files::default().write(
            "output",
            [&PathBuf::from("/dev/null")],
            Product::Folder(&SAMPLE_FOLDER),
        );
        assert!(refused(&device).contains("device"));
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }
}
