//! Every number that an option takes, at its extremes: it works, or it is refused at once as usage.
//! Nothing is allocated or repeated by a number that was not checked.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::{PROGRAM, copy_of, small_files};

const COUNTS: &[&str] = &[
    "0",
    "1",
    "-1",
    "65535",
    "4294967295",
    "18446744073709551615",
    "1e3",
];
const NUMBERS: &[&str] = &["0", "-1", "1e-320", "1e30", "1e308", "-1e308", "nan", "inf"];

/// How the values of an option are made of those above.
#[derive(Clone, Copy)]
enum Values {
    Counts(&'static str),
    Numbers(&'static str),
}
use Values::{Counts, Numbers};

/// A command and the options tried on it. `*` stands for the number. Of an option after `slow` a value
/// within its limits may be work for longer than the test waits.
struct Tried {
    command: &'static str,
    quick: &'static [(&'static str, Values)],
    slow: &'static [(&'static str, Values)],
}

const TRIED: &[Tried] = &[
    Tried {
        command: "bake --preset weave -o o.sample",
        quick: &[
            ("--light-diameter", Numbers("*")),
            ("--views", Counts("rings:45:2:*")),
            ("--views", Numbers("rings:*:2")),
        ],
        slow: &[
            ("--size", Counts("*")),
            ("--samples", Counts("*")),
            ("--bounces", Counts("*")),
            ("--views", Counts("fibonacci:*")),
            ("--lights", Counts("fibonacci:*")),
            ("--lights", Counts("rings:45:*")),
        ],
    },
    Tried {
        command: "bake --preset weave --samples auto -o o.sample",
        quick: &[("--error", Numbers("*"))],
        slow: &[],
    },
    Tried {
        command: "textons s.sample -o o.textons.npz --textons 8 --levels 2",
        quick: &[
            ("--textons", Counts("*")),
            ("--images", Counts("*")),
            ("--levels", Counts("*")),
            ("--max-iterations", Counts("*")),
            ("--image-grid", Counts("*")),
            ("--memory", Counts("*")),
        ],
        slow: &[("--restarts", Counts("*"))],
    },
    Tried {
        command: "gram s.textons.npz -o o.space.npz",
        quick: &[("--threads", Counts("*")), ("--seed", Counts("*"))],
        slow: &[],
    },
    Tried {
        command: "knn s.space.npz -o o.knn.npz --k 3 --neighborhood 3",
        quick: &[
            ("--k", Counts("*")),
            ("--neighborhood", Counts("*")),
            ("--coarse-neighborhood", Counts("*")),
            ("--min-separation", Counts("*")),
            ("--candidates", Counts("*")),
        ],
        slow: &[],
    },
    Tried {
        command: "exemplar a.png -o o --levels 2 --k 3 --neighborhood 3",
        quick: &[
            ("--levels", Counts("*")),
            ("--weights", Numbers("*")),
            ("--k", Counts("*")),
            ("--min-separation", Counts("*")),
        ],
        slow: &[],
    },
    Tried {
        command: "mesh m.ply -o o.ply --report o.json",
        quick: &[
            ("--levels", Counts("*")),
            ("--specks", Numbers("*")),
            ("--texel", Numbers("*")),
            ("--crease", Numbers("*")),
            ("--direction", Numbers("*,0,1")),
        ],
        slow: &[("--vertices", Counts("*"))],
    },
    Tried {
        command: "synth s.space.npz s.knn.npz m.ply -o o.map.ply",
        quick: &[
            ("--k", Counts("*")),
            ("--levels", Counts("*")),
            ("--neighborhood", Counts("*")),
            ("--spectrum", Numbers("*")),
            ("--coherence", Numbers("*")),
            ("--distance-floor", Numbers("*")),
            ("--reuse-penalty", Numbers("*")),
            ("--texel", Numbers("*")),
        ],
        slow: &[
            ("--passes", Counts("*")),
            ("--repair-rounds", Counts("*")),
            ("--start-passes", Counts("*")),
            ("--polish", Counts("*")),
        ],
    },
    Tried {
        command: "synth s.space.npz s.knn.npz m.ply -o o.map.ply --method adaptive",
        quick: &[
            ("--rings", Counts("*")),
            ("--link-range", Counts("*")),
            ("--levels", Counts("*")),
        ],
        slow: &[],
    },
    Tried {
        command: "synth s.space.npz s.knn.npz -o o.map.ply",
        quick: &[("--grid", Counts("*x65536")), ("--grid", Counts("16x*"))],
        slow: &[],
    },
    Tried {
        command: "render s.sample s.map.ply -o o.frames",
        quick: &[
            ("--size", Counts("*x16")),
            ("--table-memory", Counts("*")),
            ("--camera-azimuth", Numbers("*")),
            ("--camera-elevation", Numbers("*")),
            ("--camera-position", Numbers("*,1,3")),
            ("--camera-target", Numbers("*,1,0")),
            ("--fov", Numbers("*")),
            ("--zoom", Numbers("*")),
            ("--fill", Numbers("*")),
            ("--focal-length", Numbers("*")),
            ("--light-azimuth", Numbers("*")),
            ("--light-elevation", Numbers("*")),
            ("--light", Numbers("sun:*,1")),
            ("--light", Numbers("sun:1,1,*")),
            ("--light", Numbers("point:*,1,1")),
            ("--irradiance", Numbers("*")),
            ("--light-radius", Numbers("*")),
            ("--exposure", Numbers("*")),
            ("--background", Numbers("*")),
            ("--shard", Counts("0/*")),
        ],
        slow: &[("--size", Counts("16384x*"))],
    },
    Tried {
        command: "render s.sample s.map.ply -o o.frames --sweep light-spiral --frames 2",
        quick: &[
            ("--frames", Counts("*-4294967295")),
            ("--sweep-length", Counts("*")),
            ("--turns", Numbers("*")),
            ("--sweep-from", Numbers("*")),
            ("--sweep-to", Numbers("*")),
        ],
        slow: &[("--frames", Counts("*"))],
    },
    Tried {
        command: "render s.sample s.map.ply -o o.frames --projection orthographic --light-radius 1",
        quick: &[
            ("--shadow-rays", Counts("*")),
            ("--view-height", Numbers("*")),
        ],
        slow: &[],
    },
    Tried {
        command: "render s.sample s.map.ply -o o.frames --environment sky.hdr",
        quick: &[
            ("--environment-lights", Counts("*")),
            ("--environment-scale", Numbers("*")),
            ("--environment-azimuth", Numbers("*")),
        ],
        slow: &[],
    },
];

/// What keeps a command small, unless it is the option tried.
const SMALL: &[(&str, &str, &str)] = &[
    ("bake", "--size", "16"),
    ("bake", "--views", "fibonacci:2"),
    ("bake", "--lights", "fibonacci:2"),
    ("bake", "--samples", "1"),
    ("render", "--size", "16x16"),
];

/// How long a value that works may take, and how long one that is refused.
const PATIENCE: Duration = Duration::from_secs(if cfg!(debug_assertions) { 20 } else { 5 });
/// Address space of a run, in KiB: what is allocated beyond ends the run by a signal.
const ROOM: u64 = 6 << 20;

struct Trial {
    words: Vec<String>,
    is_slow: bool,
}

fn trials() -> Vec<Trial> {
    let mut all = Vec::new();
    for tried in TRIED {
        let command = tried.command.split(' ').next().unwrap();
        let options = tried.quick.iter().map(|option| (option, false));
        for ((option, values), is_slow) in options.chain(tried.slow.iter().map(|o| (o, true))) {
            let (numbers, form) = match values {
                Counts(form) => (COUNTS, form),
                Numbers(form) => (NUMBERS, form),
            };
            for number in numbers {
                let mut words: Vec<String> = Vec::new();
                let mut given = tried.command.split(' ');
                while let Some(word) = given.next() {
                    if word == *option {
                        given.next();
                    } else {
                        words.push(word.to_owned());
                    }
                }
                let others = SMALL
                    .iter()
                    .filter(|small| small.0 == command && small.1 != *option);
                words.extend(others.map(|(_, name, value)| format!("{name}={value}")));
                words.push(format!("{option}={}", form.replace('*', number)));
                all.push(Trial { words, is_slow });
            }
        }
    }
    all
}

impl Trial {
    /// What is wrong with how the program takes it.
    fn fault(&self, folder: &Path) -> Option<String> {
        let script = format!("ulimit -v {ROOM}; exec \"$0\" \"$@\"");
        let began = Instant::now();
        let mut child = Command::new("sh")
            .args(["-c", &script, PROGRAM])
            .args(&self.words)
            .arg("--quiet")
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        while child.try_wait().unwrap().is_none() {
            if began.elapsed() > if self.is_slow { PATIENCE / 8 } else { PATIENCE } {
                child.kill().unwrap();
                child.wait().unwrap();
                return (!self.is_slow).then(|| format!("{:?}: no end", self.words));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let fits = match output.status.code() {
            Some(0) => true,
            Some(2) => !said.is_empty() && !said.contains("panicked"),
            _ => false,
        };
        (!fits).then(|| format!("{:?}: {}\n{said}", self.words, output.status))
    }
}

#[cfg(unix)]
#[test]
fn extremes_of_every_option_work_or_are_refused_as_usage() {
    let trials = Mutex::new(trials());
    let faults = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let folder = copy_of(small_files());
                loop {
                    let next = trials.lock().unwrap().pop();
                    let Some(trial) = next else { break };
                    faults.lock().unwrap().extend(trial.fault(folder.path()));
                }
            });
        }
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What is refused says what the limit is and why.
#[test]
fn limits_give_their_reason() {
    let folder = copy_of(small_files());
    for (line, says) in [
        (
            "knn s.space.npz -o o --k 5000",
            "1 to 4096: a table has k entries",
        ),
        ("knn s.space.npz -o o --k 300", "256"),
        (
            "knn s.space.npz -o o --min-separation 70000",
            "no sample has longer sides",
        ),
        (
            "synth s.space.npz s.knn.npz m.ply -o o --start-passes 2000",
            "each visits every site",
        ),
        (
            "synth s.space.npz s.knn.npz m.ply -o o --texel 1e9",
            "the diagonal of the mesh",
        ),
        (
            "render s.sample s.map.ply -o o --frames 1000000",
            "at most 100000",
        ),
        (
            "render s.sample s.map.ply -o o --sweep-length 4294967295",
            "no larger numbers",
        ),
        (
            "bake --preset weave -o o --size 16 --views fibonacci:400 --lights fibonacci:99999",
            "one for each pair",
        ),
    ] {
        let output = crate::mesotex(folder.path(), &crate::words(line));
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {said}");
        assert!(said.contains(says), "{line}: {said}");
    }
}
