//! Caches and checkpoints: the same bytes with them as without, whatever was done to them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::{PROGRAM, copy_of, files, mesotex, small_files, succeed, words};

const SYNTH: &str = "synth s.space.npz s.knn.npz m.ply -o o.map.ply --report o.json --pictures o \
                     --sample s.sample --vertex-colors o.ply";
const PLAIN: &str = "synth s.space.npz s.knn.npz m.ply -o o.map.ply --report o.json";
const CHECKPOINT: &str = ".o.map.ply.resume";

/// Everything that `synth` writes.
fn outputs(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let all = files(folder).into_iter();
    all.filter(|(path, _)| path.to_string_lossy().starts_with('o'))
        .collect()
}

fn cached_file(folder: &Path) -> PathBuf {
    let entries = fs::read_dir(folder.join("m.ply.mesotex-cache")).unwrap();
    let files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 1);
    files[0].clone()
}

/// Writes an archive of bytes anew with one byte of a list altered, or the texel.
fn alter(path: &Path, list: &str) {
    use mesotex::format::npz;
    let mut reader = npz::Reader::open(path).unwrap();
    let mut meta: serde_json::Map<String, serde_json::Value> = reader.meta().unwrap();
    meta.remove("id");
    if list == "texel" {
        meta["texel"] = (meta["texel"].as_f64().unwrap() * 1.5).into();
    }
    let names = [
        "triangles",
        "positions",
        "normals",
        "orientations",
        "samples",
        "coarse_samples",
        "neighbor_starts",
        "neighbors",
        "parents",
        "areas",
    ];
    let names = names
        .iter()
        .flat_map(|name| [format!("L0/{name}"), format!("L1/{name}")]);
    let mut lists: Vec<(String, ndarray::Array1<u8>)> = names
        .map(|name| (name.clone(), reader.array(&name).unwrap()))
        .collect();
    for (name, bytes) in &mut lists {
        if name == list {
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
        }
    }
    npz::write(path, meta, |writer| {
        lists
            .iter()
            .try_for_each(|(name, bytes)| writer.array(name, bytes.view()))
    })
    .unwrap();
}

#[test]
fn first_and_cached_runs_write_the_same_bytes() {
    let folder = copy_of(small_files());
    let lines = [
        SYNTH,
        "mesh m.ply -o o2.ply --orient --report o2.json --pictures o2",
        "render s.sample o.map.ply -o o.frames --size 48x32 --frames 2 --sweep view-orbit \
         --vertex-colors o3.ply --animation gif",
    ];
    let mut runs = Vec::new();
    for run in 0..2 {
        for line in lines {
            let said = succeed(folder.path(), &words(line));
            assert!(!said.contains("made again"), "run {run}: {said}");
        }
        runs.push(outputs(folder.path()));
    }
    assert!(runs[0].len() > 15, "{}", runs[0].len());
    for ((path, first), (_, cached)) in runs[0].iter().zip(&runs[1]) {
        assert!(first == cached, "{} differs", path.display());
    }
}

#[test]
fn an_altered_cache_is_told_and_changes_no_byte() {
    let folder = copy_of(small_files());
    succeed(folder.path(), &words(PLAIN));
    let whole = outputs(folder.path());
    for list in [
        "L0/samples",
        "L0/neighbors",
        "L1/positions",
        "L0/parents",
        "texel",
    ] {
        alter(&cached_file(folder.path()), list);
        let said = succeed(folder.path(), &words(PLAIN));
        let name = cached_file(folder.path());
        let name = name.file_name().unwrap().to_string_lossy();
        assert!(
            said.contains(&*name) && said.contains("made again"),
            "{list}: {said}"
        );
        assert!(outputs(folder.path()) == whole, "{list} changed the result");
    }
}

#[test]
fn a_cache_folder_that_cannot_be_made_is_told_and_changes_no_byte() {
    let folder = copy_of(small_files());
    succeed(folder.path(), &words(PLAIN));
    let whole = outputs(folder.path());
    let cache = folder.path().join("m.ply.mesotex-cache");
    fs::remove_dir_all(&cache).unwrap();
    fs::write(&cache, "in the way").unwrap();
    let said = succeed(folder.path(), &words(PLAIN));
    assert!(said.contains("not cached"), "{said}");
    assert!(outputs(folder.path()) == whole);
}

/// Runs `synth` with room for files of so many 512-byte blocks.
#[cfg(unix)]
fn synth_within(folder: &Path, blocks: u32, more: &str) -> std::process::Output {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec {PROGRAM} {PLAIN} {more}");
    let mut shell = std::process::Command::new("sh");
    shell
        .args(["-c", &script])
        .current_dir(folder)
        .output()
        .unwrap()
}

/// The map is much larger than a checkpoint: there is a size between them.
#[cfg(unix)]
const ROOM_FOR_A_CHECKPOINT: u32 = 20;

#[cfg(unix)]
#[test]
fn a_checkpoint_stays_until_all_is_written() {
    let folder = copy_of(small_files());
    let at = folder.path();
    succeed(at, &words(PLAIN));
    let whole = outputs(at);
    for (path, _) in &whole {
        fs::remove_file(at.join(path)).unwrap();
    }
    let failed = synth_within(at, ROOM_FOR_A_CHECKPOINT, "--quiet");
    let said = String::from_utf8_lossy(&failed.stderr);
    assert_eq!(failed.status.code(), Some(1), "{said}");
    assert!(said.contains("o.map.ply: cannot write"), "{said}");
    let kept = fs::read(at.join(CHECKPOINT)).expect("the checkpoint survives a full disk");

    // Going on takes it, and ends with the same bytes.
    let resume = format!("{PLAIN} --resume");
    let said = succeed(at, &words(&resume));
    assert!(!said.contains("begins anew"), "{said}");
    assert!(outputs(at) == whole && !at.join(CHECKPOINT).exists());

    // One that is damaged is told, and not used.
    for byte in [kept.len() / 3, kept.len() / 2, kept.len() - 30] {
        let mut damaged = kept.clone();
        damaged[byte] ^= 1;
        fs::write(at.join(CHECKPOINT), damaged).unwrap();
        let said = succeed(at, &words(&resume));
        assert!(
            said.contains(CHECKPOINT) && said.contains("begins anew"),
            "{said}"
        );
        assert!(outputs(at) == whole && !at.join(CHECKPOINT).exists());
    }

    // One of other options is an error with advice, and stays.
    fs::write(at.join(CHECKPOINT), &kept).unwrap();
    let other = mesotex(at, &words(&format!("{resume} --seed 5")));
    let said = String::from_utf8_lossy(&other.stderr);
    assert_eq!(other.status.code(), Some(1), "{said}");
    assert!(said.contains("leave out --resume"), "{said}");
    assert!(fs::read(at.join(CHECKPOINT)).unwrap() == kept);

    // A finished run without --resume takes an old one away.
    succeed(at, &words(PLAIN));
    assert!(outputs(at) == whole && !at.join(CHECKPOINT).exists());
}
