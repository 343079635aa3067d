//! Imports that several runs share: however many shards, the same bytes as one run; parts are kept when they are whole,
//! and what does not belong together is refused by name.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod image_set_files;
mod program;
mod shard_parts;

use std::fmt::Write;
use std::fs;
use std::path::Path;

use image::{Rgb, RgbImage};
use image_set_files::{bitmap, compressed, spectral, zip};
use program::files;
use serde_json::Value;
use shard_parts::{
    make_parts, refused, refuses_damaged_part, refuses_other_shards, refuses_second_run,
    refuses_what_is_no_part, run, tear,
};
use tempfile::TempDir;

/// A picture of 8 × 6 pixels that no other has, with a hot pixel.
fn picture(path: &Path, number: u32) {
    let pixel = |x: u32, y: u32| match (x, y) {
        (5, 3) => Rgb([255; 3]),
        _ => Rgb([(7 * x + 3 * y + number) as u8, (11 * y + number) as u8, 40]),
    };
    RgbImage::from_fn(8, 6, pixel).save(path).unwrap();
}

/// A table of 3 views with 4 lights each, `angles.csv`, and the same without three of them, `some.csv`.
fn table(folder: &Path) {
    let head = "file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\n";
    let (mut all, mut some) = (head.to_owned(), head.to_owned());
    for image in 0..12 {
        picture(&folder.join(format!("{image}.png")), 9 * image);
        let (view, light) = (20 * (image % 3), 90 * (image / 3));
        let line = format!("{image}.png,{view},0,30,{light}\n");
        all += &line;
        if ![2, 5, 9].contains(&image) {
            some += &line;
        }
    }
    fs::write(folder.join("angles.csv"), all).unwrap();
    fs::write(folder.join("some.csv"), some).unwrap();
}

/// 3 views × 4 lights in UTIA's names: a folder, an archive of all, and two archives of some each.
fn set(folder: &Path) {
    let unpacked = folder.join("set");
    fs::create_dir(&unpacked).unwrap();
    for (view, light) in (0..3).flat_map(|view| (0..4).map(move |light| (view, light))) {
        let name = format!("tl030_pl{:03}_tv{:03}_pv000.png", 90 * light, 20 * view);
        picture(&unpacked.join(name), 20 * view + 5 * light);
    }
    let all = files(&unpacked);
    let (mut even, mut odd) = (all.clone(), all.clone());
    for (at, name) in all.keys().enumerate() {
        match at % 2 {
            0 => odd.remove(name),
            _ => even.remove(name),
        };
    }
    zip(&folder.join("all.zip"), &all, true);
    zip(&folder.join("even.zip"), &even, false);
    zip(&folder.join("odd.zip"), &odd, true);
}

/// Compares the sample of parts with that of one run.
fn compare(folder: &Path, line: &str) {
    run(folder, &format!("import {line} -o whole.sample"));
    let whole = files(&folder.join("whole.sample"));
    for count in [1, 2, 3, 7] {
        let parts = make_parts(folder, &format!("import {line}"), count, "");
        run(folder, &format!("import --reduce {parts} -o joined.sample"));
        assert!(
            whole == files(&folder.join("joined.sample")),
            "{line}: {count} shards"
        );
    }
}

#[test]
fn images_of_parts_are_those_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    table(folder);
    for line in [
        "angles.csv",
        "angles.csv --crop 6x4+1+2 --downsample 2 --dtype f4 --texel-mm 0.1 --tileable",
        "angles.csv --hot-pixels --keep-views 0,2 --values no-cosine",
        "angles.csv --grey-card 2x2+0+0:0.3",
        "some.csv",
        "some.csv --fill --name filled",
    ] {
        compare(folder, line);
    }
    let info = run(folder, "info p1of3");
    assert!(info.contains("shard 1/3"), "{info}");
}

#[test]
fn archives_are_imported_part_by_part() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    set(folder);
    compare(folder, "all.zip");
    let whole = files(&folder.join("whole.sample"));
    // The set in two archives is the same set, and so it is in a folder.
    compare(folder, "odd.zip even.zip --name all");
    assert!(whole == files(&folder.join("whole.sample")));
    run(folder, "import set --name all -o whole.sample");
    assert!(whole == files(&folder.join("whole.sample")));
    let named = run(folder, "import even.zip odd.zip -o named.sample --json");
    assert!(named.contains("\"images\": 12"), "{named}");
    // An archive of some images has gaps, and images that are there twice are named.
    let gaps = refused(folder, "import odd.zip -o x.sample", 1);
    assert!(gaps.contains("6 of 12 are missing"), "{gaps}");
    let twice = refused(folder, "import odd.zip all.zip -o x.sample", 1);
    assert!(twice.contains("6 faults"), "{twice}");
    fs::write(folder.join("a.csv"), "file\n").unwrap();
    let mixed = refused(folder, "import odd.zip a.csv -o x.sample", 1);
    assert!(
        mixed.contains("a.csv: source: one of several paths"),
        "{mixed}"
    );
}

#[test]
fn scattered_sets_of_columbia_are_shared() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let members = [1u8, 4, 60, 101, 150, 151, 190, 205].map(|number| {
        let image = bitmap(4, 3, number);
        let name = format!("02-{number:03}.bmp.Z");
        (name.into(), compressed(&image))
    });
    zip(&folder.join("felt.zip"), &members.into(), false);
    compare(folder, "felt.zip --directions curet");
}

/// A patch of 80 × 60 mm under 40 lamps 300 mm away.
fn lamps(folder: &Path) {
    let mut table =
        String::from("file,view_theta_deg,view_phi_deg,light_x_mm,light_y_mm,light_z_mm\n");
    for lamp in 0..40u32 {
        let cosine = 1.0 - 0.7 * (f64::from(lamp) + 0.5) / 40.0;
        let (y, x) = (2.4 * f64::from(lamp)).sin_cos();
        let radius = 300.0 * (1.0 - cosine * cosine).sqrt();
        let [x, y, z] = [radius * x, radius * y, 300.0 * cosine];
        let _ = writeln!(table, "{lamp}.png,0,0,{x},{y},{z}");
        picture(&folder.join(format!("{lamp}.png")), lamp);
    }
    fs::write(folder.join("lamps.csv"), table).unwrap();
}

#[test]
fn photographs_and_near_lamps_are_shared() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    lamps(folder);
    compare(folder, "lamps.csv --patch-mm 80x60 --near-field");
    let mut corners = String::from("file,x1,y1,x2,y2,x3,y3,x4,y4\n");
    for lamp in 0..40 {
        let _ = writeln!(corners, "{lamp}.png,1,1,7,0.5,7.5,5,1,5.5");
    }
    fs::write(folder.join("corners.csv"), corners).unwrap();
    compare(folder, "lamps.csv --corners corners.csv --size 5x4");
}

/// A sample of 5 views × 6 lights, as arrays and files that hold no images of their own.
fn baked(folder: &Path) {
    run(
        folder,
        "bake --preset weave --size 16 --samples 1 --views fibonacci:5 --lights fibonacci:6 -o a.sample",
    );
    fs::copy(folder.join("a.sample/radiance.npy"), folder.join("a.npy")).unwrap();
}

#[test]
fn arrays_fits_and_bonn_files_are_shared() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    baked(folder);
    compare(
        folder,
        "a.npy --views fibonacci:5 --lights fibonacci:6 --values radiance",
    );
    run(
        folder,
        "bake --preset weave --size 16 --samples 1 --views rings:0:1 --lights fibonacci:12 -o one.sample",
    );
    run(folder, "export one.sample --to ptm -o one.ptm");
    compare(folder, "one.ptm --lights fibonacci:9");
    for format in ["dfmf --rank 5", "pvf --rank 4", "bdi"] {
        let name = &format[..format.find(' ').unwrap_or(format.len())];
        run(
            folder,
            &format!("export a.sample --to {format} -o {name}.btf"),
        );
    }
    for line in ["dfmf.btf --expand", "pvf.btf --crop 5x4+3+2", "bdi.btf"] {
        compare(folder, line);
    }
    // Factors are one piece.
    let error = refused(folder, "import dfmf.btf --shard 0/2 -o p", 2);
    assert!(
        error.contains("--shard: 0/2 of a file of factors") && error.contains("--expand"),
        "{error}"
    );
}

#[test]
fn a_part_that_is_whole_is_kept_and_any_other_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    table(folder);
    let line = "import angles.csv --hot-pixels --shard 1/3 -o part";
    run(folder, line);
    let made = files(&folder.join("part"));
    let kept = run(folder, line);
    assert!(
        kept.contains("part is there already: shard 1/3") && !kept.contains("wrote"),
        "{kept}"
    );
    // Other options, another shard, another version of an image.
    for other in [
        line.replace("--hot-pixels", "--hot-pixels 9"),
        line.replace("1/3", "2/3"),
        line.replace("--hot-pixels", "--alpha ignore"),
    ] {
        assert!(run(folder, &other).contains("wrote part"), "{other}");
        assert!(run(folder, line).contains("wrote part"));
        assert_eq!(files(&folder.join("part")), made);
    }
    picture(&folder.join("4.png"), 77);
    assert!(run(folder, line).contains("wrote part"));
    assert_ne!(files(&folder.join("part")), made);
    picture(&folder.join("4.png"), 36);
    assert!(run(folder, line).contains("wrote part"));
    // Damaged values are found by their hash.
    let array = folder.join("part/radiance.npy");
    let mut damaged = fs::read(&array).unwrap();
    *damaged.last_mut().unwrap() ^= 1;
    fs::write(&array, damaged).unwrap();
    assert!(run(folder, line).contains("wrote part"));
    assert_eq!(files(&folder.join("part")), made);
    // A folder of the user is not replaced.
    fs::create_dir(folder.join("letters")).unwrap();
    fs::write(folder.join("letters/one.txt"), "dear").unwrap();
    let refusal = refused(folder, &line.replace("-o part", "-o letters"), 2);
    assert!(refusal.contains("one.txt"), "{refusal}");
}

#[test]
fn an_interrupted_part_is_continued() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    lamps(folder);
    table_of_all_kinds(folder);
    for line in [
        "angles.csv",
        "some.csv --fill",
        "lamps.csv --patch-mm 80x60 --near-field",
        "a.npy --views fibonacci:5 --lights fibonacci:6 --values radiance",
        "dfmf.btf --expand",
    ] {
        let line = format!("import {line} --shard 1/2 -o part --json");
        let first: Value = serde_json::from_str(&run(folder, &line)).unwrap();
        assert_eq!(
            (&first["resumed"], &first["kept"]),
            (&Value::from(0), &Value::from(false))
        );
        let made = files(&folder.join("part"));
        tear(folder);
        let continued: Value = serde_json::from_str(&run(folder, &line)).unwrap();
        let resumed = continued["resumed"].as_u64().unwrap();
        assert!(resumed > 1 && resumed < 15, "{line}: {continued}");
        assert_eq!(files(&folder.join("part")), made, "{line}");
        assert!(!folder.join(".part.partial").exists());
        // Of another shard nothing is taken.
        tear(folder);
        let other = line.replace("1/2", "0/2");
        let other: Value = serde_json::from_str(&run(folder, &other)).unwrap();
        assert_eq!(other["resumed"], 0);
        fs::remove_dir_all(folder.join("part")).unwrap();
    }
}

fn table_of_all_kinds(folder: &Path) {
    baked(folder);
    run(folder, "export a.sample --to dfmf --rank 5 -o dfmf.btf");
    table(folder);
}

#[test]
fn what_cannot_be_imported_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    table(folder);
    let line = "import angles.csv --shard 1/2 -o part";
    fs::write(folder.join("10.png"), "no image").unwrap();
    picture(&folder.join("8.png"), 1);
    RgbImage::new(3, 3).save(folder.join("8.png")).unwrap();
    let error = refused(folder, line, 1);
    assert!(
        error.contains("2 faults") && error.contains("10.png") && error.contains("8.png: size"),
        "{error}"
    );
    assert!(!folder.join("part").exists() && !folder.join(".part.partial").exists());
    // The other half does not need these images.
    run(folder, &line.replace("1/2", "0/2"));
}

#[test]
fn parts_that_do_not_belong_together_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    table(folder);
    set(folder);
    let part = |line: &str, output: &str| {
        run(folder, &format!("import {line} -o {output}"));
    };
    part("angles.csv --shard 0/2", "a0");
    part("angles.csv --shard 1/2", "a1");
    part("angles.csv --shard 1/2 --alpha ignore --crop 8x6+0+0", "b1");
    part("angles.csv --shard 1/2 --dtype f4", "d1");
    part("angles.csv --shard 2/3", "c2");
    part("all.zip --name angles --shard 1/2", "s1");
    part("angles.csv", "whole.sample");
    let joined = |parts: &str, code: i32| {
        refused(
            folder,
            &format!("import --reduce {parts} -o x.sample"),
            code,
        )
    };
    let others = joined("a0 b1 d1 s1", 1);
    for says in [
        "b1 has alpha \"ignore\", not \"refuse\", crop \"8x6+0+0\", not null",
        "d1 has dtype \"f4\", not \"f2\"",
        "kind \"utia\", not \"images with angles\"",
        "as a0",
    ] {
        assert!(others.contains(says), "{says}: {others}");
    }
    refuses_other_shards("", joined);
    refuses_what_is_no_part("import", joined);
    // Parts of a bake.
    let bake = "bake --preset weave --size 16 --samples 1 --views fibonacci:2 --lights fibonacci:2";
    for shard in [0, 1] {
        run(folder, &format!("{bake} --shard {shard}/2 -o k{shard}"));
    }
    let baked = joined("k0 k1", 1);
    assert!(baked.contains("made by `mesotex bake`"), "{baked}");
    // Images of other content, of the same names and lengths.
    let other = tempfile::tempdir().unwrap();
    for name in (0..12).map(|image| format!("{image}.png")) {
        fs::copy(folder.join(&name), other.path().join(&name)).unwrap();
    }
    fs::copy(folder.join("angles.csv"), other.path().join("angles.csv")).unwrap();
    picture(&other.path().join("7.png"), 64);
    let path = other.path().join("angles.csv");
    part(&format!("{} --shard 1/2", path.display()), "o1");
    let images = joined("a0 o1", 1);
    assert!(images.contains("o1 has source \""), "{images}");
    refuses_damaged_part(folder, joined);
    assert!(!folder.join("x.sample").exists());
}

#[test]
fn shards_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    table(folder);
    let import = |options: &str| refused(folder, &format!("import angles.csv {options}"), 2);
    for (options, says) in [
        ("--shard 0/13 -o p", "at most 12 shards"),
        ("--shard 3/3 -o p", "not a shard i/n"),
        (
            "--shard 0/2 --reduce a -o p",
            "cannot be given with --reduce",
        ),
        ("--reduce 2 -o x.sample", "--downsample N"),
    ] {
        let error = import(options);
        assert!(error.contains(says), "{error}");
    }
    // An option that no image of any shard has use for.
    let unused = import("--illuminant a --shard 1/2 -o p");
    assert!(unused.contains("no image is spectral"), "{unused}");
    assert!(!folder.join("p").exists() && !folder.join(".p.partial").exists());
    // One that images of other shards have.
    let mixed = folder.join("mixed");
    fs::create_dir(&mixed).unwrap();
    for light in 0..3 {
        let name = format!("tl{:03}_pl000_tv000_pv000", 20 * light);
        match light {
            1 => spectral(&mixed.join(format!("{name}.exr")), |_| 0.5),
            _ => RgbImage::new(3, 2)
                .save(mixed.join(format!("{name}.png")))
                .unwrap(),
        }
    }
    for count in [2, 3] {
        let parts = make_parts(folder, "import mixed --illuminant a", count, "");
        run(folder, &format!("import --reduce {parts} -o joined.sample"));
    }
    run(folder, "import mixed --illuminant a -o whole.sample");
    assert!(files(&folder.join("whole.sample")) == files(&folder.join("joined.sample")));
}

#[test]
fn a_second_run_of_a_shard_is_refused_while_the_first_is_at_it() {
    let folder: TempDir = tempfile::tempdir().unwrap();
    let folder = folder.path();
    table(folder);
    refuses_second_run(folder, "import angles.csv --shard 0/2 -o part", "part");
}
