//! Moving previews: finished pictures of equal size, one after the other, in a file that plays them.

use std::io;
use std::path::Path;

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, RgbaImage};
use png::{BitDepth, ColorType, Encoder, Filter};

use crate::error::Result;
use crate::format::atomic::{self, Sink};
use crate::format::ours::PICTURE_MARK;
use crate::format::rgb_image::RgbImage;

/// Pictures in their order, as writers ask for them.
pub(super) type Pictures<'a> = dyn Iterator<Item = io::Result<RgbImage>> + 'a;

/// Writes pictures as an endless GIF, `rate` of them per second.
pub fn write_gif(
    path: &Path,
    pictures: impl Iterator<Item = Result<RgbImage>>,
    rate: u32,
) -> Result<()> {
    write_pictures(path, pictures, |sink, pictures| {
        // Speed 10 of 30: the encoder's balance of palette quality and time.
        let mut encoder = GifEncoder::new_with_speed(sink, 10);
        encoder
            .set_repeat(Repeat::Infinite)
            .map_err(io::Error::other)?;
        for picture in pictures {
            let frame = gif_frame(&picture?, rate)
                .ok_or_else(|| io::Error::other("an image of another size than stated"))?;
            encoder.encode_frame(frame).map_err(io::Error::other)?;
        }
        Ok(())
    })
}

fn gif_frame(picture: &RgbImage, rate: u32) -> Option<Frame> {
    let rgba = picture
        .pixels
        .chunks(3)
        .flat_map(|p| [p[0], p[1], p[2], 255]);
    let image = RgbaImage::from_raw(picture.width, picture.height, rgba.collect())?;
    let delay = Delay::from_numer_denom_ms(1000, rate);
    Some(Frame::from_parts(image, 0, 0, delay))
}

/// Writes pictures as an endless animated PNG, `rate` of them per second: every colour as it is. A viewer that knows no
/// animation shows the first.
pub fn write_apng(
    path: &Path,
    pictures: impl ExactSizeIterator<Item = Result<RgbImage>>,
    rate: u16,
) -> Result<()> {
    let count = pictures.len() as u32;
    write_pictures(path, pictures, |sink, pictures| {
        let Some(first) = pictures.next().transpose()? else {
            return Err(io::Error::other("no image to show"));
        };
        let [keyword, text] = PICTURE_MARK.map(String::from);
        let mut encoder = Encoder::new(sink, first.width, first.height);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_filter(Filter::Adaptive);
        encoder.set_animated(count, 0)?;
        encoder.set_frame_delay(1, rate)?;
        encoder.add_text_chunk(keyword, text)?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&first.pixels)?;
        for picture in pictures {
            writer.write_image_data(&picture?.pixels)?;
        }
        writer.finish().map_err(io::Error::from)
    })
}

/// Writes a file, complete or not at all, of pictures; the fault of a picture is handed on as it is.
pub(super) fn write_pictures(
    path: &Path,
    pictures: impl Iterator<Item = Result<RgbImage>>,
    fill: impl FnOnce(&mut Sink, &mut Pictures<'_>) -> io::Result<()>,
) -> Result<()> {
    let mut fault = None;
    let mut told = pictures.map(|picture| {
        picture.map_err(|error| {
            let said = io::Error::other(error.to_string());
            fault = Some(error);
            said
        })
    });
    let written = atomic::write_file(path, |sink| fill(sink, &mut told));
    drop(told);
    fault.map_or(written, Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;
    use std::fs::File;

    fn pictures() -> impl ExactSizeIterator<Item = Result<RgbImage>> {
        let picture = |value: u8| RgbImage {
            width: 8,
            height: 4,
            pixels: vec![value; 96],
        };
        [10, 200].into_iter().map(move |value| Ok(picture(value)))
    }

    #[test]
    fn gifs_play_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gif");
        write_gif(&path, pictures(), 25).unwrap();
        let file = io::BufReader::new(File::open(&path).unwrap());
        let decoder = image::codecs::gif::GifDecoder::new(file).unwrap();
        let frames = decoder.into_frames().collect_frames().unwrap();
        assert_eq!(frames.len(), 2);
        assert!(frames[1].buffer().get_pixel(3, 2)[0].abs_diff(200) < 3);
    }

    #[test]
    fn animated_pngs_play_back_in_their_colours() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.apng");
        write_apng(&path, pictures(), 25).unwrap();
        let file = io::BufReader::new(File::open(&path).unwrap());
        let decoder = image::codecs::png::PngDecoder::new(file).unwrap();
        let frames = decoder
            .apng()
            .unwrap()
            .into_frames()
            .collect_frames()
            .unwrap();
        assert_eq!(frames.len(), 2);
        assert_eq!(frames[1].buffer().get_pixel(3, 2).0, [200, 200, 200, 255]);
        assert_eq!(frames[1].delay().numer_denom_ms(), (40, 1));
        // A reader of still pictures sees the first.
        assert_eq!(RgbImage::read(&path).unwrap().pixels, vec![10; 96]);
    }
}
