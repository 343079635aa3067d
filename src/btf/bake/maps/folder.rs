//! Folders of maps, by the names that public libraries give their files: ambientCG
//! (`Bark014_2K-PNG_Displacement.png`), Poly Haven (`bark_brown_disp_2k.png`), or plain
//! (`height.png`).

use std::fs;
use std::path::{Path, PathBuf};

use crate::btf::bake::maps::normals::NormalY;
use crate::btf::bake::maps::recipe::{Color, Recipe, Scalar};
use crate::error::{Error, Result};

/// Images, the more precise first: what a role takes where several files fit it.
const EXTENSIONS: [&str; 6] = ["exr", "tif", "tiff", "png", "jpg", "jpeg"];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Albedo,
    Height,
    Roughness,
    Metallic,
    Normal(NormalY),
}

/// The recipe that a folder's file names suggest.
pub(super) fn recognise(folder: &Path) -> Result<Recipe> {
    let files = images(folder)?;
    let find = |wanted: &[Role]| choose(&files, wanted).map_err(|error| error.in_file(folder));
    let height = find(&[Role::Height])?;
    // Both conventions show the same relief: take the one DESIGN's +y asks for.
    let normal = match &height {
        Some(_) => None,
        None => match find(&[Role::Normal(NormalY::Up)])? {
            Some(file) => Some((file, NormalY::Up)),
            None => match find(&[Role::Normal(NormalY::Down)])? {
                Some(file) => Some((file, NormalY::Down)),
                None => find(&[Role::Normal(NormalY::Auto)])?.map(|file| (file, NormalY::Auto)),
            },
        },
    };
    if height.is_none() && normal.is_none() {
        return Err(
            Error::data("folder", "no height, displacement or normal map in it")
                .expected("material.toml, or maps named as ambientCG, Poly Haven or height.png")
                .in_file(folder),
        );
    }
    let name = fs::canonicalize(folder)
        .ok()
        .and_then(|path| path.file_name().map(|n| n.to_string_lossy().into_owned()))
        .unwrap_or_default();
    Ok(Recipe {
        name,
        height,
        normal_y: normal.as_ref().map_or(NormalY::Auto, |&(_, y)| y),
        normal: normal.map(|(file, _)| file),
        albedo: find(&[Role::Albedo])?.map_or(Recipe::default().albedo, Color::Map),
        roughness: find(&[Role::Roughness])?.map(Scalar::Map),
        metallic: find(&[Role::Metallic])?.map(Scalar::Map),
        folder: folder.to_path_buf(),
        ..Recipe::default()
    })
}

/// The images of a folder and of its `textures` folder (Poly Haven's archives), sorted.
fn images(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for part in ["", "textures"] {
        let place = folder.join(part);
        if !part.is_empty() && !place.is_dir() {
            continue;
        }
        for entry in fs::read_dir(&place).map_err(Error::io(&place, "read"))? {
            let name = entry.map_err(Error::io(&place, "read"))?.file_name();
            let file = Path::new(part).join(name);
            if precision(&file).is_some() {
                files.push(file);
            }
        }
    }
    files.sort();
    Ok(files)
}

fn precision(file: &Path) -> Option<usize> {
    let extension = file.extension()?.to_str()?.to_ascii_lowercase();
    EXTENSIONS.iter().position(|&known| known == extension)
}

/// The file of a role: the most precise of those that differ in their extension alone.
fn choose(files: &[PathBuf], wanted: &[Role]) -> Result<Option<PathBuf>> {
    let mut fitting: Vec<&PathBuf> = files
        .iter()
        .filter(|file| role(file).is_some_and(|found| wanted.contains(&found)))
        .collect();
    fitting.sort_by_key(|file| (precision(file), (*file).clone()));
    let Some(&best) = fitting.first() else {
        return Ok(None);
    };
    let stem = |file: &Path| file.file_stem().map(|s| s.to_ascii_lowercase());
    match fitting.iter().find(|file| stem(file) != stem(best)) {
        None => Ok(Some(best.clone())),
        Some(other) => Err(Error::data(
            "folder",
            format!("both {} and {} fit", best.display(), other.display()),
        )
        .expected("one file for each map")
        .advice("write a material.toml that names the maps")),
    }
}

/// What a file shows, by the words of its name; the last word that says something counts.
fn role(file: &Path) -> Option<Role> {
    let stem = file.file_stem()?.to_str()?.to_ascii_lowercase();
    let words: Vec<&str> = stem
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    words.iter().enumerate().rev().find_map(|(index, &word)| {
        let next = words.get(index + 1).copied();
        Some(match (word, next) {
            ("color" | "albedo" | "diff" | "diffuse" | "basecolor" | "col", _) => Role::Albedo,
            ("displacement" | "disp" | "height" | "heightmap", _) => Role::Height,
            ("roughness" | "rough", _) => Role::Roughness,
            ("metalness" | "metallic" | "metal", _) => Role::Metallic,
            ("normalgl", _) | ("normal" | "nor" | "nrm", Some("gl" | "opengl")) => {
                Role::Normal(NormalY::Up)
            }
            ("normaldx", _) | ("normal" | "nor" | "nrm", Some("dx" | "directx")) => {
                Role::Normal(NormalY::Down)
            }
            ("normal" | "nor" | "nrm" | "normals", _) => Role::Normal(NormalY::Auto),
            _ => return None,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recognised(names: &[&str]) -> Result<Recipe> {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, b"").unwrap();
        }
        recognise(folder.path())
    }

    #[test]
    fn ambientcg_and_poly_haven_names_are_known() {
        let ambient = recognised(&[
            "Metal032_2K-JPG_AmbientOcclusion.jpg",
            "Metal032_2K-JPG_Color.jpg",
            "Metal032_2K-JPG_Displacement.jpg",
            "Metal032_2K-JPG_Metalness.jpg",
            "Metal032_2K-JPG_NormalDX.jpg",
            "Metal032_2K-JPG_NormalGL.jpg",
            "Metal032_2K-JPG_Roughness.jpg",
        ])
        .unwrap();
        assert_eq!(
            ambient.height,
            Some("Metal032_2K-JPG_Displacement.jpg".into())
        );
        assert_eq!(
            ambient.metallic,
            Some(Scalar::Map("Metal032_2K-JPG_Metalness.jpg".into()))
        );
        assert_eq!(ambient.normal, None);
        let haven = recognised(&[
            "textures/bark_brown_02_diff_2k.jpg",
            "textures/bark_brown_02_nor_gl_2k.exr",
            "textures/bark_brown_02_nor_dx_2k.exr",
            "textures/bark_brown_02_rough_2k.jpg",
        ])
        .unwrap();
        assert_eq!(
            haven.normal,
            Some("textures/bark_brown_02_nor_gl_2k.exr".into())
        );
        assert_eq!(haven.normal_y, NormalY::Up);
        assert_eq!(
            haven.albedo,
            Color::Map("textures/bark_brown_02_diff_2k.jpg".into())
        );
    }

    #[test]
    fn the_more_precise_file_wins_and_two_materials_are_refused() {
        let precise = recognised(&["height.png", "height.exr", "albedo.png"]).unwrap();
        assert_eq!(precise.height, Some("height.exr".into()));
        let error = recognised(&["a_height.png", "b_height.png"])
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("a_height.png") && error.contains("b_height.png"),
            "{error}"
        );
        let error = recognised(&["albedo.png"]).unwrap_err().to_string();
        assert!(error.contains("no height"), "{error}");
    }
}
