//! Signals, as a user or a system sends them: exit codes, hints, how soon, what stays on disk.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A bake that takes minutes: one image, no row of it done in a second.
const LONG_BAKE: [&str; 13] = [
    "bake",
    "--preset",
    "cobbles",
    "--size",
    "512",
    "--samples",
    "4096",
    "--bounces",
    "4",
    "--views",
    "fibonacci:1",
    "--lights",
    "fibonacci:2",
];

fn command(folder: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mesotex"));
    command
        .args(words)
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Waits until a file or folder is there, so that the run is past its start.
fn await_path(path: &Path) {
    let begun = Instant::now();
    while !path.exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no {path:?}");
        sleep(Duration::from_millis(5));
    }
}

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill")
        .args(["-s", signal, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
}

fn long_bake(folder: &Path) -> Child {
    let child = command(folder, &LONG_BAKE)
        .args(["-o", "x.sample"])
        .spawn()
        .unwrap();
    await_path(&folder.join(".x.sample.partial/radiance.npy"));
    child
}

/// A run that reads a FIFO nobody writes to: no loop of ours runs, none can hear.
fn stuck(folder: &Path) -> Child {
    let made = Command::new("mkfifo").arg(folder.join("in.obj")).status();
    assert!(made.unwrap().success());
    let child = command(folder, &["mesh", "in.obj", "-o", "out.ply"])
        .spawn()
        .unwrap();
    await_path(&folder.join(".out.ply.lock"));
    sleep(Duration::from_millis(300));
    child
}

/// Signals a run; its output, and how long it took to end.
fn interrupted(signal: &str, child: Child) -> (Output, Duration) {
    let begun = Instant::now();
    send(signal, &child);
    let output = child.wait_with_output().unwrap();
    (output, begun.elapsed())
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn each_signal_has_its_exit_code_and_says_how_to_go_on() {
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let folder = tempfile::tempdir().unwrap();
        let (output, took) = interrupted(signal, long_bake(folder.path()));
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(
            said.contains(&format!("interrupted by SIG{signal}"))
                && said.contains("type the same command to continue")
                && said.matches("interrupted").count() == 1,
            "{said}"
        );
        assert!(took < Duration::from_secs(20), "{took:?}");
        assert!(!folder.path().join("x.sample").exists());
    }
}

#[test]
fn hints_name_what_the_command_keeps() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sample = [
        "bake",
        "--preset",
        "weave",
        "--size",
        "32",
        "--samples",
        "1",
        "--views",
        "fibonacci:5",
    ];
    let run = |words: &[&str]| {
        let output = command(at, words).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
    };
    run(&[&sample[..], &["--lights", "fibonacci:5", "-o", "a.sample"]].concat());
    run(&[
        "textons",
        "a.sample",
        "-o",
        "a.textons.npz",
        "--textons",
        "20",
        "--levels",
        "1",
    ]);
    run(&["gram", "a.textons.npz", "-o", "a.space.npz"]);
    run(&["knn", "a.space.npz", "-o", "a.knn.npz"]);
    run(&[
        "synth",
        "a.space.npz",
        "a.knn.npz",
        "--grid",
        "64x64",
        "-o",
        "a.map.ply",
    ]);
    let synth = "synth a.space.npz a.knn.npz --grid 2048x2048 --search full -o b.map.ply";
    let render = "render a.sample a.map.ply --size 4000x4000 --samples 16 --shading pixel -o b";
    let knn = "textons a.sample --images all --restarts 10000 --textons 300 -o b.textons.npz";
    for (words, lock, hint) in [
        (synth, ".b.map.ply.lock", "--resume"),
        (render, ".b.lock", "--skip-existing"),
        (knn, ".b.textons.npz.lock", "start over"),
    ] {
        let words: Vec<&str> = words.split(' ').collect();
        let child = command(at, &words).spawn().unwrap();
        await_path(&at.join(lock));
        sleep(Duration::from_millis(200));
        let (output, took) = interrupted("TERM", child);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(143), "{said}");
        assert!(
            said.contains(hint) && took < Duration::from_secs(20),
            "{took:?} {said}"
        );
    }
}

#[test]
fn a_second_signal_ends_the_process_at_once_with_its_own_code() {
    let folder = tempfile::tempdir().unwrap();
    let child = stuck(folder.path());
    let begun = Instant::now();
    send("TERM", &child);
    sleep(Duration::from_millis(100));
    let (output, _) = interrupted("INT", child);
    // On a machine so busy that a second went by, the first signal has ended it.
    let in_time = begun.elapsed() < Duration::from_secs(1);
    let code = output.status.code();
    assert!(code == Some(130) || !in_time, "{code:?}");
}

#[test]
fn a_signal_that_is_sent_twice_at_once_counts_once() {
    let folder = tempfile::tempdir().unwrap();
    let child = long_bake(folder.path());
    // Pending together, as from `timeout`, which signals the process and its group.
    send("STOP", &child);
    send("TERM", &child);
    send("INT", &child);
    send("CONT", &child);
    let output = child.wait_with_output().unwrap();
    let said = stderr(&output);
    assert!(matches!(output.status.code(), Some(130 | 143)), "{said}");
    assert_eq!(said.matches("hint:").count(), 1, "{said}");
}

#[test]
fn a_hangup_that_was_ignored_stays_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_mesotex");
    let words =
        "bake --preset weave --size 64 --samples 64 --views fibonacci:4 --lights fibonacci:4";
    let child = Command::new("sh")
        .args([
            "-c",
            &format!("trap '' HUP; exec {program} {words} -o y.sample"),
        ])
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    await_path(&folder.path().join(".y.sample.partial"));
    let (output, _) = interrupted("HUP", child);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(folder.path().join("y.sample/btf.json").is_file());
}

#[test]
fn a_command_that_is_stuck_is_ended() {
    let folder = tempfile::tempdir().unwrap();
    let (output, took) = interrupted("TERM", stuck(folder.path()));
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(143), "{said}");
    assert!(said.contains("interrupted by SIGTERM"), "{said}");
    assert!(took < Duration::from_secs(20), "{took:?}");
    assert!(!folder.path().join("out.ply").exists());
}

#[test]
fn an_interrupted_bake_goes_on_and_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let words =
        "bake --preset weave --size 48 --samples 16 --views fibonacci:6 --lights fibonacci:6 -o";
    let words: Vec<&str> = words.split(' ').collect();
    let whole = command(at, &[&words[..], &["a.sample"]].concat())
        .output()
        .unwrap();
    assert!(whole.status.success());
    let child = command(at, &[&words[..], &["b.sample"]].concat())
        .spawn()
        .unwrap();
    await_path(&at.join(".b.sample.partial/radiance.npy"));
    let (output, _) = interrupted("HUP", child);
    assert!(
        matches!(output.status.code(), Some(129 | 0)),
        "{}",
        stderr(&output)
    );
    let again = command(at, &[&words[..], &["b.sample"]].concat())
        .output()
        .unwrap();
    assert!(again.status.success(), "{}", stderr(&again));
    for name in ["btf.json", "radiance.npy"] {
        let read = |sample: &str| fs::read(at.join(sample).join(name)).unwrap();
        assert_eq!(read("a.sample"), read("b.sample"), "{name}");
    }
}
