//! Moving previews: finished pictures as a looping GIF.

use std::io;
use std::path::Path;

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, RgbaImage};

use crate::error::Result;
use crate::format::atomic;
use crate::report::contact_sheet::Picture;

/// Writes pictures of equal size as an endless GIF, `frames_a_second` of them.
pub fn write_gif(
    path: &Path,
    pictures: impl Iterator<Item = Result<Picture>>,
    frames_a_second: u32,
) -> Result<()> {
    let mut fault = None;
    let written = atomic::write_file(path, |sink| {
        // Speed 10 of 30: the encoder's balance of palette quality and time.
        let mut encoder = GifEncoder::new_with_speed(sink, 10);
        encoder
            .set_repeat(Repeat::Infinite)
            .map_err(io::Error::other)?;
        for picture in pictures {
            let picture = picture.map_err(|error| {
                let said = io::Error::other(error.to_string());
                fault = Some(error);
                said
            })?;
            let frame = frame(&picture, frames_a_second)
                .ok_or_else(|| io::Error::other("a picture of another size than it says"))?;
            encoder.encode_frame(frame).map_err(io::Error::other)?;
        }
        Ok(())
    });
    match fault {
        Some(error) => Err(error),
        None => written,
    }
}

fn frame(picture: &Picture, frames_a_second: u32) -> Option<Frame> {
    let rgba = picture
        .pixels
        .chunks(3)
        .flat_map(|p| [p[0], p[1], p[2], 255]);
    let image = RgbaImage::from_raw(picture.width, picture.height, rgba.collect())?;
    let delay = Delay::from_numer_denom_ms(1000, frames_a_second);
    Some(Frame::from_parts(image, 0, 0, delay))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;

    #[test]
    fn gifs_play_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gif");
        let picture = |value: u8| Picture {
            width: 8,
            height: 4,
            pixels: vec![value; 96],
        };
        write_gif(&path, [10, 200].into_iter().map(|v| Ok(picture(v))), 25).unwrap();
        let file = io::BufReader::new(std::fs::File::open(&path).unwrap());
        let decoder = image::codecs::gif::GifDecoder::new(file).unwrap();
        let frames = decoder.into_frames().collect_frames().unwrap();
        assert_eq!(frames.len(), 2);
        assert!(frames[1].buffer().get_pixel(3, 2)[0].abs_diff(200) < 3);
    }
}
