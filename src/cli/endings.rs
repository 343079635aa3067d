//! The ending of an output's name: it must not promise another format than is written.

use std::path::Path;

use crate::error::{Error, Result};
use crate::format::ours::Format;

/// Endings that a reader takes for one kind of file.
const OF_FILES: [&str; 23] = [
    "bmp", "btf", "csv", "exr", "gif", "glb", "gltf", "hdr", "html", "jpeg", "jpg", "json", "npy",
    "npz", "obj", "off", "ply", "png", "ptm", "stl", "tif", "toml", "usda",
];
/// Endings of products that are folders.
const OF_FOLDERS: [&str; 2] = ["sample", "atlas"];

/// Refuses the name of a file that ends as another kind of file, or a folder, does.
pub(super) fn check_file(option: &str, path: &Path, format: Format) -> Result<()> {
    let own = endings(format);
    match ending_of(path) {
        Some(ending) if is_known(&ending) && !own.contains(&ending.as_str()) => {
            let own = own.join(" or .");
            let expected = format!("a name that ends in .{own}, which is what this writes");
            Err(refusal(option, path, &ending, &expected))
        }
        _ => Ok(()),
    }
}

/// Refuses the name of a folder that ends as a file does.
pub(super) fn check_folder(option: &str, path: &Path) -> Result<()> {
    match ending_of(path) {
        Some(ending) if OF_FILES.contains(&ending.as_str()) => {
            let expected = "the name of a folder, which this writes";
            Err(refusal(option, path, &ending, expected))
        }
        _ => Ok(()),
    }
}

fn is_known(ending: &str) -> bool {
    OF_FILES.contains(&ending) || OF_FOLDERS.contains(&ending)
}

fn refusal(option: &str, path: &Path, ending: &str, expected: &str) -> Error {
    let found = format!("{}: ends in .{ending}", path.display());
    Error::option(option, found, expected)
}

/// Refuses a stem of several products that already ends as one of them.
pub(super) fn check_stem(option: &str, stem: &Path) -> Result<()> {
    match ending_of(stem) {
        Some(ending) if OF_FILES.contains(&ending.as_str()) || ending == "sample" => {
            let plain = stem.with_extension("");
            let found = format!("{}: ends in .{ending}", stem.display());
            let expected = format!(
                "a name that the endings of several products are added to: {0} makes {0}.sample, {0}.space.npz and \
                 {0}.knn.npz",
                plain.display()
            );
            Err(Error::option(option, found, expected))
        }
        _ => Ok(()),
    }
}

fn ending_of(path: &Path) -> Option<String> {
    let ending = path.extension()?.to_str()?;
    Some(ending.to_ascii_lowercase())
}

/// The endings that a format's files have.
fn endings(format: Format) -> &'static [&'static str] {
    match format {
        Format::Archive => &["npz"],
        Format::Mesh => &["ply", "obj", "glb"],
        Format::Model => &["glb"],
        Format::Usda => &["usda"],
        Format::Page => &["html", "htm"],
        Format::Picture => &["png"],
        Format::Frame => &["exr"],
        Format::Json => &["json"],
        Format::Btf => &["btf"],
        Format::Ptm => &["ptm"],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn says(checked: Result<()>) -> String {
        match checked {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn an_ending_of_another_format_is_refused() {
        let of_mesh = |path: &str| says(check_file("output", Path::new(path), Format::Mesh));
        assert_eq!(
            of_mesh("bunny.stl"),
            "--output: bunny.stl: ends in .stl; expected a name that ends in .ply or .obj or .glb, which is what this writes"
        );
        assert_eq!(of_mesh("bunny.map.ply"), "");
        assert_eq!(of_mesh("bunny.map"), "");
        assert!(of_mesh("a.sample").contains(".ply"));
        let of_folder = |path: &str| says(check_folder("output", Path::new(path)));
        assert!(of_folder("a.npz").contains("the name of a folder"));
        assert_eq!(of_folder("a.sample"), "");
    }

    #[test]
    fn a_stem_has_no_ending_of_a_product() {
        assert!(check_stem("output", Path::new("x.sample")).is_err());
        assert!(check_stem("output", Path::new("x.npz")).is_err());
        assert!(check_stem("output", Path::new("v1.5")).is_ok());
    }
}
