//! The textons of the preset `weave` on a mesh, or on the built-in kettlebell of 20,000 vertices:
//!
//! ```sh
//! cargo run --release --example surface -- FOLDER [MESH]
//! ```
//!
//! Writes FOLDER/weave.sample, weave.textons.npz, weave.space.npz and the map weave.map.ply, which the
//! example `sweep` renders.

use std::path::{Path, PathBuf};

use mesotex::btf::Sample;
use mesotex::btf::bake::{BakeOptions, Preset, Samples, bake};
use mesotex::error::{Error, Result};
use mesotex::exemplar::{KnnOptions, neighbor_table, space_of_vocabulary};
use mesotex::mesh::builtin::kettlebell;
use mesotex::mesh::{UserMesh, reading};
use mesotex::progress::Progress;
use mesotex::sites::{SurfaceOptions, Target};
use mesotex::synthesis::{SynthesisOptions, synthesize_map};
use mesotex::texton::{StoredVocabulary, TextonOptions, analyze};

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let Some(folder) = arguments.next().map(PathBuf::from) else {
        return Err(Error::data("arguments", "none").expected("FOLDER [MESH]"));
    };
    std::fs::create_dir_all(&folder).map_err(Error::io(&folder, "create"))?;
    let quiet = Progress::silent();
    let mesh = match arguments.next() {
        Some(path) => reading::read(Path::new(&path), quiet)?,
        None => UserMesh::from(kettlebell(20_000)),
    };
    let path = folder.join("weave.sample");
    let material = Preset::Weave.material(64, 0, &quiet)?;
    let options = BakeOptions {
        samples: Samples::Fixed(1),
        ..BakeOptions::default()
    };
    bake(&material, &options, &path, quiet)?;
    let sample = Sample::open(&path)?;
    let found = analyze(&sample, &TextonOptions::default(), quiet)?.vocabulary;
    let textons = folder.join("weave.textons.npz");
    found.write(&textons)?;
    let vocabulary = StoredVocabulary::open(&textons)?;
    let mut space = space_of_vocabulary(&vocabulary)?;
    space.write(&folder.join("weave.space.npz"), Some(&vocabulary.id))?;
    let table = neighbor_table::build(&space, &KnnOptions::default(), quiet)?;

    let options = SurfaceOptions::default().with_neighborhoods(&table.neighborhoods());
    let target = Target::mesh(&mesh, &options, None, quiet)?;
    let map = synthesize_map(&space, &table, &target, &SynthesisOptions::default(), quiet)?;
    map.write(&folder.join("weave.map.ply"))
}
