//! `mesotex textons` and `gram` as a user runs them: the files' contract, the same bytes at any
//! thread count, and what is refused.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mesotex::btf::{Description, Direction, Sample, SampleWriter};
use mesotex::exemplar::{Features, Space};
use mesotex::texton::Vocabulary;
use ndarray::Array2;
use tempfile::TempDir;

/// Bumps lit from a few sides: `images` images of `width` × `height` texels.
fn write_sample(path: &Path, [width, height]: [u32; 2], images: usize, tileable: bool) {
    let lights: Vec<Direction> = (0..images)
        .map(|i| Direction::from_angles(0.2 + 0.9 * i as f64 / images as f64, i as f64 * 2.4))
        .collect();
    let description = Description {
        tileable,
        ..Description::product(
            "bumps",
            [width, height],
            vec![Direction::from_angles(0.0, 0.0)],
            lights.clone(),
        )
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
fn a_sample_that_does_not_tile_passes_the_whole_chain() {
    let bench = Bench::new([75, 48], 6, false);
    bench.succeed("textons a.sample -o a.textons.npz --textons 40 --images 4 --levels 3");
    bench.succeed("gram a.textons.npz -o a.space.npz");
    bench.succeed("knn a.space.npz -o a.knn.npz --k 5 --neighborhood 5");
    bench.succeed(
        "synth a.space.npz a.knn.npz --grid 20x12 -o a.map.ply --k 5 --neighborhood 5 --levels 2",
    );
    bench.succeed("render a.sample a.map.ply -o frames --size 32x24 --frames 1");
    assert!(bench.path("frames/frame.0001.exr").exists());
    let vocabulary = Vocabulary::read(&bench.path("a.textons.npz")).unwrap();
    let sides: Vec<_> = vocabulary
        .levels
        .iter()
        .map(|l| (l.grid.height, l.grid.width))
        .collect();
    assert_eq!(sides, [(48, 75), (24, 38), (12, 19)]);
    let textons: Vec<_> = vocabulary.levels.iter().map(|l| l.counts.len()).collect();
    assert_eq!(textons, [40, 40, 40]);
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

/// The plane's value at a row and column, off the grid too.
fn beyond_the_border(
    plane: &[f32],
    [width, height]: [i64; 2],
    tileable: bool,
    row: i64,
    column: i64,
) -> f64 {
    let fold = |at: i64, side: i64| {
        if tileable {
            return at.rem_euclid(side);
        }
        let at = at.rem_euclid(2 * side);
        at.min(2 * side - 1 - at)
    };
    f64::from(plane[(fold(row, height) * width + fold(column, width)) as usize])
}

/// Appearance vectors by the definition of convolution, [texels, planes · 48].
fn appearance_vectors(sample: &Sample, vocabulary: &Vocabulary) -> Array2<f64> {
    let grid = sample.grid();
    let sides = [i64::from(grid.width), i64::from(grid.height)];
    let filters = vocabulary.filters.mapv(f64::from);
    let mut vectors = Array2::zeros((grid.len(), vocabulary.representatives.len() * 3 * 48));
    for (at, &image) in vocabulary.representatives.iter().enumerate() {
        let mut numbers = vec![0.0; 3 * grid.len()];
        sample.image(image as usize).unwrap().copy_to(&mut numbers);
        for channel in 0..3 {
            let plane: Vec<f32> = numbers.iter().skip(channel).step_by(3).copied().collect();
            for texel in 0..grid.len() as i64 {
                let (row, column) = (texel / sides[0], texel % sides[0]);
                let window = Array2::from_shape_fn((49, 49), |(u, v)| {
                    let (row, column) = (row + 24 - u as i64, column + 24 - v as i64);
                    beyond_the_border(&plane, sides, vocabulary.tileable, row, column)
                });
                for (filter, taps) in filters.outer_iter().enumerate() {
                    let component = (at * 3 + channel) * 48 + filter;
                    vectors[[texel as usize, component]] = (&taps * &window).sum();
                }
            }
        }
    }
    vectors
}

#[test]
fn centroids_are_their_members_means_and_labels_the_nearest_of_them() {
    for (tileable, options) in [(true, ""), (false, ""), (true, "--no-tile")] {
        let bench = Bench::new([12, 10], 5, tileable);
        bench.succeed(&format!(
            "textons a.sample -o a.npz --textons 12 --images 2 --levels 1 {options}"
        ));
        let sample = Sample::open(&bench.path("a.sample")).unwrap();
        let vocabulary = Vocabulary::read(&bench.path("a.npz")).unwrap();
        let level = &vocabulary.levels[0];
        let vectors = appearance_vectors(&sample, &vocabulary);
        let mut means = Array2::<f64>::zeros(level.centroids.raw_dim());
        for (vector, &label) in vectors.outer_iter().zip(&level.labels) {
            let count = f64::from(level.counts[usize::from(label)]);
            means.row_mut(label.into()).scaled_add(1.0 / count, &vector);
        }
        let scale = means
            .iter()
            .fold(0.0_f64, |largest, v| largest.max(v.abs()));
        for (stored, mean) in level.centroids.iter().zip(&means) {
            assert!((f64::from(*stored) - mean).abs() < 1e-6 * scale);
        }
        let mut inertia = 0.0;
        for (vector, &label) in vectors.outer_iter().zip(&level.labels) {
            let distances: Vec<f64> = means
                .outer_iter()
                .map(|mean| (&mean - &vector).mapv(|d| d * d).sum())
                .collect();
            let own = distances[usize::from(label)];
            let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(own <= least * (1.0 + 1e-5), "{own} against {least}");
            inertia += own;
        }
        assert!((level.inertia / inertia - 1.0).abs() < 1e-5);
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
    let output = bench.run("textons a.sample -o a.npz --levels 2 --textons 200");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("all texels of the sample are alike; taking one texton instead of 200"),
        "{said}"
    );
    let vocabulary = Vocabulary::read(&bench.path("a.npz")).unwrap();
    assert_eq!(vocabulary.levels[0].inertia, 0.0);
    for (level, texels) in vocabulary.levels.iter().zip([64, 16]) {
        assert_eq!(level.counts, [texels]);
        assert!(level.centroids.iter().all(|&v| v == 0.0));
    }
    bench.succeed("gram a.npz -o a.space.npz");
    bench.succeed("knn a.space.npz -o a.knn.npz --neighborhood 3");
    bench.succeed("synth a.space.npz a.knn.npz --grid 16x16 -o a.map.ply --report a.json");
    let report = std::fs::read_to_string(bench.path("a.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["histogram_chi2"], 0.0);
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
