//! Work shared by several runs: however many shards, the same bytes as one run; parts are kept when they are whole,
//! and what does not belong together is refused by name.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod program;
mod shard_parts;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use program::{files, mesotex};
use shard_parts::{
    make_parts, refused, refuses_damaged_part, refuses_other_shards, refuses_second_run,
    refuses_what_is_no_part, run, tear,
};
use tempfile::TempDir;

/// Sixty-four images of 16 × 16 texels, in eight blocks.
fn sample() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let bake = "bake --preset weave --size 16 --samples 1 --views fibonacci:8 --lights fibonacci:8 -o a.sample";
    run(folder.path(), bake);
    folder
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap()
}

#[test]
fn textons_of_parts_are_those_of_one_run() {
    let folder = sample();
    let folder = folder.path();
    for options in [
        "--textons 12 --levels 2 --images 20 --seed 5",
        "--textons 12 --levels 2 --images all --restarts 2",
        "--textons 12 --levels 2 --images all --luminance --no-tile",
    ] {
        run(
            folder,
            &format!("textons a.sample {options} -o whole.textons.npz"),
        );
        let whole = bytes(folder, "whole.textons.npz");
        for count in [1, 2, 3, 7] {
            let line = format!("textons a.sample {options}");
            let parts = make_parts(folder, &line, count, ".npz");
            let montage = "--montage m.png --report r.json --threads 1";
            run(
                folder,
                &format!("textons a.sample --reduce {parts} -o joined.textons.npz {montage}"),
            );
            let joined = bytes(folder, "joined.textons.npz");
            assert!(whole == joined, "{options}: {count} shards");
        }
    }
    assert!(folder.join("m.png").exists() && folder.join("r.json").exists());
    let leftovers = fs::read_dir(folder).unwrap();
    let hidden = leftovers.filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        name.to_string_lossy().starts_with('.')
    });
    assert_eq!(hidden.count(), 0);
}

#[test]
fn a_part_that_is_whole_is_kept_and_any_other_is_made_anew() {
    let folder = sample();
    let folder = folder.path();
    let line = "textons a.sample --textons 12 --levels 2 --images all --shard 1/3 -o p.npz";
    let first = run(folder, line);
    assert!(first.contains("wrote p.npz"), "{first}");
    let made = bytes(folder, "p.npz");
    let kept = run(folder, line);
    assert!(
        kept.contains("p.npz is there already: shard 1/3") && !kept.contains("wrote"),
        "{kept}"
    );
    // Another shard, other options, and damaged numbers are made anew.
    for other in ["--shard 1/3 --textons 13", "--shard 2/3"] {
        let other = line
            .replace("--shard 1/3", other)
            .replace("--textons 12 ", "");
        assert!(run(folder, &other).contains("wrote"), "{other}");
        assert_ne!(bytes(folder, "p.npz"), made);
        assert!(run(folder, line).contains("wrote"));
        assert_eq!(bytes(folder, "p.npz"), made);
    }
    let mut damaged = made.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    fs::write(folder.join("p.npz"), &damaged).unwrap();
    let joined = "textons a.sample --reduce p.npz -o x.textons.npz";
    assert!(refused(folder, joined, 2).contains("no part of shard 0/3, 2/3"));
    assert!(run(folder, line).contains("wrote"));
    assert_eq!(bytes(folder, "p.npz"), made);
    // What this program did not make is not replaced.
    fs::write(folder.join("p.npz"), "a letter").unwrap();
    assert!(refused(folder, line, 2).contains("not a .npz archive of this program"));
    assert_eq!(bytes(folder, "p.npz"), b"a letter");
}

#[test]
fn parts_that_do_not_belong_together_are_refused_by_name() {
    let folder = sample();
    let folder = folder.path();
    let part = |options: &str, shard: &str, name: &str| {
        run(
            folder,
            &format!("textons a.sample --levels 2 {options} --shard {shard} -o {name}"),
        );
    };
    part("--textons 12 --images 9", "0/2", "a0.npz");
    part("--textons 12 --images 9", "1/2", "a1.npz");
    part("--textons 13 --images 9", "1/2", "b1.npz");
    part("--textons 12 --images 9", "2/3", "c2.npz");
    part("--textons 12 --images 9 --seed 4", "1/2", "s1.npz");
    part("--textons 12 --images all", "1/2", "all1.npz");
    let joined = |parts: &str, code: i32| {
        refused(
            folder,
            &format!("textons a.sample --reduce {parts} -o x.textons.npz"),
            code,
        )
    };
    let others = joined("a0.npz b1.npz s1.npz all1.npz", 1);
    for says in [
        "b1.npz is made with --textons 13, not 12",
        "s1.npz is made with --seed 4, not 0",
        "all1.npz is made with --images all, not 9",
        "as a0.npz",
    ] {
        assert!(others.contains(says), "{others}");
    }
    refuses_other_shards(".npz", joined);
    let whole = bytes(folder, "a1.npz");
    fs::write(folder.join("cut.npz"), &whole[..whole.len() / 2]).unwrap();
    let cut = joined("a0.npz cut.npz", 1);
    assert!(
        cut.contains("cut.npz") && cut.contains("truncated"),
        "{cut}"
    );
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    fs::write(folder.join("damaged.npz"), damaged).unwrap();
    let damaged = joined("a0.npz damaged.npz", 1);
    assert!(
        damaged.contains("damaged.npz: image_vectors") && damaged.contains("checksum"),
        "{damaged}"
    );
    run(
        folder,
        "textons a.sample --levels 2 --textons 12 --images 9 -o v.textons.npz",
    );
    let vocabulary = joined("a0.npz v.textons.npz", 1);
    assert!(vocabulary.contains("mesotex-textons-part"), "{vocabulary}");
    assert!(!folder.join("x.textons.npz").exists());
}

#[test]
fn shards_that_cannot_be_are_refused() {
    let folder = sample();
    let folder = folder.path();
    let textons = |options: &str, code: i32| {
        refused(
            folder,
            &format!("textons a.sample --levels 2 --textons 12 {options} -o p.npz"),
            code,
        )
    };
    for (options, says) in [
        ("--images 9 --shard 0/65", "at most 64 shards"),
        ("--images all --shard 0/9", "at most 8 shards"),
        ("--shard 3/3", "not a shard i/n"),
        (
            "--shard 0/2 --reduce a.npz",
            "cannot be given with --reduce",
        ),
    ] {
        let error = textons(options, 2);
        assert!(error.contains(says), "{error}");
    }
    // Parts of another sample.
    run(
        folder,
        "bake --preset bark --size 16 --samples 1 --views fibonacci:3 --lights fibonacci:3 -o b.sample",
    );
    for shard in ["0/2", "1/2"] {
        let name = format!("b{}.npz", &shard[..1]);
        let line = "textons b.sample --levels 2 --textons 12 --images 5 --shard";
        run(folder, &format!("{line} {shard} -o {name}"));
    }
    let other = refused(
        folder,
        "textons a.sample --reduce b0.npz b1.npz -o x.textons.npz",
        1,
    );
    assert!(
        other.contains("b0.npz is of the sample") && other.contains("b1.npz is of the sample"),
        "{other}"
    );
    let seed = refused(
        folder,
        "textons b.sample --reduce b0.npz b1.npz -o x.textons.npz --seed 3",
        2,
    );
    assert!(seed.contains("--seed: 3, of parts made with 0"), "{seed}");
    // A factored sample has few planes, which one run reads.
    run(folder, "factor a.sample -o f.sample --rank 4");
    let factored = refused(
        folder,
        "textons f.sample --levels 2 --textons 12 --shard 0/2 -o p.npz",
        2,
    );
    assert!(factored.contains("rank 4"), "{factored}");
    assert!(mesotex(folder, &["info", "b0.npz"]).status.success());
}

const GLOSSY: &str = "bake --preset scales --size 16 --views fibonacci:7 --lights fibonacci:6";

#[test]
fn a_bake_of_parts_is_that_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for options in [
        "--samples auto --error 0.3 --bounces 1 --seed 9",
        "--samples 2 --angular-filter on --light-diameter 9 --dtype f4",
    ] {
        let line = format!("{GLOSSY} {options}");
        run(folder, &format!("{line} -o whole.sample"));
        let whole = files(&folder.join("whole.sample"));
        assert_eq!(whole.len(), 3);
        for count in [1, 2, 3, 7] {
            let parts = make_parts(folder, &line, count, "");
            run(folder, &format!("bake --reduce {parts} -o joined.sample"));
            let joined = files(&folder.join("joined.sample"));
            assert!(whole == joined, "{options}: {count} shards");
        }
    }
    assert!(run(folder, "info p1of3").contains("shard 1/3"));
}

#[test]
fn a_baked_part_is_kept_or_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let line = format!("{GLOSSY} --samples 1 --shard 1/2 -o part");
    run(folder, &line);
    let made = files(&folder.join("part"));
    assert!(run(folder, &line).contains("part is there already: shard 1/2"));
    // Damaged values are found by their hash and made anew.
    let array = folder.join("part/radiance.npy");
    let mut damaged = fs::read(&array).unwrap();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    fs::write(&array, damaged).unwrap();
    assert!(run(folder, &line).contains("wrote part"));
    assert_eq!(files(&folder.join("part")), made);
    // A killed run is continued.
    tear(folder);
    let gone_on = run(folder, &format!("{line} --json"));
    let report: serde_json::Value = serde_json::from_str(&gone_on).unwrap();
    let resumed = report["resumed"].as_u64().unwrap();
    assert!((1..24).contains(&resumed), "{gone_on}");
    assert_eq!(files(&folder.join("part")), made);
    assert!(!folder.join(".part.partial").exists());
    // A folder of the user is not replaced.
    fs::create_dir(folder.join("letters")).unwrap();
    fs::write(folder.join("letters/one.txt"), "dear").unwrap();
    let refusal = refused(folder, &line.replace("-o part", "-o letters"), 2);
    assert!(refusal.contains("one.txt"), "{refusal}");
}

#[test]
fn baked_parts_that_do_not_belong_together_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let line = format!("{GLOSSY} --samples 1");
    let part = |options: &str, output: &str| {
        run(folder, &format!("{line} {options} -o {output}"));
    };
    part("--shard 0/2", "a0");
    part("--shard 1/2", "a1");
    part("--shard 1/2 --bounces 1", "b1");
    part("--shard 1/2 --seed 4", "s1");
    part("--shard 2/3", "c2");
    part("", "whole.sample");
    let joined = |parts: &str, code: i32| {
        refused(folder, &format!("bake --reduce {parts} -o x.sample"), code)
    };
    let others = joined("a0 b1 s1", 1);
    for says in ["b1 has bounces 1, not 0", "seed 4, not 0", "as a0"] {
        assert!(others.contains(says), "{others}");
    }
    refuses_other_shards("", joined);
    refuses_what_is_no_part("bake", joined);
    let seed = joined("a0 a1 --seed 3", 2);
    assert!(seed.contains("--seed: 3, of parts made with 0"), "{seed}");
    refuses_damaged_part(folder, joined);
    let array = folder.join("a1/radiance.npy");
    let sound = fs::read(&array).unwrap();
    fs::write(&array, &sound[..sound.len() - 7]).unwrap();
    let cut = joined("a0 a1", 1);
    assert!(cut.contains("a1/radiance.npy"), "{cut}");
    assert!(!folder.join("x.sample").exists());
    let many = refused(folder, &format!("{line} --shard 0/8 -o p"), 2);
    assert!(many.contains("at most 7 shards"), "{many}");
}

#[test]
fn frames_of_shards_are_those_of_one_run() {
    let folder = sample();
    let folder = folder.path();
    for line in [
        "textons a.sample -o a.textons.npz --textons 8 --levels 2",
        "gram a.textons.npz -o a.space.npz",
        "knn a.space.npz -o a.knn.npz --k 3 --neighborhood 3",
        "synth a.space.npz a.knn.npz --grid 16x16 -o a.map.ply --k 3 --levels 1",
    ] {
        run(folder, line);
    }
    let render =
        "render a.sample a.map.ply --size 24x18 --sweep light-azimuth --frames 8 --skip-existing";
    run(folder, &format!("{render} -o whole"));
    let whole = files(&folder.join("whole"));
    for count in [2, 3, 7] {
        let output = format!("of{count}");
        let shard = |index: usize| format!("{render} -o {output} --shard {index}/{count}");
        for index in (0..count).rev() {
            run(folder, &shard(index));
        }
        let made = files(&folder.join(&output));
        assert!(whole == made, "{count} shards");
        let again = run(folder, &shard(0));
        assert!(
            again.contains("frames kept") && again.contains("0 frames of"),
            "{again}"
        );
        assert!(files(&folder.join(&output)) == made);
    }
}

#[test]
fn a_second_run_of_a_shard_is_refused_while_the_first_is_at_it() {
    let folder = sample();
    let folder = folder.path();
    run(
        folder,
        "textons a.sample -o a.textons.npz --textons 8 --levels 2",
    );
    let bake = format!("{GLOSSY} --samples 1 --shard 0/2 -o part");
    for (line, part) in [
        (
            "textons a.sample --textons 8 --levels 2 --shard 0/2 -o p.npz",
            "p.npz",
        ),
        (&bake, "part"),
    ] {
        refuses_second_run(folder, line, part);
    }
}

#[cfg(unix)]
#[test]
fn a_killed_shard_leaves_no_half_part() {
    let folder = sample();
    let folder = folder.path();
    let bake = format!("{GLOSSY} --samples 64 --shard 0/2 -o part");
    let textons = "textons a.sample --textons 8 --levels 2 --images all --shard 0/2 -o p.npz";
    for (line, name) in [(textons, "p.npz"), (&bake, "part")] {
        run(folder, line);
        let whole = content(&folder.join(name));
        for milliseconds in [20, 60, 120] {
            remove(&folder.join(name));
            let words = line.split_whitespace();
            let mut child = Command::new(env!("CARGO_BIN_EXE_mesotex"))
                .args(words)
                .current_dir(folder)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            thread::sleep(Duration::from_millis(milliseconds));
            child.kill().unwrap();
            child.wait().unwrap();
            // It may have been done before it was killed.
            if folder.join(name).exists() {
                assert_eq!(content(&folder.join(name)), whole, "{line}");
            }
            run(folder, line);
            assert_eq!(content(&folder.join(name)), whole, "{line}");
        }
    }
    let names = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = names
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["a.sample", "p.npz", "part"]);
}

/// The bytes of a file, or of all files of a folder.
fn content(path: &Path) -> Vec<Vec<u8>> {
    match path.is_dir() {
        true => files(path).into_values().collect(),
        false => vec![fs::read(path).unwrap()],
    }
}

fn remove(path: &Path) {
    match path.is_dir() {
        true => fs::remove_dir_all(path).unwrap(),
        false => fs::remove_file(path).unwrap(),
    }
}
