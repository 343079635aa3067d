//! `mesotex textons` and `gram` as a user runs them: the files' contract, the same bytes at any
//! thread count, and what is refused.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mesotex::btf::direction::Direction;
use mesotex::btf::sample::{DType, Description, FORMAT, Layout, VERSION};
use mesotex::btf::writer::SampleWriter;
use mesotex::exemplar::space::{Features, Space};
use mesotex::format::id::ContentId;
use mesotex::texton::Vocabulary;
use tempfile::TempDir;

/// Bumps lit from a few sides: `images` images of `width` × `height` texels.
fn write_sample(path: &Path, [width, height]: [u32; 2], images: usize, tileable: bool) {
    let lights: Vec<Direction> = (0..images)
        .map(|i| Direction::from_angles(0.2 + 0.9 * i as f64 / images as f64, i as f64 * 2.4))
        .collect();
    let description = Description {
        format: FORMAT.into(),
        version: VERSION,
        name: "bumps".into(),
        width,
        height,
        channels: 3,
        dtype: DType::F4,
        texel_mm: None,
        layout: Layout::Product,
        views: vec![Direction::from_angles(0.0, 0.0)],
        lights: lights.clone(),
        pairs: None,
        tileable,
        id: ContentId::of_bytes(b""),
        source: serde_json::Value::Null,
    };
    let mut writer = SampleWriter::create(path, description).unwrap();
    for light in lights {
        let mut image = Vec::new();
        for texel in 0..width * height {
            let (row, col) = (f64::from(texel / width), f64::from(texel % width));
            let (u, v) = (
                0.9 * col + (0.7 * row).sin(),
                0.6 * row + (0.31 * col).cos(),
            );
            let normal = glam::DVec3::new(u.cos() * 0.4, v.sin() * 0.4, 1.0).normalize();
            let shade = normal.dot(light.0).max(0.0) as f32 / 3.2;
            image.extend([
                shade,
                0.8 * shade,
                0.5 * shade * (1.0 + 0.2 * (u * v).sin() as f32),
            ]);
        }
        writer.push(&image).unwrap();
    }
    writer.finish().unwrap();
}

struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new(sides: [u32; 2], images: usize, tileable: bool) -> Self {
        let bench = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        write_sample(&bench.path("a.sample"), sides, images, tileable);
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_mesotex"))
            .current_dir(self.folder.path())
            .args(line.split_whitespace())
            .output()
            .unwrap()
    }

    fn succeed(&self, line: &str) -> String {
        let output = self.run(line);
        assert!(
            output.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout).unwrap()
    }

    fn refuse(&self, line: &str, code: i32) -> String {
        let output = self.run(line);
        assert_eq!(output.status.code(), Some(code), "{line}");
        String::from_utf8(output.stderr).unwrap()
    }
}

#[test]
fn a_sample_that_does_not_tile_passes_the_appearance_chain() {
    let bench = Bench::new([24, 37], 6, false);
    bench.succeed("textons a.sample -o a.textons.npz --textons 40 --images 4 --levels 3");
    bench.succeed("gram a.textons.npz -o a.space.npz");
    bench.succeed("knn a.space.npz -o a.knn.npz --k 5 --neighborhood 5");
    let vocabulary = Vocabulary::read(&bench.path("a.textons.npz")).unwrap();
    let sides: Vec<_> = vocabulary
        .levels
        .iter()
        .map(|l| (l.grid.height, l.grid.width))
        .collect();
    assert_eq!(sides, [(37, 24), (19, 12), (10, 6)]);
    let textons: Vec<_> = vocabulary.levels.iter().map(|l| l.counts.len()).collect();
    assert_eq!(textons, [40, 10, 3]);
    assert_eq!(vocabulary.representatives.len(), 4);
    assert!(vocabulary.representatives.is_sorted());
    for level in &vocabulary.levels {
        assert_eq!(level.centroids.ncols(), 4 * 3 * 48);
        for (texton, &count) in level.counts.iter().enumerate() {
            let members = level
                .labels
                .iter()
                .filter(|&&l| usize::from(l) == texton)
                .count();
            assert_eq!(members as u32, count);
        }
    }
    let space = Space::read(&bench.path("a.space.npz")).unwrap();
    assert_eq!(space.sample, vocabulary.sample);
    for (space, level) in space.levels.iter().zip(&vocabulary.levels) {
        let Features::Textons { labels, gram } = &space.features else {
            panic!("textons")
        };
        assert_eq!(labels, &level.labels);
        let exact = level.centroids.mapv(f64::from);
        let exact = exact.dot(&exact.t());
        for ((i, j), v) in exact.indexed_iter() {
            assert!((f64::from(gram[[i, j]]) - v).abs() <= 1e-5 * v.abs());
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_at_any_thread_count() {
    let bench = Bench::new([32, 16], 12, true);
    let line = "textons a.sample --textons 30 --images 5 --levels 2 --seed 4";
    for threads in [1, 2, 8] {
        bench.succeed(&format!("{line} --threads {threads} -o {threads}.npz"));
    }
    let one = std::fs::read(bench.path("1.npz")).unwrap();
    assert_eq!(one, std::fs::read(bench.path("2.npz")).unwrap());
    assert_eq!(one, std::fs::read(bench.path("8.npz")).unwrap());
    bench.succeed("textons a.sample --textons 30 --images 5 --levels 2 --seed 5 -o other.npz");
    assert_ne!(one, std::fs::read(bench.path("other.npz")).unwrap());
}

#[test]
fn report_and_pictures_are_written() {
    let bench = Bench::new([16, 16], 4, true);
    bench.succeed(
        "textons a.sample -o a.npz --textons 9 --levels 2 --report r.json --montage m.png --label-map l.png",
    );
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(bench.path("r.json")).unwrap()).unwrap();
    assert_eq!(report["levels"][0]["route"], "gram");
    assert_eq!(
        report["levels"][0]["cluster_sizes"]
            .as_array()
            .unwrap()
            .len(),
        9
    );
    assert_eq!(report["times_read"], 2);
    assert!(report["stages"].as_array().unwrap().len() > 4);
    for picture in ["m.png", "l.png"] {
        assert!(image::open(bench.path(picture)).is_ok());
    }
}

#[test]
fn impossible_requests_are_refused_with_their_reason() {
    let bench = Bench::new([12, 12], 4, true);
    for (options, says) in [
        ("--levels 4", "divisible by 8"),
        ("--levels 1 --images 5", "at most 4"),
        ("--levels 1 --textons 145", "at most 144"),
        ("--levels 1 --textons 65535", "1 to 65534"),
        ("--levels 1 --textons 4 --memory 1MiB", "at least"),
    ] {
        let error = bench.refuse(&format!("textons a.sample -o a.npz {options}"), 2);
        assert!(error.contains(says), "{options}: {error}");
        assert!(!bench.path("a.npz").exists());
    }
    bench.refuse("textons a.sample -o a.sample", 2);
    bench.refuse("textons none.sample -o a.npz", 1);
}

#[test]
fn radiance_that_is_no_number_is_refused_by_place() {
    let bench = Bench::new([8, 8], 2, true);
    let path = bench.path("a.sample").join("radiance.npy");
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes.len() - 4 * (3 * 64 - 3 * 9);
    bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    let error = bench.refuse("textons a.sample -o a.npz --levels 1 --textons 4", 1);
    assert!(
        error.contains("light 1, row 1, column 1") && error.contains("NaN"),
        "{error}"
    );
}

#[test]
fn constant_images_have_one_texton() {
    let folder = tempfile::tempdir().unwrap();
    let bench = Bench { folder };
    write_sample(&bench.path("a.sample"), [8, 8], 1, true);
    let path = bench.path("a.sample").join("radiance.npy");
    let mut bytes = std::fs::read(&path).unwrap();
    let from = bytes.len() - 4 * 3 * 64;
    for value in bytes[from..].chunks_mut(4) {
        value.copy_from_slice(&0.25_f32.to_le_bytes());
    }
    std::fs::write(&path, bytes).unwrap();
    let error = bench.refuse("textons a.sample -o a.npz --levels 1 --textons 4", 2);
    assert!(error.contains("only 1 distinct texels"), "{error}");
    bench.succeed("textons a.sample -o a.npz --levels 1 --textons 1");
    let vocabulary = Vocabulary::read(&bench.path("a.npz")).unwrap();
    assert_eq!(vocabulary.levels[0].inertia, 0.0);
    assert!(vocabulary.levels[0].centroids.iter().all(|&v| v == 0.0));
}

#[test]
fn a_broken_vocabulary_is_refused() {
    let bench = Bench::new([8, 8], 2, true);
    bench.succeed("textons a.sample -o a.npz --levels 1 --textons 4");
    let bytes = std::fs::read(bench.path("a.npz")).unwrap();
    std::fs::write(bench.path("cut.npz"), &bytes[..bytes.len() / 2]).unwrap();
    assert!(bench.refuse("gram cut.npz -o b.npz", 1).contains("cut.npz"));
    bench.succeed("gram a.npz -o a.space.npz");
    assert!(
        bench
            .refuse("gram a.space.npz -o b.npz", 1)
            .contains("a.space.npz")
    );
    assert!(!bench.path("b.npz").exists());
}
