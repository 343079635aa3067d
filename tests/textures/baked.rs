//! `transfer` and `bake-maps` onto the vertices of a map, and onto another mesh.

use super::*;

/// `flat.map.ply` of a grey exemplar of constant colour, 188 of 255, and its sample `x.sample`.
fn flat() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    RgbImage::from_pixel(16, 16, Rgb([188, 188, 0]))
        .save(at("c.png"))
        .unwrap();
    RgbImage::from_fn(16, 16, |x, _| Rgb([16 * x as u8, 0, 0]))
        .save(at("ramp.png"))
        .unwrap();
    GrayImage::from_fn(16, 16, |_, y| Luma([17 * y as u8]))
        .save(at("rough.png"))
        .unwrap();
    run(
        folder.path(),
        "exemplar c.png -o x --tile --levels 2 --k 2 --neighborhood 3",
    );
    run(
        folder.path(),
        "synth x.space.npz x.knn.npz --grid 12x12 -o flat.map.ply --levels 2",
    );
    folder
}

#[test]
fn vertices_take_the_maps_at_their_texels() {
    let folder = flat();
    run(
        folder.path(),
        "transfer flat.map.ply --maps ramp.png mask:rough.png -o out.ply",
    );
    let map = mesotex::maps::SurfaceTextonMap::read(&folder.path().join("flat.map.ply")).unwrap();
    let out = mesotex::format::ply::read(&folder.path().join("out.ply")).unwrap();
    let column = |name: &str| out.column(name).unwrap();
    for (vertex, coord) in map.coords.iter().enumerate() {
        assert_eq!(
            column("red")[vertex],
            f64::from(16 * coord.s.floor() as u32)
        );
        assert_eq!(
            (column("green")[vertex], column("blue")[vertex]),
            (0.0, 0.0)
        );
        let row = 15.0 - (coord.t - 0.5);
        assert!((column("rough")[vertex] - f64::from(17.0 * row / 255.0)).abs() < 1e-5);
    }
    assert_eq!(out.faces.iter().count(), map.mesh.triangles.len());
}

#[test]
fn a_lambertian_plane_is_baked_as_bright_as_it_is_lit() {
    let folder = flat();
    let linear = decode_srgb(188.0 / 255.0);
    // The plane faces +z, where camera and light stand at elevation 0.
    for (elevation, cosine) in [(0.0, 1.0), (60.0, 0.5)] {
        run(
            folder.path(),
            &format!(
                "bake-maps x.sample flat.map.ply --unwrap -o baked --resolution 32 --camera-elevation 0 \
                 --light-azimuth 0 --light-elevation {elevation}"
            ),
        );
        let options = ReadOptions::data();
        let radiance = folder.path().join("baked/radiance.exr");
        let radiance = read_with(&radiance, &options).unwrap().image;
        for texel in radiance.data.chunks_exact(3) {
            assert!((texel[0] - cosine * linear).abs() < 2e-3, "{texel:?}");
            assert!(texel[2].abs() < 1e-6);
        }
        let color = read(&folder.path().join("baked/color.png")).unwrap();
        assert!(
            color
                .data
                .chunks_exact(3)
                .all(|c| (decode_srgb(c[0]) - cosine * linear).abs() < 6e-3)
        );
    }
    let bytes = fs::read(folder.path().join("baked/surface.glb")).unwrap();
    assert!(String::from_utf8_lossy(&bytes[..3000]).contains("KHR_materials_unlit"));
}

#[test]
fn another_mesh_of_the_same_surface_takes_the_bake() {
    let folder = flat();
    let map = mesotex::maps::SurfaceTextonMap::read(&folder.path().join("flat.map.ply")).unwrap();
    let (low, high) = map.mesh.bounds();
    let quad = |shift: f32, uv: f32| {
        let mut text = String::new();
        for (x, y) in [
            (low.x, low.y),
            (high.x, low.y),
            (high.x, high.y),
            (low.x, high.y),
        ] {
            text += &format!("v {x} {y} {shift}\n");
        }
        text + &format!("vt 0 0\nvt {uv} 0\nvt {uv} 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n")
    };
    fs::write(folder.path().join("quad.obj"), quad(0.0, 1.0)).unwrap();
    fs::write(folder.path().join("far.obj"), quad(high.x, 1.0)).unwrap();
    fs::write(folder.path().join("wide.obj"), quad(0.0, 1.5)).unwrap();
    let line = |mesh: &str| {
        format!(
            "bake-maps x.sample flat.map.ply --mesh {mesh} -o baked --resolution 16 --camera-elevation 0"
        )
    };
    run(folder.path(), &line("quad.obj"));
    let color = read(&folder.path().join("baked/color.png")).unwrap();
    assert!(
        color
            .data
            .chunks_exact(3)
            .all(|c| c[0] > 0.3 && c[2] == 0.0)
    );
    let refused = |line: &str, code| {
        refuse(
            folder.path(),
            &line.split_whitespace().collect::<Vec<_>>(),
            code,
        )
    };
    assert!(refused(&line("far.obj"), 1).contains("from the map's surface"));
    assert!(refused(&line("wide.obj"), 1).contains("wide.obj"));
    let bare = "bake-maps x.sample flat.map.ply -o b";
    assert!(refused(bare, 2).contains("--unwrap"));
    assert!(refused(&format!("{bare} --unwrap --resolution 8"), 2).contains("--resolution"));
    assert!(refused(&format!("{bare} --unwrap --frames 3"), 2).contains("--frames"));
    let output = mesotex(folder.path(), &["bake-maps", "--help"]);
    let help = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        help.contains("--light-azimuth") && !help.contains("--sweep "),
        "{help}"
    );
}
