//! Image sets: folders and archives of rectified images whose names say how they were taken.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`listing`] | the images of folders and zip archives |
//! | [`angles`] | the angles of one image, checked and ordered |
//! | [`angle_names`] | angles by the names of Bonn's and UTIA's sets |
//! | [`pattern`] | angles by a pattern of the user |
//! | [`archived_list`] | lists inside archives |
//! | [`curet`], [`curet_directions`] | numbered images of CUReT |
//! | [`options`] | what the user says of a set |

mod angle_names;
mod angles;
mod archived_list;
mod curet;
mod curet_directions;
mod listing;
mod options;
mod pattern;

use std::path::Path;

pub use crate::btf::import::sets::options::{Numbering, SetOptions};

use crate::btf::import::family::Family;
use crate::btf::import::image_list::{ImageList, MeasuredImage};
use crate::btf::import::list_options::Handedness;
use crate::btf::import::sets::angle_names::AngleName;
use crate::btf::import::sets::angles::Angles;
use crate::btf::import::sets::listing::{Listing, SetImage};
use crate::btf::import::sets::pattern::Pattern;
use crate::error::{Error, Result};

/// Images left out that a note names.
const NAMED: usize = 5;
/// The file by which time-varying sets of Columbia are known.
const STAF_POINTS: &str = "texturePoints3d.txt";

/// The images of a set that have angles, and the names of those that have none.
struct Sorted<'a> {
    family: Family,
    taken: Vec<(&'a SetImage, Angles)>,
    left_out: Vec<&'a str>,
}

/// Whether a folder holds images whose names state their angles.
pub fn is_set(folder: &Path) -> bool {
    Listing::of(&[folder]).is_ok_and(|listing| listing.says_angles())
}

impl Listing {
    /// Whether any image's name says its angles.
    fn says_angles(&self) -> bool {
        let mut images = self.images.iter();
        images.any(|image| AngleName::parse(&image.name).is_some())
    }
}

/// Lists the images of folders and zip archives that together hold one set: by their names, else by a list in an
/// archive.
pub fn read_set(
    paths: &[impl AsRef<Path>],
    options: &SetOptions,
    handedness: Handedness,
) -> Result<ImageList> {
    // Go by a list in an archive where no name says angles.
    let path = paths.first().map_or(Path::new(""), AsRef::as_ref);
    let listing = Listing::of(paths)?;
    if options.given().is_none()
        && !listing.says_angles()
        && let Some(list) = archived_list::find(&listing).map_err(|error| error.in_file(path))?
    {
        return archived_list::read(&listing, list, handedness);
    }
    // Go by the names.
    let sorted = sort(&listing, options).map_err(|error| error.in_file(path))?;
    check_horizon(path, &sorted.taken)?;
    let measured = |(image, angles): &(&SetImage, Angles)| MeasuredImage {
        path: image.path.clone(),
        view: handedness.applied_to(angles.view()),
        light: handedness.applied_to(angles.light()),
    };
    let images = sorted.taken.iter().map(measured).collect();
    // Tell what is not as it seems.
    let mut notes: Vec<String> = note_of_left_out(&sorted.left_out).into_iter().collect();
    if sorted.family == Family::Curet {
        notes.push(curet::NOT_RECTIFIED.into());
    }
    Ok(ImageList {
        name: listing.name(),
        kind: sorted.family.name(),
        family: sorted.family,
        is_set: sorted.family != Family::Curet,
        path: path.to_path_buf(),
        handedness,
        images,
        place: listing.place,
        positions: None,
        notes,
        facts: serde_json::Map::new(),
    })
}

/// Finds the angles of every image: by the user's pattern, by the names of known sets, by number.
fn sort<'a>(listing: &'a Listing, options: &SetOptions) -> Result<Sorted<'a>> {
    // Go by the user's pattern.
    if let Some(text) = &options.pattern {
        let pattern = Pattern::parse(text)?;
        let sorted = by_name(listing, Family::Any, |name| pattern.angles(name));
        return match sorted.taken.is_empty() {
            false => Ok(sorted),
            true => Err(Error::option(
                "pattern",
                format!("`{text}` matches none of {} names", listing.images.len()),
                format!("a pattern of names such as `{}`", listing.example()),
            )),
        };
    }
    // Go by the names of known sets.
    let names = listing.images.iter().map(|image| &image.name);
    let named: Vec<AngleName> = names.filter_map(|name| AngleName::parse(name)).collect();
    if options.directions.is_none() && !named.is_empty() {
        let family = angle_names::family(&named);
        return Ok(by_name(listing, family, |name| {
            AngleName::parse(name).map(|name| name.angles)
        }));
    }
    // Go by CUReT's numbers.
    if options.directions == Some(Numbering::Curet) || curet::is_complete(&listing.images) {
        let angles = curet::angles(&listing.images)?;
        return Ok(Sorted {
            family: Family::Curet,
            taken: listing.images.iter().zip(angles).collect(),
            left_out: Vec::new(),
        });
    }
    Err(without_angles(listing))
}

/// Images sorted by their angles: views outside, lights inside, each by θ, then φ.
fn by_name<'a>(
    listing: &'a Listing,
    family: Family,
    angles: impl Fn(&str) -> Option<Angles>,
) -> Sorted<'a> {
    let (mut taken, mut left_out) = (Vec::new(), Vec::new());
    for image in &listing.images {
        match angles(&image.name) {
            Some(angles) => taken.push((image, angles)),
            None => left_out.push(image.name.as_str()),
        }
    }
    taken.sort_by(|(a, at), (b, other)| at.order(other).then(a.name.cmp(&b.name)));
    Sorted {
        family,
        taken,
        left_out,
    }
}

fn without_angles(listing: &Listing) -> Error {
    if listing
        .others
        .iter()
        .any(|name| name.ends_with(STAF_POINTS))
    {
        return Error::data(
            "set",
            "a STAF folder (tvBTF): its files do not state the positions of camera and lamps",
        )
        .expected("the directions of each image")
        .advice(
            "rectify the images of one time step and write a table (.csv) with the columns file, camera_x_mm, \
             camera_y_mm, camera_z_mm, light_x_mm, light_y_mm, light_z_mm",
        );
    }
    if listing.images.is_empty() {
        return Error::data("images", "none")
            .expected("PNG, JPEG, TIFF, BMP, GIF, OpenEXR or Radiance HDR files");
    }
    let count = listing.images.len();
    Error::data(
        "names",
        format!("none of {count} images states its angles, as `{}`", listing.example()),
    )
    .expected(
        "`tl000 pl000 tv030 pv030` (UBO2003, ATRIUM), `tl000_pl000_tv030_pv030` (UTIA), \
         `tv30.0_pv0.0_tl15.0_pl60.0` (SPECTRAL), or the 205 images of CUReT",
    )
    .advice(
        "name the angles' places (--pattern \"…tl{tl}_pl{pl}_tv{tv}_pv{pv}\"), or write a table of angles (.csv)",
    )
}

/// Says which images have no place in the set.
fn note_of_left_out(names: &[&str]) -> Option<String> {
    let more = if names.len() > NAMED { " …" } else { "" };
    let named = names[..names.len().min(NAMED)].join(", ");
    let count = names.len();
    (count > 0).then(|| {
        format!("{count} images without angles in their names are left out: {named}{more}")
    })
}

/// Refuses directions below the horizon, all of them named.
fn check_horizon(path: &Path, taken: &[(&SetImage, Angles)]) -> Result<()> {
    let faults: Vec<String> = taken
        .iter()
        .filter_map(|(image, angles)| Some(format!("{}: {}", image.name, angles.fault()?)))
        .collect();
    match faults.is_empty() {
        true => Ok(()),
        false => Err(Error::Faults {
            path: path.to_path_buf(),
            lines: faults,
            usage: false,
        }),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn list(names: &[&str], options: &SetOptions) -> std::result::Result<ImageList, String> {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        read_set(&[folder.path()], options, Handedness::Right).map_err(|error| error.to_string())
    }

    fn ends(list: &ImageList) -> Vec<String> {
        let end = |image: &MeasuredImage| image.path.file_name().unwrap().to_string_lossy().into();
        list.images.iter().map(end).collect()
    }

    #[test]
    fn images_come_in_the_order_of_their_angles() {
        let names = [
            "tv030_pv030/00008 tl000 pl000 tv030 pv030.jpg",
            "tv000_pv000/00000 tl000 pl000 tv000 pv000.jpg",
            "tv000_pv000/00081 tl015 pl000 tv000 pv000.jpg",
            "preview.jpg",
            ".hidden.jpg",
            "readme.txt",
        ];
        let found = list(&names, &SetOptions::default()).unwrap();
        assert_eq!(found.kind, "ubo2003");
        assert_eq!(
            ends(&found),
            [
                "00000 tl000 pl000 tv000 pv000.jpg",
                "00081 tl015 pl000 tv000 pv000.jpg",
                "00008 tl000 pl000 tv030 pv030.jpg"
            ]
        );
        assert!((found.images[2].view.theta().to_degrees() - 30.0).abs() < 1e-9);
        assert!(found.notes[0].contains("1 images") && found.notes[0].contains("preview.jpg"));
    }

    #[test]
    fn a_pattern_finds_the_angles_of_other_names() {
        let options = SetOptions {
            pattern: Some("L{tl}-{pl}".into()),
            ..SetOptions::default()
        };
        let found = list(&["a_L45-90.5.png", "a_L10-0.png"], &options).unwrap();
        assert_eq!(ends(&found), ["a_L10-0.png", "a_L45-90.5.png"]);
        assert!((found.images[1].light.phi().to_degrees() - 90.5).abs() < 1e-9);
        assert_eq!(found.images[0].view.theta(), 0.0);
        let refused = list(&["x.png"], &options).unwrap_err();
        assert!(
            refused.contains("--pattern") && refused.contains("x.png"),
            "{refused}"
        );
    }

    #[test]
    fn sets_without_angles_are_told_what_would_do() {
        let refused = |names: &[&str]| list(names, &SetOptions::default()).unwrap_err();
        assert!(refused(&["notes.txt"]).contains("images: none"));
        let error = refused(&["a.png", "b.png"]);
        assert!(
            error.contains("--pattern") && error.contains("UBO2003"),
            "{error}"
        );
        let error = refused(&["btfInfo/texturePoints3d.txt", "raw/a.exr"]);
        assert!(
            error.contains("STAF") && error.contains("camera_x_mm"),
            "{error}"
        );
        let error = refused(&["tl095 pl000 tv000 pv000.jpg", "tl000 pl000 tv091 pv000.jpg"]);
        assert!(
            error.contains("2 faults") && error.contains("theta 95"),
            "{error}"
        );
    }
}
