//! The surface texton map (Tong 2002 §5): per vertex a texton label and a texture coordinate, on the mesh it was made
//! for. Written by `synthesis`, read by `render`.

use std::ops::RangeInclusive;
use std::path::Path;

use glam::{DVec3, Vec3};

use crate::error::{Error, Result};
use crate::format::guard::guarded;
use crate::format::ply::{self, Column, PlyFile};
use crate::format::polygon_mesh::FARTHEST;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TextonLabel;
use crate::maps::header::MapHeader;
use crate::mesh::reading::varying;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A decorated mesh; all per-vertex lists are in the mesh's vertex order.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTextonMap {
    /// The surface.
    pub mesh: TriangleMesh,
    /// Unit normals; (0, 0, 1) for a vertex in no face.
    pub normals: Vec<Vec3>,
    /// The orientation field: unit tangents s; (1, 0, 0) for a vertex in no face.
    pub orientations: Vec<Vec3>,
    /// Factor on the texel at each vertex, above 0; `None` for 1 everywhere.
    pub scale: Option<Vec<f32>>,
    /// Texture coordinates, in texels of the sample; (½, ½) for a vertex in no face.
    pub coords: Vec<TexCoord>,
    /// Texton labels; [`TextonLabel::NONE`] for a vertex in no face, and for plain images.
    pub textons: Vec<TextonLabel>,
    /// How far the texture has changed at each vertex, 0 to 1, where it changes.
    pub transition: Option<Vec<f32>>,
    /// The label of each vertex's texel, 0 to 3, where the exemplar has a mask.
    pub mask: Option<Vec<u8>>,
    /// What it was made from, and how.
    pub header: MapHeader,
}

impl SurfaceTextonMap {
    /// Mesh units a texel of the finest level covers at a vertex, its scale included.
    #[inline]
    pub fn texel_at(&self, vertex: usize) -> f64 {
        match &self.scale {
            Some(scale) => self.header.texel * f64::from(scale[vertex]),
            None => self.header.texel,
        }
    }

    /// The sample's grid at level 0.
    pub fn grid(&self, tileable: bool) -> TexelGrid {
        TexelGrid {
            width: self.header.exemplar[0],
            height: self.header.exemplar[1],
            tileable,
        }
    }
}

impl SurfaceTextonMap {
    /// Writes the map as a binary little-endian PLY (docs/formats.md).
    pub fn write(&self, path: &Path) -> Result<()> {
        // Split the vectors into columns.
        let axis = |vectors: &[Vec3], axis: usize| -> Vec<f32> {
            vectors.iter().map(|v| v[axis]).collect()
        };
        let positions = [0, 1, 2].map(|i| axis(&self.mesh.positions, i));
        let normals = [0, 1, 2].map(|i| axis(&self.normals, i));
        let orientations = [0, 1, 2].map(|i| axis(&self.orientations, i));
        let s: Vec<f32> = self.coords.iter().map(|coord| coord.s).collect();
        let t: Vec<f32> = self.coords.iter().map(|coord| coord.t).collect();
        let textons: Vec<u16> = self.textons.iter().map(|label| label.0).collect();
        // Join the columns in the file's order; optional ones where they are there.
        let vectors = [
            (["x", "y", "z"], &positions),
            (["nx", "ny", "nz"], &normals),
            (["sx", "sy", "sz"], &orientations),
        ];
        let mut columns: Vec<(&str, Column<'_>)> = vectors
            .iter()
            .flat_map(|(names, axes)| names.iter().zip(axes.iter()))
            .map(|(name, axis)| (*name, Column::Float(axis)))
            .collect();
        if let Some(scale) = varying(self.scale.as_deref()) {
            columns.push(("scale", Column::Float(scale)));
        }
        columns.push(("s", Column::Float(&s)));
        columns.push(("t", Column::Float(&t)));
        columns.push(("texton", Column::UShort(&textons)));
        if let Some(transition) = &self.transition {
            columns.push(("transition", Column::Float(transition)));
        }
        if let Some(mask) = &self.mask {
            columns.push(("mask", Column::UChar(mask)));
        }
        ply::write(
            path,
            &self.header.comments(&[]),
            &columns,
            &self.mesh.triangles,
        )
    }

    /// Reads a map and checks every number a later stage relies on.
    pub fn read(path: &Path) -> Result<Self> {
        let file = ply::read(path)?;
        guarded(path, || Self::from_ply(&file))
    }

    fn from_ply(file: &PlyFile) -> Result<Self> {
        let header = MapHeader::parse(&file.comments)?;
        let [width, height] = header.exemplar;
        let s = checked_column(file, "s", 0.0..=f64::from(width).next_down())?;
        let t = checked_column(file, "t", f64::MIN_POSITIVE..=f64::from(height))?;
        let textons = whole_column(file, "texton", 65535.0)?;
        Ok(Self {
            mesh: TriangleMesh {
                positions: vectors(file, ["x", "y", "z"])?,
                triangles: triangles(file)?,
            },
            normals: unit_vectors(file, ["nx", "ny", "nz"])?,
            orientations: unit_vectors(file, ["sx", "sy", "sz"])?,
            scale: scale(file, header.texel)?,
            coords: s
                .iter()
                .zip(t)
                .map(|(&s, &t)| TexCoord {
                    // Doubles next to a border round beyond it.
                    s: (s as f32).min((width as f32).next_down()),
                    t: (t as f32).max(f32::MIN_POSITIVE),
                })
                .collect(),
            textons: textons
                .iter()
                .map(|&label| TextonLabel(label as u16))
                .collect(),
            transition: transition(file)?,
            mask: mask(file)?,
            header,
        })
    }
}

/// A vertex property whose every number lies in `range`; NaN lies in none.
fn checked_column<'a>(
    file: &'a PlyFile,
    name: &str,
    range: RangeInclusive<f64>,
) -> Result<&'a [f64]> {
    let column = file.require(name)?;
    match column.iter().position(|value| !range.contains(value)) {
        None => Ok(column),
        Some(vertex) => Err(Error::data(
            format!("vertex {vertex}, property {name}"),
            column[vertex].to_string(),
        )
        .expected(format!("{} to {}", range.start(), range.end()))),
    }
}

/// Three vertex properties as vectors.
pub(super) fn vectors(file: &PlyFile, names: [&str; 3]) -> Result<Vec<Vec3>> {
    let [x, y, z] = names.map(|name| checked_column(file, name, -FARTHEST..=FARTHEST));
    let vertices = x?.iter().zip(y?).zip(z?);
    Ok(vertices
        .map(|((&x, &y), &z)| DVec3::new(x, y, z).as_vec3())
        .collect())
}

fn unit_vectors(file: &PlyFile, names: [&str; 3]) -> Result<Vec<Vec3>> {
    let vectors = vectors(file, names)?;
    let Some(vertex) = vectors.iter().position(|v| (v.length() - 1.0).abs() > 1e-3) else {
        return Ok(vectors);
    };
    let found = vectors[vertex];
    Err(Error::data(
        format!("vertex {vertex}, properties {}", names.join(" ")),
        format!("{:?} of length {}", found.to_array(), found.length()),
    )
    .expected("a unit vector"))
}

/// A column of whole numbers from 0 to `most`.
fn whole_column<'a>(file: &'a PlyFile, name: &str, most: f64) -> Result<&'a [f64]> {
    let column = checked_column(file, name, 0.0..=most)?;
    match column.iter().position(|label| label.fract() != 0.0) {
        None => Ok(column),
        Some(vertex) => {
            let place = format!("vertex {vertex}, property {name}");
            Err(Error::data(place, column[vertex].to_string()).expected("a whole number"))
        }
    }
}

/// The column `transition`, where there is one.
fn transition(file: &PlyFile) -> Result<Option<Vec<f32>>> {
    if file.column("transition").is_none() {
        return Ok(None);
    }
    let column = checked_column(file, "transition", 0.0..=1.0)?;
    Ok(Some(column.iter().map(|&value| value as f32).collect()))
}

/// The column `mask`, where there is one.
fn mask(file: &PlyFile) -> Result<Option<Vec<u8>>> {
    if file.column("mask").is_none() {
        return Ok(None);
    }
    let column = whole_column(file, "mask", 3.0)?;
    Ok(Some(column.iter().map(|&label| label as u8).collect()))
}

/// The column `scale`, where there is one that is not 1 everywhere. A texel times its scale has the
/// range of a texel.
fn scale(file: &PlyFile, texel: f64) -> Result<Option<Vec<f32>>> {
    let Some(column) = file.column("scale") else {
        return Ok(None);
    };
    let scale: Vec<f32> = column.iter().map(|&value| value as f32).collect();
    check_scale(&scale, texel)?;
    Ok(varying(Some(&scale)).map(<[f32]>::to_vec))
}

/// Refuses a scale that is no number above 0, or that makes a texel too small or large to measure with.
pub fn check_scale(scale: &[f32], texel: f64) -> Result<()> {
    let sound = |scale: &f32| {
        *scale > 0.0 && (1.0 / FARTHEST..=FARTHEST).contains(&(texel * f64::from(*scale)))
    };
    let Some(vertex) = scale.iter().position(|scale| !sound(scale)) else {
        return Ok(());
    };
    let place = format!("vertex {vertex}, property scale");
    let expected = format!("above 0, and from 1e-15 to 1e15 times the texel of {texel:e}");
    Err(Error::data(place, scale[vertex].to_string()).expected(expected))
}

/// The faces of a file, all of them triangles.
pub(super) fn triangles(file: &PlyFile) -> Result<Vec<[u32; 3]>> {
    let triangle = |(face, polygon): (usize, &[u32])| {
        <[u32; 3]>::try_from(polygon).map_err(|_| {
            Error::data(format!("face {face}"), format!("{} corners", polygon.len())).expected("3")
        })
    };
    file.faces.iter().enumerate().map(triangle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::id::ContentId;

    fn small_map() -> SurfaceTextonMap {
        let id = ContentId::of_bytes(b"x");
        SurfaceTextonMap {
            mesh: TriangleMesh {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                triangles: vec![[0, 1, 2]],
            },
            normals: vec![Vec3::Z; 3],
            orientations: vec![Vec3::X; 3],
            scale: Some(vec![1.0, 0.5, 2.0]),
            transition: Some(vec![0.0, 0.25, 1.0]),
            mask: Some(vec![3, 0, 1]),
            coords: vec![TexCoord { s: 0.5, t: 0.5 }; 3],
            textons: vec![TextonLabel(1), TextonLabel(2), TextonLabel::NONE],
            header: MapHeader {
                exemplar: [8, 4],
                texel: 0.25,
                origin: DVec3::new(4_485_513.7, -0.1, 0.0),
                seed: 7,
                method: "wei-levoy".into(),
                polish: 2,
                sample: id.clone(),
                space: id,
            },
        }
    }

    #[test]
    fn maps_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.map.ply");
        let map = small_map();
        map.write(&path).unwrap();
        assert_eq!(SurfaceTextonMap::read(&path).unwrap(), map);
        let bytes = std::fs::read(&path).unwrap();
        let header = String::from_utf8_lossy(&bytes[..320]).into_owned();
        for line in [
            "comment mesotex 1\n",
            "comment exemplar 8 4\n",
            "comment texel 0.25\n",
            "comment seed 7\n",
            "comment method wei-levoy\n",
            "comment polish 2\n",
            "comment origin 4485513.7 -0.1 0\n",
        ] {
            assert!(header.contains(line), "{header}");
        }
    }

    #[test]
    fn a_scale_of_one_is_no_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.map.ply");
        let read = |scale| {
            let map = SurfaceTextonMap {
                scale,
                ..small_map()
            };
            map.write(&path).unwrap();
            let columns = ply::read(&path).unwrap();
            let has_column = columns.column("scale").is_some();
            (SurfaceTextonMap::read(&path).unwrap(), has_column)
        };
        let (map, has_column) = read(Some(vec![1.0, 0.5, 2.0]));
        assert_eq!([0, 1, 2].map(|v| map.texel_at(v)), [0.25, 0.125, 0.5]);
        assert!(has_column);
        for scale in [Some(vec![1.0; 3]), None] {
            let (map, has_column) = read(scale);
            assert_eq!((&map.scale, has_column), (&None, false));
            assert_eq!([0, 1, 2].map(|v| map.texel_at(v)), [0.25; 3]);
        }
    }

    #[test]
    fn impossible_maps_are_refused_by_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.map.ply");
        let refused = |change: &dyn Fn(&mut SurfaceTextonMap)| {
            let mut map = small_map();
            change(&mut map);
            map.write(&path).unwrap();
            SurfaceTextonMap::read(&path).unwrap_err().to_string()
        };
        assert!(refused(&|m| m.coords[1].s = 8.0).contains("vertex 1, property s"));
        assert!(refused(&|m| m.coords[2].t = 0.0).contains("vertex 2, property t"));
        assert!(refused(&|m| m.mesh.positions[0].x = f32::NAN).contains("property x: NaN"));
        assert!(refused(&|m| m.normals[0] = Vec3::ZERO).contains("unit vector"));
        assert!(refused(&|m| m.header.exemplar = [0, 4]).contains("comment exemplar"));
        assert!(refused(&|m| m.header.method = "A b".into()).contains("comment method"));
        assert!(refused(&|m| m.header.texel = -1.0).contains("comment texel"));
        for scale in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-16, 1e17] {
            let text = refused(&|m| m.scale = Some(vec![1.0, scale, 1.0]));
            assert!(
                text.contains(&format!("vertex 1, property scale: {scale}")),
                "{text}"
            );
        }
        assert!(refused(&|m| m.header.origin.y = f64::NAN).contains("comment origin"));
    }
}
