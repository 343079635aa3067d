//! Parts of images, and means of blocks of them.

use crate::btf::import::prepare::region::Region;
use crate::error::{Error, Result};
use crate::format::image::FloatImage;

/// The part of an RGB image that a region covers.
pub(super) fn cropped(image: &FloatImage, region: Region) -> Result<FloatImage> {
    region.check_inside("crop", (image.width, image.height))?;
    let rows = region.rows(image.width);
    let data = rows.flat_map(|row| &image.data[row.start * 3..row.end * 3]);
    Ok(FloatImage {
        width: region.width,
        height: region.height,
        data: data.copied().collect(),
        ..*image
    })
}

/// The means of blocks of `block` × `block` texels of an RGB image, whose sides must be whole blocks.
pub(super) fn downsampled(image: &FloatImage, block: u32) -> Result<FloatImage> {
    // Check that the sides are whole blocks.
    let (width, height) = (image.width / block, image.height / block);
    if width * block != image.width || height * block != image.height || width * height == 0 {
        let crop = format!("{}x{}+0+0", width * block, height * block);
        let expected = match width * height {
            0 => "a smaller number".into(),
            _ => format!("sides of whole blocks, as with --crop {crop}"),
        };
        return Err(Error::option(
            "downsample",
            format!("{block} in images of {} × {}", image.width, image.height),
            expected,
        ));
    }
    // Sum each block.
    let (columns, block) = (width as usize, block as usize);
    let mut data = vec![0.0; columns * height as usize * 3];
    for (row, line) in image
        .data
        .chunks_exact(image.width as usize * 3)
        .enumerate()
    {
        let out = &mut data[row / block * columns * 3..][..columns * 3];
        for (col, texel) in line.chunks_exact(3).enumerate() {
            let sums = &mut out[col / block * 3..][..3];
            sums.iter_mut().zip(texel).for_each(|(sum, v)| *sum += v);
        }
    }
    // Divide the sums.
    let share = 1.0 / (block * block) as f32;
    data.iter_mut().for_each(|sum| *sum *= share);
    Ok(FloatImage {
        width,
        height,
        data,
        ..*image
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::image::{Encoding, Precision};

    fn picture(width: u32, height: u32) -> FloatImage {
        FloatImage {
            width,
            height,
            channels: 3,
            data: (0..width * height * 3).map(|k| k as f32).collect(),
            encoding: Encoding::Linear,
            precision: Precision::Float,
        }
    }

    #[test]
    fn crops_keep_their_texels_and_blocks_their_means() {
        let image = picture(4, 4);
        let part = cropped(&image, "2x2+1+2".parse().unwrap()).unwrap();
        assert_eq!(part.data[..6], [27.0, 28.0, 29.0, 30.0, 31.0, 32.0]);
        let half = downsampled(&image, 2).unwrap();
        assert_eq!((half.width, half.height), (2, 2));
        // Texels 0, 1, 4 and 5: red is 3 times the texel.
        assert_eq!(half.data[..3], [7.5, 8.5, 9.5]);
    }

    #[test]
    fn blocks_that_do_not_fit_are_refused() {
        let error = downsampled(&picture(5, 4), 2).unwrap_err().to_string();
        assert!(
            error.contains("--downsample") && error.contains("--crop 4x4+0+0"),
            "{error}"
        );
        assert!(
            downsampled(&picture(3, 3), 4)
                .unwrap_err()
                .to_string()
                .contains("a smaller number")
        );
    }
}
