//! The pyramids of a sample and a surface as one archive (docs/formats.md).

use std::io;
use std::path::Path;

use ndarray::{ArrayView1, ArrayView2, ArrayView3};
use serde_json::{Map, Value, json};

use crate::error::Result;
use crate::format::npz::{self, Writer};
use crate::maps::face_map::FaceMap;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::faces::pyramid::FacePyramid;
use crate::synthesis::recipes::choosy::value_pyramid::ValuePyramid;
use crate::synthesis::recipes::choosy::{ChoosyResult, FaceValues};

/// `format` in `meta.json`.
pub const FORMAT: &str = "mesotex-face-levels";
/// The version written.
const VERSION: u32 = 1;

/// Writes the levels; level 0 is the finest, as in all files.
pub fn write_levels(
    path: &Path,
    (surface, result): (&FacePyramid, &ChoosyResult),
    map: &FaceMap,
) -> Result<()> {
    let levels = surface.levels.len();
    npz::write(path, meta(result, map, levels), |file| {
        let (sample, finest_first) = (&result.sample, (0..levels).rev());
        for (number, level) in finest_first.enumerate() {
            // Write what the sample has on this level.
            let of_sample = format!("sample/L{number}");
            write_mesh(file, &of_sample, &sample.grid.pyramid.levels[level].mesh)?;
            let both = |of: fn(&ValuePyramid) -> &Vec<FaceValues>| {
                sample
                    .pyramids
                    .each_ref()
                    .map(|pyramid| &of(pyramid)[level])
            };
            write_both(
                file,
                &format!("{of_sample}/gaussian"),
                both(|pyramid| &pyramid.gaussian),
            )?;
            // Write what the surface has.
            let of_surface = format!("surface/L{number}");
            let faces = &surface.levels[level];
            write_mesh(file, &of_surface, &faces.mesh)?;
            let white: Vec<u8> = faces.white.iter().map(|&white| white.into()).collect();
            file.array(&format!("{of_surface}/white"), ArrayView1::from(&white[..]))?;
            write_values(
                file,
                &format!("{of_surface}/gaussian"),
                &result.pyramid.gaussian[level],
            )?;
            if level > 0 {
                write_both(
                    file,
                    &format!("{of_sample}/laplacian"),
                    both(|pyramid| &pyramid.laplacian),
                )?;
                write_values(
                    file,
                    &format!("{of_surface}/laplacian"),
                    &result.pyramid.laplacian[level],
                )?;
            }
        }
        Ok(())
    })
    .map(drop)
}

fn meta(result: &ChoosyResult, map: &FaceMap, levels: usize) -> Map<String, Value> {
    let square = map.square;
    let meta = json!({
        "format": FORMAT,
        "version": VERSION,
        "levels": levels,
        "channels": result.pyramid.gaussian[0].channels,
        "square": [square.left, square.top, square.side],
        "seed": map.header.seed,
        "sample": map.header.sample,
        "space": map.header.space,
    });
    match meta {
        Value::Object(fields) => fields,
        _ => Map::new(),
    }
}

fn write_mesh(file: &mut Writer<'_>, name: &str, mesh: &TriangleMesh) -> io::Result<()> {
    let positions: &[f32] = bytemuck::cast_slice(&mesh.positions);
    let shape = (mesh.positions.len(), 3);
    file.array(&format!("{name}/positions"), view(shape, positions)?)?;
    let corners = mesh.triangles.as_flattened();
    let shape = (mesh.triangles.len(), 3);
    file.array(&format!("{name}/triangles"), view(shape, corners)?)
}

fn view<T>(shape: (usize, usize), numbers: &[T]) -> io::Result<ArrayView2<'_, T>> {
    ArrayView2::from_shape(shape, numbers).map_err(io::Error::other)
}

fn write_values(file: &mut Writer<'_>, name: &str, values: &FaceValues) -> io::Result<()> {
    let shape = (values.count(), values.channels);
    file.array(name, view(shape, &values.numbers)?)
}

/// The values on the upright grid, then those on the turned one.
fn write_both(file: &mut Writer<'_>, name: &str, values: [&FaceValues; 2]) -> io::Result<()> {
    let [upright, turned] = values;
    let numbers = [&upright.numbers[..], &turned.numbers].concat();
    let shape = (2, upright.count(), upright.channels);
    let both = ArrayView3::from_shape(shape, &numbers).map_err(io::Error::other)?;
    file.array(name, both)
}
