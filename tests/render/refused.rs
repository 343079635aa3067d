//! Bad input: requests, maps and samples that are refused, and warnings of what will look wrong.

use super::*;

#[test]
fn impossible_requests_are_refused_with_reasons() {
    let bench = small_ball(DType::F2);
    for (words, code, says) in [
        (&["--frames", "0"][..], 2, "no frame"),
        (&["--size", "0x10"], 2, "size"),
        (&["--sweep", "light-azimut"], 2, "light-azimuth"),
        (
            &[
                "--sweep",
                "view-orbit",
                "--frames",
                "2",
                "--pattern",
                "frame",
            ],
            2,
            "--pattern",
        ),
        (
            &["--sweep", "view-orbit", "--frames", "12", "--pattern", "f#"],
            2,
            "at least 2 #",
        ),
        (&["--frames", "2"], 2, "without a sweep"),
        (&["--fov", "0"], 2, "--fov"),
        (&["--light", "lamp:1"], 2, "sun:AZIMUTH"),
        (&["--light", "point:0,1,0"], 2, "on the surface"),
        (
            &["--camera-position", "0,0,0", "--camera-target", "0,0,0"],
            2,
            "camera target",
        ),
        (&["--irradiance=-1"], 2, "--irradiance"),
        (&["--shard", "3/3"], 2, "shard"),
        (&["--threads", "0"], 2, "--threads"),
    ] {
        let error = bench.refuse(words, code);
        assert!(error.contains(says), "{words:?}: {error}");
    }
    let path = bench.path("path.csv");
    fs::write(&path, "camera_x,camera_y,camera_z\n0,1,5\n0,NaN,5\n").unwrap();
    let error = bench.refuse(&["--camera-path", text(&path)], 1);
    assert!(
        error.contains("path.csv") && error.contains("line 3, camera_y"),
        "{error}"
    );
    assert!(!bench.path("refused/frame.0001.exr").exists());
}

#[test]
fn warnings_say_what_will_look_wrong() {
    let bench = small_ball(DType::F2);
    let says = |words: &[&str]| {
        let result = bench.run("warned", &[words, &["--size", "16x16"]].concat());
        assert!(result.status.success());
        String::from_utf8_lossy(&result.stderr).into_owned()
    };
    assert!(says(&["--camera-position", "0,0.1,0"]).contains("inside the mesh"));
    assert!(says(&["--light", "point:0,0.1,0"]).contains("inside the mesh"));
    assert!(says(&["--pattern", "other.####"]).contains("not of this sweep"));
    assert!(
        says(&["--camera-position", "0,9,9", "--camera-target", "0,20,9"])
            .contains("shows nothing")
    );
}

#[test]
fn maps_and_samples_that_do_not_belong_together_are_refused() {
    let (a, b) = (small_ball(DType::F2), small_ball(DType::F4));
    let output = a.path("mixed");
    let words = [
        "render",
        text(&b.sample),
        text(&a.map),
        "-o",
        text(&output),
        "--size",
        "8x8",
    ];
    let refused = mesotex(&words);
    let error = String::from_utf8_lossy(&refused.stderr);
    assert!(
        refused.status.code() == Some(1) && error.contains("sample id"),
        "{error}"
    );
    assert!(
        mesotex(&[&words[..], &["--force"]].concat())
            .status
            .success()
    );

    let spec = SampleSpec {
        size: [5, 5],
        views: fibonacci(5),
        lights: fibonacci(5),
        dtype: DType::F2,
    };
    spec.write(&a.path("other.sample"), hashed);
    let other = a.path("other.sample");
    let words = [
        "render",
        text(&other),
        text(&a.map),
        "-o",
        text(&output),
        "--force",
    ];
    let error = mesotex(&words).stderr;
    assert!(String::from_utf8_lossy(&error).contains("5 × 5"));
}

#[test]
fn samples_with_few_directions_render_with_a_warning() {
    let spec = SampleSpec {
        size: [4, 4],
        views: fibonacci(1),
        lights: fibonacci(3),
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, lambertian),
        |id| ball(8, [4, 4], id),
    );
    for weights in ["continuous", "quadratic", "inverse-angle"] {
        let result = bench.run("few", &["--size", "24x24", "--weights", weights]);
        assert!(result.status.success());
        assert!(String::from_utf8_lossy(&result.stderr).contains("1 distinct views"));
        let frame = read_frame(&bench.path("few/frame.0001.exr"));
        assert!(frame.channels["R"].iter().any(|&v| v > 0.1));
    }
}

#[test]
fn radiance_that_is_none_is_named_by_place() {
    let bench = small_ball(DType::F2);
    let path = bench.sample.join("radiance.npy");
    let mut bytes = fs::read(&path).unwrap();
    // The last number of the last image: half NaN.
    let end = bytes.len();
    bytes[end - 2..].copy_from_slice(&[0x00, 0x7e]);
    fs::write(&path, bytes).unwrap();
    let error = bench.refuse(&["--size", "8x8"], 1);
    assert!(
        error.contains("view 10, light 13, row 5, column 7") && error.contains("NaN"),
        "{error}"
    );
}
