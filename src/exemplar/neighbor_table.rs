//! The neighbour table (Tong 2002 §5.2): the k nearest texels of every texel, by the distance of
//! their neighbourhoods. In: a space. Out: the file `NAME.knn.npz`.
//!
//! Neighbours are taken greedily, nearest first, each `min_separation` away from the texel and from all taken: the
//! nearest of a smooth sample are the texels next to it, and a map made of them drifts. Deviation: Tong 2002 §5.2
//! takes the nearest without separation (`--min-separation 1`).

use std::path::Path;

use ndarray::{Array2, Ix2};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::{Error, Result};
use crate::exemplar::controls::ControlKind;
use crate::exemplar::knn_options::{KnnOptions, NeighborSearch, WIDEST, check_tolerance};
use crate::exemplar::level_distances::{BlockDistances, LevelDistances, SpareDistances};
use crate::exemplar::margin::Margin;
use crate::exemplar::neighbor_list::{Rows, assemble};
use crate::exemplar::separated_neighbors::{Band, Choice};
use crate::exemplar::space::Space;
use crate::exemplar::square_window::check_square;
use crate::exemplar::texel_block::TexelBlock;
use crate::exemplar::two_level::TwoLevelSearch;
use crate::format::id::ContentId;
use crate::format::json::as_map;
use crate::format::npz;
use crate::grid::TexelGrid;
use crate::index::TexelIndex;
use crate::neighborhood::Neighborhood;
use crate::progress::Progress;

/// `format` in the file's `meta.json`.
pub const FORMAT: &str = "mesotex-knn";
/// The version written, and the only one read.
pub const VERSION: u32 = 1;

/// Levels that any sample can have: beyond these, each is a single texel.
const MOST_LEVELS: usize = 32;
/// No sample has longer sides.
const MOST_SEPARATION: u32 = 1 << 16;
/// The largest weight of a sample: weighted distances stay finite.
const LARGEST_WEIGHT: f32 = 1e3;

/// The neighbour table of one level.
#[derive(Clone, Debug, PartialEq)]
pub struct TableLevel {
    /// Flat texel indices [H·W, k], nearest first, column 0 the texel itself.
    pub neighbors: Array2<u32>,
    /// Squared neighbourhood distances, as [`neighbors`](Self::neighbors).
    pub distances: Array2<f32>,
    /// The neighbourhood they were measured in.
    pub neighborhood: Neighborhood,
    /// Least distance between listed texels, in texels (max norm).
    pub min_separation: u32,
}

/// The tables of all levels, finest first.
#[derive(Clone, Debug, PartialEq)]
pub struct NeighborTable {
    /// Level 0 is the finest.
    pub levels: Vec<TableLevel>,
    /// Neighbours a texel, itself included.
    pub k: usize,
    /// Whether neighbourhoods wrap round the sample's border.
    pub tileable: bool,
    /// Which texels are whole.
    pub margin: Margin,
    /// Listed texels' transitions differ by less than this (Zhang 2003 eq. 1); `None`: any are listed.
    pub transition_tolerance: Option<f64>,
    /// This table's own id.
    pub id: ContentId,
    /// The id of the space it was made from.
    pub space: ContentId,
}

/// How the table of a level was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSearch {
    /// The search that was run.
    pub search: NeighborSearch,
    /// The share of exact search's neighbours it found, measured on a few rows of texels; 1 for
    /// exact search.
    pub recall: f64,
}

/// Bytes of a neighbour as it is found, sorted into the table and written.
const NEIGHBOR: u64 = 32;
/// Bytes of a texel that a thread holds while it searches: distances from a block of others.
const SEARCHED: u64 = 600;
/// The program.
const PROGRAM: u64 = 16 << 20;

/// Bytes that the tables of a space take while they are built by this many threads, measured on samples of 64 × 64 to
/// 256 × 256 texels.
pub fn bytes_to_build(space: &Space, options: &KnnOptions, threads: usize) -> u64 {
    let levels = space.levels.iter().enumerate();
    let exact = levels.filter(|(at, level)| {
        let has_parent = at + 1 < space.levels.len();
        options.search_at(level.grid, has_parent) != NeighborSearch::TwoLevel
    });
    let most = exact.map(|(_, level)| level.grid.len()).max().unwrap_or(0);
    let texels: usize = space.levels.iter().map(|level| level.grid.len()).sum();
    SEARCHED * (most * threads) as u64 + NEIGHBOR * texels as u64 * u64::from(options.k) + PROGRAM
}

/// The neighbour tables of all levels of a space.
pub fn build(space: &Space, options: &KnnOptions, progress: Progress<'_>) -> Result<NeighborTable> {
    build_and_measure(space, options, progress).map(|(table, _)| table)
}

/// The neighbour tables of all levels of a space, and how each was found.
pub fn build_and_measure(
    space: &Space,
    options: &KnnOptions,
    progress: Progress<'_>,
) -> Result<(NeighborTable, Vec<LevelSearch>)> {
    // Refuse options that the space cannot meet.
    options.validate()?;
    if let Some(finest) = space.levels.first() {
        options.margin.check(finest.grid)?;
    }
    if options.transition_tolerance.is_some() {
        let levels = 0..space.levels.len();
        let checked = levels.map(|at| {
            space.required_control(at, ControlKind::Transition, "--transition-tolerance")
        });
        checked.collect::<Result<Vec<_>>>()?;
    }
    for (at, level) in space.levels.iter().enumerate() {
        let (k, separation) = (options.k as usize, options.separation(level.grid, at));
        if k > level.grid.len() {
            return Err(too_few(at, level.grid, k, level.grid.len(), separation));
        }
    }
    // Find the neighbours of each level.
    let built = (0..space.levels.len())
        .map(|at| build_level(space, at, options, progress))
        .collect::<Result<Vec<_>>>()?;
    let (levels, searches) = built.into_iter().unzip();
    let table = NeighborTable {
        levels,
        k: options.k as usize,
        tileable: space.tileable(),
        margin: options.margin,
        transition_tolerance: options.transition_tolerance,
        id: ContentId::of_bytes(&[]),
        space: space.id.clone(),
    };
    Ok((table, searches))
}

fn build_level(
    space: &Space,
    at: usize,
    options: &KnnOptions,
    progress: Progress<'_>,
) -> Result<(TableLevel, LevelSearch)> {
    // Lay out the windows, and find which texels are whole.
    let grid = space.levels[at].grid;
    let (fine_width, coarse_width) = options.widths(at + 1 < space.levels.len());
    let neighborhood = Neighborhood::square(fine_width, coarse_width);
    let min_separation = options.separation(grid, at);
    let fits = |texel| neighborhood.fits(grid, texel);
    let whole = options.margin.whole_texels(grid, options.k as usize, fits);
    // Search, and keep as many neighbours per texel as were asked for.
    let search = options.search_at(grid, at + 1 < space.levels.len());
    progress.begin(format!("neighbours, level {at}"), 0);
    let task = LevelTask {
        space,
        at,
        options,
        whole,
        min_separation,
    };
    let (found, recall) = match search {
        NeighborSearch::TwoLevel => task.two_level(progress)?,
        NeighborSearch::Auto | NeighborSearch::Exact => (task.exact(progress)?, 1.0),
    };
    let (neighbors, distances) =
        found.map_err(|found| too_few(at, grid, options.k as usize, found, min_separation))?;
    progress.end();
    let level = TableLevel {
        neighbors,
        distances,
        neighborhood,
        min_separation,
    };
    Ok((level, LevelSearch { search, recall }))
}

/// One level's search, with all it needs.
struct LevelTask<'a> {
    space: &'a Space,
    at: usize,
    options: &'a KnnOptions,
    whole: Vec<bool>,
    min_separation: u32,
}

/// Rows of a level, or the number of neighbours of a texel that has too few.
type Found = std::result::Result<Rows, usize>;

impl LevelTask<'_> {
    /// Window distances of a level of the space.
    fn distances(&self, at: usize) -> LevelDistances {
        let levels = &self.space.levels;
        let (fine, coarse) = self.options.widths(at + 1 < levels.len());
        LevelDistances::new(&levels[at], levels.get(at + 1), fine, coarse)
    }

    fn exact(&self, progress: Progress<'_>) -> Result<Found> {
        let source = self.distances(self.at);
        let choice = self.choice();
        let spare = SpareDistances::default();
        let of_block = |block: &TexelBlock| {
            progress.check()?;
            let row = |(texel, distances): (TexelIndex, &mut [f32])| {
                (texel, choice.choose(texel, distances))
            };
            let rows = |distances: &mut BlockDistances| {
                source.of_block(block, distances).map(row).collect()
            };
            Ok(spare.with(rows))
        };
        let found = TexelBlock::of_grid(source.grid())
            .par_iter()
            .map(of_block)
            .collect::<Result<Vec<Vec<_>>>>()?;
        Ok(assemble(
            source.grid().len(),
            choice.k,
            found.into_iter().flatten(),
        ))
    }

    fn choice(&self) -> Choice {
        let (grid, k) = (self.space.levels[self.at].grid, self.options.k as usize);
        Choice::new(grid, &self.whole, self.min_separation, k, self.band())
    }

    /// The band of the level's transition, where one is asked for.
    fn band(&self) -> Option<Band> {
        let tolerance = self.options.transition_tolerance? as f32;
        let transition = self.space.controls.get(self.at)?.transition.as_ref()?;
        Some(Band {
            transition: transition.iter().copied().collect(),
            tolerance,
        })
    }

    fn two_level(&self, progress: Progress<'_>) -> Result<(Found, f64)> {
        let (fine, coarse) = (self.distances(self.at), self.distances(self.at + 1));
        let search = TwoLevelSearch {
            fine: &fine,
            coarse: &coarse,
            choice: &self.choice(),
            whole: &self.whole,
            separation: self.min_separation,
            k: self.options.k as usize,
            candidates: self.options.candidates as usize,
        };
        let found = search.run(progress)?;
        let recall = found
            .as_ref()
            .map_or(0.0, |(neighbors, _)| search.recall(neighbors));
        Ok((found, recall))
    }
}

fn too_few(at: usize, grid: TexelGrid, k: usize, found: usize, separation: u32) -> Error {
    Error::option(
        "k",
        format!(
            "{k}, but level {at} ({} × {} texels) has a texel with only {found} neighbours at \
             separation {separation}, itself included",
            grid.width, grid.height
        ),
        format!("at most {found}, fewer pyramid levels, or a smaller --min-separation"),
    )
}

/// `meta.json`.
#[derive(Debug, Serialize, Deserialize)]
struct Meta {
    format: String,
    version: u32,
    k: usize,
    tileable: bool,
    #[serde(default = "without_margin")]
    margin: Margin,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    transition_tolerance: Option<f64>,
    levels: Vec<LevelMeta>,
    options: Value,
    space: ContentId,
    #[serde(skip_serializing)]
    id: Option<ContentId>,
}

/// The rule of tables that state no margin.
fn without_margin() -> Margin {
    Margin::Full
}

#[derive(Debug, Serialize, Deserialize)]
struct LevelMeta {
    offsets: Vec<[i32; 2]>,
    weights: Vec<f32>,
    coarse_offsets: Vec<[i32; 2]>,
    coarse_weights: Vec<f32>,
    min_separation: u32,
}

impl NeighborTable {
    /// The neighbourhood of each level.
    pub fn neighborhoods(&self) -> Vec<Neighborhood> {
        let levels = self.levels.iter();
        levels.map(|level| level.neighborhood.clone()).collect()
    }

    /// Which texels of a level are whole: the ones listed as others' neighbours, and the ones synthesis may pick.
    pub fn whole_texels(&self, level: usize, grid: TexelGrid) -> Vec<bool> {
        let neighborhood = &self.levels[level].neighborhood;
        let fits = |texel| neighborhood.fits(grid, texel);
        self.margin.whole_texels(grid, self.k, fits)
    }

    /// Writes the file; the table takes the id of what was written.
    pub fn write(&mut self, path: &Path, options: &KnnOptions) -> Result<()> {
        let meta = Meta {
            format: FORMAT.into(),
            version: VERSION,
            k: self.k,
            tileable: self.tileable,
            margin: self.margin,
            transition_tolerance: self.transition_tolerance,
            levels: self.levels.iter().map(TableLevel::meta).collect(),
            options: serde_json::to_value(options)
                .map_err(|error| Error::data("options", error.to_string()))?,
            space: self.space.clone(),
            id: None,
        };
        self.id = npz::write(path, as_map(&meta)?, |file| {
            for (at, level) in self.levels.iter().enumerate() {
                file.array(&format!("L{at}/neighbors"), level.neighbors.view())?;
                file.array(&format!("L{at}/distances"), level.distances.view())?;
            }
            Ok(())
        })?;
        Ok(())
    }

    /// Reads a file and checks that its parts belong together.
    pub fn read(path: &Path) -> Result<Self> {
        // Check what the file is.
        let mut file = npz::Reader::open(path)?;
        let head: Value = file.meta()?;
        let format = head.get("format").and_then(Value::as_str).unwrap_or("none");
        if format != FORMAT {
            return Err(file
                .fault("meta.json: format", format!("`{format}`"))
                .expected(format!("{FORMAT}, as `mesotex knn` writes it")));
        }
        let meta: Meta = file.meta()?;
        if meta.version != VERSION {
            return Err(file
                .fault("meta.json: version", meta.version.to_string())
                .expected(VERSION.to_string()));
        }
        // Check the numbers that hold for all levels.
        let Some(id) = meta.id else {
            return Err(file.fault("meta.json: id", "missing"));
        };
        if check_tolerance(meta.transition_tolerance).is_err() {
            let found = format!("{:?}", meta.transition_tolerance);
            return Err(file
                .fault("meta.json: transition_tolerance", found)
                .expected("above 0, at most 1"));
        }
        let count = meta.levels.len();
        if !(1..=MOST_LEVELS).contains(&count) || meta.k == 0 {
            return Err(file
                .fault("meta.json", format!("{count} levels, k {}", meta.k))
                .expected(format!("1 to {MOST_LEVELS} levels, k 1 or more")));
        }
        // Read level after level.
        let levels = meta
            .levels
            .into_iter()
            .enumerate()
            .map(|(at, level)| {
                let found = check_neighborhood(&level, at + 1 == count);
                found.map_err(|error| file.at(&format!("meta.json: levels[{at}]"), error))?;
                read_level(&mut file, at, level, meta.k)
            })
            .collect::<Result<_>>()?;
        Ok(Self {
            levels,
            k: meta.k,
            tileable: meta.tileable,
            margin: meta.margin,
            transition_tolerance: meta.transition_tolerance,
            id,
            space: meta.space,
        })
    }

    /// Refuses a table that was not made for `space`: other sizes, or (unless `force`) another id.
    pub fn check_belongs_to(&self, space: &Space, force: bool) -> Result<()> {
        let sizes = |lengths: Vec<usize>| format!("levels of {lengths:?} texels");
        let own: Vec<usize> = self
            .levels
            .iter()
            .map(|level| level.neighbors.nrows())
            .collect();
        let wanted: Vec<usize> = space.levels.iter().map(|level| level.grid.len()).collect();
        if own != wanted || self.tileable != space.tileable() {
            return Err(Error::data(
                "neighbour table",
                format!("{}, tileable {}", sizes(own), self.tileable),
            )
            .expected(format!("{}, tileable {}", sizes(wanted), space.tileable()))
            .advice("make the table again with `mesotex knn` from this space"));
        }
        crate::format::id::check_same("neighbour table: space id", &self.space, &space.id, force)
    }
}

impl TableLevel {
    fn meta(&self) -> LevelMeta {
        let neighborhood = self.neighborhood.clone();
        LevelMeta {
            offsets: neighborhood.offsets,
            weights: neighborhood.weights,
            coarse_offsets: neighborhood.coarse_offsets,
            coarse_weights: neighborhood.coarse_weights,
            min_separation: self.min_separation,
        }
    }
}

/// Checks what `meta.json` says of a level: windows and weights that synthesis can work with.
fn check_neighborhood(meta: &LevelMeta, is_coarsest: bool) -> Result<()> {
    check_window("offsets", &meta.offsets, &meta.weights)?;
    check_window("coarse_offsets", &meta.coarse_offsets, &meta.coarse_weights)?;
    let fault =
        |field, found: String, expected: &str| Err(Error::data(field, found).expected(expected));
    if meta.offsets.is_empty() {
        return fault("offsets", "none".into(), "at least 1");
    }
    if is_coarsest && !meta.coarse_offsets.is_empty() {
        let found = format!("{} samples", meta.coarse_offsets.len());
        return fault("coarse_offsets", found, "none: no level is coarser");
    }
    if meta.min_separation > MOST_SEPARATION {
        let found = meta.min_separation.to_string();
        return fault("min_separation", found, "at most 65536 texels");
    }
    Ok(())
}

/// Checks a window's offsets and weights: none, or a square; `field` names the offsets.
fn check_window(field: &str, offsets: &[[i32; 2]], weights: &[f32]) -> Result<()> {
    if offsets.len() != weights.len() {
        let found = format!("{} offsets, {} weights", offsets.len(), weights.len());
        return Err(Error::data(field, found).expected("one weight per offset"));
    }
    let reach = WIDEST / 2;
    let within = |offset: &[i32; 2]| offset.iter().all(|step| step.unsigned_abs() <= reach);
    if let Some(at) = offsets.iter().position(|offset| !within(offset)) {
        let found = format!("{:?}", offsets[at]);
        return Err(Error::data(format!("{field}[{at}]"), found)
            .expected(format!("steps from −{reach} to {reach} texels")));
    }
    let most = (WIDEST * WIDEST) as usize;
    if offsets.len() > most {
        let found = format!("{} samples", offsets.len());
        return Err(Error::data(field, found).expected(format!("at most {most}")));
    }
    let sound = |weight: &f32| *weight > 0.0 && *weight <= LARGEST_WEIGHT;
    if let Some(at) = weights.iter().position(|weight| !sound(weight)) {
        let found = weights[at].to_string();
        return Err(Error::data(format!("weight {at} of {field}"), found)
            .expected(format!("above 0, at most {LARGEST_WEIGHT:e}")));
    }
    match offsets.is_empty() {
        true => Ok(()),
        false => check_square(field, offsets),
    }
}

fn read_level(file: &mut npz::Reader, at: usize, meta: LevelMeta, k: usize) -> Result<TableLevel> {
    // Check the shapes.
    let (neighbors_name, distances_name) = (format!("L{at}/neighbors"), format!("L{at}/distances"));
    let neighbors = file.array::<u32, Ix2>(&neighbors_name)?;
    let distances = file.array::<f32, Ix2>(&distances_name)?;
    let texels = neighbors.nrows();
    if neighbors.ncols() != k || distances.dim() != neighbors.dim() {
        return Err(file
            .fault(
                &neighbors_name,
                format!("shapes {:?} and {:?}", neighbors.shape(), distances.shape()),
            )
            .expected(format!("[texels, {k}] both, as meta.json's k states")));
    }
    // Check that each entry is a texel, each distance a number, and the texel itself first.
    if let Some((place, index)) = neighbors
        .indexed_iter()
        .find(|(_, i)| **i as usize >= texels)
    {
        return Err(file
            .fault(&neighbors_name, format!("texel {index} at {place:?}"))
            .expected(format!("texels below {texels}")));
    }
    if let Some((place, value)) = distances
        .indexed_iter()
        .find(|(_, d)| !(**d >= 0.0 && d.is_finite()))
    {
        return Err(file
            .fault(&distances_name, format!("{value} at {place:?}"))
            .expected("finite and not negative"));
    }
    if let Some(texel) = (0..texels).find(|&texel| neighbors[[texel, 0]] as usize != texel) {
        return Err(file
            .fault(
                &neighbors_name,
                format!("texel {} at [{texel}, 0]", neighbors[[texel, 0]]),
            )
            .expected("the texel itself first"));
    }
    Ok(TableLevel {
        neighbors,
        distances,
        neighborhood: Neighborhood {
            offsets: meta.offsets,
            weights: meta.weights,
            coarse_offsets: meta.coarse_offsets,
            coarse_weights: meta.coarse_weights,
        },
        min_separation: meta.min_separation,
    })
}

#[cfg(test)]
mod tests;
