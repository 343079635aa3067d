//! Files that were damaged or made to harm: each is refused by name, at once, and the program lives.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process::Command;

use mesotex::btf::{DType, Description, Direction, Sample, SampleWriter};
use mesotex::exemplar::neighbor_table::NeighborTable;
use mesotex::exemplar::{Features, KnnOptions, Space, SpaceLevel, neighbor_table};
use mesotex::format::{ContentId, npz};
use mesotex::grid::TexelGrid;
use mesotex::progress::Progress;
use ndarray::Array2;
use serde_json::json;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Runs a command that must refuse its data: exit code 1, one message that names `file`.
fn refuse(folder: &Path, words: &[&str], file: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    let output = command.args(words).current_dir(folder).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{words:?}: {error}");
    assert!(error.contains(file), "{error}");
    assert!(
        !error.contains("panicked") && !error.contains("backtrace"),
        "{error}"
    );
    error
}

/// A PNG whose palette is no whole number of colours: its decoder panics.
fn broken_palette() -> Vec<u8> {
    let chunk = |kind: &[u8; 4], content: &[u8]| {
        let mut crc = flate2::Crc::new();
        crc.update(kind);
        crc.update(content);
        let length = (content.len() as u32).to_be_bytes();
        [&length, &kind[..], content, &crc.sum().to_be_bytes()].concat()
    };
    let mut pixels = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    pixels.write_all(&[0, 1]).unwrap();
    [
        b"\x89PNG\r\n\x1a\n".to_vec(),
        chunk(b"IHDR", b"\0\0\0\x01\0\0\0\x01\x08\x03\0\0\0"),
        chunk(b"PLTE", &[1, 2, 3, 4]),
        chunk(b"IDAT", &pixels.finish().unwrap()),
        chunk(b"IEND", b""),
    ]
    .concat()
}

#[test]
fn a_decoder_that_panics_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.png"), broken_palette()).unwrap();
    refuse(folder.path(), &["info", "p.png"], "p.png");
    let table = "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\np.png,0,0,0,0\n";
    fs::write(folder.path().join("a.csv"), table).unwrap();
    refuse(
        folder.path(),
        &["import", "a.csv", "-o", "a.sample"],
        "p.png",
    );
    assert!(!folder.path().join("a.sample").exists());
}

#[test]
fn counts_without_bytes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\n\
        property float y\nproperty float z\nelement nothing 18446744073709551615\nend_header\n";
    fs::write(folder.path().join("a.ply"), header).unwrap();
    let error = refuse(folder.path(), &["info", "a.ply"], "a.ply");
    assert!(error.contains("element nothing"), "{error}");
    let gif =
        b"GIF89a\0\x10\0\x10\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\x01\0\x01\0\0\x02\x02\x44\x01\0;";
    fs::write(folder.path().join("a.gif"), gif).unwrap();
    let error = refuse(folder.path(), &["info", "a.gif"], "a.gif");
    assert!(error.contains("4096 × 4096"), "{error}");
}

fn space(folder: &Path) -> Space {
    let level = |side: u32| SpaceLevel {
        grid: TexelGrid {
            width: side,
            height: side,
            tileable: true,
        },
        features: Features::Textons {
            labels: (0..side * side).map(|k| (k * k % 5) as u16).collect(),
            gram: Array2::from_shape_fn((6, 6), |(r, c)| if r == c { 2.0 } else { 0.25 }),
        },
    };
    let mut space = Space {
        levels: vec![level(8), level(4)],
        channels: mesotex::exemplar::Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(b""),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    };
    space.write(&folder.join("a.space.npz"), None).unwrap();
    space
}

/// Writes a table for `space` after a change to it.
fn write_table(folder: &Path, space: &Space, change: impl FnOnce(&mut NeighborTable)) {
    let options = KnnOptions {
        k: 2,
        neighborhood: 3,
        ..KnnOptions::default()
    };
    let mut table = neighbor_table::build(space, &options, Progress::silent()).unwrap();
    change(&mut table);
    table.write(&folder.join("a.knn.npz"), &options).unwrap();
}

#[test]
fn numbers_of_a_table_are_checked_before_they_are_used() {
    let folder = tempfile::tempdir().unwrap();
    let space = space(folder.path());
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(folder.path().join("a.obj"), mesh).unwrap();
    let refused = |field: &str, change: fn(&mut NeighborTable)| {
        write_table(folder.path(), &space, change);
        let synth = [
            "synth",
            "a.space.npz",
            "a.knn.npz",
            "a.obj",
            "-o",
            "a.map.ply",
        ];
        for words in [&synth[..], &["info", "a.knn.npz"]] {
            let error = refuse(folder.path(), words, "a.knn.npz");
            assert!(error.contains(field), "{field}: {error}");
        }
    };
    refused("levels[0]: offsets[3]", |table| {
        table.levels[0].neighborhood.offsets[3] = [i32::MIN, 0];
    });
    refused("levels[0]: coarse_offsets[0]", |table| {
        table.levels[0].neighborhood.coarse_offsets[0] = [0, 128];
    });
    refused("levels[0]: offsets[1]: [-2, -2]; expected [", |table| {
        table.levels[0].neighborhood.offsets[1] = [-2, -2];
    });
    refused("levels[0]: coarse_offsets[0]", |table| {
        table.levels[0].neighborhood.coarse_offsets.swap(0, 1);
    });
    refused("levels[0]: offsets: ", |table| {
        table.levels[0].neighborhood.offsets.pop();
        table.levels[0].neighborhood.weights.pop();
    });
    refused("weight 1 of offsets", |table| {
        table.levels[1].neighborhood.weights[1] = -1.0;
    });
    refused("levels[1]: coarse_offsets", |table| {
        table.levels[1].neighborhood = table.levels[0].neighborhood.clone();
    });
    refused("levels[1]: min_separation", |table| {
        table.levels[1].min_separation = u32::MAX;
    });
}

/// Writes a vocabulary of two levels, the second of `side` texels, all centroids holding `value`.
fn write_vocabulary(path: &Path, side: usize, counts: [u32; 2], value: f32) {
    let meta = json!({
        "format": "mesotex-textons", "version": 1, "tileable": true, "channels": 3,
        "options": {}, "seed": 0, "inertia": [1.0, 1.0], "iterations": [1, 1],
        "sample": ContentId::of_bytes(b"sample").to_string()
    });
    npz::write(path, meta.as_object().unwrap().clone(), |file| {
        for (at, side) in [4, side].into_iter().enumerate() {
            let labels = Array2::from_shape_fn((side, side), |(_, c)| (c % 2) as u16);
            let half = (side * side / 2) as u32;
            let counts = if at == 0 { counts } else { [half, half] };
            let centroids = Array2::from_elem((2, 6), value);
            file.array(&format!("L{at}/labels"), labels.view())?;
            file.array(&format!("L{at}/centroids"), centroids.view())?;
            file.array(&format!("L{at}/counts"), ndarray::aview1(&counts))?;
        }
        file.array("representatives", ndarray::aview1(&[0_u32]))?;
        let filters = ndarray::Array3::from_elem((2, 3, 3), 0.5_f32);
        file.array("filters", filters.view())
    })
    .unwrap();
}

#[test]
fn vocabularies_that_do_not_hold_together_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.textons.npz");
    let refused = |place: &str| {
        let gram = ["gram", "a.textons.npz", "-o", "a.space.npz"];
        for words in [&gram[..], &["info", "a.textons.npz"]] {
            let error = refuse(folder.path(), words, "a.textons.npz");
            assert!(error.contains(place), "{place}: {error}");
        }
        assert!(!folder.path().join("a.space.npz").exists());
    };
    write_vocabulary(&path, 4, [8, 8], 1.0);
    refused("L1/labels: 4 × 4 texels; expected 2 × 2");
    // The two counts add up to 16 in 32 bits, not in truth.
    write_vocabulary(&path, 2, [u32::MAX, 17], 1.0);
    refused("L0/counts");
    write_vocabulary(&path, 2, [16, 0], 1.0);
    refused("L0/counts");
    // Finite, but its square is not.
    write_vocabulary(&path, 2, [8, 8], 1e30);
    refused("L0/centroids");
    write_vocabulary(&path, 2, [8, 8], 1.0);
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    let words = ["gram", "a.textons.npz", "-o", "a.space.npz"];
    let output = command
        .args(words)
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn members_that_share_bytes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = File::create(folder.path().join("a.npz")).unwrap();
    let mut zip = ZipWriter::new(file);
    zip.start_file("a.npy", SimpleFileOptions::default())
        .unwrap();
    zip.write_all(&[7; 100]).unwrap();
    zip.shallow_copy_file("a.npy", "b.npy").unwrap();
    zip.finish().unwrap();
    let error = refuse(folder.path(), &["info", "a.npz"], "a.npz");
    assert!(error.contains("share bytes"), "{error}");
}

#[test]
fn a_sample_that_shrinks_while_it_is_open_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.sample");
    let side = 64;
    let description = Description {
        dtype: DType::F2,
        tileable: true,
        ..Description::product(
            "a",
            [side, side],
            vec![Direction::from_angles(0.0, 0.0)],
            vec![
                Direction::from_angles(0.0, 0.0),
                Direction::from_angles(0.5, 0.0),
            ],
        )
    };
    let mut writer = SampleWriter::create(&path, description).unwrap();
    for _ in 0..2 {
        writer.push(&vec![0.5; (side * side * 3) as usize]).unwrap();
    }
    writer.finish().unwrap();
    let sample = Sample::open(&path).unwrap();
    assert_eq!(sample.image(1).unwrap().get(0), 0.5);
    let radiance = path.join("radiance.npy");
    File::options()
        .write(true)
        .open(&radiance)
        .unwrap()
        .set_len(20_000)
        .unwrap();
    assert_eq!(sample.image(0).map(|image| image.get(0)).ok(), None);
    let error = sample.image(1).unwrap_err().to_string();
    assert!(
        error.contains("radiance.npy") && error.contains("shrank"),
        "{error}"
    );
    // Arrays in archives, too.
    let space = space(folder.path());
    write_table(folder.path(), &space, |_| {});
    let archive = folder.path().join("a.knn.npz");
    let mut reader = npz::Reader::open(&archive).unwrap();
    File::options()
        .write(true)
        .open(&archive)
        .unwrap()
        .set_len(100)
        .unwrap();
    let error = reader
        .array::<u32, ndarray::Ix2>("L0/neighbors")
        .unwrap_err()
        .to_string();
    assert!(error.contains("a.knn.npz"), "{error}");
}
