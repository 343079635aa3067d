//! The checkpoint of an interrupted run: the last finished level, beside the output, keyed by what
//! the run was given.

use std::fs;
use std::path::{Path, PathBuf};

use ndarray::{Array2, ArrayView2};
use serde::Deserialize;

use crate::error::{Error, Result};
use crate::format::atomic::{hidden_name, parent};
use crate::format::id::ContentId;
use crate::format::npz;
use crate::grid::TexCoord;
use crate::index::Level;
use crate::mesh::hierarchy::SiteHierarchy;
use crate::mesh::stencil::Stencils;
use crate::synthesis::engine::{Inputs, LevelMap};
use crate::synthesis::options::SynthesisOptions;

/// Where an interrupted run of one output is kept, and whose run it is.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    path: PathBuf,
    run: ContentId,
}

const FORMAT: &str = "mesotex-checkpoint";
const VERSION: u32 = 1;

#[derive(Deserialize)]
struct Meta {
    format: String,
    version: u32,
    run: ContentId,
    level: u32,
}

impl Checkpoint {
    /// The checkpoint of the run that writes `output` from these inputs and options.
    pub fn new(output: &Path, inputs: Inputs<'_>, options: &SynthesisOptions) -> Self {
        Self {
            path: parent(output).join(hidden_name(output, ".resume")),
            run: run_id(inputs, options),
        }
    }

    /// The level an interrupted run finished last; `None` when there was none. A checkpoint of other
    /// inputs or options is an error.
    pub fn load(&self) -> Result<Option<LevelMap>> {
        if !self.path.exists() {
            return Ok(None);
        }
        let mut reader = npz::Reader::open(&self.path)?;
        let meta: Meta = reader.meta()?;
        if meta.format != FORMAT || meta.version != VERSION || meta.run != self.run {
            return Err(reader
                .fault("meta.json", "an interrupted run of other inputs or options")
                .advice("give what that run was given, or leave out --resume"));
        }
        let coords: Array2<f32> = reader.array("coords")?;
        if coords.ncols() != 2 {
            return Err(reader.fault("coords", format!("shape {:?}", coords.dim())));
        }
        let coord = |row: ndarray::ArrayView1<'_, f32>| TexCoord {
            s: row[0],
            t: row[1],
        };
        Ok(Some(LevelMap {
            level: Level(meta.level),
            coords: coords.rows().into_iter().map(coord).collect(),
        }))
    }

    /// Keeps a finished level.
    pub fn save(&self, map: &LevelMap) -> Result<()> {
        let numbers: Vec<f32> = map.coords.iter().flat_map(|at| [at.s, at.t]).collect();
        let coords = ArrayView2::from_shape((map.coords.len(), 2), &numbers)
            .map_err(|error| Error::data("checkpoint", error.to_string()))?;
        let mut meta = serde_json::Map::new();
        meta.insert("format".into(), FORMAT.into());
        meta.insert("version".into(), VERSION.into());
        meta.insert("run".into(), self.run.to_string().into());
        meta.insert("level".into(), map.level.0.into());
        npz::write(&self.path, meta, |writer| writer.array("coords", coords)).map(drop)
    }

    /// Takes the checkpoint away: the run is over.
    pub fn remove(&self) -> Result<()> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::io(&self.path, "remove")(error))
            }
            _ => Ok(()),
        }
    }
}

/// What a run depends on: the exemplar's ids, the options, and the sites.
fn run_id(inputs: Inputs<'_>, options: &SynthesisOptions) -> ContentId {
    let mut hasher = blake3::Hasher::new();
    let stated = (options, options.seed, &inputs.space.id, &inputs.table.id);
    hasher.update(format!("{stated:?}").as_bytes());
    let SiteHierarchy { levels } = inputs.sites;
    // Neighbours come of the same patches, or grid, as the samples.
    for level in levels {
        hasher.update_rayon(bytemuck::cast_slice(&level.parents));
        match &level.fine {
            Stencils::OfPatches(stencils) => {
                hasher.update_rayon(bytemuck::cast_slice(&stencils.cells));
                hasher.update_rayon(bytemuck::cast_slice(&stencils.samples));
            }
            Stencils::OfGrid(window) => {
                hasher.update(format!("{window:?}").as_bytes());
            }
        }
    }
    ContentId::of_hash(&hasher.finalize())
}
