//! The ending of an output's name: it must not promise another format than is written.

use std::path::Path;

use crate::cli::outputs::{Output, Product};
use crate::error::{Error, Result};
use crate::format::ours::Format;

/// Endings that a reader takes for one kind of file.
const OF_FILES: [&str; 23] = [
    "bmp", "btf", "csv", "exr", "gif", "glb", "gltf", "hdr", "html", "jpeg", "jpg", "json", "npy",
    "npz", "obj", "off", "ply", "png", "ptm", "stl", "tif", "toml", "usda",
];
/// Endings of products that are folders.
const OF_FOLDERS: [&str; 2] = ["sample", "atlas"];

/// Refuses a name that ends as another kind of file or folder does.
pub(super) fn check(output: &Output) -> Result<()> {
    let Some(ending) = ending_of(&output.path) else {
        return Ok(());
    };
    let (is_wrong, expected) = match output.product {
        Product::File(format) => {
            let own = endings(format);
            let known = OF_FILES.iter().chain(&OF_FOLDERS);
            let is_known = known.into_iter().any(|known| *known == ending);
            (
                is_known && !own.contains(&ending.as_str()),
                own.join(" or ."),
            )
        }
        Product::Folder(_) | Product::NewFolder | Product::Frames => {
            let is_file = OF_FILES.contains(&ending.as_str());
            (is_file, String::new())
        }
    };
    if !is_wrong {
        return Ok(());
    }
    let found = format!("{}: ends in .{ending}", output.path.display());
    let expected = match expected.as_str() {
        "" => "the name of a folder, which this writes".to_owned(),
        endings => format!("a name that ends in .{endings}, which is what this writes"),
    };
    Err(Error::option(output.option, found, expected))
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
    use crate::btf::writer::SAMPLE_FOLDER;

    fn says(path: &str, product: Product) -> String {
        match check(&Output::new("output", Path::new(path), product)) {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn an_ending_of_another_format_is_refused() {
        let mesh = Product::File(Format::Mesh);
        assert!(says("bunny.stl", mesh).ends_with(
            "ends in .stl; expected a name that ends in .ply or .obj or .glb, which is what this writes"
        ));
        assert_eq!(says("bunny.map.ply", mesh), "");
        assert_eq!(says("bunny.map", mesh), "");
        assert!(says("a.npz", Product::Folder(&SAMPLE_FOLDER)).contains("the name of a folder"));
        assert_eq!(says("a.sample", Product::Folder(&SAMPLE_FOLDER)), "");
        assert!(says("a.sample", Product::File(Format::Archive)).contains(".npz"));
    }

    #[test]
    fn a_stem_has_no_ending_of_a_product() {
        assert!(check_stem("output", Path::new("x.sample")).is_err());
        assert!(check_stem("output", Path::new("x.npz")).is_err());
        assert!(check_stem("output", Path::new("v1.5")).is_ok());
    }
}
