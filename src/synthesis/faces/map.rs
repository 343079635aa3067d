//! The face map of a texture that choosy sampling has finished.

use glam::DVec3;

use crate::exemplar::space::Space;
use crate::maps::face_map::{FaceMap, Square};
use crate::maps::header::MapHeader;
use crate::sites::faces::pyramid::FacePyramid;
use crate::synthesis::options::Method;
use crate::synthesis::recipes::choosy::{ChoosyResult, Source};

/// The map of the finest level, without colours; positions count from `origin`.
pub fn face_map(
    space: &Space,
    (surface, result): (&FacePyramid, &ChoosyResult),
    square: Square,
    (origin, seed): (DVec3, u64),
) -> FaceMap {
    let finest = surface.levels.len() - 1;
    let mesh = surface.levels[finest].mesh.clone();
    // Number the sample's faces row by row; turned ones follow.
    let order = result.sample.grid.row_by_row(finest);
    let mut numbers = vec![0u32; order.len()];
    for (number, &face) in order.iter().enumerate() {
        numbers[face as usize] = number as u32;
    }
    let number_of = |source: &Source| {
        let first = u32::from(source.turn) * order.len() as u32;
        first + numbers[source.face as usize]
    };
    // Put the map together.
    let grid = space.levels[0].grid;
    FaceMap {
        colors: None,
        channels: Vec::new(),
        sources: result.sources.iter().map(number_of).collect(),
        phases: result.sources.iter().map(|source| source.phase).collect(),
        square,
        subdivisions: finest as u32,
        header: MapHeader {
            exemplar: [grid.width, grid.height],
            texel: (3f64.sqrt() * mesh.area() / mesh.triangles.len() as f64).sqrt(),
            origin,
            seed,
            method: Method::Choosy.name().into(),
            polish: 0,
            sample: space.sample.clone(),
            space: space.id.clone(),
        },
        mesh,
    }
}
