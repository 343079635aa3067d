//! `mesotex knn` as a user runs it: the file's contract and what is refused.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

use std::path::Path;
use std::process::{Command, Output};

use mesotex::exemplar::neighbor_table::NeighborTable;
use mesotex::exemplar::{Features, Space, SpaceLevel};
use mesotex::format::ContentId;
use mesotex::grid::TexelGrid;
use ndarray::Array2;

/// Two levels of a few textons on a line.
fn write_space(path: &Path, side: u32, tileable: bool) -> Space {
    let level = |side: u32| SpaceLevel {
        grid: TexelGrid {
            width: side,
            height: side,
            tileable,
        },
        features: Features::Textons {
            labels: (0..side * side)
                .map(|i| ((i * i + i / 3) % 7) as u16)
                .collect(),
            gram: Array2::from_shape_fn((8, 8), |(i, j)| ((i % 7) * (j % 7)) as f32),
        },
    };
    let mut space = Space {
        levels: vec![level(side), level(side.div_ceil(2))],
        channels: mesotex::exemplar::Channels::default(),
        controls: Vec::new(),
        id: ContentId::of_bytes(b""),
        texel_mm: None,
        sample: ContentId::of_bytes(b"sample"),
    };
    space.write(path, None).unwrap();
    space
}

fn run(folder: &Path, line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .current_dir(folder)
        .args(line.split_whitespace())
        .output()
        .unwrap()
}

#[test]
fn the_table_carries_what_synthesis_needs() {
    let folder = tempfile::tempdir().unwrap();
    let space = write_space(&folder.path().join("a.space.npz"), 20, false);
    let output = run(folder.path(), "knn a.space.npz -o a.knn.npz --k 6 --json");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["levels"][0]["search"], "exact");
    let table = NeighborTable::read(&folder.path().join("a.knn.npz")).unwrap();
    table.check_belongs_to(&space, false).unwrap();
    let [fine, coarse] = &table.levels[..] else {
        panic!("two levels")
    };
    assert_eq!(fine.neighborhood.offsets.len(), 49);
    assert_eq!(
        (fine.neighborhood.offsets[0], fine.neighborhood.offsets[24]),
        ([-3, -3], [0, 0])
    );
    assert_eq!(fine.neighborhood.coarse_offsets.len(), 9);
    assert!(coarse.neighborhood.coarse_offsets.is_empty());
    let whole = table.whole_texels(0, space.levels[0].grid);
    for (texel, row) in fine.neighbors.outer_iter().enumerate() {
        assert_eq!(row[0] as usize, texel);
        assert!(row.iter().skip(1).all(|&neighbor| whole[neighbor as usize]));
        let distances = fine.distances.row(texel);
        assert!(distances.iter().skip(1).is_sorted());
    }
}

#[test]
fn impossible_tables_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    write_space(&folder.path().join("a.space.npz"), 8, true);
    for (options, says) in [
        ("--neighborhood 6", "odd"),
        ("--coarse-neighborhood 2", "odd"),
        ("--k 0", "1 to 4096"),
        ("--k 17", "level 1"),
        ("--candidates 0", "1 to 1048576"),
        ("--margin 4", "at most 3, or `full`"),
        ("--margin some", "neither `full` nor a number"),
    ] {
        let output = run(
            folder.path(),
            &format!("knn a.space.npz -o a.knn.npz {options}"),
        );
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{options}: {error}");
        assert!(error.contains(says), "{options}: {error}");
    }
    assert!(!folder.path().join("a.knn.npz").exists());
    let output = run(folder.path(), "knn missing.npz -o a.knn.npz");
    assert_eq!(output.status.code(), Some(1));
}
