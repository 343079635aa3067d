//! A surface texton map: its size and scale, and whether it belongs to a space or a sample.

use std::path::Path;

use crate::btf::sample::{DESCRIPTION, Sample};
use crate::cli::outcome::Outcome;
use crate::error::{Error, Result};
use crate::exemplar::space::{Features, Space, SpaceLevel};
use crate::format::id::{ContentId, check_same};
use crate::grid::TexelGrid;
use crate::index::TextonLabel;
use crate::maps::MapHeader;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::origin::origin_text;

/// Adds where a map comes from, and its scale.
pub(super) fn with_header(outcome: Outcome, header: &MapHeader) -> Outcome {
    let outcome = outcome
        .figure("texel", header.texel)
        .figure("seed", header.seed)
        .figure("method", header.method.as_str())
        .figure("polish", header.polish)
        .figure("origin", header.origin.to_array().to_vec())
        .figure("sample", header.sample.to_string())
        .figure("space", header.space.to_string());
    match origin_text(header.origin) {
        Some(origin) => outcome.line(format!("positions are relative to the origin {origin}")),
        None => outcome,
    }
}

/// Reads a whole map and describes its content.
pub fn describe(path: &Path, against: Option<&Path>) -> Result<Outcome> {
    let map = SurfaceTextonMap::read(path)?;
    let [width, height] = map.header.exemplar;
    let unused = map
        .textons
        .iter()
        .filter(|&&texton| texton == TextonLabel::NONE)
        .count();
    // Tell what the map holds.
    let mut outcome = Outcome::default()
        .line(format!(
            "surface texton map: {} vertices, {} triangles, sample of {width} × {height} texels",
            map.mesh.positions.len(),
            map.mesh.triangles.len(),
        ))
        .line(format!(
            "a texel covers {:.6} mesh units; method {}, seed {}",
            map.header.texel, map.header.method, map.header.seed
        ))
        .line(format!("{unused} vertices have no texton"))
        .figure("kind", "surface texton map")
        .figure("vertices", map.mesh.positions.len())
        .figure("triangles", map.mesh.triangles.len())
        .figure("exemplar", vec![width, height]);
    // Tell its scale and where it comes from.
    if let Some([least, most]) = range(map.scale.as_deref()) {
        outcome = outcome
            .line(format!(
                "scale from {least} to {most}: a texel covers that many times as much"
            ))
            .figure("scale", vec![least, most]);
    }
    outcome = with_header(outcome, &map.header);
    // Check whether it belongs to the other file.
    if let Some(other) = against {
        check_belongs(&map, other).map_err(|error| error.in_file(path))?;
        outcome = outcome.line(format!("it belongs to {}", other.display()));
    }
    Ok(outcome)
}

/// The least and the largest scale of a map that has any.
fn range(scale: Option<&[f32]>) -> Option<[f32; 2]> {
    let around = |[least, most]: [f32; 2], scale: &f32| [least.min(*scale), most.max(*scale)];
    scale.map(|scale| scale.iter().fold([f32::INFINITY, 0.0], around))
}

/// Refuses a map that was not made from `other`, a space or a sample.
fn check_belongs(map: &SurfaceTextonMap, other: &Path) -> Result<()> {
    let space = check_belongs_to(
        (map.header.exemplar, &map.header.sample, &map.header.space),
        other,
    )?;
    match space.as_ref().map(|space| &space.levels[0]) {
        Some(SpaceLevel {
            grid,
            features: Features::Textons { labels, .. },
        }) => check_labels(map, *grid, labels),
        _ => Ok(()),
    }
}

/// Refuses a map of some size, sample and space that was not made from `other`; returns it if it is a space.
pub(super) fn check_belongs_to(
    (exemplar, sample_id, space_id): ([u32; 2], &ContentId, &ContentId),
    other: &Path,
) -> Result<Option<Space>> {
    if other.join(DESCRIPTION).is_file() {
        let sample = Sample::open(other)?;
        check_size(exemplar, sample.grid())?;
        check_same("sample id", sample_id, sample.id(), false)?;
        return Ok(None);
    }
    let space = Space::read(other)?;
    check_size(exemplar, space.levels[0].grid)?;
    check_same("space id", space_id, &space.id, false)?;
    Ok(Some(space))
}

fn check_size([width, height]: [u32; 2], grid: TexelGrid) -> Result<()> {
    if [width, height] == [grid.width, grid.height] {
        return Ok(());
    }
    Err(Error::data("comment exemplar", format!("{width} {height}"))
        .expected(format!("{} {}", grid.width, grid.height)))
}

/// Every vertex must carry the label of the texel its coordinate names.
fn check_labels(map: &SurfaceTextonMap, grid: TexelGrid, labels: &[u16]) -> Result<()> {
    let vertices = map.textons.iter().zip(&map.coords).enumerate();
    for (vertex, (&texton, &coord)) in vertices {
        let label = labels[grid.texel_nearest(coord).index()];
        if texton != TextonLabel::NONE && texton.0 != label {
            return Err(Error::data(
                format!("vertex {vertex}, property texton"),
                texton.0.to_string(),
            )
            .expected(format!("{label}, the texton at its texture coordinate")));
        }
    }
    Ok(())
}
