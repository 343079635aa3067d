//! A flat tile of 256 × 256 texels from a small image of 32 × 32 texels or more:
//!
//! ```sh
//! cargo run --release --example flat -- IMAGE OUTPUT.png
//! ```
//!
//! Writes OUTPUT.png.

use std::path::Path;

use mesotex::error::{Error, Result};
use mesotex::exemplar::{
    ChannelImage, ChannelKind, Controls, KnnOptions, neighbor_table, space_of_images,
};
use mesotex::format::image::encode_srgb8;
use mesotex::format::{ContentId, image};
use mesotex::progress::Progress;
use mesotex::sites::{SiteGrid, Target};
use mesotex::synthesis::{SynthesisOptions, synthesize_map};

const SIDE: u32 = 256;
const LEVELS: u32 = 3;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, output] = arguments.as_slice() else {
        return Err(Error::data("arguments", arguments.join(" ")).expected("IMAGE OUTPUT.png"));
    };
    let quiet = Progress::silent();
    let colors = image::read(Path::new(input))?.into_linear().into_rgb();
    let images = [ChannelImage::new(ChannelKind::Color, colors.clone())];
    let id = ContentId::of_file(Path::new(input))?;
    let space = space_of_images(&images, Controls::default(), LEVELS, false, &id)?;
    let table = neighbor_table::build(&space, &KnnOptions::default(), quiet)?;
    let grid = SiteGrid {
        width: SIDE,
        height: SIDE,
        toroidal: true,
    };
    let target = Target::grid(grid, &table.neighborhoods())?;
    let map = synthesize_map(&space, &table, &target, &SynthesisOptions::default(), quiet)?;
    let texels = map
        .coords
        .iter()
        .map(|&at| map.grid(false).texel_nearest(at));
    let numbers = texels.flat_map(|texel| &colors.data[3 * texel.index()..][..3]);
    let pixels: Vec<u8> = numbers.map(|&number| encode_srgb8(number)).collect();
    image::write_png(Path::new(output), SIDE, SIDE, &pixels)
}
