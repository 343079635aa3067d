//! Runs that are killed, or asked to stop, at moments of chance: what stands under a final name is whole,
//! no folder vanishes, and running again gives the same bytes and leaves nothing over.
//!
//! The long run (docs/reliability.md): `cargo test --release --test kills -- --ignored --nocapture`.
#![cfg(unix)]

mod program;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use program::{copy_of, files, succeed, write_obj};
use tempfile::TempDir;

/// The commands, each with the outputs it must make again: a file, or a folder with all that is in it.
const COMMANDS: [(&[&str], &[&str]); 6] = [
    (
        &[
            "bake",
            "--preset",
            "bark",
            "--size",
            "48",
            "--samples",
            "1",
            "--views",
            "fibonacci:12",
            "--lights",
            "fibonacci:12",
            "-o",
            "b.sample",
        ],
        &["b.sample"],
    ),
    (
        &[
            "textons",
            "a.sample",
            "-o",
            "b.textons.npz",
            "--textons",
            "40",
            "--images",
            "60",
            "--levels",
            "2",
        ],
        &["b.textons.npz"],
    ),
    (
        &["mesh", "k.obj", "-o", "b.ply", "--vertices", "3000"],
        &["b.ply"],
    ),
    (
        &[
            "synth",
            "a.space.npz",
            "a.knn.npz",
            "k.obj",
            "-o",
            "b.map.ply",
            "--pictures",
            "b",
        ],
        &[
            "b.map.ply",
            "b.coordinate.png",
            "b.label.png",
            "b.energy.png",
        ],
    ),
    (
        &[
            "render",
            "a.sample",
            "a.map.ply",
            "-o",
            "b.frames",
            "--size",
            "160x120",
            "--sweep",
            "light-azimuth",
            "--frames",
            "6",
        ],
        &["b.frames"],
    ),
    (
        &["run", "scene.toml"],
        &[
            "r.sample",
            "r.textons.npz",
            "r.space.npz",
            "r.knn.npz",
            "r.mesh.ply",
            "r.map.ply",
            "r.frames",
        ],
    ),
];

const SCENE: &str = "name = \"r\"\n[bake]\npreset = \"weave\"\nsize = 32\nviews = \"fibonacci:9\"\nlights = \"fibonacci:9\"\nsamples = 1\n\
    [textons]\ntextons = 16\nimages = 20\nlevels = 2\n[knn]\nk = 3\n[mesh]\ninput = \"k.obj\"\nvertices = 2000\n[synth]\nk = 3\n\
    [[render]]\nsize = \"64x48\"\nsweep = \"light-azimuth\"\nframes = 3\n";

/// Everything the commands read.
fn inputs() -> &'static Path {
    static INPUTS: OnceLock<TempDir> = OnceLock::new();
    let root = INPUTS.get_or_init(|| {
        let root = tempfile::tempdir().unwrap();
        let at = |words: &[&str]| succeed(root.path(), words);
        write_obj(&root.path().join("k.obj"), 2000);
        fs::write(root.path().join("scene.toml"), SCENE).unwrap();
        at(&[
            "bake",
            "--preset",
            "weave",
            "--size",
            "32",
            "--samples",
            "1",
            "--views",
            "fibonacci:9",
            "--lights",
            "fibonacci:9",
            "-o",
            "a.sample",
        ]);
        at(&[
            "textons",
            "a.sample",
            "-o",
            "a.textons.npz",
            "--textons",
            "16",
            "--images",
            "20",
            "--levels",
            "2",
        ]);
        at(&["gram", "a.textons.npz", "-o", "a.space.npz"]);
        at(&["knn", "a.space.npz", "-o", "a.knn.npz", "--k", "3"]);
        at(&[
            "synth",
            "a.space.npz",
            "a.knn.npz",
            "k.obj",
            "-o",
            "a.map.ply",
        ]);
        fs::remove_dir_all(root.path().join("k.obj.mesotex-cache")).unwrap();
        root
    });
    root.path()
}

/// What a command leaves when nothing disturbs it, and how long it takes.
struct Reference {
    words: &'static [&'static str],
    outputs: BTreeMap<PathBuf, Vec<u8>>,
    duration: Duration,
}

impl Reference {
    fn of((words, names): (&'static [&'static str], &[&str])) -> Self {
        let folder = copy_of(inputs());
        let begun = Instant::now();
        succeed(folder.path(), words);
        let duration = begun.elapsed();
        let mut outputs = files(folder.path());
        outputs.retain(|path, _| names.iter().any(|name| path.starts_with(name)));
        assert!(outputs.len() >= names.len());
        Self {
            words,
            outputs,
            duration,
        }
    }

    /// Disturbs one run, of which an earlier run's outputs stand there when `replaced`, and runs again.
    fn try_once(&self, signal: &str, share: f64, replaced: bool) {
        let folder = copy_of(inputs());
        if replaced {
            for (path, bytes) in &self.outputs {
                let path = folder.path().join(path);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, bytes).unwrap();
            }
        }
        let mut child = Command::new(env!("CARGO_BIN_EXE_mesotex"))
            .args(self.words)
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(self.duration.mul_f64(share));
        let sent = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .stderr(Stdio::null())
            .status();
        assert!(sent.is_ok());
        let code = child.wait().unwrap().code();
        let when = format!("{:?}, {signal} after {share:.3} of its time", self.words);
        assert!(
            code.is_none_or(|code| code == 0 || code == 143),
            "{when}: exit code {code:?}"
        );
        self.check(folder.path(), replaced, &when);
        succeed(folder.path(), self.words);
        self.check(folder.path(), true, &when);
        let left: Vec<_> = files(folder.path())
            .into_keys()
            .filter(|path| is_hidden(path))
            .collect();
        assert!(left.is_empty(), "{when}: left over {left:?}");
    }

    /// Every output that is there is whole, and there are all of them where they have to be.
    fn check(&self, folder: &Path, all: bool, when: &str) {
        let found = files(folder);
        for (path, bytes) in &self.outputs {
            match found.get(path) {
                Some(found) => assert!(found == bytes, "{when}: {} is not whole", path.display()),
                None => assert!(!all, "{when}: {} is gone", path.display()),
            }
        }
    }
}

/// Whether a file, or a folder above it, is one of those that runs make for themselves.
fn is_hidden(path: &Path) -> bool {
    path.iter()
        .any(|part| part.to_string_lossy().starts_with('.'))
}

/// The golden ratio's multiples spread over (0, 1) evenly, however many are taken.
fn share(count: usize) -> f64 {
    (0.618_033_988_75 * (count as f64 + 0.5)).fract()
}

fn disturb(signal: &str, times: usize) {
    let references: Vec<Reference> = COMMANDS.into_iter().map(Reference::of).collect();
    for count in 0..times {
        let reference = &references[count % references.len()];
        reference.try_once(signal, share(count), count / references.len() % 2 == 1);
    }
    println!("{times} times {signal}: every output whole, every rerun the same");
}

#[test]
fn a_killed_run_leaves_whole_files_and_is_made_good_by_the_next() {
    disturb("-KILL", 12);
}

#[test]
fn a_run_asked_to_stop_leaves_whole_files_and_is_made_good_by_the_next() {
    disturb("-TERM", 6);
}

#[test]
#[ignore = "takes minutes; docs/reliability.md says how to run it"]
fn killed_200_times() {
    disturb("-KILL", 200);
}

#[test]
#[ignore = "takes minutes; docs/reliability.md says how to run it"]
fn asked_to_stop_60_times() {
    disturb("-TERM", 60);
}
