//! Measured image sets in, BTF samples out.
//!
//! [`mod@recognize`] says what a path is. A *source* lists its images, each with the view and light it was taken
//! under; [`assemble`] turns the list into a sample, image by image.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`mod@recognize`], [`lists`] | what a path holds |
//! | [`light_positions`], [`image_table`], [`near_field`], [`find_images`] | lists: RTI captures, tables of angles or positions |
//! | [`sets`], [`family`] | folders and archives whose names say the angles |
//! | [`image_list`], [`place`] | what every source hands on |
//! | [`image_reader`], [`size_line`], [`spectrum`] | an image as linear Rec. 709 |
//! | [`prepare`] | crop, downsampling, grey card, hot pixels, choice of directions |
//! | [`photographs`] | photographs of a patch, rectified |
//! | [`stations`] | images of near cameras and lamps, resampled |
//! | [`mod@array`], [`stated_directions`], [`curve`] | arrays, and what the user says of sources without image files |
//! | [`arrangement`], [`fill`], [`subject`], [`assemble`], [`reading_faults`] | the sample |
//! | [`destination`], [`shard_images`], [`list_ids`] | the part of a sample that one of several runs makes |

mod arrangement;
pub mod array;
mod assemble;
pub(in crate::btf) mod curve;
pub(in crate::btf) mod destination;
mod family;
mod fill;
mod find_images;
mod image_list;
mod image_reader;
mod image_table;
pub(in crate::btf) mod light_positions;
mod list_ids;
mod list_options;
mod listed;
mod lists;
mod near_field;
mod options;
pub(crate) mod photographs;
mod place;
mod prepare;
mod reading_faults;
pub(crate) mod recognize;
mod sets;
mod shard_images;
mod size_line;
mod spectrum;
pub(crate) mod stated_directions;
mod stations;
mod subject;

use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

pub use crate::btf::import::assemble::assemble;
pub(crate) use crate::btf::import::assemble::foresee;
pub use crate::btf::import::destination::Destination;
pub use crate::btf::import::family::Family;
pub use crate::btf::import::image_list::{ImageList, MeasuredImage};
pub use crate::btf::import::list_options::{Handedness, ListOptions};
pub use crate::btf::import::lists::lists_in;
pub use crate::btf::import::options::{ImportOptions, Values};
pub use crate::btf::import::place::Place;
pub use crate::btf::import::prepare::{GreyCard, Preparation, Region, Selection};
pub use crate::btf::import::sets::{Numbering, SetOptions, is_set, read_set};
pub use crate::btf::import::size_line::SizeLine;
pub use crate::btf::import::spectrum::Illuminant;
pub use crate::format::image::SourceEncoding;
pub use list_options::PatchSize;
pub use photographs::{LensOptions, PhotographOptions, Rectification};

use crate::btf::import::find_images::Found;
use crate::btf::import::listed::Listed;
use crate::btf::import::lists::{extension, is_list, only_list_in};
use crate::btf::import::near_field::NearPositions;
use crate::btf::import::recognize::{Source, recognize};
use crate::btf::parts::{self, Maker};
use crate::btf::sample::Description;
use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::text::{self, TextEncoding};
use crate::progress::Progress;

/// The largest list read, in bytes.
const LARGEST_LIST: u64 = 64 << 20;

/// Lists the images of `paths`: by a list, or by their names in folders and archives.
pub fn read_source(
    paths: &[impl AsRef<Path>],
    list: &ListOptions,
    set: &SetOptions,
) -> Result<ImageList> {
    match source_of(paths, set)? {
        Source::List(path) => {
            check_unused(set.given(), "a folder or an archive of images")?;
            read_list_with(&path, list)
        }
        Source::ImageSet(paths) => {
            check_unused(list.given(), "a list of images")?;
            read_set(&paths, set, list.handedness)
        }
        Source::Bonn(path) | Source::Ptm(path) | Source::Hsh(path) | Source::Array(path) => {
            Err(Error::data("source", "a file without images of its own")
                .expected("a list, a folder or an archive of images")
                .in_file(&path))
        }
    }
}

/// What paths are. A folder is a set of images where the user says how to read their names. Several paths are one set.
pub(crate) fn source_of(paths: &[impl AsRef<Path>], set: &SetOptions) -> Result<Source> {
    let of_path = |path: &Path| match path.is_dir() && set.given().is_some() {
        true => Ok(Source::ImageSet(vec![path.to_path_buf()])),
        false => recognize(path),
    };
    if let [path] = paths {
        return of_path(path.as_ref());
    }
    let mut all = Vec::new();
    for path in paths.iter().map(AsRef::as_ref) {
        match of_path(path)? {
            Source::ImageSet(paths) => all.extend(paths),
            _ => {
                return Err(Error::data("source", "one of several paths")
                    .expected("several folders or zip archives of one set of images, or one path of any other kind")
                    .advice("join lists to one, and import it alone")
                    .in_file(path));
            }
        }
    }
    Ok(Source::ImageSet(all))
}

/// Joins the parts of all shards to the sample `target`, as one run imports it; returns its description. Refuses parts
/// of other imports than the first, and shards that are missing or there twice.
pub fn join(parts: &[PathBuf], target: &Path, progress: Progress<'_>) -> Result<Description> {
    parts::join(parts, Maker::Import, target, progress)
}

/// Refuses an option that is for other sources.
pub(crate) fn check_unused(given: Option<&str>, wanted: &str) -> Result<()> {
    match given {
        None => Ok(()),
        Some(flag) => Err(Error::option(
            flag,
            "without effect for this source",
            wanted,
        )),
    }
}

/// Reads the image list of `path`: a `.lp` or `.csv` file, or a folder that holds just one.
pub fn read_list(path: &Path) -> Result<ImageList> {
    read_list_with(path, &ListOptions::default())
}

/// The same with what the user says of it.
pub fn read_list_with(path: &Path, options: &ListOptions) -> Result<ImageList> {
    let list = match path.is_dir() {
        true => only_list_in(path)?.ok_or_else(|| {
            Error::data("source", "0 .lp and .csv files")
                .expected("just one")
                .in_file(path)
        })?,
        false => path.to_path_buf(),
    };
    match is_list(&list) {
        true => guarded(&list, || read(&list, options)),
        false => Err(
            Error::data("source", format!("a file of kind `.{}`", extension(&list)))
                .expected("a folder, a .lp file (RTI) or a .csv file of angles")
                .in_file(path),
        ),
    }
}

fn read(path: &Path, options: &ListOptions) -> Result<ImageList> {
    // Read the list in its format.
    let text::Text { text, encoding } = text::read(path, LARGEST_LIST)?;
    let is_rti = extension(path) == "lp";
    let ListText {
        listed,
        mut notes,
        positions,
        facts,
    } = match is_rti {
        true => of_lights(&text, options)?,
        false => of_table(&text, options)?,
    };
    if encoding == TextEncoding::Latin1 {
        notes.push("the list is not UTF-8; its names are read as Latin-1".into());
    }
    // Find its images.
    let folder = path.parent().unwrap_or(Path::new(""));
    let Found { paths, note } = match &options.images {
        Some(source) => find_images::from(&listed, source)?,
        None => find_images::find(&listed, folder)?,
    };
    notes.extend(note);
    // Turn the directions to the sample's frame.
    let measured = |(listed, path): (&Listed, PathBuf)| {
        let view = match options.collocated {
            true => listed.light,
            false => listed.view,
        };
        MeasuredImage {
            path,
            view: options.handedness.applied_to(view),
            light: options.handedness.applied_to(listed.light),
        }
    };
    Ok(ImageList {
        name: if is_rti {
            folder_name(path)
        } else {
            own_name(path)
        },
        path: path.to_path_buf(),
        kind: if is_rti { "rti" } else { "images with angles" },
        family: Family::Any,
        handedness: options.handedness,
        images: listed.iter().zip(paths).map(measured).collect(),
        place: Place::default(),
        is_set: false,
        positions,
        notes,
        facts,
    })
}

/// What the text of a list says.
struct ListText {
    listed: Vec<Listed>,
    notes: Vec<String>,
    positions: Option<NearPositions>,
    facts: Map<String, Value>,
}

/// A `.lp` file: directions to distant lights.
fn of_lights(text: &str, options: &ListOptions) -> Result<ListText> {
    let of_positions = [
        ("patch-mm", options.patch_mm.is_some()),
        ("near-field", options.near_field.is_some()),
    ];
    if let Some((option, _)) = of_positions.iter().find(|(_, is_given)| *is_given) {
        return Err(near_field::without_positions(option));
    }
    let lights = light_positions::parse(text)?;
    Ok(ListText {
        listed: lights.listed,
        notes: lights.notes,
        positions: None,
        facts: Map::new(),
    })
}

/// A table of angles or positions; positions are kept where the images are to be resampled.
fn of_table(text: &str, options: &ListOptions) -> Result<ListText> {
    let table = match options.collocated {
        true => image_table::parse_collocated(text)?,
        false => image_table::parse(text)?,
    };
    let spread = near_field::spread(&table, options.patch_mm)?;
    let mut notes: Vec<String> = near_field::note(&table, &spread).into_iter().collect();
    let mut positions = None;
    if near_field::is_beyond(&spread, options.near_field)? {
        let of_patch = |patch| NearPositions::of(&table, patch, options.handedness);
        positions = options.patch_mm.map(of_patch);
        notes.push(near_field::RESAMPLED.into());
    }
    Ok(ListText {
        listed: table.listed,
        notes,
        positions,
        facts: spread.iter().map(near_field::Spread::fact).collect(),
    })
}

/// A capture's name: its folder's, since most `.lp` files are called `dirs` or `lights`.
fn folder_name(path: &Path) -> String {
    let folder = std::fs::canonicalize(path)
        .ok()
        .and_then(|path| Some(path.parent()?.file_name()?.to_string_lossy().into_owned()));
    folder.unwrap_or_else(|| "rti".into())
}

fn own_name(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
