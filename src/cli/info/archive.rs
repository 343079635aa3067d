//! A texton vocabulary, a surface texton space or a neighbour table: read whole and checked.

use std::path::Path;

use ndarray::{Ix2, Ix3};
use serde_json::Value;

use crate::cli::exemplar::describe_channels;
use crate::cli::outcome::Outcome;
use crate::error::{Error, Result};
use crate::exemplar::neighbor_table::{self, NeighborTable};
use crate::exemplar::space::{self, Features, Space, SpaceKind};
use crate::format::npz;
use crate::grid::TexelGrid;
use crate::synthesis::faces::levels_file;
use crate::texton::PartFile;
use crate::texton::parts;
use crate::texton::vocabulary::{self, StoredVocabulary};

/// Reads an archive and describes its content.
pub fn describe(path: &Path) -> Result<Outcome> {
    let meta: Value = npz::Reader::open(path)?.meta()?;
    match meta["format"].as_str() {
        Some(vocabulary::FORMAT) => Ok(describe_vocabulary(&StoredVocabulary::open(path)?)),
        Some(space::FORMAT) => Ok(describe_space(&Space::read(path)?)),
        Some(neighbor_table::FORMAT) => Ok(describe_table(&NeighborTable::read(path)?)),
        Some(levels_file::FORMAT) => describe_levels(path, &meta),
        Some(parts::FORMAT) => describe_part(path),
        other => Err(Error::data("meta.json, format", format!("{other:?}"))
            .expected(format!(
                "{}, {}, {}, {} or {}",
                vocabulary::FORMAT,
                space::FORMAT,
                neighbor_table::FORMAT,
                levels_file::FORMAT,
                parts::FORMAT
            ))
            .in_file(path)),
    }
}

fn size(grid: TexelGrid) -> String {
    format!("{} × {} texels", grid.width, grid.height)
}

fn tiles(tileable: bool) -> &'static str {
    if tileable { "tileable" } else { "not tileable" }
}

/// A part of a texton analysis: every checksum is compared.
fn describe_part(path: &Path) -> Result<Outcome> {
    let part = PartFile::read(path)?;
    Ok(Outcome::default()
        .line(format!(
            "part of a texton analysis: shard {}, {} numbers, of version {} of the program",
            part.shard, part.numbers, part.program
        ))
        .line(format!("options {}", part.options))
        .figure("kind", "texton part")
        .figure("shard", part.shard.to_string())
        .figure("numbers", part.numbers)
        .figure("options", part.options)
        .figure("sample", part.sample.to_string()))
}

/// The pyramids of a face map's sample and surface: every surface level is read.
fn describe_levels(path: &Path, meta: &Value) -> Result<Outcome> {
    let mut file = npz::Reader::open(path)?;
    let levels = meta["levels"].as_u64().unwrap_or(0);
    let mut outcome = Outcome::default()
        .line(format!("levels of a face map: {levels}"))
        .figure("kind", "face levels")
        .figure("levels", levels);
    let mut counts = Vec::new();
    for level in 0..levels {
        let values = file.array::<f32, Ix2>(&format!("surface/L{level}/gaussian"))?;
        let sample = file.array::<f32, Ix3>(&format!("sample/L{level}/gaussian"))?;
        outcome = outcome.line(format!(
            "level {level}: {} faces of {} numbers, {} triangles on each grid of the sample",
            values.nrows(),
            values.ncols(),
            sample.dim().1
        ));
        counts.push(values.nrows());
    }
    Ok(outcome.figure("faces", counts))
}

fn describe_vocabulary(vocabulary: &StoredVocabulary) -> Outcome {
    // Tell what holds for all levels.
    let mut outcome = Outcome::default()
        .line(format!(
            "texton vocabulary: {} levels, {} images, {} channels, {}; seed {}",
            vocabulary.levels.len(),
            vocabulary.representatives.len(),
            vocabulary.channels,
            tiles(vocabulary.tileable),
            vocabulary.seed,
        ))
        .figure("kind", "texton vocabulary")
        .figure("images", vocabulary.representatives.len())
        .figure("channels", vocabulary.channels)
        .figure("id", vocabulary.id.to_string())
        .figure("sample", vocabulary.sample.to_string());
    if let Some(basis) = &vocabulary.factor_basis {
        outcome = outcome
            .line(format!(
                "centroids in the basis of {} eigentextures, of rank {}",
                basis.matrix.nrows(),
                basis.rank
            ))
            .figure("rank", basis.rank);
    }
    // Tell each level.
    for (index, level) in vocabulary.levels.iter().enumerate() {
        outcome = outcome.line(format!(
            "level {index}: {}, {} textons of {} numbers, inertia {:.6e}",
            size(level.grid),
            level.counts.len(),
            level.centroids.shape()[1],
            level.inertia,
        ));
    }
    let textons: Vec<usize> = vocabulary
        .levels
        .iter()
        .map(|level| level.counts.len())
        .collect();
    outcome.figure("textons", textons)
}

/// The size of a texel, where it is known.
fn side_of(texel_mm: Option<f64>) -> String {
    texel_mm.map_or(String::new(), |mm| format!(", {mm} mm per texel"))
}

fn describe_space(space: &Space) -> Outcome {
    let mut outcome = Outcome::default()
        .line(format!(
            "surface texton space: {} levels{}, {}",
            space.levels.len(),
            side_of(space.texel_mm),
            tiles(space.tileable())
        ))
        .figure("kind", "surface texton space")
        .figure("levels", space.levels.len())
        .figure("id", space.id.to_string())
        .figure("sample", space.sample.to_string());
    for (index, level) in space.levels.iter().enumerate() {
        let holds = match &level.features {
            Features::Textons { gram, .. } => format!("{} textons", gram.nrows() - 1),
            Features::Plain(vectors) => format!("{} features per texel", vectors.dim().2),
        };
        outcome = outcome.line(format!("level {index}: {}, {holds}", size(level.grid)));
    }
    if space.kind() == SpaceKind::Features && space.channels.list().is_empty() {
        outcome = outcome.line("its channels are not stated");
    }
    describe_channels(outcome, space)
}

fn describe_table(table: &NeighborTable) -> Outcome {
    let mut outcome = Outcome::default()
        .line(format!(
            "neighbour table: {} levels, k {}, {}",
            table.levels.len(),
            table.k,
            tiles(table.tileable)
        ))
        .figure("kind", "neighbour table")
        .figure("levels", table.levels.len())
        .figure("k", table.k)
        .figure("id", table.id.to_string())
        .figure("space", table.space.to_string());
    for (index, level) in table.levels.iter().enumerate() {
        outcome = outcome.line(format!(
            "level {index}: {} texels, {} + {} window samples, at least {} texels apart",
            level.neighbors.nrows(),
            level.neighborhood.offsets.len(),
            level.neighborhood.coarse_offsets.len(),
            level.min_separation,
        ));
    }
    outcome
}
