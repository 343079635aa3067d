//! Samples out as image sets: folders of images that other programs, and `import`, read.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`angle_folders`] | images by their angles, as UBO2003 and UTIA have them |
//! | [`table_folder`] | OpenEXR images with a table of angles |
//! | [`exported`] | what an export reports |
//! | [`reflectance`] | an image of a sample as the numbers that sets hold |
//!
//! Sets hold reflectance with the light's cosine in it: a white plane facing the light has 1. The folder
//! appears when it is complete, and replaces nothing but an empty folder.

mod angle_folders;
mod exported;
mod reflectance;
mod table_folder;

use std::fs;
use std::io;
use std::path::Path;

use serde::Serialize;

pub use crate::btf::image_sets::exported::Exported;

use crate::btf::image_sets::angle_folders::{Images, write_by_angles};
use crate::btf::image_sets::table_folder::write_with_table;
use crate::btf::sample::Sample;
use crate::error::Result;
use crate::format::atomic::folder::FolderInProgress;
use crate::progress::Progress;

/// A kind of image set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ImageSet {
    /// UBO2003: 8-bit JPEG in sRGB, a folder per view, whole degrees.
    Ubo2003,
    /// UTIA: 8-bit PNG in sRGB, a folder per view, whole degrees.
    Utia,
    /// UTIA's OpenEXR: half floats in XYZ (D65), a folder per view, whole degrees.
    UtiaExr,
    /// OpenEXR images, 32-bit floats in linear Rec. 709, with a table of angles: nothing is lost.
    Folder,
}

/// Writes a sample as the set `out`, which is exactly the folder.
pub fn export_set(
    sample: &Sample,
    set: ImageSet,
    out: &Path,
    progress: Progress<'_>,
) -> Result<Exported> {
    let folder = FolderInProgress::create(out, objection_to_replacing)?;
    progress.begin("exporting images", sample.image_count() as u64);
    let exported = match set {
        ImageSet::Ubo2003 => write_by_angles(sample, Images::Jpeg, folder.path(), progress)?,
        ImageSet::Utia => write_by_angles(sample, Images::Png, folder.path(), progress)?,
        ImageSet::UtiaExr => write_by_angles(sample, Images::Xyz, folder.path(), progress)?,
        ImageSet::Folder => write_with_table(sample, folder.path(), progress)?,
    };
    progress.end();
    folder.finish()?;
    Ok(exported)
}

/// Writes a sample as Bonn's UBO2003: JPEG files by their angles.
pub fn export_ubo2003(sample: &Sample, out: &Path) -> Result<Exported> {
    export_set(sample, ImageSet::Ubo2003, out, Progress::silent())
}

/// Writes a sample as UTIA's BTFs: PNG files by their angles.
pub fn export_utia(sample: &Sample, out: &Path) -> Result<Exported> {
    export_set(sample, ImageSet::Utia, out, Progress::silent())
}

/// Writes a sample as OpenEXR images with a table of angles.
pub fn export_folder(sample: &Sample, out: &Path) -> Result<Exported> {
    export_set(sample, ImageSet::Folder, out, Progress::silent())
}

/// Only an empty folder makes room for a set: images bear no mark of this program.
fn objection_to_replacing(folder: &Path) -> io::Result<Option<String>> {
    let is_empty = fs::read_dir(folder)?.next().is_none();
    Ok((!is_empty).then(|| "a folder that is not empty".into()))
}

#[cfg(test)]
mod tests;
