//! Orientation as EXIF and TIFF count it: which stored row and column is up and left.

use image::metadata::Orientation as Tag;

/// The orientation that EXIF data state; 1 where they state none.
pub(super) fn of_exif(exif: Option<&[u8]>) -> u8 {
    let bytes = exif.unwrap_or_default();
    let bytes = bytes.strip_prefix(b"Exif\0\0").unwrap_or(bytes);
    Tag::from_exif_chunk(bytes).map_or(1, Tag::to_exif)
}

/// Interleaved numbers turned upright; with orientations 5 to 8 width and height change places.
pub(super) fn turned(
    data: &[f32],
    (width, height): (usize, usize),
    channels: usize,
    orientation: u8,
) -> Vec<f32> {
    let (columns, rows) = match orientation {
        5..=8 => (height, width),
        _ => (width, height),
    };
    let mut upright = Vec::with_capacity(data.len());
    for row in 0..rows {
        for col in 0..columns {
            let (row, col) = stored_at(orientation, (row, col), (width, height));
            let texel = row * width + col;
            upright.extend_from_slice(&data[texel * channels..][..channels]);
        }
    }
    upright
}

/// Where the file stores the texel that is seen at (row, col).
fn stored_at(
    orientation: u8,
    (row, col): (usize, usize),
    (width, height): (usize, usize),
) -> (usize, usize) {
    match orientation {
        2 => (row, width - 1 - col),
        3 => (height - 1 - row, width - 1 - col),
        4 => (height - 1 - row, col),
        5 => (col, row),
        6 => (height - 1 - col, row),
        7 => (height - 1 - col, width - 1 - row),
        8 => (col, width - 1 - row),
        _ => (row, col),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, Luma};

    #[test]
    fn all_eight_are_as_the_image_crate_turns_them() {
        let stored = GrayImage::from_fn(3, 2, |x, y| Luma([(10 * y + x) as u8]));
        let numbers: Vec<f32> = stored.iter().map(|&v| f32::from(v)).collect();
        for orientation in 1..=8 {
            let mut expected = DynamicImage::ImageLuma8(stored.clone());
            expected.apply_orientation(Tag::from_exif(orientation).unwrap());
            let expected: Vec<f32> = expected.to_luma8().iter().map(|&v| f32::from(v)).collect();
            assert_eq!(
                turned(&numbers, (3, 2), 1, orientation),
                expected,
                "{orientation}"
            );
        }
    }

    #[test]
    fn exif_of_either_byte_order_is_read() {
        let little = b"II\x2a\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
        let big = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x08\0\0\0\0\0\0";
        assert_eq!(of_exif(Some(little)), 6);
        assert_eq!(of_exif(Some(big)), 8);
        assert_eq!(of_exif(Some(&little[..9])), 1);
        assert_eq!(of_exif(None), 1);
    }
}
