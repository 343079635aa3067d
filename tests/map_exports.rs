//! Maps as meshes that other programs read: counts, coordinates and colours in each format.

mod program;

use std::fs;
use std::path::Path;

use mesotex::btf::{Direction, Sample};
use mesotex::format::ply;
use mesotex::maps::SurfaceTextonMap;
use mesotex::render::blended_image;
use program::{refuse, succeed};
use serde_json::Value;

const EXPORT: &str = "export grid.map.ply --sample weave.sample --view 20,40 --light 35,120";

fn run(folder: &Path, line: &str) -> String {
    succeed(folder, &line.split(' ').collect::<Vec<_>>())
}

/// A folder with a sample and a map on a grid of 14 × 10 vertices.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    run(
        at,
        "bake --preset weave --size 16 --samples 1 --views 12x5 --lights 12x5 -o weave.sample",
    );
    run(
        at,
        "textons weave.sample -o weave.textons.npz --textons 8 --levels 1",
    );
    run(at, "gram weave.textons.npz -o weave.space.npz");
    run(at, "knn weave.space.npz -o weave.knn.npz --k 3");
    run(
        at,
        "synth weave.space.npz weave.knn.npz --grid 14x10 -o grid.map.ply",
    );
    folder
}

/// The linear colours that the vertices should have.
fn expected(folder: &Path) -> (SurfaceTextonMap, Vec<[f32; 3]>) {
    let map = SurfaceTextonMap::read(&folder.join("grid.map.ply")).unwrap();
    let sample = Sample::open(&folder.join("weave.sample")).unwrap();
    let angles =
        |theta: f64, phi: f64| Direction::from_angles(theta.to_radians(), phi.to_radians());
    let image = blended_image(&sample, angles(20.0, 40.0), angles(35.0, 120.0)).unwrap();
    let colors = map.coords.iter().map(|at| {
        let (row, col) = ((16.0 - at.t) as usize, at.s as usize);
        [0, 1, 2].map(|c| {
            (image[(row * 16 + col) * 3 + c] / std::f32::consts::FRAC_1_PI).clamp(0.0, 1.0)
        })
    });
    let colors = colors.collect();
    (map, colors)
}

fn encoded(linear: f32) -> f32 {
    let curve = match linear <= 0.003_130_8 {
        true => 12.92 * linear,
        false => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
    };
    (curve * 255.0).round() / 255.0
}

#[test]
fn a_glb_has_coordinates_tangents_labels_and_linear_colors() {
    let folder = prepared();
    run(folder.path(), &format!("{EXPORT} --to glb -o grid.glb"));
    let bytes = fs::read(folder.path().join("grid.glb")).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let text: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let binary = &bytes[20 + length + 8..];
    let primitive = &text["meshes"][0]["primitives"][0];
    let floats = |name: &str| -> Vec<f32> {
        let accessor = &text["accessors"][primitive["attributes"][name].as_u64().unwrap() as usize];
        let view = &text["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        let end = start + view["byteLength"].as_u64().unwrap() as usize;
        let (words, _) = binary[start..end].as_chunks::<4>();
        words.iter().map(|word| f32::from_le_bytes(*word)).collect()
    };
    let (map, colors) = expected(folder.path());
    assert_eq!(floats("POSITION").len(), 3 * 140);
    assert_eq!(floats("COLOR_0"), colors.as_flattened());
    let uvs = floats("TEXCOORD_0");
    for (uv, at) in uvs.chunks(2).zip(&map.coords) {
        assert_eq!(uv, [at.s / 16.0, at.t / 16.0]);
    }
    let labels: Vec<f32> = map.textons.iter().map(|label| f32::from(label.0)).collect();
    assert_eq!(floats("_TEXTON"), labels);
    for (tangent, s) in floats("TANGENT").chunks(4).zip(&map.orientations) {
        assert_eq!(tangent, [s.x, s.y, s.z, 1.0]);
    }
}

#[test]
fn an_obj_and_a_ply_have_the_same_mesh_and_srgb_colors() {
    let folder = prepared();
    let at = folder.path();
    run(at, &format!("{EXPORT} --to obj -o grid.obj"));
    run(at, &format!("{EXPORT} --to ply -o grid.ply"));
    let (map, colors) = expected(at);
    let text = fs::read_to_string(at.join("grid.obj")).unwrap();
    let rows = |kind: &str| -> Vec<Vec<f32>> {
        let lines = text.lines().filter_map(|line| line.strip_prefix(kind));
        lines
            .map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect())
            .collect()
    };
    let (vertices, uvs) = (rows("v "), rows("vt "));
    assert_eq!(
        (vertices.len(), uvs.len(), rows("vn ").len()),
        (140, 140, 140)
    );
    assert_eq!(
        text.lines().filter(|line| line.starts_with("f ")).count(),
        map.mesh.triangles.len()
    );
    let file = ply::read(&at.join("grid.ply")).unwrap();
    for (vertex, color) in colors.iter().enumerate() {
        for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
            let wanted = encoded(color[channel]);
            assert!(
                (vertices[vertex][3 + channel] - wanted).abs() < 1e-6,
                "{vertex}"
            );
            assert_eq!(
                file.column(name).unwrap()[vertex],
                f64::from((wanted * 255.0).round())
            );
        }
        assert_eq!(
            file.column("s").unwrap()[vertex],
            f64::from(map.coords[vertex].s / 16.0)
        );
        assert_eq!(uvs[vertex][1], map.coords[vertex].t / 16.0);
        assert_eq!(
            file.column("texton").unwrap()[vertex],
            f64::from(map.textons[vertex].0)
        );
    }
}

#[test]
fn rendered_vertex_colors_are_srgb_bytes_and_linear_floats_on_request() {
    let folder = prepared();
    let at = folder.path();
    let render = "render weave.sample grid.map.ply --size 32x24 --light sun:20,50";
    let bright = run(
        at,
        &format!("{render} -o a --irradiance 9 --vertex-colors both.ply --linear-colors"),
    );
    run(
        at,
        &format!("{render} -o b --irradiance 9 --vertex-colors bytes.ply"),
    );
    let [both, bytes] = ["both.ply", "bytes.ply"].map(|name| ply::read(&at.join(name)).unwrap());
    assert_eq!(both.vertex_count, 140);
    let mut clipped = 0;
    for (linear, name) in [("r", "red"), ("g", "green"), ("b", "blue")] {
        assert!(bytes.column(linear).is_none());
        assert_eq!(both.column(name), bytes.column(name));
        let (found, shown) = (both.require(linear).unwrap(), both.require(name).unwrap());
        for (&found, &shown) in found.iter().zip(shown) {
            let wanted = encoded(found.clamp(0.0, 1.0) as f32);
            assert_eq!(shown, f64::from((wanted * 255.0).round()));
            clipped += usize::from(found > 1.0);
        }
    }
    assert!(clipped > 0);
    let said = format!("{clipped} colour values are brighter than white");
    assert!(bright.contains(&said), "{bright}");
    let refused = "render weave.sample grid.map.ply -o c --linear-colors";
    let said = refuse(at, &refused.split(' ').collect::<Vec<_>>(), 2);
    assert!(said.contains("--vertex-colors"), "{said}");
}

#[test]
fn usd_text_has_all_primvars_and_no_colors_without_a_sample() {
    let folder = prepared();
    let at = folder.path();
    run(at, "export grid.map.ply --to usda -o plain.usda");
    run(at, &format!("{EXPORT} --to usda -o lit.usda"));
    let [plain, lit] =
        ["plain.usda", "lit.usda"].map(|name| fs::read_to_string(at.join(name)).unwrap());
    for name in [
        "point3f[] points",
        "primvars:st",
        "primvars:texton",
        "primvars:orientation",
    ] {
        assert!(plain.contains(name), "{name}");
    }
    assert!(plain.starts_with("#usda 1.0\n") && !plain.contains("displayColor"));
    let line = lit
        .lines()
        .position(|line| line.contains("displayColor"))
        .unwrap();
    let colors: String = lit
        .lines()
        .skip(line)
        .take_while(|line| !line.contains("xformOp"))
        .collect();
    assert_eq!(
        colors.matches('(').count(),
        140 + 1,
        "a tuple per vertex and the interpolation"
    );
}

#[test]
fn exports_that_cannot_be_are_refused() {
    let folder = prepared();
    for (line, code, says) in [
        ("export weave.sample --to glb -o a.glb", 1, "a BTF sample"),
        (
            "export grid.map.ply --to ptm -o a.ptm",
            1,
            "a surface texton map",
        ),
        ("export grid.map.ply --to glb -o a.ply", 2, "ends in .ply"),
        (
            "export grid.map.ply --to glb -o a.glb --light 30,0",
            2,
            "--sample as well",
        ),
        (
            "export grid.map.ply --to glb -o a.glb --sample weave.sample --view 10,x,20",
            2,
            "THETA,PHI",
        ),
        (
            "export weave.sample --to bdi -o a.btf --sample weave.sample",
            2,
            "not a mesh",
        ),
        (
            "export grid.map.ply --to glb -o a.glb --sample weave.sample --view 95,0",
            2,
            "0 to 90",
        ),
    ] {
        let said = refuse(folder.path(), &line.split(' ').collect::<Vec<_>>(), code);
        assert!(said.contains(says), "{line}: {said}");
    }
    run(
        folder.path(),
        "bake --preset weave --size 16 --samples 1 --views rings:0:1 --lights rings:0:1 -o b.sample",
    );
    let line = "export grid.map.ply --to glb -o a.glb --sample b.sample";
    let said = refuse(folder.path(), &line.split(' ').collect::<Vec<_>>(), 1);
    assert!(
        said.contains("the sample that the map was made from"),
        "{said}"
    );
}
