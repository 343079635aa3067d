//! A texture on the faces of a surface (Castellanos and Williams): per face the triangle of the sample that it shows.
//!
//! Out of `synthesis`, into `render`; on disk `NAME.faces.ply` (docs/formats.md).

use std::fs::File;
use std::io::Read;
use std::path::Path;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::image::encode_srgb8;
use crate::format::ply::{self, Column, PlyFile};
use crate::maps::header::{MapHeader, bad_comment};
use crate::maps::vertex_map::{triangles, vectors};
use crate::mesh::triangle_mesh::TriangleMesh;

/// How often a base mesh is subdivided, at most: each time its faces become four times as many.
pub const MOST_SUBDIVISIONS: u32 = 15;
/// Bytes in which the header's comments are looked for.
const START: u64 = 4096;
/// The comment that only face maps have.
const SQUARE: &str = "square";
/// Properties that are not channels.
const OWN: [&str; 8] = ["r", "g", "b", "red", "green", "blue", "source", "phase"];

/// The square of the sample that is used, in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Square {
    /// Columns to the left of it.
    pub left: u32,
    /// Rows above it.
    pub top: u32,
    /// Its rows and columns.
    pub side: u32,
}

/// Numbers of a channel of the sample, one per face.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceChannel {
    /// The property's name.
    pub name: String,
    /// A number per face.
    pub numbers: Vec<f32>,
}

/// A decorated mesh; all lists are in the order of its faces.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceMap {
    /// The surface. Its faces are nested in fours: faces 4·f … 4·f + 3 are the parts of face f of the next coarser
    /// level, the centre last.
    pub mesh: TriangleMesh,
    /// Linear colours, where the sample has any.
    pub colors: Option<Vec<[f32; 3]>>,
    /// Other channels of the sample.
    pub channels: Vec<FaceChannel>,
    /// The triangle of the sample that each face shows: triangles of the upright grid row by row from the top, then
    /// those of the grid rotated by 90° in the same order.
    pub sources: Vec<u32>,
    /// Corner k of a face lies on corner (k + phase) mod 3 of its triangle of the sample.
    pub phases: Vec<u8>,
    /// The part of it that the grids lie on.
    pub square: Square,
    /// How often the base mesh was subdivided; the grids have one level more.
    pub subdivisions: u32,
    /// What it was made from, and how.
    pub header: MapHeader,
}

impl FaceMap {
    /// Whether the start of a file is that of a face map.
    pub fn is_told_by(start: &[u8]) -> bool {
        let mark = format!("\ncomment {SQUARE} ");
        let is_mark = |window: &[u8]| window == mark.as_bytes();
        start.starts_with(b"ply") && start.windows(mark.len()).any(is_mark)
    }

    /// Whether a path is a face map, by its name and its header.
    pub fn is_at(path: &Path) -> Result<bool> {
        let ending = path.extension().unwrap_or_default();
        if !ending.eq_ignore_ascii_case("ply") {
            return Ok(false);
        }
        let failed = || Error::io(path, "read");
        let file = File::open(path).map_err(failed())?;
        let mut start = Vec::new();
        file.take(START).read_to_end(&mut start).map_err(failed())?;
        Ok(Self::is_told_by(&start))
    }

    /// Refuses a face map where another map is wanted.
    pub fn refuse_at(path: &Path) -> Result<()> {
        if !path.is_file() || !Self::is_at(path)? {
            return Ok(());
        }
        Err(Error::data("map", "a map of faces, made by choosy sampling")
            .expected("a surface texton map, NAME.map.ply, or an atlas, NAME.atlas")
            .advice("a map of faces has the colours and channels of its sample itself, and `synth --glb` makes a model of it")
            .in_file(path))
    }

    /// Writes the map as a binary little-endian PLY.
    pub fn write(&self, path: &Path) -> Result<()> {
        // Lay out the positions.
        let axis =
            |axis: usize| -> Vec<f32> { self.mesh.positions.iter().map(|p| p[axis]).collect() };
        let positions = [0, 1, 2].map(axis);
        let vertex_columns: Vec<(&str, Column<'_>)> = ["x", "y", "z"]
            .into_iter()
            .zip(&positions)
            .map(|(name, axis)| (name, Column::Float(axis)))
            .collect();
        // Lay out the colours, as numbers and as bytes.
        let colors = self.colors.as_deref();
        let linear: Vec<Vec<f32>> = colors.map_or_else(Vec::new, |colors| {
            let channel = |at: usize| colors.iter().map(|color| color[at]).collect();
            (0..3).map(channel).collect()
        });
        let encoded: Vec<Vec<u8>> = linear
            .par_iter()
            .map(|channel| channel.iter().map(|&value| encode_srgb8(value)).collect())
            .collect();
        // Join the columns of the faces.
        let mut columns: Vec<(&str, Column<'_>)> = Vec::new();
        for (name, channel) in ["r", "g", "b"].into_iter().zip(&linear) {
            columns.push((name, Column::Float(channel)));
        }
        for (name, channel) in ["red", "green", "blue"].into_iter().zip(&encoded) {
            columns.push((name, Column::UChar(channel)));
        }
        columns.push(("source", Column::UInt(&self.sources)));
        columns.push(("phase", Column::UChar(&self.phases)));
        for channel in &self.channels {
            columns.push((&channel.name, Column::Float(&channel.numbers)));
        }
        let triangles = &self.mesh.triangles;
        ply::write_with_faces(path, &self.comments(), &vertex_columns, triangles, &columns)
    }

    fn comments(&self) -> Vec<String> {
        let Square { left, top, side } = self.square;
        self.header.comments(&[
            format!("{SQUARE} {left} {top} {side}"),
            format!("subdivisions {}", self.subdivisions),
        ])
    }

    /// Reads a map and checks every number a later stage relies on, but whether the sources are on the sample's
    /// grids: those are not laid out here.
    pub fn read(path: &Path) -> Result<Self> {
        let file = ply::read(path)?;
        guarded(path, || Self::from_ply(&file))
    }

    fn from_ply(file: &PlyFile) -> Result<Self> {
        let header = MapHeader::parse(&file.comments)?;
        let (square, subdivisions) = parse_square(&file.comments, header.exemplar)?;
        let mesh = TriangleMesh {
            positions: vectors(file, ["x", "y", "z"])?,
            triangles: triangles(file)?,
        };
        let faces = mesh.triangles.len();
        Ok(Self {
            sources: whole_numbers(file, "source", (faces, u32::MAX))?,
            phases: whole_numbers(file, "phase", (faces, 2))?
                .into_iter()
                .map(|phase| phase as u8)
                .collect(),
            colors: colors(file, faces)?,
            channels: channels(file, faces)?,
            mesh,
            square,
            subdivisions,
            header,
        })
    }
}

/// The square and the subdivisions that the comments state.
fn parse_square(comments: &[String], [width, height]: [u32; 2]) -> Result<(Square, u32)> {
    // Read the subdivisions.
    let word = |key: &str| -> Result<&str> {
        let mut lines = comments.iter();
        let found = lines.find_map(|line| line.strip_prefix(key)?.strip_prefix(' '));
        found.ok_or_else(|| {
            Error::data("header", format!("no line `comment {key} …`"))
                .expected("a map made by `mesotex synth --onto faces`")
        })
    };
    let text = word("subdivisions")?;
    let subdivisions: Option<u32> = text.parse().ok();
    let Some(subdivisions) = subdivisions.filter(|&count| count <= MOST_SUBDIVISIONS) else {
        let expected = format!("0 to {MOST_SUBDIVISIONS}");
        return Err(bad_comment("subdivisions", text, &expected));
    };
    // Read the square, which must lie in the sample and divide evenly.
    let text = word(SQUARE)?;
    let numbers: Vec<u32> = text.split(' ').filter_map(|n| n.parse().ok()).collect();
    let fits =
        |first: u32, side: u32, all: u32| u64::from(first) + u64::from(side) <= u64::from(all);
    match numbers[..] {
        [left, top, side]
            if side > 0
                && side.is_multiple_of(1 << subdivisions)
                && fits(left, side, width)
                && fits(top, side, height) =>
        {
            Ok((Square { left, top, side }, subdivisions))
        }
        _ => {
            let expected = format!(
                "columns on the left, rows above, and a side that 2^{subdivisions} divides, inside {width} × {height} \
                 texels"
            );
            Err(bad_comment(SQUARE, text, &expected))
        }
    }
}

/// A face property of finite numbers, one per face.
fn numbers<'a>(file: &'a PlyFile, name: &str, faces: usize) -> Result<&'a [f64]> {
    let Some(column) = file.face_column(name) else {
        return Err(Error::data("element face", format!("no property `{name}`"))
            .expected("a property of this name"));
    };
    if column.len() != faces {
        return Err(Error::data(
            "element face",
            format!("{} rows for {faces} triangles", column.len()),
        )
        .expected("a row per triangle, and no strips"));
    }
    match column
        .iter()
        .position(|number| !(*number as f32).is_finite())
    {
        None => Ok(column),
        Some(face) => Err(fault(face, name, column[face]).expected("a finite number")),
    }
}

fn fault(face: usize, name: &str, found: f64) -> Error {
    Error::data(format!("face {face}, property {name}"), found.to_string())
}

/// A face property of whole numbers from 0 to `most`.
fn whole_numbers(file: &PlyFile, name: &str, (faces, most): (usize, u32)) -> Result<Vec<u32>> {
    let column = numbers(file, name, faces)?;
    let is_whole = |number: f64| number.fract() == 0.0 && (0.0..=f64::from(most)).contains(&number);
    match column.iter().position(|&number| !is_whole(number)) {
        None => Ok(column.iter().map(|&number| number as u32).collect()),
        Some(face) => {
            let expected = format!("a whole number, 0 to {most}");
            Err(fault(face, name, column[face]).expected(expected))
        }
    }
}

/// The linear colours of a file that has any.
fn colors(file: &PlyFile, faces: usize) -> Result<Option<Vec<[f32; 3]>>> {
    if file.face_column("r").is_none() {
        return Ok(None);
    }
    let [r, g, b] = ["r", "g", "b"].map(|name| numbers(file, name, faces));
    let rows = r?.iter().zip(g?).zip(b?);
    let colors = rows.map(|((&r, &g), &b)| [r as f32, g as f32, b as f32]);
    Ok(Some(colors.collect()))
}

/// All other properties.
fn channels(file: &PlyFile, faces: usize) -> Result<Vec<FaceChannel>> {
    let others = file.face_columns.iter();
    let others = others.filter(|(name, _)| !OWN.contains(&name.as_str()));
    let channel = |(name, _): &(String, Vec<f64>)| {
        let numbers = numbers(file, name, faces)?;
        Ok(FaceChannel {
            name: name.clone(),
            numbers: numbers.iter().map(|&number| number as f32).collect(),
        })
    };
    others.map(channel).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::format::id::ContentId;

    /// Two triangles of a square.
    pub(crate) fn pair() -> FaceMap {
        let id = ContentId::of_bytes(b"x");
        FaceMap {
            mesh: TriangleMesh {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
            },
            colors: Some(vec![[0.25, 0.5, 1.0], [0.0, 0.125, 2.0]]),
            channels: vec![FaceChannel {
                name: "height".into(),
                numbers: vec![-1.5, 3.0],
            }],
            sources: vec![3, 1_000],
            phases: vec![0, 2],
            square: Square {
                left: 4,
                top: 0,
                side: 16,
            },
            subdivisions: 2,
            header: MapHeader {
                exemplar: [24, 16],
                texel: 0.25,
                origin: DVec3::ZERO,
                seed: 7,
                method: "choosy".into(),
                polish: 0,
                sample: id.clone(),
                space: id,
            },
        }
    }

    #[test]
    fn files_round_trip_and_are_told_by_their_start() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.faces.ply");
        let mut map = pair();
        map.write(&path).unwrap();
        assert_eq!(FaceMap::read(&path).unwrap(), map);
        let bytes = std::fs::read(&path).unwrap();
        assert!(FaceMap::is_told_by(&bytes));
        let text = String::from_utf8_lossy(&bytes);
        for line in [
            "comment exemplar 24 16\ncomment square 4 0 16\ncomment subdivisions 2\n",
            "property float r\n",
            "property uchar blue\n",
            "property uint source\nproperty uchar phase\nproperty float height\n",
        ] {
            assert!(text.contains(line), "{line}");
        }
        (map.colors, map.channels) = (None, Vec::new());
        map.write(&path).unwrap();
        assert_eq!(FaceMap::read(&path).unwrap(), map);
    }

    #[test]
    fn what_no_map_can_hold_is_refused_by_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.faces.ply");
        let refused = |change: &dyn Fn(&mut FaceMap)| {
            let mut map = pair();
            change(&mut map);
            map.write(&path).unwrap();
            FaceMap::read(&path).unwrap_err().to_string()
        };
        assert!(refused(&|map| map.phases[1] = 3).contains("face 1, property phase: 3"));
        assert!(refused(&|map| map.square.side = 18).contains("comment square: `4 0 18`"));
        assert!(refused(&|map| map.square.left = 9).contains("inside 24 × 16 texels"));
        assert!(refused(&|map| map.subdivisions = 40).contains("comment subdivisions: `40`"));
        assert!(refused(&|map| map.header.texel = 0.0).contains("comment texel"));
        let nan = |map: &mut FaceMap| map.channels[0].numbers[0] = f32::NAN;
        assert!(refused(&nan).contains("face 0, property height: NaN"));
        pair().write(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let text = |from: &str, to: &str| {
            let at = bytes
                .windows(from.len())
                .position(|w| w == from.as_bytes())
                .unwrap();
            let mut bytes = bytes.clone();
            bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
            std::fs::write(&path, bytes).unwrap();
            FaceMap::read(&path).unwrap_err().to_string()
        };
        assert!(text("uint source", "uint sauce_").contains("no property `source`"));
        assert!(text("comment square", "comment circle").contains("comment square"));
    }
}
