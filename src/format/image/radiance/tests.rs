//! Radiance files made here, byte by byte or by another writer; what is odd, what is refused.

use super::*;

/// Three columns and two rows: red counts columns, green rows.
const TEXELS: [[u8; 4]; 6] = [
    [10, 1, 7, 129],
    [20, 1, 7, 129],
    [30, 1, 7, 129],
    [10, 2, 7, 129],
    [20, 2, 7, 129],
    [30, 2, 7, 129],
];

fn file(header: &str, order: &str, pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = format!("{header}\n\n{order}\n").into_bytes();
    bytes.extend(pixels.concat());
    bytes
}

const HEADER: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe";

/// What mantissa 1 stands for with exponent 129.
const STEP: f32 = 0.0078125;

#[test]
fn all_eight_orders_show_the_same_picture() {
    let at = |row: usize, col: usize| TEXELS[row * 3 + col];
    let expected: Vec<f32> = TEXELS
        .iter()
        .flat_map(|t| [0, 1, 2].map(|c| f32::from(t[c]) * STEP))
        .collect();
    for (y, x) in [("-Y", "+X"), ("-Y", "-X"), ("+Y", "+X"), ("+Y", "-X")] {
        let rows: Vec<usize> = if y == "-Y" { vec![0, 1] } else { vec![1, 0] };
        let cols: Vec<usize> = if x == "+X" {
            vec![0, 1, 2]
        } else {
            vec![2, 1, 0]
        };
        let by_rows: Vec<_> = rows
            .iter()
            .flat_map(|&r| cols.iter().map(move |&c| at(r, c)))
            .collect();
        let by_cols: Vec<_> = cols
            .iter()
            .flat_map(|&c| rows.iter().map(move |&r| at(r, c)))
            .collect();
        for (order, pixels) in [
            (format!("{y} 2 {x} 3"), by_rows),
            (format!("{x} 3 {y} 2"), by_cols),
        ] {
            let image = read(&file(HEADER, &order, &pixels)).unwrap();
            assert_eq!((image.width, image.height), (3, 2), "{order}");
            assert_eq!(image.data, expected, "{order}");
        }
    }
}

#[test]
fn signatures_of_all_kinds_are_read() {
    for signature in ["#?RGBE", "#?RADIANCE", "#?AUTOPANO"] {
        let header = format!("{signature}\n# a comment\nFORMAT=32-bit_rle_rgbe");
        assert!(read(&file(&header, "-Y 2 +X 3", &TEXELS)).is_ok());
    }
}

#[test]
fn exposure_and_correction_are_divided_out() {
    let header = format!("{HEADER}\nEXPOSURE=2\nEXPOSURE= 4.0\nCOLORCORR=1 0.5 2\nPIXASPECT=1");
    let image = read(&file(&header, "-Y 2 +X 3", &TEXELS)).unwrap();
    let expected = [10.0 * STEP / 8.0, STEP / 4.0, 7.0 * STEP / 16.0];
    assert_eq!(image.data[..3], expected);
    let narrow = format!("{HEADER}\nPIXASPECT=2");
    let image = read(&file(&narrow, "-Y 2 +X 3", &TEXELS)).unwrap();
    assert_eq!(image.pixel_aspect, 0.5);
}

#[test]
fn old_and_new_run_lengths_are_read() {
    let mut old = format!("{HEADER}\n\n-Y 1 +X 300\n").into_bytes();
    // 1 pixel, 43 = 0x2b repeats, then 1 << 8.
    old.extend([9, 8, 7, 129, 1, 1, 1, 43, 1, 1, 1, 1]);
    let image = read(&old).unwrap();
    assert!(
        image
            .data
            .chunks(3)
            .all(|t| t == [9.0 * STEP, 8.0 * STEP, 7.0 * STEP])
    );
    let mut new = format!("{HEADER}\n\n-Y 1 +X 8\n").into_bytes();
    new.extend([2, 2, 0, 8, 136, 9, 3, 1, 2, 3, 133, 4, 136, 0, 136, 129]);
    let image = read(&new).unwrap();
    let green: Vec<f32> = image.data.chunks(3).map(|t| t[1] / STEP).collect();
    assert_eq!(green, [1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0, 4.0]);
}

#[test]
fn other_primaries_and_xyze_are_stated() {
    let primaries = format!("{HEADER}\nPRIMARIES=0.64 0.33 0.29 0.6 0.15 0.06 0.3333 0.3333");
    let image = read(&file(&primaries, "-Y 2 +X 3", &TEXELS)).unwrap();
    assert!(image.statement.matrix.is_some());
    let xyz = "#?RADIANCE\nFORMAT=32-bit_rle_xyze";
    let image = read(&file(xyz, "-Y 2 +X 3", &TEXELS)).unwrap();
    let white = image.statement.matrix.unwrap() * glam::DVec3::ONE;
    assert!((white - glam::DVec3::ONE).length() < 1e-9);
}

#[test]
fn damaged_files_are_refused_by_place() {
    let refused = |bytes: &[u8]| match read(bytes) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    let sound = file(HEADER, "-Y 2 +X 3", &TEXELS);
    assert!(refused(&sound[..sound.len() - 1]).contains("line 1: the end of the file"));
    assert!(refused(&file(HEADER, "-Y 2 +Y 3", &TEXELS)).contains("resolution line"));
    assert!(refused(&file(HEADER, "-Y 2 +X", &TEXELS)).contains("-Y 480 +X 640"));
    assert!(refused(&file(HEADER, "-Y 2 +X 99999999999", &TEXELS)).contains("resolution"));
    assert!(refused(&file(HEADER, "-Y 9999 +X 9999", &TEXELS)).contains("fewer texels"));
    let exposure = format!("{HEADER}\nEXPOSURE=0");
    assert!(refused(&file(&exposure, "-Y 2 +X 3", &TEXELS)).contains("EXPOSURE: 0"));
    let format = "#?RADIANCE\nFORMAT=16-bit";
    assert!(refused(&file(format, "-Y 2 +X 3", &TEXELS)).contains("FORMAT: 16-bit"));
    assert!(refused(b"#?RADIANCE").contains("end of the file"));
    // A run that begins before any pixel, and one beyond the line.
    assert!(refused(&file(HEADER, "-Y 1 +X 3", &[[1, 1, 1, 2]])).contains("run of 2"));
    assert!(
        refused(&file(HEADER, "-Y 1 +X 3", &[[5, 5, 5, 5], [1, 1, 1, 9]])).contains("run of 9")
    );
}
