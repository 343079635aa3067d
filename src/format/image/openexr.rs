//! OpenEXR: the first flat layer's R, G, B, or its one channel (Y, or whatever it is called).

use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, FlatSamples};
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers, read as reader};

use crate::error::Result;
use crate::format::image::{Claim, Encoding, FloatImage, Precision, undecodable};

/// Bytes that one byte of a file can stand for. PIZ does better on pictures of one colour; those are
/// refused beyond the size that is always read.
const STRONGEST_COMPRESSION: u64 = 4096;

pub(super) fn read(path: &Path, file_length: u64) -> Result<FloatImage> {
    let meta = MetaData::read_from_file(path, false).map_err(undecodable)?;
    for header in &meta.headers {
        let bytes = header.channels.bytes_per_pixel as u64;
        let claim = Claim {
            width: header.layer_size.0 as u64,
            height: header.layer_size.1 as u64,
            stored_bits: bytes * 8,
            decoded_bytes: bytes,
        };
        claim.check(STRONGEST_COMPRESSION, file_length)?;
    }
    let image = reader()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel() // a panic in a thread of the decoder's own would end the process
        .from_file(path)
        .map_err(undecodable)?;
    let layer = image.layer_data;
    let chosen = chosen_channels(&layer.channel_data)?;
    let planes: Vec<Vec<f32>> = chosen.iter().map(|channel| plane(channel)).collect();
    let texels = layer.size.0 * layer.size.1;
    if planes.iter().any(|plane| plane.len() != texels) {
        return Err(undecodable("subsampled channels in OpenEXR"));
    }
    Ok(FloatImage {
        width: layer.size.0 as u32,
        height: layer.size.1 as u32,
        channels: planes.len() as u32,
        data: interleave(&planes, texels),
        encoding: Encoding::Linear,
        precision: Precision::Float,
    })
}

/// R, G, B in this order, or Y, or the only channel there is.
fn chosen_channels(channels: &AnyChannels<FlatSamples>) -> Result<Vec<&AnyChannel<FlatSamples>>> {
    let named = |name: &str| channels.list.iter().find(|channel| channel.name == *name);
    if let (Some(red), Some(green), Some(blue)) = (named("R"), named("G"), named("B")) {
        return Ok(vec![red, green, blue]);
    }
    let names: Vec<String> = channels.list.iter().map(|c| c.name.to_string()).collect();
    match (named("Y"), channels.list.as_slice()) {
        (Some(luminance), _) => Ok(vec![luminance]),
        (None, [only]) => Ok(vec![only]),
        _ => Err(undecodable(format!("channels {}", names.join(", ")))
            .expected("R, G and B, or Y, or a single channel")),
    }
}

fn plane(channel: &AnyChannel<FlatSamples>) -> Vec<f32> {
    channel.sample_data.values_as_f32().collect()
}

fn interleave(planes: &[Vec<f32>], texels: usize) -> Vec<f32> {
    let mut numbers = Vec::with_capacity(texels * planes.len());
    numbers.extend((0..texels).flat_map(|texel| planes.iter().map(move |plane| plane[texel])));
    numbers
}
