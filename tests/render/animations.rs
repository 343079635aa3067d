//! Moving previews: which files they are, and what is said where the machine has no encoder.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt;

use super::*;

/// Stands in for ffmpeg: it knows one encoder, and leaves what it was told and what it was given.
const ENCODER: &str = "#!/bin/sh
case \"$*\" in
  *-encoders*) echo ' V....D CODEC   an encoder'; exit 0;;
esac
for last in \"$@\"; do :; done
[ -z \"$BREAK\" ] || { echo 'no room in the picture' >&2; exit 1; }
echo \"$@\" > \"$TOLD\"
cat > \"$last\"
";

/// A folder with a program `ffmpeg` that knows an encoder.
fn with_encoder(codec: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("ffmpeg");
    fs::write(&program, ENCODER.replace("CODEC", codec)).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    folder
}

/// Renders three frames of a moving light, with programs from `programs` alone and some variables.
fn render(bench: &Bench, animation: &str, programs: &str, variables: &[(&str, &Path)]) -> Output {
    let folder = bench.path("moving");
    let words = [
        "--sweep",
        "light-azimuth",
        "--frames",
        "3",
        "--size",
        "25x16",
    ];
    Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .args([
            "render",
            text(&bench.sample),
            text(&bench.map),
            "-o",
            text(&folder),
        ])
        .args(words)
        .args(["--animation", animation])
        .env("PATH", programs)
        .envs(variables.iter().copied())
        .output()
        .unwrap()
}

#[test]
fn animated_pngs_hold_the_previews() {
    let bench = small_ball(DType::F2);
    let output = render(&bench, "apng", "", &[]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let bytes = fs::read(bench.path("moving/sweep.apng")).unwrap();
    assert!(bytes.windows(4).any(|part| part == b"acTL"));
    let first = mesotex::format::image::read(&bench.path("moving/frame.0001.png")).unwrap();
    let shown = mesotex::format::image::read(&bench.path("moving/sweep.apng")).unwrap();
    assert_eq!(shown.into_rgb().data, first.into_rgb().data);
    // Again, over its own files.
    assert!(render(&bench, "apng", "", &[]).status.success());
}

#[test]
fn videos_are_written_by_the_machines_encoder() {
    let bench = small_ball(DType::F2);
    for (animation, codec) in [("mp4", "libx264"), ("mp4", "mpeg4"), ("webm", "libvpx-vp9")] {
        let programs = with_encoder(codec);
        let told = programs.path().join("told");
        let path = format!("{}:/usr/bin:/bin", text(programs.path()));
        let output = render(&bench, animation, &path, &[("TOLD", &told)]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{error}");
        let told = fs::read_to_string(told).unwrap();
        for words in [
            "-pixel_format rgb24 -video_size 25x16 -framerate 24",
            &format!("-c:v {codec} "),
            &format!("-f {animation} "),
        ] {
            assert!(told.contains(words), "{told}");
        }
        // The stand-in keeps the pictures as they come.
        let file = bench.path(&format!("moving/sweep.{animation}"));
        assert_eq!(fs::read(file).unwrap().len(), 3 * 25 * 16 * 3);
    }
}

#[test]
fn a_missing_encoder_is_said_before_anything_is_made() {
    let bench = small_ball(DType::F2);
    let nothing = tempfile::tempdir().unwrap();
    let other = with_encoder("gif");
    let others = format!("{}:/usr/bin:/bin", text(other.path()));
    for (programs, says) in [
        (text(nothing.path()), "ffmpeg does not run"),
        (&others, "has none of libx264"),
    ] {
        let output = render(&bench, "mp4", programs, &[]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        for part in ["--animation", says, "gif or apng", "install ffmpeg"] {
            assert!(error.contains(part), "{error}");
        }
        assert!(!bench.path("moving/frame.0001.exr").exists());
    }
}

#[test]
fn an_encoder_that_fails_says_why_and_leaves_no_file() {
    let bench = small_ball(DType::F2);
    let programs = with_encoder("libx264");
    let path = format!("{}:/usr/bin:/bin", text(programs.path()));
    let output = render(&bench, "mp4", &path, &[("BREAK", Path::new("yes"))]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.contains("sweep.mp4") && error.contains("no room in the picture"),
        "{error}"
    );
    let left = fs::read_dir(bench.path("moving")).unwrap();
    let names: Vec<String> = left
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    assert!(
        names.iter().all(|name| !name.contains("sweep")),
        "{names:?}"
    );
}
