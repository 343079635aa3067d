//! The extension of an output's name: it must fit the format that is written.

use std::path::Path;

use crate::error::{Error, Result};
use crate::format::mesh_formats;
use crate::format::ours::Format;
use crate::mesh::writing;

/// Endings that a reader takes for one kind of file, those of meshes apart.
const OF_FILES: [&str; 23] = [
    "bmp", "btf", "csv", "exr", "gif", "gz", "hdr", "htm", "html", "jpeg", "jpg", "json", "lp",
    "npy", "npz", "png", "ptm", "rti", "tif", "tiff", "toml", "usda", "zip",
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

/// Refuses the name of a folder that ends as a file, or as a folder of another kind, does; `own` is what folders of its
/// kind end in.
pub(super) fn check_folder(option: &str, path: &Path, own: Option<&str>) -> Result<()> {
    match ending_of(path) {
        Some(ending) if is_known(&ending) && own != Some(ending.as_str()) => {
            let expected = match own {
                Some(own) => {
                    format!("the name of a folder, as NAME.{own}, which is what this writes")
                }
                None => "the name of a folder, which this writes".into(),
            };
            Err(refusal(option, path, &ending, &expected))
        }
        _ => Ok(()),
    }
}

fn is_known(ending: &str) -> bool {
    OF_FILES.contains(&ending)
        || OF_FOLDERS.contains(&ending)
        || mesh_formats::has_extension(ending)
}

fn refusal(option: &str, path: &Path, ending: &str, expected: &str) -> Error {
    let found = format!("{}: ends in .{ending}", path.display());
    Error::option(option, found, expected)
}

/// Refuses a stem that the endings of several `products` are added to, and that already ends as a file or folder does.
pub(super) fn check_stem(option: &str, stem: &Path, products: &[&str]) -> Result<()> {
    match ending_of(stem) {
        Some(ending) if is_known(&ending) => {
            let plain = stem.with_extension("");
            let made: Vec<String> = products
                .iter()
                .map(|product| format!("{}.{product}", plain.display()))
                .collect();
            let expected = format!(
                "a name that endings are added to: {} makes {}",
                plain.display(),
                made.join(", ")
            );
            Err(refusal(option, stem, &ending, &expected))
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
        Format::Mesh => &writing::EXTENSIONS,
        Format::Ply => &["ply"],
        Format::Obj => &["obj"],
        Format::Scene => &["toml"],
        Format::Model => &["glb"],
        Format::Usda => &["usda"],
        Format::Page => &["html", "htm"],
        Format::Picture => &["png"],
        Format::Frame => &["exr"],
        Format::Json => &["json"],
        Format::Btf => &["btf"],
        Format::Ptm => &["ptm"],
        Format::Plan => &["sh", "smk"],
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
        let of_map = says(check_file("output", Path::new("map.obj"), Format::Ply));
        assert!(
            of_map.contains("ends in .obj; expected a name that ends in .ply"),
            "{of_map}"
        );
        let of_sample = |path: &str| says(check_folder("output", Path::new(path), Some("sample")));
        assert!(of_sample("a.npz").contains("as NAME.sample"));
        assert!(of_sample("a.atlas").contains("as NAME.sample"));
        assert_eq!(of_sample("a.sample"), "");
        let of_frames = says(check_folder("output", Path::new("a.sample"), None));
        assert!(of_frames.contains("the name of a folder"), "{of_frames}");
    }

    #[test]
    fn a_stem_has_no_ending_of_a_product() {
        let of_stem = |path: &str| says(check_stem("output", Path::new(path), &["sample"]));
        assert!(of_stem("x.sample").ends_with("x makes x.sample"));
        assert!(of_stem("x.npz").contains("ends in .npz"));
        assert_eq!(of_stem("v1.5"), "");
    }
}
