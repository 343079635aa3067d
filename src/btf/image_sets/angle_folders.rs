//! Images by their angles in whole degrees, a folder per view: `tv030_pv060/…tl015 pl120 tv030 pv060.jpg`.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use half::f16;
use rayon::prelude::*;

use crate::btf::direction::{Direction, SAME_DIRECTION};
use crate::btf::image_sets::exported::Exported;
use crate::btf::image_sets::reflectance::{in_8_bits, reflectance};
use crate::btf::sample::Sample;
use crate::error::{Error, Result};
use crate::format::exr::{self, Compression, ExrImage, Numbers};
use crate::format::image::{rec709_to_xyz, write_jpeg, write_png};
use crate::progress::Progress;

/// The best that JPEG can do.
const QUALITY: u8 = 100;
/// Directions that an error names.
const NAMED: usize = 5;

/// What the images are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Images {
    /// UBO2003's, with a number and spaces in their names.
    Jpeg,
    /// UTIA's, with underscores.
    Png,
    /// UTIA's in XYZ.
    Xyz,
}

/// θ and φ in whole degrees.
type Degrees = [u32; 2];

/// Writes all images of a sample into `folder`.
pub(super) fn write_by_angles(
    sample: &Sample,
    images: Images,
    folder: &Path,
    progress: Progress<'_>,
) -> Result<Exported> {
    let description = sample.description();
    let views = whole_degrees("views", &description.views)?;
    let lights = whole_degrees("lights", &description.lights)?;
    for [theta, phi] in &views {
        let folder = folder.join(format!("tv{theta:03}_pv{phi:03}"));
        fs::create_dir_all(&folder).map_err(Error::io(&folder, "create"))?;
    }
    let count = sample.image_count();
    let clipped: Vec<u64> = (0..count)
        .into_par_iter()
        .map(|image| {
            let (view, light) = description.view_and_light(image);
            let number = light * views.len() + view;
            let path = folder.join(name(images, number, views[view], lights[light]));
            let clipped = write_image(sample, image, images, &path)?;
            progress.advance(1)?;
            Ok(clipped)
        })
        .collect::<Result<_>>()?;
    Ok(Exported {
        images: count,
        clipped: clipped.iter().sum(),
    })
}

fn name(images: Images, number: usize, [tv, pv]: Degrees, [tl, pl]: Degrees) -> String {
    let file = match images {
        Images::Jpeg => format!("{number:05} tl{tl:03} pl{pl:03} tv{tv:03} pv{pv:03}.jpg"),
        Images::Png => format!("tl{tl:03}_pl{pl:03}_tv{tv:03}_pv{pv:03}.png"),
        Images::Xyz => format!("tl{tl:03}_pl{pl:03}_tv{tv:03}_pv{pv:03}.exr"),
    };
    format!("tv{tv:03}_pv{pv:03}/{file}")
}

/// Writes one image; how many of its numbers were above 1.
fn write_image(sample: &Sample, image: usize, images: Images, path: &Path) -> Result<u64> {
    let (width, height) = (sample.grid().width, sample.grid().height);
    let numbers = reflectance(sample, image)?;
    if images == Images::Xyz {
        write_xyz(path, [width, height], &numbers)?;
        return Ok(0);
    }
    let (bytes, clipped) = in_8_bits(&numbers);
    match images {
        Images::Jpeg => write_jpeg(path, width, height, &bytes, QUALITY)?,
        _ => write_png(path, width, height, &bytes)?,
    }
    Ok(clipped)
}

/// Writes reflectance as half floats in XYZ, in channels called R, G and B as viewers want them.
fn write_xyz(path: &Path, size: [u32; 2], numbers: &[f32]) -> Result<()> {
    let matrix = rec709_to_xyz().unwrap_or_default();
    let mut planes = [const { Vec::new() }; 3];
    for texel in numbers.chunks_exact(3) {
        let rgb = glam::DVec3::new(texel[0].into(), texel[1].into(), texel[2].into());
        let xyz = (matrix * rgb).to_array();
        for (plane, value) in planes.iter_mut().zip(xyz) {
            plane.push(f16::from_f64(value));
        }
    }
    let channels: BTreeMap<String, Numbers<'_>> = ["R", "G", "B"]
        .into_iter()
        .zip(planes)
        .map(|(name, plane)| (name.to_owned(), Numbers::Half(Cow::Owned(plane))))
        .collect();
    let image = ExrImage {
        size,
        channels,
        attributes: BTreeMap::new(),
    };
    exr::write(path, &exr::encode_with(&image, Compression::Zip, exr::XYZ)?)
}

/// Directions in whole degrees; refuses those that are not.
fn whole_degrees(kind: &str, directions: &[Direction]) -> Result<Vec<Degrees>> {
    // Round to whole degrees.
    let rounded: Vec<Degrees> = directions
        .iter()
        .map(|direction| {
            let theta = direction.theta().to_degrees().round() as u32;
            let phi = direction.phi().to_degrees().round() as u32 % 360;
            [theta, if theta == 0 { 0 } else { phi }]
        })
        .collect();
    // Name the directions that lie elsewhere.
    let is_off = |(place, degrees): &(usize, &Degrees)| {
        let [theta, phi] = degrees.map(|degrees| f64::from(degrees).to_radians());
        Direction::from_angles(theta, phi).angle_to(directions[*place]) > SAME_DIRECTION
    };
    let off: Vec<String> = rounded
        .iter()
        .enumerate()
        .filter(is_off)
        .map(|(place, _)| {
            let direction = directions[place];
            let (theta, phi) = (direction.theta().to_degrees(), direction.phi().to_degrees());
            format!("({theta:.3}°, {phi:.3}°)")
        })
        .collect();
    if off.is_empty() {
        return Ok(rounded);
    }
    let more = if off.len() > NAMED { " …" } else { "" };
    Err(Error::data(
        kind,
        format!(
            "{} of {} are not at whole degrees: {}{more}",
            off.len(),
            directions.len(),
            off[..off.len().min(NAMED)].join(", ")
        ),
    )
    .expected("directions at whole degrees, as the names of this set state them")
    .advice("export to `folder`, whose table holds any direction"))
}
