//! CUReT: 205 images of a sample, numbered in the order of a table of directions.
//!
//! The names of images differ from copy to copy. What they share is a number from 1 to 205 that no two images
//! have in common; where names have none, 205 images in their order.

use std::collections::BTreeSet;

use crate::btf::import::sets::angles::Angles;
use crate::btf::import::sets::curet_directions::DIRECTIONS;
use crate::btf::import::sets::listing::SetImage;
use crate::error::{Error, Result};

/// What a user should know of these images.
pub(super) const NOT_RECTIFIED: &str = "CUReT rotated the sample in front of camera and lamp, and its images show it \
    rotated: texels of different images show the same position of the material only if the images were rectified";

/// Whether images are those of CUReT as distributed: 205, all BMP.
pub(super) fn is_complete(images: &[SetImage]) -> bool {
    let is_bitmap = |image: &SetImage| {
        let lower = image.name.to_lowercase();
        lower.ends_with(".bmp") || lower.ends_with(".bmp.z")
    };
    images.len() == DIRECTIONS.len() && images.iter().all(is_bitmap)
}

/// The angles of each image, by its number.
pub(super) fn angles(images: &[SetImage]) -> Result<Vec<Angles>> {
    Ok(numbers(images)?
        .into_iter()
        .map(|number| {
            let [view_theta, view_phi, light_theta, light_phi] =
                DIRECTIONS[number - 1].map(f64::to_degrees);
            Angles::new([view_theta, view_phi], [light_theta, light_phi])
        })
        .collect())
}

/// The number of each image, from 1.
fn numbers(images: &[SetImage]) -> Result<Vec<usize>> {
    let fields: Vec<Vec<usize>> = images.iter().map(|image| digits(&image.name)).collect();
    let least = fields.iter().map(Vec::len).min().unwrap_or(0);
    let column = |place: usize| fields.iter().map(|field| field[place]).collect::<Vec<_>>();
    let is_numbering = |numbers: &Vec<usize>| {
        let distinct: BTreeSet<&usize> = numbers.iter().collect();
        let in_range = numbers.iter().all(|n| (1..=DIRECTIONS.len()).contains(n));
        in_range && distinct.len() == numbers.len()
    };
    let mut found = (0..least).map(column).filter(is_numbering);
    if let Some(first) = found.next() {
        let is_only = found.next().is_none();
        if is_only || first.len() == DIRECTIONS.len() {
            return Ok(first);
        }
    }
    if images.len() == DIRECTIONS.len() && least == 0 {
        return Ok((1..=images.len()).collect());
    }
    Err(Error::data(
        "names",
        format!(
            "{} images without one number each from 1 to {}",
            images.len(),
            DIRECTIONS.len()
        ),
    )
    .expected("the number of CUReT's table in every name, as 07-031.bmp")
    .advice("write a table of angles (.csv) where names have other numbers"))
}

/// The numbers in the last part of a path.
fn digits(path: &str) -> Vec<usize> {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.split(|c: char| !c.is_ascii_digit())
        .filter(|digits| !digits.is_empty())
        .map(|digits| digits.parse().unwrap_or(usize::MAX))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn images(names: impl Iterator<Item = String>) -> Vec<SetImage> {
        let image = |name: String| SetImage {
            path: (&name).into(),
            name,
        };
        names.map(image).collect()
    }

    #[test]
    fn images_are_found_by_their_numbers() {
        let whole = images((1..=205).map(|n| format!("s/11-{n:03}.bmp.Z")));
        assert!(is_complete(&whole));
        assert_eq!(numbers(&whole).unwrap(), (1..=205).collect::<Vec<_>>());
        let some = images([9, 31, 200].iter().map(|n| format!("11-{n}.png")));
        assert!(!is_complete(&some));
        assert_eq!(numbers(&some).unwrap(), [9, 31, 200]);
        let unnamed = images((0..205).map(|n| {
            let letter = |n: u8| char::from(b'a' + n);
            format!("{}{}.bmp", letter(n / 26), letter(n % 26))
        }));
        assert_eq!(numbers(&unnamed).unwrap()[204], 205);
    }

    #[test]
    fn numbers_that_say_nothing_are_refused() {
        for names in [
            ["a0.bmp", "a1.bmp"],
            ["a.bmp", "b.bmp"],
            ["1-2.bmp", "2-1.bmp"],
        ] {
            let set = images(names.iter().map(|&name| name.to_owned()));
            assert!(numbers(&set).unwrap_err().to_string().contains("1 to 205"));
        }
    }

    #[test]
    fn the_table_has_the_runs_of_a_fixed_lamp() {
        // Angles between light and view, constant in seven runs of the table.
        let runs = [
            (55, 22.5),
            (103, 45.0),
            (142, 67.5),
            (170, 90.0),
            (189, 112.5),
            (201, 135.0),
            (205, 157.5),
        ];
        let mut first = 0;
        for (end, expected) in runs {
            for row in &DIRECTIONS[first..end] {
                let [tv, pv, tl, pl] = row.map(f64::to_degrees);
                let angles = Angles::new([tv, pv], [tl, pl]);
                let between = angles.view().angle_to(angles.light()).to_degrees();
                assert!((between - expected).abs() < 0.1, "{row:?}: {between}");
                assert_eq!(angles.fault(), None);
            }
            first = end;
        }
        assert_eq!(
            DIRECTIONS
                .iter()
                .filter(|row| row[0].to_degrees() < 60.0)
                .count(),
            118
        );
    }
}
