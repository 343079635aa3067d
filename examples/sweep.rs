//! A surface texton map while the light goes round, in 24 frames:
//!
//! ```sh
//! cargo run --release --example sweep -- NAME.sample NAME.map.ply FOLDER
//! ```
//!
//! Writes FOLDER/frame.0001.exr and further frames, each with a preview as PNG beside it. The example
//! `surface` makes a sample and a map.

#![expect(clippy::print_stdout, reason = "a program of its own")]

use std::path::PathBuf;

use mesotex::btf::Sample;
use mesotex::error::{Error, Result};
use mesotex::format::ContentId;
use mesotex::maps::SurfaceTextonMap;
use mesotex::progress::Progress;
use mesotex::render::sweep::Inputs;
use mesotex::render::{ImageOptions, ImageSize, RenderOptions, Sweep, SweepOptions, sweep};

fn main() -> Result<()> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [sample, map, folder] = arguments.as_slice() else {
        return Err(
            Error::data("arguments", format!("{} of them", arguments.len()))
                .expected("NAME.sample NAME.map.ply FOLDER"),
        );
    };
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create"))?;
    let inputs = Inputs {
        sample: &Sample::open(sample)?,
        map: &SurfaceTextonMap::read(map)?,
        map_id: &ContentId::of_file(map)?,
        cover: None,
        folder,
        force: false,
    };
    let options = RenderOptions {
        sweep: SweepOptions {
            kind: Sweep::LightAzimuth,
            ..SweepOptions::default()
        },
        image: ImageOptions {
            size: ImageSize([480, 360]),
            ..ImageOptions::default()
        },
        ..RenderOptions::default()
    };
    let report = sweep::render(&inputs, &options, Progress::silent())?;
    for file in &report.files {
        println!("{}  {}", file.frame.display(), file.label);
    }
    Ok(())
}
