//! What cannot be baked, and outputs that are inputs.

use super::*;

#[test]
fn what_cannot_be_baked_is_refused_and_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = tempfile::tempdir().unwrap();
    let shiny = inputs.path().join("shiny.toml");
    fs::write(
        &shiny,
        "albedo = [1, 1, 1]\nmetallic = 1.0\nroughness = 0.0",
    )
    .unwrap();
    let matte = inputs.path().join("matte.toml");
    fs::write(&matte, "albedo = [1, 1, 1]").unwrap();
    let matte = matte.to_str().unwrap();
    let csv = inputs.path().join("bad.csv");
    fs::write(&csv, "theta_deg,phi_deg\n95,0\n").unwrap();
    let (shiny, csv) = (shiny.to_str().unwrap(), csv.to_str().unwrap());
    // A mirror seen in the light's own direction: brighter than half precision holds.
    let seen_along_the_light: &[&str] = &[
        shiny,
        "--size",
        "4",
        "--views",
        "rings:0:1",
        "--lights",
        "rings:0:1",
    ];
    let cases: [(&[&str], i32, &str); 16] = [
        (&["--preset", "weave", "--samples", "0"], 2, "--samples: 0"),
        (&["--preset", "weave", "--samples", "some"], 2, "or auto"),
        (
            &["--preset", "weave", "--error", "0.1"],
            2,
            "--samples auto",
        ),
        (
            &["--preset", "weave", "--samples", "auto", "--error", "0"],
            2,
            "above 0, below 1",
        ),
        (
            &["--preset", "weave", "--clamp", "--dtype", "f4"],
            2,
            "--dtype f2",
        ),
        (&[matte, "--angular-filter", "on"], 2, "roughness"),
        (
            &[
                "--preset",
                "weave",
                "--angular-filter",
                "on",
                "--views",
                "fibonacci:5",
                "--lights",
                "rings:0:1",
            ],
            2,
            "at least 6",
        ),
        (
            &["--preset", "weave", "--light-diameter", "nan"],
            2,
            "0 to 90",
        ),
        (&["--preset", "weave", "--size", "3"], 2, "--size: 3"),
        (&["--preset", "weave", "--views", "13x5"], 2, "bonn151"),
        (&["--preset", "weave", "--depth", "0.1"], 2, "--preset"),
        (
            &["--preset", "weave", "--views", "rings:90:4"],
            2,
            "above the horizon",
        ),
        (
            &["--preset", "weave", "--lights", csv],
            1,
            "line 2: theta_deg: 95",
        ),
        (&["no-such.toml"], 1, "no-such.toml"),
        (seen_along_the_light, 1, "the highlight at row 0, column 0"),
        (
            seen_along_the_light,
            1,
            "--min-roughness 0.04 makes highlights less bright, --dtype f4 holds them, --clamp",
        ),
    ];
    for (words, code, says) in cases {
        let output = mesotex(
            folder.path(),
            &[&["bake", "-o", "x.sample"], words].concat(),
        );
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {errors}");
        assert!(errors.contains(says), "{words:?}: {errors}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{words:?}");
    }
}

#[test]
fn an_output_that_is_an_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("flat.toml"), "albedo = [0.8, 0.5, 0.1]").unwrap();
    let output = mesotex(folder.path(), &["bake", "flat.toml", "-o", "flat.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("also an input"));
    assert!(folder.path().join("flat.toml").is_file());
}
