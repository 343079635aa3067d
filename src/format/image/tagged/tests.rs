//! TIFF files made here, byte by byte or by another writer; what is odd, what is refused.

use super::*;
use crate::format::image::{FloatImage, ReadOptions, read_with};

/// A TIFF of one strip: (tag, values) of 16-bit numbers, then the pixels.
fn tiff(tags: &[(u16, &[u16])], pixels: &[u8]) -> Vec<u8> {
    let mut tags: Vec<(u16, Vec<u16>)> = tags.iter().map(|(t, v)| (*t, v.to_vec())).collect();
    tags.push((273, vec![0]));
    tags.push((279, vec![pixels.len() as u16]));
    tags.sort();
    let directory = 2 + tags.len() * 12 + 4;
    let mut beyond = Vec::new();
    let mut bytes = b"II\x2a\0\x08\0\0\0".to_vec();
    bytes.extend((tags.len() as u16).to_le_bytes());
    let long: usize = tags
        .iter()
        .map(|(_, v)| if v.len() > 2 { v.len() * 2 } else { 0 })
        .sum();
    for (tag, values) in &mut tags {
        if *tag == 273 {
            values[0] = (8 + directory + long) as u16;
        }
        bytes.extend(tag.to_le_bytes());
        bytes.extend(3_u16.to_le_bytes());
        bytes.extend((values.len() as u32).to_le_bytes());
        let mut content: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        if content.len() > 4 {
            let at = (8 + directory + beyond.len()) as u32;
            beyond.extend(content);
            content = at.to_le_bytes().to_vec();
        }
        content.resize(4, 0);
        bytes.extend(content);
    }
    bytes.extend([0; 4]);
    bytes.extend(beyond);
    bytes.extend(pixels);
    bytes
}

fn read_bytes(bytes: &[u8], options: &ReadOptions) -> Result<FloatImage> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::write(&path, bytes).unwrap();
    read_with(&path, options).map(|read| read.image)
}

fn data(tags: &[(u16, &[u16])], pixels: &[u8]) -> Vec<f32> {
    read_bytes(&tiff(tags, pixels), &ReadOptions::data())
        .unwrap()
        .data
}

fn bytes(values: &[f32]) -> Vec<f32> {
    values.iter().map(|v| v / 255.0).collect()
}

#[test]
fn planes_are_interleaved() {
    let tags: &[(u16, &[u16])] = &[
        (256, &[2]),
        (257, &[1]),
        (258, &[8, 8, 8]),
        (262, &[2]),
        (277, &[3]),
        (278, &[1]),
        (284, &[2]),
    ];
    // Three strips of one plane each.
    let mut file = tiff(tags, &[1, 4, 2, 5, 3, 6]);
    let first = file.len() as u16 - 6;
    let tags: Vec<(u16, Vec<u16>)> =
        vec![(273, vec![first, first + 2, first + 4]), (279, vec![2; 3])];
    let mut all: Vec<u8> = Vec::new();
    // The strip tables have three entries, so the directory is written again with them at the end.
    let entries = u16::from_le_bytes([file[8], file[9]]) as usize;
    for index in 0..entries {
        let at = 10 + index * 12;
        let tag = u16::from_le_bytes([file[at], file[at + 1]]);
        if let Some((_, values)) = tags.iter().find(|(t, _)| *t == tag) {
            let place = (file.len() + all.len()) as u32;
            all.extend(values.iter().flat_map(|v| v.to_le_bytes()));
            file[at + 4..at + 8].copy_from_slice(&3_u32.to_le_bytes());
            file[at + 8..at + 12].copy_from_slice(&place.to_le_bytes());
        }
    }
    file.extend(all);
    let image = read_bytes(&file, &ReadOptions::data()).unwrap();
    assert_eq!(image.data, bytes(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
}

#[test]
fn few_bits_and_white_as_zero_are_read() {
    let grey = |bits: u16, photometric: u16, pixels: &[u8]| {
        let tags: &[(u16, &[u16])] = &[
            (256, &[3]),
            (257, &[1]),
            (258, &[bits]),
            (262, &[photometric]),
            (278, &[1]),
        ];
        data(tags, pixels)
    };
    assert_eq!(grey(1, 1, &[0b1010_0000]), [1.0, 0.0, 1.0]);
    assert_eq!(grey(1, 0, &[0b1010_0000]), [0.0, 1.0, 0.0]);
    assert_eq!(grey(4, 1, &[0x0f, 0x50]), [0.0, 1.0, 1.0 / 3.0]);
    assert_eq!(grey(2, 1, &[0b00_11_10_00]), [0.0, 1.0, 2.0 / 3.0]);
    assert_eq!(grey(8, 0, &[255, 0, 255]), [0.0, 1.0, 0.0]);
}

#[test]
fn palettes_become_colours() {
    let map: [u16; 12] = [0, 65535, 0, 0, 0, 0, 65535, 0, 0, 0, 0, 65535];
    let tags: &[(u16, &[u16])] = &[
        (256, &[4]),
        (257, &[1]),
        (258, &[2]),
        (262, &[3]),
        (278, &[1]),
        (320, &map),
    ];
    let found = data(tags, &[0b00_01_10_11]);
    assert_eq!(found, [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.]);
    let short: &[(u16, &[u16])] = &[
        (256, &[4]),
        (257, &[1]),
        (258, &[2]),
        (262, &[3]),
        (278, &[1]),
        (320, &map[..9]),
    ];
    let error = read_bytes(&tiff(short, &[0b00_01_10_11]), &ReadOptions::data());
    assert!(error.unwrap_err().to_string().contains("palette of 9"));
}

#[test]
fn alpha_of_either_kind_is_seen() {
    let tags = |kind: &'static [u16]| -> Vec<(u16, &'static [u16])> {
        vec![
            (256, &[2]),
            (257, &[1]),
            (258, &[8, 8, 8, 8]),
            (262, &[2]),
            (277, &[4]),
            (278, &[1]),
            (338, kind),
        ]
    };
    let pixels = [100, 0, 0, 0, 10, 20, 30, 255];
    let black = ReadOptions {
        alpha: crate::format::image::Alpha::OverBlack,
        ..ReadOptions::default()
    };
    let lit = crate::format::image::decode_srgb(100.0 / 255.0);
    for (kind, expected) in [(&[1][..], lit), (&[2], 0.0)] {
        let file = tiff(&tags(if kind == [1] { &[1] } else { &[2] }), &pixels);
        let error = read_bytes(&file, &ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains("1 of 2 texels"), "{error}");
        assert_eq!(read_bytes(&file, &black).unwrap().data[0], expected);
    }
}

#[test]
fn inks_and_other_colours_are_refused_by_name() {
    for (photometric, name) in [(5, "CMYK"), (8, "L*a*b*"), (4, "mask"), (32845, "LogLuv")] {
        let tags: &[(u16, &[u16])] = &[
            (256, &[1]),
            (257, &[1]),
            (258, &[8, 8, 8, 8]),
            (262, &[photometric]),
            (277, &[4]),
            (278, &[1]),
        ];
        let error = read_bytes(&tiff(tags, &[0; 4]), &ReadOptions::default());
        let error = error.unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn the_orientation_tag_turns_the_image() {
    let tags: &[(u16, &[u16])] = &[
        (256, &[2]),
        (257, &[1]),
        (258, &[8]),
        (262, &[1]),
        (274, &[2]),
        (278, &[1]),
    ];
    assert_eq!(data(tags, &[51, 255]), [1.0, 0.2]);
}
