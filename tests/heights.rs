//! Heights of samples and parallax, as a user meets them.

mod program;

use std::fs;
use std::path::Path;

use mesotex::btf::Sample;
use mesotex::format::{npy, npz};
use ndarray::{Array2, Ix2};
use program::{refuse, succeed};
use serde_json::Value;

fn run(folder: &Path, line: &str) -> String {
    succeed(folder, &line.split_whitespace().collect::<Vec<_>>())
}

fn refused(folder: &Path, line: &str, code: i32) -> String {
    refuse(folder, &line.split_whitespace().collect::<Vec<_>>(), code)
}

fn report(folder: &Path, line: &str) -> Value {
    serde_json::from_str(&run(folder, &format!("{line} --json"))).unwrap()
}

/// `a.sample`, and `a.map.ply` on a flat grid.
fn prepared(views: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let bake = "bake --preset cobbles --size 24 --samples 1";
    let directions = format!("--views {views} --lights rings:20:3,50:4");
    let line = format!("{bake} {directions} --surface surface.npz -o a.sample");
    run(folder.path(), &line);
    for line in [
        "textons a.sample --textons 20 --images 4 --levels 2 -o a.textons.npz",
        "gram a.textons.npz -o a.space.npz",
        "knn a.space.npz --k 3 --neighborhood 3 -o a.knn.npz",
        "synth a.space.npz a.knn.npz --grid 24x24 -o a.map.ply",
    ] {
        run(folder.path(), line);
    }
    folder
}

#[test]
fn heights_go_from_bake_to_frames() {
    let folder = prepared("rings:10:4,45:6");
    let at = folder.path();
    // A bake writes the surface it knows.
    let mut surface = npz::Reader::open(&at.join("surface.npz")).unwrap();
    let true_heights = surface.array::<f32, Ix2>("heights").unwrap();
    let written = npy::read::<f32>(&at.join("a.sample/height.npy")).unwrap();
    assert_eq!(written, true_heights.into_dyn());
    assert!(run(at, "info a.sample").contains("texels above z = 0"));
    let info = report(at, "info a.sample --leave-out");
    let parallax = &info["parallax"];
    let error = |name: &str| parallax[name].as_f64().unwrap();
    assert!(
        error("relative_error") < error("relative_error_plain"),
        "{parallax}"
    );
    // Factors keep it.
    run(at, "factor a.sample --rank 4 -o b.sample");
    assert_eq!(
        Sample::open(&at.join("b.sample"))
            .unwrap()
            .heights()
            .unwrap(),
        Sample::open(&at.join("a.sample"))
            .unwrap()
            .heights()
            .unwrap()
    );
    let said = run(at, "export a.sample --to bdi -o a.btf");
    assert!(said.contains("heights are left out"), "{said}");
    // Frames say what was chosen, and differ.
    let render = "render a.sample a.map.ply --size 32x32 --camera-elevation 35";
    let frame = |words: &str, output: &str| {
        let said = report(at, &format!("{render} {words} -o {output}"));
        (
            said["parallax"].clone(),
            fs::read(at.join(output).join("frame.0001.png")).unwrap(),
        )
    };
    let (chosen, automatic) = frame("", "auto");
    assert_eq!(chosen, Value::Bool(true));
    let (_, on) = frame("--parallax on", "on");
    let (chosen, off) = frame("--parallax off", "off");
    assert_eq!(chosen, Value::Bool(false));
    assert_eq!(automatic, on);
    assert_ne!(on, off);
    let said = run(at, &format!("{render} -o said"));
    assert!(
        said.contains("parallax on: ") && said.contains("left-out"),
        "{said}"
    );
    // Pixels, coarser levels and texture maps, too; at any number of threads.
    let pixels = "--shading pixel --texels bilinear";
    frame(pixels, "pixels");
    frame(&format!("{pixels} --threads 1"), "alone");
    let bytes = |name: &str| fs::read(at.join(name).join("frame.0001.exr")).unwrap();
    assert_eq!(bytes("pixels"), bytes("alone"));
    let baked = report(
        at,
        "bake-maps a.sample a.map.ply --unwrap --resolution 32 -o baked",
    );
    assert_eq!(baked["parallax"], Value::Bool(true));
    // Other heights make kept frames stale.
    let keep = "--skip-existing -o auto";
    assert_eq!(report(at, &format!("{render} {keep}"))["kept"], 1);
    let flat = Array2::<f32>::zeros((24, 24)).into_dyn();
    npy::write(&at.join("a.sample/height.npy"), flat.view()).unwrap();
    let again = report(at, &format!("{render} {keep}"));
    assert_eq!(
        (&again["kept"], &again["parallax"]),
        (&0.into(), &Value::Bool(false))
    );
}

#[test]
fn heights_are_estimated_and_never_replaced_unasked() {
    let folder = prepared("rings:10:4,35:6");
    let at = folder.path();
    let wanted = Sample::open(&at.join("a.sample"))
        .unwrap()
        .heights()
        .unwrap()
        .unwrap();
    let error = refused(at, "heights a.sample", 2);
    assert!(
        error.contains("--force") && error.contains("height.npy"),
        "{error}"
    );
    fs::remove_file(at.join("a.sample/height.npy")).unwrap();
    let said = run(at, "info a.sample");
    assert!(said.contains("no heights"), "{said}");
    let said = run(at, "heights a.sample --range 5");
    assert!(
        said.contains("correlation") && said.contains("left-out"),
        "{said}"
    );
    let found = Sample::open(&at.join("a.sample"))
        .unwrap()
        .heights()
        .unwrap()
        .unwrap();
    let product: f64 = found
        .heights()
        .iter()
        .zip(wanted.heights())
        .map(|(a, b)| f64::from(a * b))
        .sum();
    let correlation = product / (576.0 * found.deviation() * wanted.deviation());
    assert!(correlation > 0.7, "{correlation}");
    let report = report(at, "heights a.sample --range 5 --force");
    assert!(
        report["agreement"]["correlation"].as_f64().unwrap() > 0.5,
        "{report}"
    );
    assert!(refused(at, "heights a.sample --force --range 0", 2).contains("--range"));
}

#[test]
fn heights_that_cannot_be_are_refused_by_name() {
    let folder = prepared("rings:0:1,40:4");
    let at = folder.path();
    let path = at.join("a.sample/height.npy");
    let write = |array: Array2<f32>| npy::write(&path, array.view().into_dyn()).unwrap();
    let render = "render a.sample a.map.ply --size 8x8 -o frames";
    write(Array2::zeros((24, 23)));
    for line in ["info a.sample", render] {
        let error = refused(at, line, 1);
        assert!(
            error.contains("height.npy") && error.contains("[24, 24]"),
            "{error}"
        );
    }
    let mut broken = Array2::zeros((24, 24));
    broken[[3, 7]] = f32::NAN;
    write(broken);
    for line in [
        "info a.sample",
        render,
        "factor a.sample --rank 2 -o b.sample",
    ] {
        let error = refused(at, line, 1);
        assert!(
            error.contains("row 3, column 7") && error.contains("NaN"),
            "{error}"
        );
    }
    // Plain blending does not read them; estimating replaces them.
    run(at, &format!("{render} --parallax off"));
    run(at, "heights a.sample --force");
    run(at, &format!("{render} --parallax on"));
}

#[test]
fn parallax_is_refused_where_there_is_none() {
    let folder = prepared("rings:0:1");
    let at = folder.path();
    let render = "render a.sample a.map.ply --size 8x8 -o frames";
    let error = refused(at, &format!("{render} --parallax on"), 2);
    assert!(
        error.contains("--parallax") && error.contains("one view"),
        "{error}"
    );
    let said = run(at, render);
    assert!(
        said.contains("parallax off") && said.contains("one view"),
        "{said}"
    );
    let error = refused(at, "heights a.sample --force", 1);
    assert!(
        error.contains("views") && error.contains("at least 3"),
        "{error}"
    );
    let folder = prepared("rings:0:1,40:4");
    let at = folder.path();
    fs::remove_file(at.join("a.sample/height.npy")).unwrap();
    let error = refused(at, &format!("{render} --parallax on"), 2);
    assert!(error.contains("mesotex heights"), "{error}");
    assert!(run(at, render).contains("no heights"));
}
