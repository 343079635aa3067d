//! Folders that this program writes as a whole: which files belong to one, and whether one may be replaced.
//!
//! A folder is recognised by its description, a JSON file whose field `format` names the kind. Images that the
//! description lists (`channels[…].file`) belong to it where they bear the program's mark: a picture that someone
//! painted over is theirs.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::format::json;
use crate::format::ours::{Format, is_ours};

/// A kind of folder.
#[derive(Debug, PartialEq, Eq)]
pub struct OwnFolder {
    /// What a message calls it, with its article.
    pub name: &'static str,
    /// What its name ends in, where that tells the kind.
    pub ending: Option<&'static str>,
    /// The file that says what the folder is.
    pub description: &'static str,
    /// The field `format` of that file.
    pub format: &'static str,
    /// The other files of every such folder.
    pub members: &'static [&'static str],
}

impl OwnFolder {
    /// Says why what is in a folder must not be replaced by another of this kind; `None` where it may:
    /// the folder is empty, or holds one of this kind and nothing else.
    pub fn objection(&self, folder: &Path) -> io::Result<Option<String>> {
        if let Some(name) = self.foreign_member(folder)? {
            return Ok(Some(format!(
                "a folder that holds `{name}`, which is not part of {}",
                self.name
            )));
        }
        if fs::read_dir(folder)?.next().is_none() || self.is_told_by(folder) {
            return Ok(None);
        }
        Ok(Some(format!(
            "a folder without a {} of this program",
            self.description
        )))
    }

    /// Something in a folder that is no part of this kind; the first by name.
    pub fn foreign_member(&self, folder: &Path) -> io::Result<Option<String>> {
        let listed = self.listed(folder);
        let mut foreign = Vec::new();
        for entry in fs::read_dir(folder)? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            let is_known = name == self.description
                || self.members.contains(&name.as_str())
                || (listed.contains(&name) && is_our_image(&folder.join(&name))?);
            if !is_known {
                foreign.push(name);
            }
        }
        Ok(foreign.into_iter().min())
    }

    /// The files of this kind that a folder holds.
    pub fn files(&self, folder: &Path) -> Vec<PathBuf> {
        let members = self.members.iter().map(|name| (*name).to_owned());
        let mut names: Vec<String> = members.chain(self.listed(folder)).collect();
        names.push(self.description.into());
        let paths = names.into_iter().map(|name| folder.join(name));
        paths.filter(|path| path.is_file()).collect()
    }

    /// Whether a folder's description names this kind.
    pub fn is_told_by(&self, folder: &Path) -> bool {
        let told = json::read::<Value>(&folder.join(self.description));
        told.is_ok_and(|told| told["format"] == self.format)
    }

    /// The images that a folder's description lists.
    fn listed(&self, folder: &Path) -> Vec<String> {
        let told = json::read::<Value>(&folder.join(self.description)).unwrap_or_default();
        let channels = told["channels"].as_array().into_iter().flatten();
        let files = channels.filter_map(|channel| channel["file"].as_str());
        files
            .filter(|file| is_plain_name(file))
            .map(String::from)
            .collect()
    }
}

/// Whether a name leads nowhere but into the folder it stands in.
pub fn is_plain_name(name: &str) -> bool {
    !name.is_empty() && !name.starts_with('.') && !name.contains(['/', '\\', ':', '\0'])
}

fn is_our_image(path: &Path) -> io::Result<bool> {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("png") => is_ours(path, Format::Picture),
        Some("exr") => is_ours(path, Format::Frame),
        _ => Ok(false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::write_png;

    const KIND: OwnFolder = OwnFolder {
        name: "a set of textures",
        ending: None,
        description: "set.json",
        format: "mesotex-test",
        members: &["a.npy"],
    };

    #[test]
    fn only_folders_of_the_kind_are_replaced() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        let objection = || KIND.objection(root.path()).unwrap();
        assert_eq!(objection(), None);
        fs::write(at("a.npy"), "x").unwrap();
        assert!(objection().unwrap().contains("without a set.json"));
        let told = "{\"format\": \"mesotex-test\", \"channels\": [{\"file\": \"color.png\"}, {\"file\": \"../b\"}]}";
        fs::write(at("set.json"), told).unwrap();
        write_png(&at("color.png"), 1, 1, &[7]).unwrap();
        assert_eq!(objection(), None);
        assert_eq!(KIND.files(root.path()).len(), 3);
        // Someone painted over it.
        fs::write(at("color.png"), b"\x89PNG\r\n\x1a\n").unwrap();
        assert!(objection().unwrap().contains("`color.png`"));
        write_png(&at("color.png"), 1, 1, &[7]).unwrap();
        fs::write(at("thesis.tex"), "x").unwrap();
        assert!(objection().unwrap().contains("`thesis.tex`"));
    }
}
