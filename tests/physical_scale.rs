//! `synth --mesh-unit`: the size of a sample's texels meets the unit of a mesh.

mod program;

use std::fs;
use std::path::Path;

use mesotex::btf::Sample;
use mesotex::exemplar::Space;
use mesotex::maps::SurfaceTextonMap;
use program::{refuse, succeed, write_obj};

const SYNTH: &str = "synth weave.space.npz weave.knn.npz m.obj -o m.map.ply --levels 1";

fn words(line: &str) -> Vec<&str> {
    line.split(' ').collect()
}

fn run(folder: &Path, line: &str) -> String {
    succeed(folder, &words(line))
}

/// A folder with an exemplar and a mesh 3 units high of about 4,000 vertices.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let few = "--views fibonacci:5 --lights fibonacci:5 --samples 1";
    run(
        at,
        &format!("bake --preset weave --size 16 {few} -o weave.sample"),
    );
    run(
        at,
        "textons weave.sample -o weave.textons.npz --textons 12 --levels 1",
    );
    run(at, "gram weave.textons.npz -o weave.space.npz");
    run(at, "knn weave.space.npz -o weave.knn.npz --k 3");
    write_obj(&at.join("m.obj"), 4000);
    folder
}

#[test]
fn a_texel_has_the_size_that_the_sample_says() {
    let folder = prepared();
    let at = folder.path();
    let sample = Sample::open(&at.join("weave.sample")).unwrap();
    let size = sample.description().texel_mm.unwrap();
    let space = Space::read(&at.join("weave.space.npz")).unwrap();
    assert_eq!(space.texel_mm, Some(size));
    for (unit, millimetres) in [("cm", 10.0), ("in", 25.4)] {
        let said = run(at, &format!("{SYNTH} --mesh-unit {unit}"));
        let map = SurfaceTextonMap::read(&at.join("m.map.ply")).unwrap();
        let expected = size / millimetres;
        assert!((map.header.texel / expected - 1.0).abs() < 1e-6, "{unit}");
        assert!(
            said.contains(&format!("a texel of {size} mm covers")),
            "{said}"
        );
    }
    let faces = "synth weave.space.npz m.obj -o m.faces.ply --method choosy --mesh-unit cm";
    let said = run(at, faces);
    assert!(said.contains("mesh units (cm)"), "{said}");
}

#[test]
fn sizes_that_cannot_be_are_refused_with_the_number_to_type() {
    let folder = prepared();
    let at = folder.path();
    let refused = |more: &str, parts: &[&str]| {
        let said = refuse(at, &words(&format!("{SYNTH} {more}")), 2);
        for part in parts {
            assert!(said.contains(part), "{more}: {said}");
        }
    };
    // Texels of half a millimetre on a mesh of 3 m, then on one of 3 hundredths of a millimetre.
    refused(
        "--mesh-unit m",
        &[
            "--mesh-unit: m, in which a texel of 0.5 mm is 0.0005",
            "--texel",
        ],
    );
    refused(
        "--texel 1e-7",
        &["texels, which need as many vertices", "--texel"],
    );
    let text = fs::read_to_string(at.join("m.obj")).unwrap();
    let shrunk = text.lines().map(|line| match line.strip_prefix("v ") {
        Some(rest) => {
            let numbers = rest
                .split(' ')
                .map(|word| word.parse::<f64>().unwrap() / 100.0);
            let words: Vec<String> = numbers.map(|number| number.to_string()).collect();
            format!("v {}\n", words.join(" "))
        }
        None => format!("{line}\n"),
    });
    fs::write(at.join("m.obj"), shrunk.collect::<String>()).unwrap();
    refused(
        "--mesh-unit mm",
        &[
            "--mesh-unit: mm, in which a texel of",
            "the diagonal of the mesh's box",
            "--texel",
        ],
    );
    refused("--mesh-unit cm --texel 0.1", &["--texel"]);
    refused("--mesh-unit ft", &["mm", "cm", "in"]);
    let grid = "synth weave.space.npz weave.knn.npz --grid 16x16 -o m.map.ply --mesh-unit cm";
    assert!(refuse(at, &words(grid), 2).contains("--mesh-unit"));
    let mut space = Space::read(&at.join("weave.space.npz")).unwrap();
    space.texel_mm = None;
    space.write(&at.join("weave.space.npz"), None).unwrap();
    refused(
        "--force --mesh-unit cm",
        &["the space does not state the size of a texel", "--texel X"],
    );
}
