//! `mesotex mask` and `mesotex vary` as a user runs them: what they write, and what is refused.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use image::{GrayImage, Luma, Rgb, RgbImage};
use mesotex::btf::Sample;
use mesotex::exemplar::{NeighborTable, Space};
use serde_json::Value;

/// Options that keep runs short.
const FEW: &str = "--levels 2 --k 3 --neighborhood 3";
const FILTER: &str = "--mask-window 5 --color-window 3 --filter-levels 2";

fn mesotex(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    command.args(line.split_whitespace()).current_dir(folder);
    command.output().unwrap()
}

fn done(folder: &Path, line: &str) -> Value {
    let output = mesotex(folder, &format!("{line} --json"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {said}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(folder: &Path, line: &str, code: i32) -> String {
    let before = fs::read_dir(folder).unwrap().count();
    let output = mesotex(folder, line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{line}: {said}");
    assert_eq!(fs::read_dir(folder).unwrap().count(), before, "{line}");
    said
}

/// `dots.png`, 24 × 24: red discs of radius 3 on grey, 8 pixels apart; `bars.png`, blue bars; `one.png` and
/// `small.png`, masks that will not do.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let shade = |x: u32, y: u32| 100 + (7 * x + 5 * y) as u8 % 9;
    let in_dot = |v: u32| f64::from(v % 8) - 3.5;
    let dots = |x: u32, y: u32| match in_dot(x).hypot(in_dot(y)) < 3.0 {
        true => Rgb([230, 20 + shade(x, y) % 9, 30]),
        false => Rgb([shade(x, y); 3]),
    };
    RgbImage::from_fn(24, 24, dots)
        .save(at("dots.png"))
        .unwrap();
    let bars = |x: u32, y: u32| match x % 8 < 4 {
        true => Rgb([20, 30, 200 + shade(x, y) % 9]),
        false => Rgb([shade(x, y); 3]),
    };
    RgbImage::from_fn(24, 24, bars)
        .save(at("bars.png"))
        .unwrap();
    GrayImage::from_pixel(24, 24, Luma([85]))
        .save(at("one.png"))
        .unwrap();
    GrayImage::from_fn(9, 9, |x, _| Luma([85 * (x as u8 % 2)]))
        .save(at("small.png"))
        .unwrap();
    done(
        folder.path(),
        "mask dots.png --pick 4,4:0.3 -o dots-mask.png",
    );
    done(
        folder.path(),
        "mask bars.png --pick 1,1:0.3 -o bars-mask.png",
    );
    folder
}

#[test]
fn masks_mark_what_has_the_colour() {
    let folder = folder();
    let here = folder.path();
    let report = done(
        here,
        "mask dots.png --pick #e61e1e:0.3 --edit erode:1 -o m.png --overlay o.png",
    );
    assert_eq!(report["features"].as_array().unwrap().len(), 9);
    assert_eq!(
        report["features"][0]["centre"],
        serde_json::json!([3.5, 3.5])
    );
    assert_eq!(image::open(here.join("o.png")).unwrap().width(), 24);
    // The mask can be read as a painted one, and comes back as it is.
    done(here, "mask dots.png --painted m.png -o again.png");
    assert_eq!(
        fs::read(here.join("m.png")).unwrap(),
        fs::read(here.join("again.png")).unwrap()
    );
    assert!(refused(here, "mask dots.png -o n.png", 2).contains("--pick: not given"));
    assert!(refused(here, "mask dots.png --pick 24,0 -o n.png", 2).contains("24×24"));
    assert!(refused(here, "mask dots.png --painted small.png -o n.png", 1).contains("9×9"));
}

fn space_and_table(folder: &Path, name: &str) -> (Space, NeighborTable) {
    let space = Space::read(&folder.join(format!("{name}.space.npz"))).unwrap();
    let table = NeighborTable::read(&folder.join(format!("{name}.knn.npz"))).unwrap();
    table.check_belongs_to(&space, false).unwrap();
    (space, table)
}

#[test]
fn a_warp_carries_its_controls_and_lists_only_the_band() {
    let folder = folder();
    let line = "vary warp dots.png --mask dots-mask.png --tile --size 48x24 --warp scale:by=0.4 --transition-tolerance 0.2";
    done(folder.path(), &format!("{line} {FEW} {FILTER} -o w"));
    let (space, table) = space_and_table(folder.path(), "w");
    let controls = &space.controls[0];
    let (mask, transition) = (
        controls.mask.as_ref().unwrap(),
        controls.transition.as_ref().unwrap(),
    );
    assert!((transition[[5, 0]], transition[[5, 47]]) == (0.0, 1.0));
    let marked = |cols: std::ops::Range<usize>| {
        mask.indexed_iter()
            .filter(|((_, col), label)| cols.contains(col) && **label == 1)
            .count()
    };
    assert!(
        3 * marked(40..48) < marked(0..8),
        "{} {}",
        marked(40..48),
        marked(0..8)
    );
    assert_eq!(controls.orientation.as_ref().unwrap()[[3, 3, 0]], 1.0);
    assert_eq!(table.transition_tolerance, Some(0.2));
    for (level, listed) in table.levels.iter().enumerate() {
        let transition = space.controls[level].transition.as_ref().unwrap();
        let of =
            |texel: usize| transition[[texel / transition.ncols(), texel % transition.ncols()]];
        for (texel, row) in listed.neighbors.rows().into_iter().enumerate() {
            assert!(
                row.iter()
                    .all(|&other| (of(texel) - of(other as usize)).abs() < 0.2)
            );
        }
    }
    // The texture follows the mask: red where it marks features.
    let made = image::open(folder.path().join("w.color.png"))
        .unwrap()
        .to_rgb8();
    let fits = mask.indexed_iter().filter(|((row, col), label)| {
        let red = made.get_pixel(*col as u32, *row as u32).0[0] > 180;
        red == (**label == 1)
    });
    assert!(fits.count() > 48 * 24 * 95 / 100);
    assert_eq!(
        Sample::open(&folder.path().join("w.sample"))
            .unwrap()
            .grid()
            .width,
        48
    );
}

#[test]
fn blends_begin_as_the_first_and_end_as_the_second() {
    let folder = folder();
    let here = folder.path();
    let line = "vary blend dots.png bars.png --masks dots-mask.png bars-mask.png --tile --size 48x24 --ramp-begin 0.3 --ramp-end 0.7";
    done(here, &format!("{line} {FEW} {FILTER} -o b"));
    let made = image::open(here.join("b.color.png")).unwrap().to_rgb8();
    let [dots, bars] =
        ["dots.png", "bars.png"].map(|name| image::open(here.join(name)).unwrap().to_rgb8());
    for row in 0..24 {
        for col in 0..8 {
            assert_eq!(
                made.get_pixel(col, row),
                dots.get_pixel(col, row),
                "{col} {row}"
            );
        }
    }
    let same = (0..24).flat_map(|row| (40..48).map(move |col| (col, row)));
    let same = same.filter(|&(col, row)| made.get_pixel(col, row) == bars.get_pixel(col % 24, row));
    assert!(same.count() > 8 * 24 * 3 / 4);
    // A mixture compares no masks.
    let without_masks = FILTER.replace("--mask-window 5 ", "");
    for (by, filter) in [("average", FILTER), ("mixture", &without_masks)] {
        done(here, &format!("{line} --by {by} {FEW} {filter} -o {by}"));
        assert!(space_and_table(here, by).0.controls[0].mask.is_some());
    }
    let said = refused(here, "vary blend dots.png bars.png -o n", 2);
    assert!(said.contains("--masks: not given"), "{said}");
    let said = refused(here, "vary blend dots.png small.png --by mixture -o n", 1);
    assert!(said.contains("9×9; expected 24×24"), "{said}");
}

#[test]
fn distortion_gives_the_same_bytes_at_one_and_two_threads() {
    let folder = folder();
    let line = "vary distort dots.png --mask dots-mask.png --tile --scale-to 0.6 --window 3 --distortion-levels 2 --orientation-key 3,3,0 --orientation-key 20,20,40";
    for threads in [1, 2] {
        done(
            folder.path(),
            &format!("{line} {FEW} --threads {threads} -o d{threads}"),
        );
    }
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("d1.space.npz"), read("d2.space.npz"));
    assert_eq!(read("d1.color.png"), read("d2.color.png"));
    let (space, _) = space_and_table(folder.path(), "d1");
    let orientation = space.controls[0].orientation.as_ref().unwrap();
    assert!((orientation[[3, 3, 0]] - 1.0).abs() < 1e-4);
    assert!((orientation[[20, 20, 1]] - 40_f32.to_radians().sin()).abs() < 1e-3);
}

#[test]
fn samples_are_blended_in_every_direction() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for preset in ["weave", "cobbles"] {
        let bake = "--size 16 --views fibonacci:3 --lights fibonacci:3 --samples 1";
        done(
            here,
            &format!("bake --preset {preset} {bake} -o {preset}.sample"),
        );
        let half = |x: u32, _| Luma([if x < 8 { 85 } else { 0 }]);
        GrayImage::from_fn(16, 16, half)
            .save(here.join(format!("{preset}.png")))
            .unwrap();
    }
    let line =
        "vary blend weave.sample cobbles.sample --masks weave.png cobbles.png --compare-images 1";
    done(here, &format!("{line} {FEW} {FILTER} -o b"));
    let [first, second, made] = ["weave", "cobbles", "b"]
        .map(|name| Sample::open(&here.join(format!("{name}.sample"))).unwrap());
    assert_eq!(made.description().views, first.description().views);
    for image in 0..9 {
        let [first, second, made] =
            [&first, &second, &made].map(|sample| sample.image(image).unwrap());
        for row in 0..16 {
            let ends = [(&first, 0), (&second, 15)];
            assert!(ends.iter().all(|(of, col)| {
                let at = 3 * (row * 16 + col);
                (0..16 * 16).any(|texel| of.get(3 * texel) == made.get(at))
            }));
        }
    }
    let line = "vary warp weave.sample --mask weave.png --warp erode:by=2 --ramp 90";
    done(here, &format!("{line} {FEW} {FILTER} -o w"));
    assert_eq!(space_and_table(here, "w").0.channels.list().len(), 3);
    done(
        here,
        "bake --preset weave --size 16 --views fibonacci:3 --lights fibonacci:4 --samples 1 -o other.sample",
    );
    let line = "vary blend weave.sample other.sample --masks weave.png weave.png -o n";
    assert!(refused(here, line, 1).contains("the set of the first"));
}

#[test]
fn what_cannot_be_varied_is_refused_and_writes_nothing() {
    let folder = folder();
    let said = |line: &str, code| refused(folder.path(), &format!("vary {line} -o n"), code);
    let warp = "warp dots.png --mask dots-mask.png --warp erode:by=1";
    assert!(
        said("warp dots.png --mask one.png --warp erode:by=1", 1)
            .contains("every pixel has label 1")
    );
    assert!(
        said("warp dots.png --mask small.png --warp erode:by=1", 1).contains("9×9; expected 24×24")
    );
    assert!(
        said("warp dots.png --mask dots-mask.png --warp shrink:by=1", 2).contains("scale, dilate")
    );
    assert!(said(&format!("{warp} --transition-key 1,1,0.5"), 2).contains("two or more"));
    let twice = "--transition-key 1,1,0.5 --transition-key 1,1,0.6";
    assert!(said(&format!("{warp} {twice}"), 2).contains("one value at a place"));
    let above = "--transition-key 1,1,0.5 --transition-key 2,1,1.6";
    assert!(said(&format!("{warp} {above}"), 2).contains("0 to 1"));
    let flat = "--transition-key 1,1,0.5 --transition-key 20,1,0.55";
    assert!(said(&format!("{warp} {flat}"), 1).contains("a range of 0.1 or more"));
    assert!(said(&format!("{warp} --size 4000000x4000000"), 2).contains("at most 4194304 pixels"));
    assert!(said(&format!("{warp} --ramp-begin 0.6 --ramp-end 0.5"), 2).contains("--ramp-begin"));
    assert!(said(&format!("{warp} --mask-window 4"), 2).contains("an odd width"));
    let none = "--warp erode:by=40 --transition one.png";
    assert!(said(&format!("warp dots.png --mask dots-mask.png {none}"), 1).contains("one.png"));
    assert!(said("distort dots.png --scale-to 0", 2).contains("0.1 to 8"));
    assert!(said("distort missing.png", 1).contains("missing.png"));
    let space = "exemplar dots.png -o plain --levels 2 --k 2 --neighborhood 3";
    done(folder.path(), space);
    let line = "knn plain.space.npz --transition-tolerance 0.1 -o n.knn.npz";
    assert!(refused(folder.path(), line, 1).contains("transition"));
    let line = "knn plain.space.npz --transition-tolerance 0 -o n.knn.npz";
    assert!(refused(folder.path(), line, 2).contains("above 0, at most 1"));
}
