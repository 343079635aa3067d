//! Lists inside archives: a `.lp` or `.csv` member that names the images beside it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::btf::import::family::Family;
use crate::btf::import::find_images::by_last_names;
use crate::btf::import::image_list::{ImageList, MeasuredImage};
use crate::btf::import::list_options::Handedness;
use crate::btf::import::listed::Listed;
use crate::btf::import::lists::extension;
use crate::btf::import::sets::listing::Listing;
use crate::btf::import::{image_table, light_positions};
use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::text;

/// The list of archives, by its path; `None` where there is none.
pub(super) fn find(listing: &Listing) -> Result<Option<&Path>> {
    match listing.lists.as_slice() {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        lists => {
            let names: Vec<_> = lists.iter().map(|path| path.to_string_lossy()).collect();
            Err(Error::data("lists", names.join(", "))
                .expected("exactly one, in an archive whose images do not have their angles in their names")
                .advice("unpack the archive and name the list"))
        }
    }
}

/// Reads the list of archives.
pub(super) fn read(listing: &Listing, path: &Path, handedness: Handedness) -> Result<ImageList> {
    // Read the list in its format.
    let path = path.to_path_buf();
    let bytes = listing.place.read(&path)?;
    let is_rti = extension(&path) == "lp";
    let (listed, notes) = guarded(&path, || {
        let text = text::of_bytes(&bytes)?.text;
        match is_rti {
            true => light_positions::parse(&text).map(|lights| (lights.listed, lights.notes)),
            false => image_table::parse(&text).map(|table| (table.listed, Vec::new())),
        }
    })?;
    // Find its images in the archive, and turn the directions to the sample's frame.
    let paths = paths(&listed, listing, &path).map_err(|error| error.in_file(&path))?;
    let measured = |(listed, path): (&Listed, PathBuf)| MeasuredImage {
        path,
        view: handedness.applied_to(listed.view),
        light: handedness.applied_to(listed.light),
    };
    Ok(ImageList {
        name: listing.name(),
        kind: if is_rti { "rti" } else { "images with angles" },
        family: Family::Any,
        is_set: false,
        handedness,
        images: listed.iter().zip(paths).map(measured).collect(),
        place: listing.place.clone(),
        positions: None,
        notes,
        facts: serde_json::Map::new(),
        path,
    })
}

/// The images of a list: as it names them, else by the last part of their names.
fn paths(listed: &[Listed], listing: &Listing, list: &Path) -> Result<Vec<PathBuf>> {
    let all: BTreeSet<&Path> = listing.images.iter().map(|i| i.path.as_path()).collect();
    let folder = list.parent().unwrap_or(Path::new(""));
    let as_named: Option<Vec<PathBuf>> = listed
        .iter()
        .map(|image| folder.join(image.file.replace('\\', "/")))
        .map(|path| all.contains(path.as_path()).then_some(path))
        .collect();
    match as_named {
        Some(paths) => Ok(paths),
        None => by_last_names(listed, all.into_iter().map(Path::to_path_buf)),
    }
}
