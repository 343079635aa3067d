//! What a path holds: by its name where that tells, else by its first bytes or its first line.

use std::borrow::Cow;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::btf::bake::maps::read_set;
use crate::btf::bonn::signature::Signature;
use crate::btf::import::{is_set, lists_in};
use crate::btf::sample::DESCRIPTION;
use crate::cli::run::sections::SECTIONS;
use crate::error::{Error, Result};
use crate::format::mesh_formats;
use crate::maps::atlas_map::ATLAS_FOLDER;
use crate::maps::face_map::FaceMap;
use crate::textures::folder::TEXTURES_FOLDER;

/// How much of a file is looked at.
const START: u64 = 4096;

/// What a path holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Sample,
    Atlas,
    Textures,
    Map,
    FaceMap,
    Mesh,
    Archive,
    Array,
    Image,
    Material,
    Scene,
    Capture,
    Bonn,
    Ptm,
    Hsh,
    Directions,
    CameraPath,
    Json,
    Frames,
}

/// What a mesh is read from: maps are meshes too.
pub const MESHES: [Kind; 3] = [Kind::Mesh, Kind::Map, Kind::FaceMap];

/// What `info` knows, for errors.
fn known() -> String {
    format!(
        "a sample (X.sample), an atlas (X.atlas) or other folder of textures, a folder of maps or a material recipe (.toml), a scene (.toml), \
    a capture (a list, .lp or .csv, or a folder or a zip archive of images), a .btf file of Bonn, a fit over lights (.ptm, .rti), a table of directions or a camera path (.csv, .json), a \
    folder of frames, an archive of ours (.npz), an array (.npy), a mesh, a surface texton map or a face map ({}), a record or report of ours (.json), or an image (PNG, JPEG, TIFF, OpenEXR, Radiance \
    HDR, GIF, BMP)",
        mesh_formats::listed_names()
    )
}

/// What is said of everything else.
pub fn unknown(path: &Path) -> Error {
    Error::data("kind", "a kind of file that info does not know")
        .expected(known())
        .in_file(path)
}

impl Kind {
    /// What a message calls it.
    pub fn name(self) -> Cow<'static, str> {
        let name = match self {
            Self::Mesh => return format!("a mesh ({})", mesh_formats::listed_names()).into(),
            Self::Sample => "a BTF sample (NAME.sample)",
            Self::Atlas => "an atlas (NAME.atlas)",
            Self::Textures => "a folder of textures",
            Self::Map => "a surface texton map (NAME.map.ply)",
            Self::FaceMap => "a face map (NAME.faces.ply)",
            Self::Archive => "an archive (.npz)",
            Self::Array => "an array (.npy)",
            Self::Image => "an image",
            Self::Material => "a folder of texture maps or a material recipe",
            Self::Scene => "a scene (.toml)",
            Self::Capture => "a capture (a list or a folder of images)",
            Self::Bonn => "a .btf file of Bonn",
            Self::Ptm => "a polynomial texture map (.ptm)",
            Self::Hsh => "a hemispherical harmonics fit (.rti)",
            Self::Directions => "a table of directions",
            Self::CameraPath => "a camera path",
            Self::Json => "a JSON file",
            Self::Frames => "a folder of frames",
        };
        name.into()
    }

    /// What is at `path`.
    pub fn of(path: &Path) -> Result<Self> {
        // Tell folders by the files in them.
        if path.join(DESCRIPTION).is_file() {
            return Ok(Self::Sample);
        }
        if path.join(ATLAS_FOLDER.description).is_file() {
            return Ok(Self::Atlas);
        }
        if TEXTURES_FOLDER.is_told_by(path) {
            return Ok(Self::Textures);
        }
        let metadata = fs::metadata(path).map_err(Error::io(path, "read"))?;
        if metadata.is_dir() {
            return Self::of_folder(path);
        }
        // Tell a file by its ending, then by its first bytes.
        let start = start_of(path)?;
        let extension = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        match extension.as_str() {
            "npy" => Ok(Self::Array),
            "npz" => Ok(Self::Archive),
            "ply" if FaceMap::is_told_by(&start) => Ok(Self::FaceMap),
            "ply" if is_map(&start) => Ok(Self::Map),
            "gz" => Ok(Self::Mesh),
            extension if mesh_formats::has_extension(extension) => Ok(Self::Mesh),
            "toml" => Ok(of_toml(&start)),
            "lp" => Ok(Self::Capture),
            _ if start.starts_with(b"PTM_") => Ok(Self::Ptm),
            "rti" => Ok(Self::Hsh),
            "csv" | "tsv" => of_table(path, &start),
            "json" => Ok(Self::Json),
            "png" | "jpg" | "jpeg" | "jpe" | "tif" | "tiff" | "exr" | "hdr" | "rgbe" | "pic"
            | "gif" | "bmp" | "dib" => Ok(Self::Image),
            _ if is_image(&start) => Ok(Self::Image),
            _ if start.starts_with(b"PK\x03\x04") => Ok(Self::Capture),
            _ if Signature::of(&start).is_ok() => Ok(Self::Bonn),
            _ => Err(unknown(path)),
        }
    }

    fn of_folder(folder: &Path) -> Result<Self> {
        if folder.join("material.toml").is_file() {
            return Ok(Self::Material);
        }
        let lists = lists_in(folder)?;
        if !lists.is_empty() || is_set(folder) {
            return Ok(Self::Capture);
        }
        if !frames_in(folder)?.is_empty() {
            return Ok(Self::Frames);
        }
        match is_material_set(folder)? {
            true => Ok(Self::Material),
            false => Err(unknown(folder)),
        }
    }
}

/// Whether a folder holds a file whose name says what map it is.
fn is_material_set(folder: &Path) -> Result<bool> {
    let none = ["unknown", "no image", "folder", "preview"];
    let set = read_set(folder)?;
    Ok(set
        .files
        .iter()
        .any(|file| !none.contains(&file.role.as_str())))
}

/// The frames in a folder, `NAME.0001.exr`, sorted.
pub fn frames_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let is_frame = |path: &PathBuf| {
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        let number = name
            .strip_suffix(".exr")
            .and_then(|stem| stem.rsplit_once('.'));
        number.is_some_and(|(_, digits)| {
            digits.len() >= 3 && digits.bytes().all(|byte| byte.is_ascii_digit())
        })
    };
    let entries = fs::read_dir(folder).map_err(Error::io(folder, "read"))?;
    let mut frames: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(is_frame)
        .collect();
    frames.sort();
    Ok(frames)
}

fn start_of(path: &Path) -> Result<Vec<u8>> {
    let mut start = Vec::new();
    let file = fs::File::open(path).map_err(Error::io(path, "read"))?;
    file.take(START)
        .read_to_end(&mut start)
        .map_err(Error::io(path, "read"))?;
    Ok(start)
}

/// Whether a PLY says in its header that it is a surface texton map.
fn is_map(start: &[u8]) -> bool {
    let mark = b"\ncomment exemplar ";
    start.windows(mark.len()).any(|window| window == mark)
}

fn is_image(start: &[u8]) -> bool {
    let marks: [&[u8]; 9] = [
        b"\x89PNG",
        b"\xff\xd8\xff",
        b"\x76\x2f\x31\x01",
        b"II*\0",
        b"MM\0*",
        b"II+\0",
        b"#?RADIANCE",
        b"#?RGBE",
        b"GIF8",
    ];
    marks.iter().any(|mark| start.starts_with(mark))
}

/// A scene has the sections of its stages, a recipe has none.
fn of_toml(start: &[u8]) -> Kind {
    let text = String::from_utf8_lossy(start);
    let section = |line: &str| {
        let name = line.trim().trim_start_matches('[').split(']').next();
        line.trim().starts_with('[') && name.is_some_and(|name| SECTIONS.contains(&name.trim()))
    };
    match text.lines().any(section) {
        true => Kind::Scene,
        false => Kind::Material,
    }
}

/// A table by the names of its columns.
fn of_table(path: &Path, start: &[u8]) -> Result<Kind> {
    let text = String::from_utf8_lossy(start)
        .replace('\0', "")
        .to_lowercase();
    let is_content = |line: &&str| {
        !line.trim().is_empty() && !line.starts_with(['#']) && !line.starts_with("sep=")
    };
    let header = text.lines().find(is_content).unwrap_or_default();
    let captures = ["view_theta", "light_theta", "camera_x_mm", "light_x_mm"];
    if captures.iter().any(|column| header.contains(column)) {
        Ok(Kind::Capture)
    } else if header.contains("theta_deg") {
        Ok(Kind::Directions)
    } else if header.contains("camera_") || header.contains("light_") {
        Ok(Kind::CameraPath)
    } else {
        Err(unknown(path))
    }
}
