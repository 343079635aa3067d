//! Mutated files, thousands of them, through every reader: each is read or refused. None may panic
//! outside a guard or in our own code, allocate more than [`watch::MOST_MEMORY`] at once, or take
//! longer than [`watch::MOST_SECONDS`].
//!
//! The small run belongs to the normal tests. The long one:
//!
//! ```text
//! MESOTEX_FUZZ_RUNS=1000000 MESOTEX_FUZZ_SEED=1 cargo test --release --test fuzz -- --ignored --nocapture
//! ```
//!
//! `MESOTEX_FUZZ_READER=png` tries one reader alone. Every file follows from the seed, its reader and its
//! number. A file that fails is kept and named.

#![allow(
    unsafe_code,
    reason = "a global allocator, here one that counts, is unsafe by its nature"
)]

#[path = "../bonn/files.rs"]
mod bonn_files;
mod corpus;
#[path = "../image_set_files/mod.rs"]
mod image_set_files;
mod mesh_corpus;
mod mutation;
mod readers;
mod set_corpus;
mod watch;

use std::fs;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use mesotex::error::Error;
use mesotex::format::guard;

use crate::mutation::Mutator;
use crate::readers::{Reader, readers};
use crate::watch::Watch;

#[global_allocator]
static ALLOCATOR: watch::Counting = watch::Counting;

/// What became of a reader's files.
#[derive(Default)]
struct Tally {
    read: u64,
    refused: u64,
    /// Panics of other crates that a guard made errors of.
    caught: u64,
    /// Bytes held at most, and the file that made them held.
    peak: usize,
    peak_run: u64,
}

/// A number from the environment, for the long run.
fn number(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text.parse().expect("a whole number"),
        Err(_) => default,
    }
}

/// Where files that fail are kept.
fn kept() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz-failures");
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Reads `runs` mutated files of one reader.
fn fuzz(reader: &Reader, seed: u64, runs: u64, watch: &Watch) -> Tally {
    let folder = tempfile::tempdir().unwrap();
    let path = reader.prepare(folder.path());
    let mut tally = Tally::default();
    for run in 0..runs {
        let mut mutator = Mutator::new(seed, reader.name, run);
        let bytes = mutator.mutate(&reader.files, reader.content);
        fs::write(&path, &bytes).unwrap();
        let name = format!("seed {seed}, reader {}, run {run}", reader.name);
        let keep = kept().join(format!("{}-{seed}-{run}", reader.name));
        watch.begin(&name, &path, &keep);
        let result = catch_unwind(AssertUnwindSafe(|| (reader.read)(&path)));
        let peak = watch.end();
        if peak > tally.peak {
            (tally.peak, tally.peak_run) = (peak, run);
        }
        let fault = match &result {
            _ if peak > watch::MOST_MEMORY => Some(format!("{} MiB held at once", peak >> 20)),
            Err(_) => Some("a panic outside every guard".into()),
            Ok(Err(error)) => panic_in_our_code(error),
            Ok(Ok(())) => None,
        };
        if let Some(fault) = fault {
            fs::write(&keep, &bytes).unwrap();
            panic!("{name}: {fault}; the file is kept as {}", keep.display());
        }
        match result {
            Ok(Ok(())) => tally.read += 1,
            Ok(Err(error)) if is_caught(&error) => tally.caught += 1,
            _ => tally.refused += 1,
        }
    }
    tally
}

fn is_caught(error: &Error) -> bool {
    matches!(error, Error::Data(fault) if fault.place.ends_with(guard::PLACE))
}

/// A panic that a guard caught, where it is a fault of this crate.
fn panic_in_our_code(error: &Error) -> Option<String> {
    let text = error.to_string();
    (is_caught(error) && text.contains("(src/")).then_some(text)
}

/// Reads mutated files of all readers and says what became of them.
fn fuzz_all(seed: u64, runs: u64) {
    guard::silence();
    let watch = Watch::start();
    let only = std::env::var("MESOTEX_FUZZ_READER").ok();
    let mut readers = readers();
    readers.retain(|reader| only.as_ref().is_none_or(|name| name == reader.name));
    let each = runs.div_ceil(readers.len() as u64);
    let begun = Instant::now();
    let mut all = Tally::default();
    for reader in &readers {
        let start = Instant::now();
        let tally = fuzz(reader, seed, each, &watch);
        say(&format!(
            "{:16} {each:8} files: {:8} read, {:8} refused, {:6} panics of other crates caught; at most {:4} MiB (file {}); {:6.1} s",
            reader.name,
            tally.read,
            tally.refused,
            tally.caught,
            tally.peak >> 20,
            tally.peak_run,
            start.elapsed().as_secs_f64()
        ));
        all.read += tally.read;
        all.refused += tally.refused;
        all.caught += tally.caught;
    }
    say(&format!(
        "seed {seed}: {} files: {} read, {} refused, {} caught; {:.0} s",
        each * readers.len() as u64,
        all.read,
        all.refused,
        all.caught,
        begun.elapsed().as_secs_f64()
    ));
    assert!(all.read > 0 && all.refused > 0);
}

/// Writes a line past the test harness, which would hold it back until the end.
fn say(line: &str) {
    let mut stderr = std::io::stderr();
    writeln!(stderr, "{line}").unwrap();
}

#[test]
fn whole_files_are_read() {
    for reader in readers() {
        let folder = tempfile::tempdir().unwrap();
        let path = reader.prepare(folder.path());
        for (at, bytes) in reader.files.iter().enumerate() {
            fs::write(&path, bytes).unwrap();
            let result = (reader.read)(&path);
            assert!(result.is_ok(), "{} {at}: {result:?}", reader.name);
        }
    }
}

#[test]
fn mutated_files_are_read_or_refused() {
    fuzz_all(1, 4000);
}

#[test]
#[ignore = "minutes: the long run, for releases and after changes to readers"]
fn many_mutated_files_are_read_or_refused() {
    let (seed, runs) = (
        number("MESOTEX_FUZZ_SEED", 1),
        number("MESOTEX_FUZZ_RUNS", 1_000_000),
    );
    fuzz_all(seed, runs);
}
