//! Measured image sets in, BTF samples out.
//!
//! A *source* lists its images, each with the view and light it was taken under; [`assemble`]
//! turns the list into a sample. One file per source: [`light_positions`] (RTI captures),
//! [`image_table`] (a folder of rectified images with a table of angles); [`find_images`] looks for what
//! they name. [`recognize`] says which source a path is.

pub(crate) mod assemble;
mod find_images;
mod image_table;
mod light_positions;
mod list_options;
mod listed;
mod lists;
pub(crate) mod recognize;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use crate::btf::import::list_options::{Handedness, ListOptions};
pub use crate::btf::import::lists::lists_in;

use crate::btf::direction::Direction;
use crate::btf::import::find_images::Found;
use crate::btf::import::listed::Listed;
use crate::btf::import::lists::{extension, is_list, only_list_in};
use crate::btf::sample::DType;
use crate::error::{Error, Result};
use crate::format::guard::guarded;
pub use crate::format::image::SourceEncoding;
use crate::format::image::{Alpha, Flags, Orientation, ReadOptions};
use crate::format::text::{self, TextEncoding};

/// The largest list read, in bytes.
const LARGEST_LIST: u64 = 64 << 20;

/// How an image set becomes a sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct ImportOptions {
    /// What the images' numbers mean: reflectance times the light's cosine, where a white plane
    /// facing the light has 1 (divided by π), or radiance for unit irradiance (taken as it is).
    #[arg(long, value_enum, default_value_t = ImportOptions::default().values)]
    pub values: Values,
    /// How the images' numbers stand for light.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().encoding)]
    pub encoding: SourceEncoding,
    /// Which way up images are read. A camera's orientation tag may differ from shot to shot of one
    /// capture, and lights are stated in the stored image's frame: so rows are read as stored.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().orientation)]
    pub orientation: Orientation,
    /// What becomes of texels that are not opaque.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().alpha)]
    pub alpha: Alpha,
    /// The layer, part or view of OpenEXR images that have several; `mesotex info IMAGE` lists them.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Opposite borders of the images continue each other.
    #[arg(long)]
    pub tileable: bool,
    /// Side of a texel in millimetres, where known.
    #[arg(long)]
    pub texel_mm: Option<f64>,
    /// What the material is called; the source's own name by default.
    #[arg(long)]
    pub name: Option<String>,
    /// Number type of the sample.
    #[arg(long, value_enum, default_value_t = ImportOptions::default().dtype)]
    pub dtype: DType,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            values: Values::default(),
            encoding: SourceEncoding::default(),
            orientation: Orientation::Stored,
            alpha: Alpha::default(),
            layer: None,
            tileable: false,
            texel_mm: None,
            name: None,
            dtype: DType::default(),
        }
    }
}

impl ImportOptions {
    /// How each image is read.
    fn reading(&self) -> ReadOptions {
        ReadOptions {
            encoding: self.encoding,
            orientation: self.orientation,
            alpha: self.alpha,
            layer: self.layer.clone(),
            flags: Flags {
                layer: "--layer",
                encoding: "--encoding",
                alpha: "--alpha",
                orientation: "--orientation",
            },
            ..ReadOptions::default()
        }
    }
}

/// What the images' numbers mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Values {
    /// Reflectance times the light's cosine: a white plane facing the light has 1.
    #[default]
    Reflectance,
    /// Radiance for unit irradiance: a white plane facing the light has 1/π.
    Radiance,
}

/// One measured image.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredImage {
    /// The image file.
    pub path: PathBuf,
    /// Where it was seen from.
    pub view: Direction,
    /// Where the light stood.
    pub light: Direction,
}

/// Everything a source says of its images.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageList {
    /// The source's own name.
    pub name: String,
    /// The file that lists the images.
    pub path: PathBuf,
    /// The kind of source, for `btf.json`.
    pub kind: &'static str,
    /// Which way the list's y axis was taken to point, for `btf.json`.
    pub handedness: Handedness,
    /// The images, in the source's order.
    pub images: Vec<MeasuredImage>,
    /// What the user should know of the list.
    pub notes: Vec<String>,
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
    let text::Text { text, encoding } = text::read(path, LARGEST_LIST)?;
    let is_rti = extension(path) == "lp";
    let (listed, mut notes) = match is_rti {
        true => light_positions::parse(&text).map(|lights| (lights.listed, lights.notes))?,
        false => (image_table::parse(&text)?, Vec::new()),
    };
    if encoding == TextEncoding::Latin1 {
        notes.push("the list is no UTF-8; its names are read as Latin-1".into());
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let Found { paths, note } = match &options.images {
        Some(source) => find_images::from(&listed, source)?,
        None => find_images::find(&listed, folder)?,
    };
    notes.extend(note);
    let measured = |(listed, path): (&Listed, PathBuf)| MeasuredImage {
        path,
        view: options.handedness.applied_to(listed.view),
        light: options.handedness.applied_to(listed.light),
    };
    Ok(ImageList {
        name: if is_rti {
            folder_name(path)
        } else {
            own_name(path)
        },
        path: path.to_path_buf(),
        kind: if is_rti { "rti" } else { "images with angles" },
        handedness: options.handedness,
        images: listed.iter().zip(paths).map(measured).collect(),
        notes,
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
