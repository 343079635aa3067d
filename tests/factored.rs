//! Factored samples as a user meets them: `factor`, and every later command on what it wrote.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mesotex::btf::factored::{FactoredWriter, Factorization};
use mesotex::btf::{Description, Direction, Layout, Sample, SampleWriter};
use mesotex::exemplar::{Features, Space};
use mesotex::texton::Vocabulary;
use serde_json::Value;
use tempfile::TempDir;

const SIDE: u32 = 32;
const TEXELS: usize = (SIDE * SIDE) as usize;
const IMAGES: usize = 40;

struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
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

    fn succeed(&self, line: &str) -> Value {
        let output = self.run(&format!("{line} --json"));
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}: {errors}");
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn refuse(&self, line: &str, code: i32, says: &str) {
        let output = self.run(line);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{line}: {errors}");
        assert!(errors.contains(says), "{line}: {errors}");
    }
}

/// 5 views × 8 lights of a tileable patch.
fn description(layout: Layout) -> Description {
    let ring = |count: usize, theta: f64| {
        let directions = (0..count).map(|i| Direction::from_angles(theta, i as f64));
        directions.collect()
    };
    Description {
        layout,
        tileable: true,
        ..Description::product("waves", [SIDE, SIDE], ring(5, 0.4), ring(8, 0.7))
    }
}

/// A number from 0 to 1 that nothing foretells.
fn noise(seed: usize) -> f32 {
    (seed.wrapping_mul(2_654_435_761) % 65_521) as f32 / 65_521.0
}

/// A factored sample all whose products are positive.
fn write_factored(path: &Path, factors: Factorization) {
    let rank = factors.rank as usize;
    let mut writer = FactoredWriter::create(path, description(Layout::Factored(factors))).unwrap();
    for channel in 0..3 {
        let direction = |at| 0.1 + noise(at + 977 * channel);
        let rows: Vec<f32> = (0..IMAGES * rank).map(direction).collect();
        writer.push_directions(&rows).unwrap();
    }
    for set in 0..factors.sets() {
        let bump = |at: usize| {
            let (texel, factor) = (at / rank, at % rank);
            let (row, col) = (texel / SIDE as usize, texel % SIDE as usize);
            let wave = (row * (factor + 1) + 3 * col * (set + 1)) as f32;
            0.05 * (1.5 + (wave * std::f32::consts::TAU / SIDE as f32).sin()) + 0.02 * noise(at)
        };
        let rows: Vec<f32> = (0..TEXELS * rank).map(bump).collect();
        writer.push_eigentextures(&rows).unwrap();
    }
    writer.finish().unwrap();
}

/// The same images, stored whole.
fn expand(from: &Path, to: &Path) {
    let sample = Sample::open(from).unwrap();
    let whole = sample.description().clone().with_whole_images();
    let mut writer = SampleWriter::create(to, whole).unwrap();
    let mut values = vec![0.0; 3 * TEXELS];
    for image in 0..sample.image_count() {
        sample.image(image).unwrap().copy_to(&mut values);
        writer.push(&values).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn a_sample_is_factored_and_its_error_reported() {
    let bench = Bench::new();
    write_factored(&bench.path("a.sample"), Factorization::of_rank(12));
    expand(&bench.path("a.sample"), &bench.path("whole.sample"));
    let report = bench.succeed("factor whole.sample --rank 6 -o six.sample");
    let relative = report["relative_error"].as_f64().unwrap();
    assert!(relative > 1e-4 && relative < 0.2, "{relative}");
    assert!(report["worst_image"]["error"].as_f64().unwrap() >= relative);
    assert!(report["worst_texel"]["error"].as_f64().unwrap() >= relative);
    let info = bench.succeed("info six.sample");
    assert_eq!(info["rank"], 6);
    assert_eq!(info["id"], report["id"]);
    assert!(info["bytes_on_disk"].as_u64() < info["bytes_of_whole_images"].as_u64());
    assert_eq!(
        info["source"]["error"]["relative"],
        report["relative_error"]
    );
    // The rank that was put in is found, and nothing is left but rounding.
    let report = bench.succeed("factor whole.sample --error 0.0001 -o exact.sample");
    assert!(report["rank"].as_u64().unwrap() <= 12);
    // A factored sample is factored like any other.
    let again = bench.succeed("factor exact.sample --rank 6 -o again.sample");
    let again = again["relative_error"].as_f64().unwrap();
    assert!(
        (again - relative).abs() < 0.01 * relative,
        "{again} against {relative}"
    );
}

#[test]
fn bytes_do_not_depend_on_threads_and_replace_only_samples() {
    let bench = Bench::new();
    write_factored(&bench.path("a.sample"), Factorization::of_rank(12));
    for threads in [1, 2] {
        let line = format!("factor a.sample --rank 5 -o {threads}.sample --threads {threads}");
        bench.succeed(&line);
        bench.succeed(&line);
    }
    for name in ["btf.json", "directions.npy", "eigentextures.npy"] {
        let read = |sample: &str| fs::read(bench.path(sample).join(name)).unwrap();
        assert_eq!(read("1.sample"), read("2.sample"), "{name}");
    }
    fs::write(bench.path("1.sample/notes.txt"), "mine").unwrap();
    bench.refuse("factor a.sample --rank 5 -o 1.sample", 2, "notes.txt");
}

#[test]
fn options_that_cannot_be_met_are_refused() {
    let bench = Bench::new();
    write_factored(&bench.path("a.sample"), Factorization::of_rank(12));
    bench.refuse("factor a.sample -o b.sample", 2, "--rank");
    bench.refuse(
        "factor a.sample --rank 3 --error 0.1 -o b.sample",
        2,
        "--error",
    );
    bench.refuse("factor a.sample --rank 0 -o b.sample", 2, "1 to 40");
    bench.refuse("factor a.sample --rank 41 -o b.sample", 2, "1 to 40");
    bench.refuse("factor a.sample --error 1.5 -o b.sample", 2, "--error");
    bench.refuse(
        "factor missing.sample --rank 3 -o b.sample",
        1,
        "missing.sample",
    );
    assert!(!bench.path("b.sample").exists());
}

/// The labels and dot products of every level, from the chain of commands.
fn analyzed(bench: &Bench, name: &str, options: &str) -> (Vocabulary, Space) {
    bench.succeed(&format!(
        "textons {name}.sample -o {name}.textons.npz --textons 24 --images all {options}"
    ));
    bench.succeed(&format!("gram {name}.textons.npz -o {name}.space.npz"));
    bench.succeed(&format!(
        "knn {name}.space.npz -o {name}.knn.npz --k 3 --neighborhood 3"
    ));
    let vocabulary = Vocabulary::read(&bench.path(&format!("{name}.textons.npz"))).unwrap();
    let space = Space::read(&bench.path(&format!("{name}.space.npz"))).unwrap();
    (vocabulary, space)
}

#[test]
fn factors_and_whole_images_give_the_same_texton_map() {
    let bench = Bench::new();
    let rank = Factorization::of_rank(6);
    let colored = Factorization {
        color_transform: [0.9, 0.2, 0.1, 0.1, 0.8, 0.3, 0.2, 0.1, 0.7],
        color_mean: [0.1, 0.0, 0.05],
        ..rank
    };
    let shared = Factorization {
        shared_eigentextures: true,
        ..rank
    };
    for (factors, options) in [
        (rank, "--levels 2"),
        (colored, "--levels 2 --no-tile"),
        (shared, "--levels 1 --luminance"),
        // Too little memory for dot products of all texels.
        (rank, "--levels 1 --memory 188MiB"),
    ] {
        write_factored(&bench.path("a.sample"), factors);
        expand(&bench.path("a.sample"), &bench.path("b.sample"));
        let (factored, factored_space) = analyzed(&bench, "a", options);
        let (whole, whole_space) = analyzed(&bench, "b", options);
        let basis = factored.factor_basis.as_ref().unwrap();
        assert_eq!((basis.rank, basis.sets as usize), (6, factors.sets()));
        assert_eq!(whole.factor_basis, None);
        for (a, b) in factored.levels.iter().zip(&whole.levels) {
            assert_eq!(a.centroids.ncols(), 6 * factors.sets() * 48);
            assert_eq!(a.labels, b.labels, "{options}");
        }
        for (a, b) in factored_space.levels.iter().zip(&whole_space.levels) {
            let (Features::Textons { gram: a, .. }, Features::Textons { gram: b, .. }) =
                (&a.features, &b.features)
            else {
                panic!("both are of textons");
            };
            let largest = b.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-5 * largest, "{a} against {b}");
            }
        }
    }
}

/// Appearance vectors are A B times a centroid.
#[test]
fn the_factor_basis_leads_back_to_appearance_vectors() {
    let bench = Bench::new();
    write_factored(&bench.path("a.sample"), Factorization::of_rank(6));
    expand(&bench.path("a.sample"), &bench.path("b.sample"));
    let (factored, _) = analyzed(&bench, "a", "--levels 1");
    let (whole, _) = analyzed(&bench, "b", "--levels 1");
    let sample = Sample::open(&bench.path("a.sample")).unwrap();
    let basis = &factored.factor_basis.as_ref().unwrap().matrix;
    let (stored, wanted) = (&factored.levels[0].centroids, &whole.levels[0].centroids);
    let largest = wanted.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
    for (texton, image, channel, filter) in [(0, 0, 0, 0), (7, 13, 1, 20), (23, 39, 2, 47)] {
        let numbers = sample.factors().unwrap().direction(channel, image);
        let mut found = 0.0;
        for (k, number) in numbers.iter().enumerate() {
            for j in 0..basis.ncols() {
                found += number * basis[[channel * 6 + k, j]] * stored[[texton, j * 48 + filter]];
            }
        }
        let wanted = wanted[[texton, (image * 3 + channel) * 48 + filter]];
        assert!(
            (found - wanted).abs() < 1e-4 * largest,
            "{found} against {wanted}"
        );
    }
}

#[test]
fn few_images_are_taken_as_images() {
    let bench = Bench::new();
    write_factored(&bench.path("a.sample"), Factorization::of_rank(12));
    bench.succeed("textons a.sample -o a.textons.npz --textons 10 --images 5 --levels 1");
    let few = Vocabulary::read(&bench.path("a.textons.npz")).unwrap();
    assert_eq!(few.factor_basis, None);
    assert_eq!(few.levels[0].centroids.ncols(), 5 * 3 * 48);
    // Of a factored sample all images are the default.
    bench.succeed("textons a.sample -o a.textons.npz --textons 10 --levels 1");
    let all = Vocabulary::read(&bench.path("a.textons.npz")).unwrap();
    assert_eq!(all.representatives.len(), IMAGES);
    let info = bench.succeed("info a.textons.npz");
    assert_eq!(info["rank"], 12);
}

#[test]
fn frames_are_those_of_the_whole_sample() {
    let bench = Bench::new();
    write_factored(&bench.path("a.sample"), Factorization::of_rank(6));
    expand(&bench.path("a.sample"), &bench.path("b.sample"));
    let (factored, _) = analyzed(&bench, "a", "--levels 2");
    assert_eq!(factored.levels.len(), 2);
    bench.succeed(
        "synth a.space.npz a.knn.npz --grid 24x20 -o a.map.ply --k 3 --neighborhood 3 --levels 2",
    );
    let frame = |sample: &str, threads: u32| {
        bench.succeed(&format!(
            "render {sample}.sample a.map.ply -o {sample}.frames --size 40x30 --force --threads {threads}"
        ));
        let exr = bench.path(&format!("{sample}.frames/frame.0001.exr"));
        let image = exr::prelude::read_first_rgba_layer_from_file(
            exr,
            |size, _| vec![[0.0_f32; 4]; size.area()],
            |pixels: &mut Vec<[f32; 4]>, at, (r, g, b, a): (f32, f32, f32, f32)| {
                pixels[at.y() * 40 + at.x()] = [r, g, b, a];
            },
        );
        image.unwrap().layer_data.channel_data.pixels
    };
    let whole = frame("b", 1);
    assert!(whole.iter().any(|pixel| pixel[0] > 0.0));
    assert_eq!(frame("a", 1), whole);
    assert_eq!(frame("a", 2), whole);
}

#[test]
fn other_commands_read_factored_samples() {
    let bench = Bench::new();
    let dim = Factorization {
        color_mean: [-0.2, -0.3, -0.1],
        ..Factorization::of_rank(4)
    };
    write_factored(&bench.path("a.sample"), dim);
    let info = bench.succeed("info a.sample");
    assert!(info["negative_share"].as_f64().unwrap() > 0.0);
    assert!(info["most_negative"].as_f64().unwrap() < 0.0);
    assert_eq!(info["least"], 0.0);
    // A factor changed behind the id's back.
    let path = bench.path("a.sample/directions.npy");
    let mut bytes = fs::read(&path).unwrap();
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&0.5_f32.to_le_bytes());
    fs::write(&path, &bytes).unwrap();
    bench.refuse("info a.sample", 1, "id of the arrays");
    bytes[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(&path, &bytes).unwrap();
    for command in [
        "info a.sample",
        "textons a.sample -o a.textons.npz",
        "factor a.sample --rank 2 -o b.sample",
    ] {
        bench.refuse(command, 1, "[2, 39, 3]: NaN");
    }
}
