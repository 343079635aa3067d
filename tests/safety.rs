//! Nothing that a user owns is lost, whatever is named as an output.

mod program;

use std::fs;
use std::path::Path;

use program::{files, mesotex, refuse, succeed, write_capture, write_obj};
use tempfile::TempDir;

const BAKE: [&str; 10] = [
    "bake",
    "--preset",
    "weave",
    "--size",
    "16",
    "--views",
    "fibonacci:3",
    "--lights",
    "fibonacci:3",
    "--samples=1",
];

fn bake(folder: &Path, output: &str) -> String {
    succeed(folder, &[&BAKE[..], &["-o", output]].concat())
}

/// Runs a command that must be refused as wrong usage and change nothing.
fn refuse_unchanged(folder: &Path, words: &[&str]) -> String {
    let before = files(folder);
    let error = refuse(folder, words, 2);
    assert!(files(folder) == before, "{words:?} changed something");
    error
}

fn write_photographs(folder: &Path) {
    fs::create_dir_all(folder.join("2026")).unwrap();
    for name in ["coast.jpg", "2026/frame.0001.png", "contact.png"] {
        fs::write(folder.join(name), format!("a photograph, {name}")).unwrap();
    }
}

/// A user who names the folder of the capture, or one above it, as the output.
#[test]
fn the_parent_of_an_input_is_not_replaced() {
    let root = tempfile::tempdir().unwrap();
    write_capture(&root.path().join("coins/cap"));
    let at = |words: &[&str]| refuse_unchanged(root.path(), words);
    let error = at(&["import", "coins/cap/dirs.lp", "-o", "coins/cap"]);
    assert!(
        error.contains("`0.png`") && error.contains("a free name"),
        "{error}"
    );
    at(&["import", "coins/cap/dirs.lp", "-o", "coins"]);
    at(&["import", "coins/cap/dirs.lp", "-o", "."]);
    at(&[
        "import",
        "coins/cap/dirs.lp",
        "-o",
        "coins/cap/../../coins/cap",
    ]);
    at(&["import", "coins/cap", "-o", "coins/cap"]);
    // The same through a link, which stays as it is.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("coins/cap", root.path().join("link")).unwrap();
        at(&["import", "coins/cap/dirs.lp", "-o", "link"]);
        assert!(
            fs::symlink_metadata(root.path().join("link"))
                .unwrap()
                .is_symlink()
        );
    }
    // What the user meant.
    succeed(
        root.path(),
        &["import", "coins/cap/dirs.lp", "-o", "coins/cap.sample"],
    );
    succeed(
        root.path(),
        &["import", "coins/cap/dirs.lp", "-o", "coins/cap.sample"],
    );
}

/// A user who names a folder of photographs as the output, of every command that takes a folder.
#[test]
fn a_folder_of_photographs_is_not_replaced() {
    let root = tempfile::tempdir().unwrap();
    write_photographs(&root.path().join("photos"));
    write_capture(&root.path().join("cap"));
    fs::create_dir(root.path().join("texture.sample")).unwrap();
    write_photographs(&root.path().join("texture.sample"));
    for words in [
        &[&BAKE[..], &["-o", "photos"]].concat()[..],
        &["import", "cap/dirs.lp", "-o", "photos"],
        &["exemplar", "cap/0.png", "-o", "texture", "--levels", "2"],
    ] {
        let error = refuse_unchanged(root.path(), words);
        assert!(error.contains("which is not part of a sample"), "{error}");
    }
}

#[test]
fn a_sample_within_or_around_an_input_is_not_replaced() {
    let root = tempfile::tempdir().unwrap();
    write_capture(&root.path().join("cap"));
    bake(root.path(), "cap/x.sample");
    let error = refuse_unchanged(root.path(), &["import", "cap", "-o", "cap/x.sample"]);
    assert!(error.contains("is inside the input"), "{error}");
    // A list inside the very sample.
    let list = fs::read_to_string(root.path().join("cap/dirs.lp")).unwrap();
    fs::write(root.path().join("cap/x.sample/dirs.lp"), list).unwrap();
    refuse_unchanged(
        root.path(),
        &["import", "cap/x.sample/dirs.lp", "-o", "cap/x.sample"],
    );
}

#[test]
fn samples_are_replaced_and_links_to_them_followed() {
    let root = tempfile::tempdir().unwrap();
    fs::create_dir(root.path().join("empty")).unwrap();
    bake(root.path(), "empty");
    bake(root.path(), "empty");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("empty", root.path().join("link")).unwrap();
        fs::write(root.path().join("empty/radiance.npy"), "damaged").unwrap();
        bake(root.path(), "link");
        assert!(
            fs::symlink_metadata(root.path().join("link"))
                .unwrap()
                .is_symlink()
        );
        succeed(root.path(), &["info", "empty"]);
    }
    let names: Vec<_> = files(root.path()).into_keys().collect();
    assert!(
        names
            .iter()
            .all(|name| !name.to_string_lossy().contains("partial")),
        "{names:?}"
    );
}

#[cfg(unix)]
#[test]
fn files_pipes_and_devices_are_refused_as_outputs() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("notes.txt"), "mine").unwrap();
    let made = std::process::Command::new("mkfifo")
        .arg(root.path().join("pipe"))
        .status();
    assert!(made.unwrap().success());
    std::os::unix::fs::symlink("nowhere", root.path().join("loose")).unwrap();
    write_obj(&root.path().join("k.obj"), 300);
    let kinds = |words: &[&str]| {
        for (output, says) in [
            ("pipe", "a device, a pipe"),
            ("/dev/null", "a device, a pipe"),
            ("/dev/stdout", "--output"),
            ("loose", "a link to nothing"),
        ] {
            let error = refuse(root.path(), &[words, &["-o", output]].concat(), 2);
            assert!(error.contains(says), "{words:?} {output}: {error}");
        }
    };
    kinds(&BAKE);
    kinds(&["render", "x.sample", "y.map.ply"]);
    kinds(&["bake-maps", "x.sample", "y.map.ply", "--unwrap"]);
    kinds(&["transfer", "y.map.ply", "--maps", "color.png"]);
    bake(root.path(), "x.sample");
    kinds(&["textons", "x.sample", "--levels", "1"]);
    let error = refuse(root.path(), &[&BAKE[..], &["-o", "notes.txt"]].concat(), 2);
    assert!(error.contains("notes.txt: a file"), "{error}");
    let error = refuse(root.path(), &["textons", "x.sample", "-o", "notes.txt"], 2);
    assert!(
        error.contains("not a .npz archive of this program"),
        "{error}"
    );
    assert_eq!(fs::read(root.path().join("notes.txt")).unwrap(), b"mine");
    assert!(!fs::symlink_metadata("/dev/null").unwrap().is_file());
}

#[test]
fn a_file_of_the_user_is_not_written_over() {
    let root = tempfile::tempdir().unwrap();
    write_obj(&root.path().join("k.obj"), 300);
    write_obj(&root.path().join("scan.obj"), 300);
    fs::write(root.path().join("photo.png"), "a photograph").unwrap();
    let at = |words: &[&str]| refuse_unchanged(root.path(), words);
    // Input and output exchanged by mistake.
    assert!(at(&["mesh", "k.obj", "-o", "scan.obj"]).contains("not a mesh of this program"));
    at(&["mesh", "k.obj", "-o", "k.obj"]);
    at(&[&BAKE[..], &["-o", "x.sample", "--preview", "photo.png"]].concat());
    at(&["mesh", "k.obj", "-o", "new.ply", "--report", "new.ply"]);
    succeed(root.path(), &["mesh", "k.obj", "-o", "new.obj"]);
    succeed(root.path(), &["mesh", "k.obj", "-o", "new.obj"]);
}

/// A sample, and a map of it on a small mesh.
fn decorated() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let at = |words: &[&str]| succeed(root.path(), words);
    write_obj(&root.path().join("k.obj"), 300);
    bake(root.path(), "x.sample");
    at(&[
        "textons",
        "x.sample",
        "-o",
        "x.textons.npz",
        "--textons",
        "6",
        "--levels",
        "1",
    ]);
    at(&["gram", "x.textons.npz", "-o", "x.space.npz"]);
    at(&[
        "knn",
        "x.space.npz",
        "-o",
        "x.knn.npz",
        "--k",
        "2",
        "--neighborhood",
        "3",
    ]);
    at(&[
        "synth",
        "x.space.npz",
        "x.knn.npz",
        "k.obj",
        "-o",
        "k.map.ply",
        "--k",
        "2",
    ]);
    root
}

#[test]
fn frames_and_overviews_replace_only_frames_and_overviews() {
    let root = decorated();
    let render = ["render", "x.sample", "k.map.ply", "--size", "32x24", "-o"];
    let photos = [&render[..], &["photos"]].concat();
    for (name, says) in [
        ("contact.png", "not a picture of this program"),
        ("frame.0001.png", "not a picture of this program"),
        ("frame.0001.exr", "not a frame of this program"),
    ] {
        let folder = root.path().join("photos");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join(name), "a photograph").unwrap();
        let error = refuse_unchanged(root.path(), &photos);
        assert!(error.contains(says), "{name}: {error}");
        fs::remove_dir_all(&folder).unwrap();
    }
    let error = refuse_unchanged(root.path(), &[&render[..], &["x.sample"]].concat());
    assert!(error.contains("also an input"), "{error}");
    // Beside other files, frames are welcome; and they replace each other.
    fs::create_dir(root.path().join("photos")).unwrap();
    fs::write(root.path().join("photos/coast.jpg"), "a photograph").unwrap();
    succeed(root.path(), &photos);
    succeed(root.path(), &photos);
    assert_eq!(
        fs::read(root.path().join("photos/coast.jpg")).unwrap(),
        b"a photograph"
    );
}

#[cfg(unix)]
#[test]
fn a_lock_is_neither_followed_nor_waited_for() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("letter"), "dear").unwrap();
    let lock = root.path().join(".x.sample.lock");
    std::os::unix::fs::symlink("letter", &lock).unwrap();
    let words = [&BAKE[..], &["-o", "x.sample"]].concat();
    let error = refuse(root.path(), &words, 1);
    assert!(
        error.contains(".x.sample.lock is not a regular file"),
        "{error}"
    );
    assert_eq!(fs::read(root.path().join("letter")).unwrap(), b"dear");
    fs::remove_file(&lock).unwrap();
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&lock)
            .status()
            .unwrap()
            .success()
    );
    refuse(root.path(), &words, 1);
}

#[test]
fn what_killed_runs_left_is_removed_unless_it_is_held() {
    let root = tempfile::tempdir().unwrap();
    bake(root.path(), "x.sample");
    let left = root.path().join(".x.textons.npz.Ab12Cd.partial");
    let held = root.path().join(".other.npz.Ab12Cd.partial");
    for path in [&left, &held] {
        fs::write(path, "half").unwrap();
    }
    let holder = fs::File::open(&held).unwrap();
    holder.lock().unwrap();
    let textons = [
        "textons",
        "x.sample",
        "-o",
        "x.textons.npz",
        "--textons",
        "6",
        "--levels",
        "1",
    ];
    succeed(root.path(), &textons);
    assert!(!left.exists() && held.exists());
    drop(holder);
    succeed(root.path(), &textons);
    assert!(!held.exists());
}

#[test]
fn a_replacement_that_was_killed_is_mended_by_the_next_run_and_by_info() {
    let root = tempfile::tempdir().unwrap();
    let (sample, aside) = (
        root.path().join("x.sample"),
        root.path().join(".x.sample.replaced"),
    );
    bake(root.path(), "x.sample");
    let whole = files(&sample);
    fs::rename(&sample, &aside).unwrap();
    let error = refuse(root.path(), &["textons", "x.sample", "-o", "t.npz"], 1);
    assert!(
        error.contains("`mesotex info` puts the earlier one back"),
        "{error}"
    );
    let output = mesotex(root.path(), &["info", "x.sample"]);
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("was put back"));
    assert!(files(&sample) == whole && !aside.exists());
    // The next run that writes it mends it as well, even one that fails later.
    fs::rename(&sample, &aside).unwrap();
    refuse(
        root.path(),
        &[&BAKE[..], &["-o", "x.sample", "--bounces", "1001"]].concat(),
        2,
    );
    bake(root.path(), "x.sample");
    assert!(files(&sample) == whole && !aside.exists());
}
