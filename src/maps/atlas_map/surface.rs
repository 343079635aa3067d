//! `surface.npz`: the surface of every texel of an atlas, and the mesh with its texture coordinates.
//!
//! The mesh stands here, and not in `surface.glb` alone: glTF repeats vertices, and programs that edit a
//! GLB renumber them.

use std::io;
use std::path::Path;

use glam::{Vec2, Vec3};
use ndarray::{Array, ArrayView, Dimension, Ix1, Ix2, Ix3};
use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::format::id::ContentId;
use crate::format::npy::Element;
use crate::format::npz;
use crate::format::polygon_mesh::FARTHEST;
use crate::maps::atlas_map::map::AtlasMap;
use crate::mesh::triangle_mesh::TriangleMesh;

/// The file's name.
pub const SURFACE: &str = "surface.npz";
/// `format` in its `meta.json`.
const FORMAT: &str = "mesotex-atlas-surface";
/// The version written, and the only one read.
const VERSION: u32 = 1;

/// What the file holds; per texel row by row.
pub(super) struct SurfaceFile {
    pub(super) mesh: TriangleMesh,
    pub(super) vertex_normals: Vec<Vec3>,
    pub(super) corner_uvs: Vec<[Vec2; 3]>,
    pub(super) chart_of: Vec<u32>,
    pub(super) chart: Vec<i32>,
    pub(super) position: Vec<Vec3>,
    pub(super) normal: Vec<Vec3>,
    pub(super) orientation: Vec<Vec3>,
    pub(super) scale: Option<Vec<f32>>,
}

/// Writes the file; returns its id.
pub(super) fn write(path: &Path, map: &AtlasMap) -> Result<ContentId> {
    let meta = json!({"format": FORMAT, "version": VERSION});
    let meta = meta.as_object().cloned().unwrap_or_default();
    let (width, height) = (map.width as usize, map.height as usize);
    let (vertices, triangles) = (map.mesh.positions.len(), map.mesh.triangles.len());
    // Write what holds per texel.
    npz::write(path, meta, |file| {
        for (name, vectors) in [
            ("position", &map.position),
            ("normal", &map.normal),
            ("orientation", &map.orientation),
        ] {
            file.array(
                name,
                view(
                    [height, width, 3],
                    bytemuck::cast_slice::<Vec3, f32>(vectors),
                )?,
            )?;
        }
        if let Some(scale) = &map.scale {
            file.array("scale", view([height, width], scale)?)?;
        }
        // Write the mesh and its charts.
        file.array("chart", view([height, width], &map.chart)?)?;
        let positions: &[f32] = bytemuck::cast_slice(&map.mesh.positions);
        file.array("vertices", view([vertices, 3], positions)?)?;
        let normals: &[f32] = bytemuck::cast_slice(&map.vertex_normals);
        file.array("vertex_normals", view([vertices, 3], normals)?)?;
        let corners: &[u32] = bytemuck::cast_slice(&map.mesh.triangles);
        file.array("triangles", view([triangles, 3], corners)?)?;
        let uvs: &[f32] = bytemuck::cast_slice(&map.corner_uvs);
        file.array("corner_uvs", view([triangles, 3, 2], uvs)?)?;
        file.array("triangle_chart", view([triangles], &map.chart_of)?)
    })
}

fn view<T, const N: usize>(
    shape: [usize; N],
    numbers: &[T],
) -> io::Result<ArrayView<'_, T, ndarray::Dim<[usize; N]>>>
where
    ndarray::Dim<[usize; N]>: Dimension,
    [usize; N]: ndarray::IntoDimension<Dim = ndarray::Dim<[usize; N]>>,
{
    ArrayView::from_shape(shape, numbers).map_err(io::Error::other)
}

/// Reads the file of a folder whose atlas has these sides; `wanted` is the id that the atlas states.
pub(super) fn read(path: &Path, sides: [usize; 2], wanted: &ContentId) -> Result<SurfaceFile> {
    let mut file = npz::Reader::open(path)?;
    check_meta(&mut file, wanted)?;
    // Read what holds per texel.
    let [height, width] = sides;
    let position = array::<f32, Ix3>(&mut file, "position", &[height, width, 3])?;
    let normal = array::<f32, Ix3>(&mut file, "normal", &[height, width, 3])?;
    let orientation = array::<f32, Ix3>(&mut file, "orientation", &[height, width, 3])?;
    let chart = array::<i32, Ix2>(&mut file, "chart", &[height, width])?;
    let scale = match file.has("scale") {
        true => Some(array::<f32, Ix2>(&mut file, "scale", &[height, width])?),
        false => None,
    };
    // Read the mesh and its charts.
    let vertices = file.array::<f32, Ix2>("vertices")?;
    let count = vertices.nrows();
    let vertices = shaped(&file, "vertices", vertices, &[count, 3])?;
    let normals = array::<f32, Ix2>(&mut file, "vertex_normals", &[count, 3])?;
    let corners = file.array::<u32, Ix2>("triangles")?;
    let triangles = corners.nrows();
    let corners = shaped(&file, "triangles", corners, &[triangles, 3])?;
    let uvs = array::<f32, Ix3>(&mut file, "corner_uvs", &[triangles, 3, 2])?;
    let chart_of = array::<u32, Ix1>(&mut file, "triangle_chart", &[triangles])?;
    Ok(SurfaceFile {
        mesh: TriangleMesh {
            positions: vectors(&vertices),
            triangles: corners
                .chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]])
                .collect(),
        },
        vertex_normals: vectors(&normals),
        corner_uvs: bytemuck::pod_collect_to_vec(&uvs),
        chart_of,
        chart,
        position: vectors(&position),
        normal: vectors(&normal),
        orientation: vectors(&orientation),
        scale,
    })
}

fn check_meta(file: &mut npz::Reader, wanted: &ContentId) -> Result<()> {
    let meta: Value = file.meta()?;
    let found = format!("{} {}", meta["format"], meta["version"]);
    if meta["format"] != FORMAT || meta["version"] != VERSION {
        return Err(file
            .fault("meta.json: format, version", found)
            .expected(format!("\"{FORMAT}\" {VERSION}")));
    }
    let id = meta["id"].as_str().unwrap_or("missing");
    match ContentId::parse(id).as_ref() == Some(wanted) {
        true => Ok(()),
        false => Err(file
            .fault("meta.json: id", id)
            .expected(format!("{wanted}, as atlas.json states"))
            .advice("the folder's files come from different runs; synthesize it again")),
    }
}

/// An array of a known shape, in C order.
fn array<T: Element, D: Dimension>(
    file: &mut npz::Reader,
    name: &str,
    shape: &[usize],
) -> Result<Vec<T>> {
    let array = file.array::<T, D>(name)?;
    shaped(file, name, array, shape)
}

fn shaped<T: Element, D: Dimension>(
    file: &npz::Reader,
    name: &str,
    array: Array<T, D>,
    shape: &[usize],
) -> Result<Vec<T>> {
    if array.shape() != shape {
        return Err(file
            .fault(name, format!("shape {:?}", array.shape()))
            .expected(format!("{shape:?}")));
    }
    // Readers hand on arrays in C order.
    Ok(array.into_iter().collect())
}

fn vectors(numbers: &[f32]) -> Vec<Vec3> {
    numbers.chunks_exact(3).map(Vec3::from_slice).collect()
}

impl SurfaceFile {
    /// Refuses a mesh that is none, and texels whose surface is none.
    pub(super) fn check(map: &AtlasMap) -> Result<()> {
        check_mesh(map)?;
        // Count the charts.
        let charts = map
            .chart_of
            .iter()
            .max()
            .map_or(0, |last| i64::from(*last) + 1);
        let width = map.width as usize;
        // Check each texel inside them.
        for (texel, &chart) in map.chart.iter().enumerate() {
            let fault = |name: &str, found: String, expected: String| {
                let place = format!("{name}, row {}, column {}", texel / width, texel % width);
                Err(Error::data(place, found).expected(expected))
            };
            if !(-1..charts).contains(&i64::from(chart)) {
                let expected = format!("−1, or a chart below {charts}");
                return fault("chart", chart.to_string(), expected);
            }
            if chart < 0 {
                continue;
            }
            if !(1.0 / FARTHEST..=FARTHEST).contains(&map.texel_at(texel)) {
                let expected = "above 0, and a texel of 1e-15 to 1e15 mesh units".into();
                let scale = map.scale.as_ref().map_or(1.0, |scale| scale[texel]);
                return fault("scale", scale.to_string(), expected);
            }
            if !is_near(map.position[texel]) {
                let found = map.position[texel].to_string();
                return fault("position", found, "finite numbers, none beyond 1e15".into());
            }
            for (name, vector) in [
                ("normal", map.normal[texel]),
                ("orientation", map.orientation[texel]),
            ] {
                if !is_unit(vector) {
                    return fault(name, vector.to_string(), "a unit vector".into());
                }
            }
        }
        Ok(())
    }
}

fn check_mesh(map: &AtlasMap) -> Result<()> {
    let fault = |place: String, found: String, expected: &str| {
        Err(Error::data(place, found).expected(expected))
    };
    // Check the vertices.
    let (vertices, triangles) = (map.mesh.positions.len(), map.mesh.triangles.len());
    if triangles == 0 {
        return fault("triangles".into(), "none".into(), "a surface");
    }
    for (vertex, (position, normal)) in map
        .mesh
        .positions
        .iter()
        .zip(&map.vertex_normals)
        .enumerate()
    {
        if !is_near(*position) {
            let place = format!("vertices, row {vertex}");
            return fault(
                place,
                position.to_string(),
                "finite numbers, none beyond 1e15",
            );
        }
        if !is_unit(*normal) {
            let place = format!("vertex_normals, row {vertex}");
            return fault(place, normal.to_string(), "a unit vector");
        }
    }
    // Check the triangles, their texture coordinates and charts.
    for (triangle, corners) in map.mesh.triangles.iter().enumerate() {
        if corners.iter().any(|&vertex| vertex as usize >= vertices) {
            let place = format!("triangles, row {triangle}");
            let expected = format!("vertices below {vertices}");
            return fault(place, format!("{corners:?}"), &expected);
        }
        let uvs = map.corner_uvs[triangle];
        if !uvs
            .iter()
            .all(|uv| uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all())
        {
            let place = format!("corner_uvs, row {triangle}");
            return fault(place, format!("{uvs:?}"), "numbers from 0 to 1");
        }
        if map.chart_of[triangle] as usize >= triangles {
            let place = format!("triangle_chart, row {triangle}");
            let expected = format!("a chart below {triangles}");
            return fault(place, map.chart_of[triangle].to_string(), &expected);
        }
    }
    Ok(())
}

fn is_near(position: Vec3) -> bool {
    position.abs().max_element() <= FARTHEST as f32 && position.is_finite()
}

fn is_unit(vector: Vec3) -> bool {
    (vector.length() - 1.0).abs() <= 1e-3
}
