//! What a report shows: the products of a scene's stages, or the files of a folder.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::btf::sample::Sample;
use crate::cli::info::kind::Kind;
use crate::cli::run::overview::{Overview, overview};
use crate::cli::run::quality::Quality;
use crate::cli::session::Session;
use crate::cli::view::name_of;
use crate::error::{Error, Result};
use crate::exemplar::{neighbor_table, space};
use crate::format::npz;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::texton::vocabulary;

/// What of a scene is wanted: a quality, and one run of its `[matrix]`.
type Wanted<'a> = (Quality, Option<&'a str>);

/// Products by their kind; of several the first by name.
#[derive(Default)]
pub(super) struct Products {
    /// What the page is called.
    pub(super) title: String,
    /// Samples.
    samples: Vec<PathBuf>,
    /// The sample: of several the one that the map was made from.
    pub(super) sample: Option<PathBuf>,
    /// The vocabulary.
    pub(super) textons: Option<PathBuf>,
    /// The space.
    pub(super) space: Option<PathBuf>,
    /// The neighbour table.
    pub(super) table: Option<PathBuf>,
    /// Meshes.
    pub(super) meshes: Vec<PathBuf>,
    /// The surface texton map.
    pub(super) map: Option<PathBuf>,
    /// Maps of other kinds.
    pub(super) other_maps: Vec<PathBuf>,
    /// Folders of frames.
    pub(super) frames: Vec<PathBuf>,
    /// The scene's stages, where there is a scene.
    pub(super) overview: Option<Overview>,
}

impl Products {
    /// Those of a scene, of the one scene in a folder, or those that lie in a folder.
    pub(super) fn find(input: &Path, wanted: Wanted<'_>, session: &Session) -> Result<Self> {
        if !input.is_dir() {
            return Self::of_scene(input, wanted, session);
        }
        let entries = entries(input)?;
        let is_scene = |path: &&PathBuf| {
            path.extension().is_some_and(|ending| ending == "toml")
                && matches!(Kind::of(path), Ok(Kind::Scene))
        };
        let scenes: Vec<&PathBuf> = entries.iter().filter(is_scene).collect();
        match scenes[..] {
            [] => {
                let mut found = Self {
                    title: title_of(input),
                    ..Self::default()
                };
                found.take(entries.into_iter())?;
                found.check_any(input)?;
                Ok(found)
            }
            [scene] => Self::of_scene(scene, wanted, session),
            _ => Err(Error::data("scenes", format!("{} of them", scenes.len()))
                .expected("one")
                .advice("name one of them: mesotex report SCENE.toml -o PAGE.html")
                .in_file(input)),
        }
    }

    fn of_scene(scene: &Path, (quality, only): Wanted<'_>, session: &Session) -> Result<Self> {
        let overview = overview(scene, quality, only, session)?;
        let mut found = Self {
            title: overview.name.clone(),
            ..Self::default()
        };
        let reads = overview.stages.iter().flat_map(|stage| &stage.reads);
        let writes = overview.stages.iter().flat_map(|stage| &stage.outputs);
        let mut seen = BTreeSet::new();
        let paths: Vec<PathBuf> = writes
            .chain(reads)
            .filter(|path| path.exists() && seen.insert(*path))
            .cloned()
            .collect();
        found.take(paths.into_iter())?;
        found.overview = Some(overview);
        Ok(found)
    }

    fn take(&mut self, paths: impl Iterator<Item = PathBuf>) -> Result<()> {
        for path in paths {
            let Ok(kind) = Kind::of(&path) else {
                continue;
            };
            match kind {
                Kind::Sample => self.samples.push(path),
                Kind::Map => first(&mut self.map, path),
                Kind::Mesh => self.meshes.push(path),
                Kind::FaceMap | Kind::Atlas => self.other_maps.push(path),
                Kind::Frames => self.frames.push(path),
                Kind::Archive => self.take_archive(path),
                _ => {}
            }
        }
        self.choose_sample()
    }

    fn choose_sample(&mut self) -> Result<()> {
        self.sample = self.samples.first().cloned();
        if let (Some(map), true) = (&self.map, self.samples.len() > 1) {
            let wanted = SurfaceTextonMap::read(map)?.header.sample;
            let is_wanted =
                |path: &&PathBuf| Sample::open(path).is_ok_and(|sample| *sample.id() == wanted);
            self.sample = self.samples.iter().find(is_wanted).cloned();
        }
        Ok(())
    }

    fn take_archive(&mut self, path: PathBuf) {
        let head = npz::Reader::open(&path).and_then(|mut file| file.meta::<serde_json::Value>());
        let format = head
            .ok()
            .and_then(|head| head["format"].as_str().map(str::to_owned));
        match format.as_deref() {
            Some(vocabulary::FORMAT) => first(&mut self.textons, path),
            Some(space::FORMAT) => first(&mut self.space, path),
            Some(neighbor_table::FORMAT) => first(&mut self.table, path),
            _ => {}
        }
    }

    /// Refuses a folder that nothing of ours lies in.
    fn check_any(&self, folder: &Path) -> Result<()> {
        let files = [
            &self.sample,
            &self.textons,
            &self.space,
            &self.table,
            &self.map,
        ];
        let lists = [&self.other_maps, &self.frames];
        if files.iter().any(|file| file.is_some()) || lists.iter().any(|list| !list.is_empty()) {
            return Ok(());
        }
        Err(Error::data("content", "nothing that mesotex made")
            .expected("a scene, a sample, textons, a map or frames")
            .advice("run a scene first: mesotex run SCENE.toml, or mesotex demo")
            .in_file(folder))
    }
}

/// What a folder is called, `.` as well.
fn title_of(folder: &Path) -> String {
    let whole = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    name_of(&whole)
}

fn first(place: &mut Option<PathBuf>, path: PathBuf) {
    place.get_or_insert(path);
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let list = fs::read_dir(folder).map_err(Error::io(folder, "read"))?;
    let mut paths: Vec<PathBuf> = list.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    Ok(paths)
}
