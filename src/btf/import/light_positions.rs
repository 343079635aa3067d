//! RTI captures: a `.lp` file names one image a light, all taken from straight above.
//!
//! Format: a first line with the number of images, then `file x y z` a line: the light's position
//! on a dome, x to the image's right, y up, z towards the camera; positions are normalised.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::btf::direction::Direction;
use crate::btf::import::{ImageList, MeasuredImage};
use crate::error::{Error, Result};
use crate::format::guard::guarded;

/// Reads a `.lp` file.
pub fn read(path: &Path) -> Result<ImageList> {
    let text = fs::read_to_string(path).map_err(Error::io(path, "read"))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let images = guarded(path, || parse(&text, folder))?;
    Ok(ImageList {
        name: name_of(path),
        path: path.to_path_buf(),
        kind: "rti",
        images,
    })
}

/// A capture's name: its folder's, since most `.lp` files are called `dirs` or `lights`.
fn name_of(path: &Path) -> String {
    let folder = fs::canonicalize(path)
        .ok()
        .and_then(|path| Some(path.parent()?.file_name()?.to_string_lossy().into_owned()));
    folder.unwrap_or_else(|| "rti".into())
}

fn parse(text: &str, folder: &Path) -> Result<Vec<MeasuredImage>> {
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    let count: Option<usize> = lines.next().and_then(|(_, line)| line.trim().parse().ok());
    let Some(count) = count else {
        return Err(Error::data("line 1", "no number").expected("the number of images"));
    };
    let images = lines
        .map(|(number, line)| parse_line(line, folder).map_err(|fault| at_line(number + 1, fault)))
        .collect::<Result<Vec<_>>>()?;
    if images.len() != count || count == 0 {
        return Err(Error::data("line 1", format!("{count} images announced"))
            .expected(format!("the {} that follow", images.len())));
    }
    Ok(images)
}

fn at_line(line: usize, (found, expected): (String, &str)) -> Error {
    Error::data(format!("line {line}"), found).expected(expected)
}

fn parse_line(
    line: &str,
    folder: &Path,
) -> std::result::Result<MeasuredImage, (String, &'static str)> {
    // File names may hold spaces; the last three words are the position.
    let words: Vec<&str> = line.trim().rsplitn(4, char::is_whitespace).collect();
    let [z, y, x, file] = words[..] else {
        return Err((format!("`{line}`"), "file x y z"));
    };
    let numbers: Vec<f64> = [x, y, z]
        .iter()
        .filter_map(|word| word.parse().ok())
        .collect();
    let position = match numbers[..] {
        [x, y, z] => DVec3::new(x, y, z),
        _ => return Err((format!("position `{x} {y} {z}`"), "three numbers")),
    };
    let light = match position.try_normalize() {
        Some(direction) if direction.z >= 0.0 => Direction(direction),
        _ => {
            return Err((
                format!("position ({x}, {y}, {z})"),
                "a light above the horizon, z >= 0",
            ));
        }
    };
    Ok(MeasuredImage {
        path: find_image(file.trim(), folder),
        view: Direction(DVec3::Z),
        light,
    })
}

/// The image as the line names it; or, since captures are moved and their `.lp` files keep the old
/// folders, a file of that name beside the `.lp` file.
fn find_image(named: &str, folder: &Path) -> PathBuf {
    let named = named.replace('\\', "/");
    let as_named = folder.join(&named);
    if as_named.exists() {
        return as_named;
    }
    let beside = Path::new(&named).file_name().map(|name| folder.join(name));
    beside.filter(|path| path.exists()).unwrap_or(as_named)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_become_directions() {
        let list = parse("2\na b.jpg 0 0 2\nb.jpg 3 0 4\n", Path::new("rti")).unwrap();
        assert_eq!(list[0].path, Path::new("rti/a b.jpg"));
        assert_eq!(list[0].light.0, DVec3::Z);
        assert!((list[1].light.0 - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
    }

    #[test]
    fn broken_lists_are_refused_by_line() {
        let refused = |text: &str| parse(text, Path::new("")).unwrap_err().to_string();
        assert!(refused("a.jpg 0 0 1\n").contains("line 1"));
        assert!(refused("2\na.jpg 0 0 1\n").contains("2 images announced"));
        assert!(refused("1\na.jpg 0 0\n").contains("line 2"));
        assert!(refused("1\na.jpg 0 x 1\n").contains("three numbers"));
        assert!(refused("1\na.jpg 0 0 -1\n").contains("horizon"));
        assert!(refused("1\na.jpg 0 NaN 1\n").contains("horizon"));
        assert!(refused("0\n").contains("announced"));
    }
}
