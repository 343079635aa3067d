//! The 3D textons of a small sample of the preset `weave`, and their sizes, level by level:
//!
//! ```sh
//! cargo run --release --example textons -- FOLDER
//! ```
//!
//! Writes the sample FOLDER/weave.sample and its vocabulary FOLDER/weave.textons.npz.

#![expect(clippy::print_stdout, reason = "a program of its own")]

use std::path::PathBuf;

use mesotex::btf::Sample;
use mesotex::btf::bake::{BakeOptions, Preset, Samples, bake};
use mesotex::error::{Error, Result};
use mesotex::progress::Progress;
use mesotex::texton::{TextonOptions, analyze};

fn main() -> Result<()> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err(Error::data("arguments", "none").expected("FOLDER"));
    };
    std::fs::create_dir_all(&folder).map_err(Error::io(&folder, "create"))?;
    let quiet = Progress::silent();
    let path = folder.join("weave.sample");
    let material = Preset::Weave.material(64, 0, &quiet)?;
    let options = BakeOptions {
        samples: Samples::Fixed(1),
        ..BakeOptions::default()
    };
    bake(&material, &options, &path, quiet)?;

    let options = TextonOptions {
        textons: 100,
        levels: 3,
        ..TextonOptions::default()
    };
    let vocabulary = analyze(&Sample::open(&path)?, &options, quiet)?.vocabulary;
    for (number, level) in vocabulary.levels.iter().enumerate() {
        let largest = level.counts.iter().max().unwrap_or(&0);
        let (width, height) = (level.grid.width, level.grid.height);
        let textons = level.counts.len();
        println!("level {number}: {width} × {height} texels, {textons} textons of up to {largest}");
    }
    vocabulary.write(&folder.join("weave.textons.npz"))?;
    Ok(())
}
