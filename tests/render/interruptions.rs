//! Sweeps that are killed, run out of disk, or whose sample does not fit into memory.

use std::process::{Child, Stdio};
use std::time::{Duration, SystemTime};

use super::*;

/// All files of a folder but the hidden ones that a killed run leaves.
fn finished_files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = files(folder);
    all.retain(|name, _| !name.starts_with('.'));
    all
}

fn frames_in(folder: &Path) -> usize {
    let names = fs::read_dir(folder).into_iter().flatten().flatten();
    names
        .filter(|entry| entry.file_name().to_string_lossy().ends_with("exr"))
        .count()
}

fn is_running(child: &mut Child) -> bool {
    child.try_wait().unwrap().is_none()
}

#[test]
fn a_killed_sweep_goes_on_to_the_same_bytes() {
    let bench = small_ball(DType::F2);
    let sweep = [
        "--size",
        "200x150",
        "--sweep",
        "light-azimuth",
        "--frames",
        "24",
    ];
    let whole = files(&bench.render("whole", &sweep));
    for enough in [0, 3, 9] {
        let name = format!("killed-{enough}");
        let folder = bench.path(&name);
        let mut child = Command::new(env!("CARGO_BIN_EXE_mesotex"))
            .args(["render", text(&bench.sample), text(&bench.map), "-o"])
            .arg(&folder)
            .args(sweep)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while frames_in(&folder) < enough && is_running(&mut child) {
            std::thread::sleep(Duration::from_micros(200));
        }
        // Whatever the clock says: the moment must not matter.
        let now = SystemTime::now()
            .duration_since(SystemTime::UNIX_EPOCH)
            .unwrap();
        std::thread::sleep(Duration::from_micros(u64::from(now.subsec_nanos()) % 9000));
        child.kill().unwrap();
        child.wait().unwrap();
        let left = if folder.exists() {
            finished_files(&folder)
        } else {
            BTreeMap::new()
        };
        for (name, bytes) in &left {
            assert!(whole[name] == *bytes, "{name} is not whole");
        }
        bench.render(&name, &[&sweep[..], &["--skip-existing"]].concat());
        assert!(
            finished_files(&folder) == whole,
            "killed after {} files",
            left.len()
        );
    }
}

/// A limit on the size of files stands for the full disk: writing fails part way, as there.
#[cfg(unix)]
#[test]
fn a_disk_that_fills_up_names_the_frame_and_leaves_the_finished_ones() {
    let bench = small_ball(DType::F2);
    let path = bench.path("nearer.csv");
    fs::write(
        &path,
        "camera_x,camera_y,camera_z\n0,0,900\n0,0,800\n0,0,4\n0,0,900\n",
    )
    .unwrap();
    let sweep = ["--size", "240x180", "--sweep", text(&path)];
    let whole = files(&bench.render("whole", &sweep));
    assert!(whole["frame.0002.exr"].len() < 12_000 && whole["frame.0003.exr"].len() > 200_000);

    let folder = bench.path("full");
    let words = [
        "render",
        text(&bench.sample),
        text(&bench.map),
        "-o",
        text(&folder),
    ];
    let result = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$@\"", "sh"])
        .arg(env!("CARGO_BIN_EXE_mesotex"))
        .args(words)
        .args(sweep)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&result.stderr);
    assert_eq!(result.status.code(), Some(1), "{error}");
    assert!(error.contains("frame.0003"), "{error}");
    let left = files(&folder);
    for name in [
        "frame.0001.exr",
        "frame.0001.png",
        "frame.0002.exr",
        "frame.0002.png",
    ] {
        assert!(left[name] == whole[name], "{name}");
    }
    assert!(!left.contains_key("frame.0003.exr"));
    assert!(
        left.keys().all(|name| !name.starts_with('.')),
        "{:?}",
        left.keys()
    );

    bench.render("full", &[&sweep[..], &["--skip-existing"]].concat());
    assert!(files(&folder) == whole);
}

#[test]
fn a_sample_larger_than_the_memory_allowed_renders_the_same() {
    for dtype in [DType::F2, DType::F4] {
        let bench = small_ball(dtype);
        for shading in ["vertex", "pixel"] {
            let words = ["--size", "60x40", "--shading", shading];
            let whole = files(&bench.render("memory", &words));
            let mapped = bench.run("mapped", &[&words[..], &["--table-memory", "0"]].concat());
            assert!(mapped.status.success());
            assert!(String::from_utf8_lossy(&mapped.stdout).contains("on disk"));
            assert!(files(&bench.path("mapped")) == whole);
        }
    }
}
