//! The folder of an atlas map, out and in.

use std::path::Path;

use glam::DVec3;
use ndarray::ArrayViewD;

use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::own_folder::OwnFolder;
use crate::format::{json, npy};
use crate::grid::TexCoord;
use crate::index::TextonLabel;
use crate::maps::atlas_map::description::{
    AtlasIds, ChannelFile, DESCRIPTION, Description, FORMAT, VERSION,
};
use crate::maps::atlas_map::map::AtlasMap;
use crate::maps::atlas_map::surface::{self, SURFACE, SurfaceFile};
use crate::maps::header::MapHeader;

const COORDS: &str = "coords.npy";
const TEXTON: &str = "texton.npy";
/// The mesh with its textures.
pub const MODEL: &str = "surface.glb";

/// The folder of an atlas; the images of its channels are listed in its description.
pub const ATLAS_FOLDER: OwnFolder = OwnFolder {
    name: "an atlas",
    ending: Some("atlas"),
    description: DESCRIPTION,
    format: FORMAT,
    members: &[COORDS, TEXTON, SURFACE, MODEL],
};

impl AtlasMap {
    /// Writes coordinates, surface and description into a folder under construction; the images of
    /// `channels` and the model are written beside them by others.
    pub fn write_into(&self, folder: &Path, channels: Vec<ChannelFile>) -> Result<()> {
        self.check_lengths()?;
        self.check()?;
        let description = Description {
            format: FORMAT.into(),
            version: VERSION,
            width: self.width,
            height: self.height,
            exemplar: self.header.exemplar,
            tileable: self.tileable,
            texel: self.header.texel,
            origin: self.header.origin.to_array(),
            seed: self.header.seed,
            method: self.header.method.clone(),
            polish: self.header.polish,
            ids: AtlasIds {
                sample: self.header.sample.clone(),
                space: self.header.space.clone(),
                coords: self.write_coords(&folder.join(COORDS))?,
                texton: self.write_textons(&folder.join(TEXTON))?,
                surface: surface::write(&folder.join(SURFACE), self)?,
            },
            channels,
        };
        description.check()?;
        json::write(&folder.join(DESCRIPTION), &description)
    }

    fn write_coords(&self, path: &Path) -> Result<ContentId> {
        let number = |coord: &Option<TexCoord>| match coord {
            Some(TexCoord { s, t }) => [*s, *t],
            None => [f32::NAN; 2],
        };
        let numbers: Vec<f32> = self.coords.iter().flat_map(number).collect();
        self.write_array(
            path,
            &[self.height as usize, self.width as usize, 2],
            &numbers,
        )
    }

    /// Labels are kept where there are any.
    fn write_textons(&self, path: &Path) -> Result<Option<ContentId>> {
        if self.textons.iter().all(|label| *label == TextonLabel::NONE) {
            return Ok(None);
        }
        let labels: &[u16] = bytemuck::cast_slice(&self.textons);
        let id = self.write_array(path, &[self.height as usize, self.width as usize], labels)?;
        Ok(Some(id))
    }

    fn write_array<T: npy::Element>(
        &self,
        path: &Path,
        shape: &[usize],
        numbers: &[T],
    ) -> Result<ContentId> {
        let array = ArrayViewD::from_shape(shape, numbers)
            .map_err(|error| Error::data("shape", error.to_string()))?;
        npy::write(path, array)?;
        ContentId::of_file(path)
    }

    /// Reads the description of a folder, and refuses one whose size its coordinates do not have.
    pub fn read_description(folder: &Path) -> Result<Description> {
        let description = Description::read(folder)?;
        let path = folder.join(COORDS);
        let header = npy::read_header(&path)?;
        let wanted = [description.height as usize, description.width as usize, 2];
        check_shape(&header.shape, &wanted).map_err(|error| error.in_file(&path))?;
        Ok(description)
    }

    /// Reads a folder and checks every number that a later stage relies on.
    pub fn read(folder: &Path) -> Result<Self> {
        // Read each file.
        let description = Self::read_description(folder)?;
        let sides = [description.height as usize, description.width as usize];
        let coords = read_coords(folder, sides, &description)?;
        let textons = read_textons(folder, sides, &description)?;
        let surface = surface::read(&folder.join(SURFACE), sides, &description.ids.surface)?;
        // Put the map together.
        let map = Self {
            mesh: surface.mesh,
            vertex_normals: surface.vertex_normals,
            corner_uvs: surface.corner_uvs,
            chart_of: surface.chart_of,
            width: description.width,
            height: description.height,
            chart: surface.chart,
            position: surface.position,
            normal: surface.normal,
            orientation: surface.orientation,
            scale: surface.scale,
            coords,
            textons,
            tileable: description.tileable,
            header: MapHeader {
                exemplar: description.exemplar,
                texel: description.texel,
                origin: DVec3::from_array(description.origin),
                seed: description.seed,
                method: description.method,
                polish: description.polish,
                sample: description.ids.sample,
                space: description.ids.space,
            },
        };
        // Check what only the whole tells.
        map.check().map_err(|error| error.in_file(folder))?;
        Ok(map)
    }

    /// Lists of every length but the right one are a fault of the caller.
    fn check_lengths(&self) -> Result<()> {
        // List each column with its right length.
        let texels = self.len();
        let triangles = self.mesh.triangles.len();
        let lengths = [
            ("chart", self.chart.len(), texels),
            ("position", self.position.len(), texels),
            ("normal", self.normal.len(), texels),
            ("orientation", self.orientation.len(), texels),
            ("coords", self.coords.len(), texels),
            ("textons", self.textons.len(), texels),
            (
                "vertex normals",
                self.vertex_normals.len(),
                self.mesh.positions.len(),
            ),
            ("corner uvs", self.corner_uvs.len(), triangles),
            ("chart of", self.chart_of.len(), triangles),
        ];
        let scaled = self.scale.as_ref().map_or(texels, Vec::len);
        if scaled != texels {
            return Err(
                Error::data("scale", format!("{scaled} entries")).expected(texels.to_string())
            );
        }
        // Name the first that is off.
        match lengths.iter().find(|(_, found, wanted)| found != wanted) {
            None => Ok(()),
            Some((name, found, wanted)) => {
                Err(Error::data(*name, format!("{found} entries")).expected(wanted.to_string()))
            }
        }
    }

    /// Refuses numbers that no atlas has.
    fn check(&self) -> Result<()> {
        SurfaceFile::check(self)?;
        // Check each texel: a coordinate inside charts, none outside.
        let [width, height] = self.header.exemplar.map(|side| side as f32);
        let columns = self.width as usize;
        for (texel, (coord, &chart)) in self.coords.iter().zip(&self.chart).enumerate() {
            let fault = |name: &str, found: String, expected: String| {
                let place = format!(
                    "{name}, row {}, column {}",
                    texel / columns,
                    texel % columns
                );
                Err(Error::data(place, found).expected(expected))
            };
            match coord {
                Some(TexCoord { s, t }) if chart >= 0 => {
                    if !((0.0..width).contains(s) && *t > 0.0 && *t <= height) {
                        let expected = format!("0 ≤ s < {width}, 0 < t ≤ {height}");
                        return fault(COORDS, format!("({s}, {t})"), expected);
                    }
                }
                None if chart < 0 => {}
                Some(TexCoord { s, t }) => {
                    let expected = "NaN outside charts".into();
                    return fault(COORDS, format!("({s}, {t})"), expected);
                }
                None => {
                    let expected = format!("a coordinate inside chart {chart}");
                    return fault(COORDS, "NaN".into(), expected);
                }
            }
            if chart < 0 && self.textons[texel] != TextonLabel::NONE {
                let expected = "65535 outside charts".into();
                return fault(TEXTON, self.textons[texel].0.to_string(), expected);
            }
        }
        Ok(())
    }
}

fn read_coords(
    folder: &Path,
    [height, width]: [usize; 2],
    description: &Description,
) -> Result<Vec<Option<TexCoord>>> {
    let numbers: Vec<f32> =
        read_array(folder, COORDS, &[height, width, 2], &description.ids.coords)?;
    let coord = |pair: &[f32]| match pair {
        [s, t] if s.is_nan() && t.is_nan() => None,
        _ => Some(TexCoord {
            s: pair[0],
            t: pair[1],
        }),
    };
    Ok(numbers.chunks_exact(2).map(coord).collect())
}

fn read_textons(
    folder: &Path,
    [height, width]: [usize; 2],
    description: &Description,
) -> Result<Vec<TextonLabel>> {
    let Some(id) = &description.ids.texton else {
        return Ok(vec![TextonLabel::NONE; height * width]);
    };
    let labels: Vec<u16> = read_array(folder, TEXTON, &[height, width], id)?;
    Ok(labels.into_iter().map(TextonLabel).collect())
}

fn check_shape(found: &[usize], wanted: &[usize]) -> Result<()> {
    match found == wanted {
        true => Ok(()),
        false => Err(Error::data("shape", format!("{found:?}"))
            .expected(format!("{wanted:?}, as {DESCRIPTION} states"))
            .advice(
                "the folder's files come from different runs, or were changed; synthesize it again",
            )),
    }
}

/// An array of a known shape and content.
fn read_array<T: npy::Element>(
    folder: &Path,
    name: &str,
    shape: &[usize],
    wanted: &ContentId,
) -> Result<Vec<T>> {
    let path = folder.join(name);
    let array = npy::read::<T>(&path)?;
    check_shape(array.shape(), shape).map_err(|error| error.in_file(&path))?;
    let found = ContentId::of_file(&path)?;
    if found != *wanted {
        return Err(Error::data("content", format!("id {found}"))
            .expected(format!("{wanted}, as {DESCRIPTION} states"))
            .advice(
                "the folder's files come from different runs, or were changed; synthesize it again",
            )
            .in_file(&path));
    }
    Ok(array.into_iter().collect())
}
