//! The checkpoint of an interrupted run: the last finished level, beside the output, keyed by what
//! the run was given.
//!
//! A checkpoint is checked like any file. One of other inputs or options is an error: the user asked to continue with
//! another run. One that is damaged, or of another version of the program, is of no use to anyone: the caller is told
//! and the run starts over.

use std::fs;
use std::path::{Path, PathBuf};

use ndarray::{Array2, ArrayView2};
use serde::Deserialize;

use crate::error::{Error, Result};
use crate::format::atomic::{hidden_name, parent};
use crate::format::id::ContentId;
use crate::format::npz;
use crate::format::seal::{ENGINE, Seal};
use crate::grid::{TexCoord, TexelGrid};
use crate::index::Level;
use crate::progress::Progress;
use crate::sites::level::Sites;
use crate::synthesis::inputs::{Inputs, LevelMap};
use crate::synthesis::options::SynthesisOptions;

/// Where an interrupted run of one output is kept, and whose run it is.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    path: PathBuf,
    run: ContentId,
    levels: Vec<LevelSize>,
}

/// What a finished level must fit.
#[derive(Clone, Copy, Debug)]
struct LevelSize {
    sites: usize,
    grid: TexelGrid,
}

const FORMAT: &str = "mesotex-checkpoint";
/// Changes whenever the same run would give other numbers, or the file has another form.
const VERSION: u32 = 3;

#[derive(Deserialize)]
struct Meta {
    format: String,
    version: u32,
    engine: String,
    run: ContentId,
    level: u32,
    searched: u64,
    seal: ContentId,
}

impl Checkpoint {
    /// The checkpoint of the run that writes `output` from these inputs and options.
    pub fn new<const N: usize, S: Sites<N>>(
        output: &Path,
        inputs: Inputs<'_, S>,
        options: &SynthesisOptions,
    ) -> Result<Self> {
        let levels = inputs.space.levels.iter().zip(&inputs.sites.levels);
        Ok(Self {
            path: parent(output).join(hidden_name(output, ".resume")),
            run: run_id(inputs, options)?,
            levels: levels
                .map(|(space, sites)| LevelSize {
                    sites: sites.count(),
                    grid: space.grid,
                })
                .collect(),
        })
    }

    /// The level an interrupted run finished last; `None` when there was none, or none that can be used,
    /// which is told. A checkpoint of other inputs or options is an error.
    pub fn load(&self, progress: Progress<'_>) -> Result<Option<LevelMap>> {
        if !self.path.exists() {
            return Ok(None);
        }
        match self.read() {
            Ok((run, map)) if run == self.run => Ok(Some(map)),
            Ok(_) => Err(Error::data(
                "meta.json, run",
                "an interrupted run of other inputs or options",
            )
            .advice("give what that run was given, or leave out --resume")
            .in_file(&self.path)),
            Err(error @ Error::Data(_)) => {
                progress.warn(format!(
                    "{error}; the checkpoint is not used, the run begins anew"
                ));
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    /// The run and the level that the file holds, if it is sound.
    fn read(&self) -> Result<(ContentId, LevelMap)> {
        // Check what the file is.
        if !self.path.is_file() {
            return Err(Error::data("checkpoint", "not a regular file").in_file(&self.path));
        }
        let mut reader = npz::Reader::open(&self.path)?;
        let meta: Meta = reader.meta()?;
        let kind = (meta.format.as_str(), meta.version, meta.engine.as_str());
        if kind != (FORMAT, VERSION, ENGINE) {
            let found = format!("{} {} of mesotex {}", kind.0, kind.1, kind.2);
            return Err(reader
                .fault("meta.json, format", found)
                .expected(format!("{FORMAT} {VERSION} of mesotex {ENGINE}")));
        }
        // Read the level.
        let coords: Array2<f32> = reader.array("coords")?;
        if coords.ncols() != 2 {
            let place = format!("level {}, coords", meta.level);
            return Err(reader
                .fault(&place, format!("shape {:?}", coords.dim()))
                .expected("[sites, 2]"));
        }
        let coord = |row: ndarray::ArrayView1<'_, f32>| TexCoord {
            s: row[0],
            t: row[1],
        };
        let map = LevelMap {
            level: Level(meta.level),
            coords: coords.rows().into_iter().map(coord).collect(),
            searched: meta.searched,
        };
        // Check that it is whole, and fits this run if it is of this run.
        if seal(&meta.run, &map) != meta.seal {
            return Err(reader.fault("seal", "it does not belong to what the file holds"));
        }
        if meta.run == self.run {
            self.check(&map)
                .map_err(|error| error.in_file(&self.path))?;
        }
        Ok((meta.run, map))
    }

    /// Whether a level can be one of this run's: as many coordinates as sites, each on the level's grid. On
    /// coarser levels they are no texel centres.
    fn check(&self, map: &LevelMap) -> Result<()> {
        let Some(size) = self.levels.get(map.level.index()) else {
            return Err(Error::data("level", map.level.0.to_string())
                .expected(format!("a level below {}", self.levels.len())));
        };
        let place = format!("level {}, coords", map.level.0);
        if map.coords.len() != size.sites {
            return Err(Error::data(place, format!("{} sites", map.coords.len()))
                .expected(size.sites.to_string()));
        }
        let (width, height) = (size.grid.width as f32, size.grid.height as f32);
        let inside = |at: &TexCoord| (0.0..width).contains(&at.s) && at.t > 0.0 && at.t <= height;
        match map.coords.iter().position(|at| !inside(at)) {
            None => Ok(()),
            Some(site) => {
                let TexCoord { s, t } = map.coords[site];
                let fault = Error::data(format!("{place}, site {site}"), format!("({s}, {t})"));
                Err(fault.expected(format!("0 ≤ s < {width}, 0 < t ≤ {height}")))
            }
        }
    }

    /// Keeps a finished level.
    pub fn save(&self, map: &LevelMap) -> Result<()> {
        let numbers = flat(map);
        let coords = ArrayView2::from_shape((map.coords.len(), 2), &numbers)
            .map_err(|error| Error::data("checkpoint", error.to_string()))?;
        let mut meta = serde_json::Map::new();
        meta.insert("format".into(), FORMAT.into());
        meta.insert("version".into(), VERSION.into());
        meta.insert("engine".into(), ENGINE.into());
        meta.insert("run".into(), self.run.to_string().into());
        meta.insert("level".into(), map.level.0.into());
        meta.insert("searched".into(), map.searched.into());
        meta.insert("seal".into(), seal(&self.run, map).to_string().into());
        npz::write(&self.path, meta, |writer| writer.array("coords", coords)).map(drop)
    }

    /// Takes the checkpoint away: all that the run was to write is there.
    pub fn remove(&self) -> Result<()> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::io(&self.path, "remove")(error))
            }
            _ => Ok(()),
        }
    }
}

fn flat(map: &LevelMap) -> Vec<f32> {
    map.coords.iter().flat_map(|at| [at.s, at.t]).collect()
}

fn seal(run: &ContentId, map: &LevelMap) -> ContentId {
    let mut seal = Seal::new(FORMAT, VERSION, run);
    seal.text("level", &map.level.0.to_string());
    seal.text("searched", &map.searched.to_string());
    seal.list("coords", &flat(map));
    seal.finish()
}

/// What a run depends on: the exemplar's ids, the options, and the sites.
fn run_id<const N: usize, S: Sites<N>>(
    inputs: Inputs<'_, S>,
    options: &SynthesisOptions,
) -> Result<ContentId> {
    let not_json = |error: serde_json::Error| Error::data("options", error.to_string());
    let mut hasher = blake3::Hasher::new();
    let stated = (options, &inputs.space.id, &inputs.table.id);
    hasher.update(&serde_json::to_vec(&stated).map_err(not_json)?);
    for level in &inputs.sites.levels {
        level.digest(&mut hasher);
    }
    if let Some(controls) = inputs.controls {
        controls.digest(&mut hasher);
    }
    Ok(ContentId::of_hash(&hasher.finalize()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sites::level::SiteHierarchy;
    use crate::synthesis::tests::fixtures;
    use rand::Rng;
    use serde_json::{Map, Value, json};
    use std::sync::Mutex;

    const SITES: [usize; 2] = [40, 12];

    fn checkpoint(folder: &Path) -> Checkpoint {
        let grid = TexelGrid {
            width: 8,
            height: 6,
            tileable: true,
        };
        Checkpoint {
            path: folder.join(".out.resume"),
            run: ContentId::of_bytes(b"run"),
            levels: vec![
                LevelSize {
                    sites: SITES[0],
                    grid,
                },
                LevelSize {
                    sites: SITES[1],
                    grid: grid.coarser(),
                },
            ],
        }
    }

    fn level(number: u32) -> LevelMap {
        let mut stream = crate::random::stream(7, "coords", number, 0);
        let coord = |_| TexCoord {
            s: stream.gen_range(0.0..4.0),
            t: 3.0 - stream.gen_range(0.0_f32..3.0),
        };
        LevelMap {
            level: Level(number),
            coords: (0..SITES[number as usize]).map(coord).collect(),
            searched: 5,
        }
    }

    /// What is loaded, and what is told meanwhile.
    fn load(checkpoint: &Checkpoint) -> (Result<Option<LevelMap>>, Vec<String>) {
        let told = Mutex::new(Vec::new());
        let listener = |event| {
            if let crate::progress::Event::Warn(text) = event {
                told.lock().unwrap().push(text);
            }
        };
        let loaded = checkpoint.load(Progress::new(&listener, None));
        (loaded, told.into_inner().unwrap())
    }

    fn assert_not_used(checkpoint: &Checkpoint, what: &str) {
        let (loaded, told) = load(checkpoint);
        assert!(loaded.unwrap().is_none(), "{what} was used");
        let says = |words: &str| told.len() == 1 && told[0].contains(words);
        assert!(
            says(".out.resume") && says("begins anew"),
            "{what}: {told:?}"
        );
    }

    /// The file of a checkpoint, in parts that can be altered.
    fn parts(checkpoint: &Checkpoint) -> (Map<String, Value>, Array2<f32>) {
        let mut reader = npz::Reader::open(&checkpoint.path).unwrap();
        let mut meta: Map<String, Value> = reader.meta().unwrap();
        meta.remove("id");
        (meta, reader.array("coords").unwrap())
    }

    fn write(checkpoint: &Checkpoint, meta: Map<String, Value>, coords: &Array2<f32>) {
        npz::write(&checkpoint.path, meta, |w| w.array("coords", coords.view())).unwrap();
    }

    #[test]
    fn a_level_comes_back_as_it_was_kept() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path());
        assert!(load(&checkpoint).0.unwrap().is_none());
        for number in [1, 0] {
            checkpoint.save(&level(number)).unwrap();
            let (loaded, told) = load(&checkpoint);
            assert_eq!((loaded.unwrap(), told.len()), (Some(level(number)), 0));
        }
        checkpoint.remove().unwrap();
        checkpoint.remove().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_checkpoint_with_anything_altered_is_told_and_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path());
        checkpoint.save(&level(1)).unwrap();
        let (meta, coords) = parts(&checkpoint);
        let other_id = ContentId::of_bytes(b"other").to_string();
        for (field, value) in [
            ("format", json!("mesotex-surface")),
            ("version", json!(VERSION - 1)),
            ("engine", json!("0.0.9")),
            ("run", json!(other_id)),
            ("level", json!(0)),
            ("level", json!(-1)),
            ("seal", json!(other_id)),
        ] {
            let mut altered = meta.clone();
            altered.insert(field.into(), value.clone());
            write(&checkpoint, altered, &coords);
            assert_not_used(&checkpoint, &format!("{field} {value}"));
            let mut without = meta.clone();
            without.remove(field);
            write(&checkpoint, without, &coords);
            assert_not_used(&checkpoint, &format!("no {field}"));
        }
        let mut stream = crate::random::stream(3, "altered", 0, 0);
        for _ in 0..20 {
            let mut altered = coords.clone();
            let at = [stream.gen_range(0..SITES[1]), stream.gen_range(0..2)];
            altered[at] = f32::from_bits(altered[at].to_bits() ^ (1 << stream.gen_range(0..32)));
            write(&checkpoint, meta.clone(), &altered);
            assert_not_used(&checkpoint, &format!("coords {at:?}"));
        }
        let fewer = coords.slice(ndarray::s![1.., ..]).to_owned();
        write(&checkpoint, meta.clone(), &fewer);
        assert_not_used(&checkpoint, "fewer coords");
        write(&checkpoint, meta, &coords);
        let bytes = fs::read(&checkpoint.path).unwrap();
        fs::write(&checkpoint.path, &bytes[..bytes.len() / 2]).unwrap();
        assert_not_used(&checkpoint, "half a file");
        fs::remove_file(&checkpoint.path).unwrap();
        fs::create_dir(&checkpoint.path).unwrap();
        assert_not_used(&checkpoint, "a folder");
    }

    #[test]
    fn sealed_levels_that_cannot_be_the_runs_are_told_and_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path());
        type Change = (fn(&mut LevelMap), &'static str);
        let changes: [Change; 10] = [
            (
                |map| map.level = Level(2),
                "level: 2; expected a level below 2",
            ),
            (
                |map| map.level = Level(0),
                "level 0, coords: 12 sites; expected 40",
            ),
            (
                |map| map.coords.truncate(9),
                "level 1, coords: 9 sites; expected 12",
            ),
            (
                |map| map.coords.clear(),
                "level 1, coords: 0 sites; expected 12",
            ),
            (
                |map| map.coords[3].s = f32::NAN,
                "level 1, coords, site 3: (NaN, ",
            ),
            (
                |map| map.coords[3].t = f32::NEG_INFINITY,
                "level 1, coords, site 3: (",
            ),
            (|map| map.coords[3].s = -0.5, "site 3: (-0.5, "),
            (
                |map| map.coords[3].s = 4.0,
                "; expected 0 ≤ s < 4, 0 < t ≤ 3",
            ),
            (
                |map| map.coords[5].t = 0.0,
                ", 0); expected 0 ≤ s < 4, 0 < t ≤ 3",
            ),
            (
                |map| map.coords[5].t = 3.5,
                ", 3.5); expected 0 ≤ s < 4, 0 < t ≤ 3",
            ),
        ];
        for (change, words) in changes {
            let mut map = level(1);
            change(&mut map);
            checkpoint.save(&map).unwrap();
            let error = checkpoint.read().unwrap_err().to_string();
            let named = error.contains(".out.resume") && error.contains(words);
            assert!(named, "{words}: {error}");
            assert_not_used(&checkpoint, words);
        }
    }

    #[test]
    fn coordinates_on_the_inner_borders_are_used() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path());
        let mut map = level(1);
        map.coords[0] = TexCoord { s: 0.0, t: 3.0 };
        let (s, t) = (4.0_f32.next_down(), f32::MIN_POSITIVE);
        map.coords[1] = TexCoord { s, t };
        checkpoint.save(&map).unwrap();
        assert_eq!(load(&checkpoint).0.unwrap(), Some(map));
    }

    #[test]
    fn coords_of_another_shape_are_told_and_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path());
        checkpoint.save(&level(1)).unwrap();
        let (meta, _) = parts(&checkpoint);
        for columns in [0, 1, 3] {
            let shape = (SITES[1], columns);
            write(&checkpoint, meta.clone(), &Array2::from_elem(shape, 0.5));
            let error = checkpoint.read().unwrap_err().to_string();
            let words = format!("level 1, coords: shape {shape:?}; expected [sites, 2]");
            assert!(error.contains(&words), "{error}");
            assert_not_used(&checkpoint, &words);
        }
    }

    #[test]
    fn a_checkpoint_of_another_run_is_an_error_with_advice() {
        let folder = tempfile::tempdir().unwrap();
        let checkpoint = checkpoint(folder.path());
        let other = Checkpoint {
            run: ContentId::of_bytes(b"another"),
            ..checkpoint.clone()
        };
        other.save(&level(1)).unwrap();
        let error = load(&checkpoint).0.unwrap_err().to_string();
        assert!(error.contains("leave out --resume"), "{error}");
    }

    #[test]
    fn options_and_sites_tell_runs_apart() {
        let (space, table) = fixtures::random_exemplar(1, 8, 1, true);
        let id = |seed, sites_seed| {
            let sites = SiteHierarchy {
                levels: vec![fixtures::random_sites(sites_seed, 30, 4)],
            };
            let inputs = Inputs {
                space: &space,
                table: &table,
                sites: &sites,
                controls: None,
            };
            let options = SynthesisOptions {
                seed,
                ..SynthesisOptions::default()
            };
            Checkpoint::new(Path::new("out"), inputs, &options)
                .unwrap()
                .run
        };
        assert_eq!(id(1, 1), id(1, 1));
        assert!(id(1, 1) != id(2, 1) && id(1, 1) != id(1, 2));
    }
}
