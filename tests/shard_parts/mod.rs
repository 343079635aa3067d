//! Shards as a user runs them, and what every command refuses of parts.
#![allow(dead_code, reason = "every test file uses its own part")]

use std::fs;
use std::path::Path;

use mesotex::format::{ContentId, OutputLock};
use serde_json::Value;

use crate::program::{refuse, succeed, words};

/// Runs a line that must succeed; returns its stdout.
pub fn run(folder: &Path, line: &str) -> String {
    succeed(folder, &words(line))
}

/// Runs a line that must be refused; returns its stderr in one line.
pub fn refused(folder: &Path, line: &str, code: i32) -> String {
    let error = refuse(folder, &words(line), code);
    error.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Makes the parts of all shards of a line, each by its own run, the last first; their names, with this ending.
pub fn make_parts(folder: &Path, line: &str, count: usize, ending: &str) -> String {
    let name = |shard: usize| format!("p{shard}of{count}{ending}");
    for shard in (0..count).rev() {
        let output = name(shard);
        run(
            folder,
            &format!("{line} --shard {shard}/{count} -o {output}"),
        );
    }
    (0..count).map(name).collect::<Vec<_>>().join(" ")
}

/// Turns the folder `part` into what a killed run leaves: some whole images and a torn one.
pub fn tear(folder: &Path) {
    let text = fs::read_to_string(folder.join("part/btf.json")).unwrap();
    let description: Value = serde_json::from_str(&text).unwrap();
    let id = description["id"].as_str().unwrap();
    let no_id = ContentId::of_bytes(b"").to_string();
    let partial = folder.join(".part.partial");
    fs::rename(folder.join("part"), &partial).unwrap();
    fs::write(
        partial.join("unfinished.json"),
        text.replace(id, &no_id).trim_end(),
    )
    .unwrap();
    fs::remove_file(partial.join("btf.json")).unwrap();
    let array = fs::read(partial.join("radiance.npy")).unwrap();
    let torn = &array[..array.len() * 6 / 10];
    fs::write(partial.join("radiance.npy"), torn).unwrap();
}

/// Checks that shards which are missing, there twice or of another number are refused. Of one sample there are `a0` and
/// `a1`, shards of two, and `c2`, shard 2/3; `joined` joins parts, which must fail with the exit code.
pub fn refuses_other_shards(ending: &str, joined: impl Fn(&str, i32) -> String) {
    for (parts, says) in [
        ("a0", "no part of shard 1/2"),
        ("a0 a1 a1", "a1# and a1# are shard 1/2"),
        ("a0 a1 c2", "c2# is shard 2/3"),
    ] {
        let parts: Vec<String> = parts
            .split(' ')
            .map(|part| format!("{part}{ending}"))
            .collect();
        let error = joined(&parts.join(" "), 2);
        assert!(error.contains(&says.replace('#', ending)), "{error}");
    }
}

/// Checks that a whole sample is refused among the parts of a command, and a path where there is nothing.
pub fn refuses_what_is_no_part(command: &str, joined: impl Fn(&str, i32) -> String) {
    let whole = joined("a0 whole.sample", 1);
    let expected = format!("a part, as `mesotex {command} --shard` writes it");
    assert!(whole.contains(&expected), "{whole}");
    assert!(joined("a0 nothing", 1).contains("nothing"));
}

/// Checks that a part with damaged numbers is refused; afterwards it is sound again.
pub fn refuses_damaged_part(folder: &Path, joined: impl Fn(&str, i32) -> String) {
    let array = folder.join("a1/radiance.npy");
    let sound = fs::read(&array).unwrap();
    let mut damaged = sound.clone();
    *damaged.last_mut().unwrap() ^= 1;
    fs::write(&array, damaged).unwrap();
    let error = joined("a0 a1", 1);
    assert!(
        error.contains("a1/radiance.npy: hash") && error.contains("damaged"),
        "{error}"
    );
    fs::write(&array, sound).unwrap();
}

/// Checks that a shard is refused while another run is writing its part, and that the part is kept afterwards.
pub fn refuses_second_run(folder: &Path, line: &str, part: &str) {
    let held = OutputLock::acquire(&folder.join(part)).unwrap();
    let error = refused(folder, line, 1);
    assert!(error.contains("another run is writing it"), "{error}");
    assert!(!folder.join(part).exists());
    drop(held);
    run(folder, line);
    assert!(run(folder, line).contains("is there already"));
}
