//! Broken files are refused, and the words say what is wrong.

use std::fs;

use mesotex::btf::bonn::{Compression, Scalar};

use crate::files::{self, Dfmf, TEXELS, bdi, fmf, header, import, pvf};

/// What is said of a file's bytes.
fn refused(bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.btf");
    fs::write(&path, bytes).unwrap();
    let error = import(&path).unwrap_err().to_string();
    assert!(error.contains("a.btf"), "{error}");
    assert!(!path.with_extension("sample").exists());
    error
}

fn check(bytes: &[u8], says: &[&str]) {
    let error = refused(bytes);
    for word in says {
        assert!(error.contains(word), "{word}: {error}");
    }
}

/// Where a 32-bit number stands for the first time behind `from`.
fn place_of(bytes: &[u8], number: u32, from: usize) -> usize {
    let wanted = number.to_le_bytes();
    let found = bytes[from..].windows(4).position(|word| word == wanted);
    from + found.unwrap()
}

fn with_number(bytes: &[u8], at: usize, number: u32) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
    bytes
}

#[test]
fn every_beginning_of_every_file_is_refused() {
    for bytes in files::all() {
        let step = (bytes.len() / 200).max(1);
        for length in (0..bytes.len()).step_by(step) {
            refused(&bytes[..length]);
        }
        refused(&bytes[..bytes.len() - 1]);
        let mut longer = bytes.clone();
        longer.push(0);
        check(&longer, &["1 bytes follow the last number"]);
    }
}

#[test]
fn other_byte_orders_are_recognised() {
    let mut bytes = Dfmf::default().bytes();
    for field in [10..14, 14..18] {
        bytes[field].reverse();
    }
    check(&bytes, &["big-endian", "header version"]);
    let mut bytes = Dfmf::default().bytes();
    bytes[14] = 9;
    check(&bytes, &["header version: 9", "1 to 4"]);
}

#[test]
fn older_headers_of_other_byte_orders_are_recognised() {
    let mut bytes = pvf("!PVF06FC", &header(), Scalar::Half, false, true);
    bytes[8..12].reverse();
    check(&bytes, &["big-endian"]);
}

#[test]
fn wrong_counts_are_refused_before_anything_is_allocated() {
    let bytes = Dfmf::default().bytes();
    let body = bytes.len() - files::channels_length();
    let header_size = u32::from_le_bytes(bytes[10..14].try_into().unwrap());
    let sampling = 10 + header_size as usize;
    for (at, says) in [
        (10, "header size"),
        (sampling, "number of views"),
        (sampling + 12, "number of lights"),
        (body - 60, "rotations"),
        (body + 1, "channel 0"),
        (body + 5, "channel 0"),
        (body + 9, "channel 0"),
    ] {
        check(&with_number(&bytes, at, u32::MAX), &[says]);
    }
    let size = place_of(&bytes, files::WIDTH as u32, sampling);
    check(&with_number(&bytes, size, 0), &["0 × 3"]);
    check(&with_number(&bytes, size, 6), &["rows of U"]);
    check(&with_number(&bytes, size, u32::MAX), &["2^32"]);
    let mut odd = bytes.clone();
    odd[body] = 3;
    check(&odd, &["channel 0: scalar size: 3"]);
}

#[test]
fn numbers_that_are_none_are_named_by_their_place() {
    let bytes = Dfmf::default().bytes();
    let body = bytes.len() - files::channels_length();
    // Behind scalar size, three counts and the singular values, as halves.
    let first = body + 13 + 2 * files::RANK;
    let mut nan = bytes.clone();
    nan[first + 2 * (2 * files::RANK + 1) + 1] = 0x7e;
    check(&nan, &["channel 0: U: row 2, component 1", "NaN"]);
    let mut bytes = bdi(&header(), Compression::Full, 4, &[true; TEXELS]);
    let last = bytes.len() - 1;
    bytes[last] = 0x7c;
    check(&bytes, &["view 2, light 3, row 2, column 4"]);
    let far = fmf("!FMF06FC", &header(), None, Scalar::Double, false);
    let mut beyond = far.clone();
    let end = beyond.len();
    beyond[end - 8..].copy_from_slice(&1e300_f64.to_le_bytes());
    check(&beyond, &["factors: SxV: row 14, component 2", "32-bit"]);
}

#[test]
fn what_cannot_be_turned_to_rgb_is_refused_with_words() {
    let model = |number: u32| {
        let bytes = Dfmf::default().bytes();
        let body = bytes.len() - files::channels_length();
        with_number(&bytes, body - 52, number)
    };
    check(&model(6), &["SPECTRAL_LINEAR", "11 (logY U/Y V/Y)"]);
    check(&model(99), &["color_model: 99"]);
    let mut header = header();
    header.meta.channels = ["400", "450", "500", "550"].map(str::to_owned).to_vec();
    let file = Dfmf {
        header: header.clone(),
        ..Dfmf::default()
    };
    check(&file.bytes(), &["400, 450, 500, 550", "spectral"]);
    header.meta.channels = ["B", "G", "R"].map(str::to_owned).to_vec();
    let file = Dfmf {
        header,
        ..Dfmf::default()
    };
    check(&file.bytes(), &["R, G, B in this order"]);
}

#[test]
fn directions_that_no_patch_has_are_refused() {
    let bytes = Dfmf::default().bytes();
    let header_size = u32::from_le_bytes(bytes[10..14].try_into().unwrap());
    let first = 10 + header_size as usize + 4;
    let degrees = with_number(&bytes, first, 75_f32.to_bits());
    check(&degrees, &["view 0: polar angle: 75 radians"]);
    let nan = with_number(&bytes, first + 4, f32::NAN.to_bits());
    check(&nan, &["view 0", "NaN"]);
    // The second view has another number of lights.
    let second = first + 12 + files::LIGHTS * 8 + 8;
    check(
        &with_number(&bytes, second, 3),
        &["view 1: number of lights: 3"],
    );
}

#[test]
fn bdi_chunks_and_masks_that_do_not_fit_are_refused() {
    let bytes = bdi(&header(), Compression::Sparse, 4, &[true; TEXELS]);
    let chunk = bytes.len() - TEXELS * files::IMAGES * 6 - 4;
    check(
        &with_number(&bytes, chunk, 10),
        &["chunk 0: size: 10 bytes"],
    );
    let rotations = chunk - 4;
    let mask = rotations - TEXELS;
    let mut other = bytes.clone();
    other[mask - 1] = 7;
    check(&other, &["compression: 7"]);
    let mut empty = bytes.clone();
    empty[mask..rotations].fill(0);
    check(&empty, &["mask: 0 of 15"]);
    check(&with_number(&bytes, mask - 5, 0), &["scan lines per chunk"]);
    let mut packed = bdi(&header(), Compression::Bzip, 4, &[true; TEXELS]);
    let end = packed.len();
    packed[end - 20] ^= 0xff;
    check(&packed, &["bzip2"]);
}

#[test]
fn views_of_pvf_that_do_not_fit_are_refused() {
    let bytes = pvf("!PVF06FC", &header(), Scalar::Half, false, false);
    let header_size = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
    let sampling = 4 + files::VIEWS * (12 + files::LIGHTS * 8);
    let slots = 8 + header_size + sampling + 8 + 4;
    check(
        &with_number(&bytes, slots, 2),
        &["view slots: 2", "3, one per view"],
    );
    check(&with_number(&bytes, slots + 9, 14), &["view 0"]);
    check(&with_number(&bytes, slots + 5, 0), &["view 0"]);
}
