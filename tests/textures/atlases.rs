//! Atlases with channels: rendered, and written by synthesis.

use super::*;

#[test]
fn atlases_are_rendered_with_relief_and_holes() {
    let folder = with_channels();
    let camera = "--size 64x64 --force --camera-position 0,0,6";
    let drawn = |atlas: &str, more: &str| {
        run(
            folder.path(),
            &format!("render x.sample {atlas} -o f {camera} {more}"),
        );
        coverage(&folder.path().join("f/frame.0001.exr"))
    };
    let whole = drawn("ball.atlas", "");
    let holed = drawn("relief.atlas", "");
    let raised = drawn("relief.atlas", "--displace 0.5");
    // Through holes of the front those of the back are seen through, here and there.
    assert!(
        holed < 0.95 * whole && holed > 0.3 * whole,
        "{holed} of {whole}"
    );
    assert!(raised > 1.1 * holed, "{raised} after {holed}");
    // Frames of another relief are made anew.
    let kept = |more: &str| {
        let line =
            format!("render x.sample relief.atlas -o f {camera} --skip-existing --json {more}");
        let told: Value = serde_json::from_str(&run(folder.path(), &line)).unwrap();
        told["kept"].as_u64().unwrap()
    };
    assert_eq!([kept("--displace 0.5"), kept("--displace 0.4")], [1, 0]);
    let refused = |line: &str, code| {
        refuse(
            folder.path(),
            &line.split_whitespace().collect::<Vec<_>>(),
            code,
        )
    };
    let line = format!("render x.sample ball.atlas -o g {camera} --displace 0.5");
    assert!(refused(&line, 2).contains("no channel of heights"));
    fs::write(folder.path().join("relief.atlas/holes-png.png"), "damaged").unwrap();
    assert!(refused(&line.replace("ball", "relief"), 1).contains("holes-png.png"));
}

#[test]
fn synthesis_writes_an_atlas_that_everything_reads() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let color = |x: u32, y: u32| {
        Rgb([
            if (x / 4 + y / 4).is_multiple_of(2) {
                220
            } else {
                40
            },
            90,
            8 * x as u8,
        ])
    };
    RgbImage::from_fn(SAMPLE, SAMPLE, color)
        .save(at.join("c.png"))
        .unwrap();
    let height = |x: u32, _| Luma([(16 * x) as u8]);
    GrayImage::from_fn(SAMPLE, SAMPLE, height)
        .save(at.join("height.png"))
        .unwrap();
    let torus = mesotex::mesh::shapes::torus(24, 12, 1.0, 0.4);
    mesotex::mesh::write_mesh(&at.join("torus.obj"), &torus).unwrap();
    run(
        at,
        "exemplar c.png height.png -o x --tile --levels 2 --k 3 --neighborhood 3",
    );
    let synth = "synth x.space.npz x.knn.npz torus.obj --levels 2";
    let onto = "--onto atlas --resolution 64 --unwrap -o t.atlas";
    run(at, &format!("{synth} {onto} --displace 0.05"));
    let map = AtlasMap::read(&at.join("t.atlas")).unwrap();
    assert_eq!(
        (map.width, map.header.exemplar, map.tileable),
        (64, [SAMPLE; 2], true)
    );
    // Each texel shows the sample's texel that its coordinate names.
    let image = read(&at.join("t.atlas/color.png")).unwrap();
    let height = read_with(&at.join("t.atlas/height.png"), &ReadOptions::data())
        .unwrap()
        .image;
    let sample = read(&at.join("c.png")).unwrap();
    for (texel, coord) in map.coords.iter().enumerate() {
        let Some(coord) = coord else { continue };
        let from = map.grid().texel_nearest(*coord);
        let (row, col) = map.grid().row_col(from);
        for channel in 0..3 {
            let (found, wanted) = (
                image.data[3 * texel + channel],
                sample.get(row, col, channel as u32),
            );
            assert!((found - wanted).abs() < 1.5 / 255.0, "{found} {wanted}");
        }
        assert!((height.data[texel] - 16.0 * col as f32 / 255.0).abs() < 1e-3);
    }
    let told: Value = serde_json::from_str(&run(at, "info t.atlas --json")).unwrap();
    assert_eq!(
        (&told["kind"], &told["width"]),
        (&"atlas".into(), &64.into())
    );
    run(
        at,
        "render x.sample t.atlas -o f --size 64x48 --displace 0.05",
    );
    run(at, "transfer t.atlas --maps c.png --finer 2 -o t.textures");
    assert_eq!(read(&at.join("t.textures/c.png")).unwrap().width, 128);
    let refused = |line: &str, code| refuse(at, &line.split_whitespace().collect::<Vec<_>>(), code);
    assert!(refused(&format!("{synth} -o t.atlas"), 2).contains("--onto atlas"));
    assert!(refused(&format!("{synth} -o t.map.ply --displace 1"), 2).contains("--displace"));
    run(
        at,
        "exemplar c.png -o y --tile --levels 2 --k 3 --neighborhood 3",
    );
    let flat = synth.replace("x.", "y.");
    assert!(refused(&format!("{flat} {onto} --displace 1"), 2).contains("no channel is a height"));
    fs::write(at.join("t.atlas/thesis.tex"), "mine").unwrap();
    assert!(refused(&format!("{synth} {onto}"), 2).contains("thesis.tex"));
}
