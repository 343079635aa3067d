//! `--surface-color`: a plain colour where a surface has holes.

use super::*;

/// The mean of a channel of a frame over the pixels that the surface covers.
fn mean_of(frame: &Path, channel: &str) -> f32 {
    let options = ReadOptions {
        layer: Some(channel.into()),
        ..ReadOptions::data()
    };
    let values = read_with(frame, &options).unwrap().image.data;
    values.iter().sum::<f32>() / values.len() as f32 / coverage(frame)
}

#[test]
fn a_plain_colour_shows_in_place_of_holes() {
    let folder = with_channels();
    let at = |name: &str| folder.path().join(name);
    let green = "--surface-color 0,255,0";
    // In the model: opaque, red over green where the image is transparent.
    RgbImage::from_pixel(SAMPLE, SAMPLE, Rgb([255, 0, 0]))
        .save(at("red.png"))
        .unwrap();
    run(
        folder.path(),
        &format!("transfer ball.atlas --maps color:red.png alpha:holes.png -o g {green}"),
    );
    let model = fs::read(at("g/surface.glb")).unwrap();
    let text = String::from_utf8_lossy(&model[..4000]).into_owned();
    assert!(
        !text.contains("alphaMode") && !text.contains("doubleSided"),
        "{text}"
    );
    let image = embedded_png(&model);
    let holes = read_with(&at("g/holes.png"), &ReadOptions::data())
        .unwrap()
        .image;
    let map = AtlasMap::read(&at("ball.atlas")).unwrap();
    for texel in (0..map.len()).filter(|texel| map.chart[*texel] >= 0) {
        let [red, share] = [decode_srgb(image.data[3 * texel]), holes.data[texel]];
        assert!((red - share).abs() < 0.01, "{red} {share}");
        assert!((decode_srgb(image.data[3 * texel + 1]) - (1.0 - share)).abs() < 0.01);
    }
    // In frames, with every way of shading: the whole ball is there, and greener.
    let camera =
        "--size 48x48 --force --camera-position 0,0,6 --light-azimuth 0 --light-elevation 0";
    for shading in [
        "--shading vertex",
        "--shading pixel",
        "--shading vertex --shadows pixel",
    ] {
        let drawn = |atlas: &str, more: &str| {
            let line = format!("render x.sample {atlas} -o f {camera} {shading} {more}");
            run(folder.path(), &line);
            let frame = at("f/frame.0001.exr");
            (
                coverage(&frame),
                ["R", "G", "B"].map(|name| mean_of(&frame, name)),
            )
        };
        let (whole, plain) = drawn("ball.atlas", "");
        let (covered, mixed) = drawn("relief.atlas", green);
        assert!((covered - whole).abs() < 1e-3, "{covered} of {whole}");
        // About half of the sample is transparent there: blue is halved, and green comes near that of a matte ball.
        assert!(
            (mixed[2] / plain[2] - 0.5).abs() < 0.1,
            "{mixed:?} {plain:?}"
        );
        assert!(mixed[1] > plain[1], "{mixed:?} {plain:?}");
    }
    // Frames of another colour are made anew.
    let kept = |color: &str| {
        let line = format!("render x.sample relief.atlas -o f {camera} --skip-existing --json");
        let line = format!("{line} --shading vertex --shadows pixel --surface-color {color}");
        let told: Value = serde_json::from_str(&run(folder.path(), &line)).unwrap();
        told["kept"].as_u64().unwrap()
    };
    assert_eq!([kept("#00ff00"), kept("#00fe00")], [1, 0]);
}

#[test]
fn a_plain_colour_that_nothing_shows_is_refused() {
    let folder = with_channels();
    GrayImage::from_pixel(SAMPLE, SAMPLE, Luma([255]))
        .save(folder.path().join("white.png"))
        .unwrap();
    let refused = |line: &str| {
        refuse(
            folder.path(),
            &line.split_whitespace().collect::<Vec<_>>(),
            2,
        )
    };
    let blue = "--surface-color 0,0,255";
    for (line, says) in [
        (
            "transfer ball.atlas --maps color.png -o o",
            "no channel is alpha",
        ),
        (
            "transfer ball.atlas --maps color.png alpha:white.png -o o",
            "channel `white` is 1 at every texel",
        ),
        (
            "transfer ball.atlas --maps alpha:holes.png -o o --transparency blend",
            "beside --transparency blend",
        ),
        ("render x.sample ball.atlas -o o", "has no channel of alpha"),
        (
            "render x.sample ball.map.ply -o o",
            "given for ball.map.ply",
        ),
        (
            "bake-maps x.sample ball.atlas -o o",
            "has no channel of alpha",
        ),
        (
            "bake-maps x.sample ball.map.ply --unwrap -o o",
            "given for ball.map.ply",
        ),
        (
            "transfer ball.map.ply --maps color.png -o o.ply",
            "given for ball.map.ply",
        ),
    ] {
        let said = refused(&format!("{line} {blue}"));
        assert!(
            said.contains("surface-color") && said.contains(says),
            "{line}: {said}"
        );
    }
    let said = refused("render x.sample relief.atlas -o o --surface-color 0.1,0.5,0.2");
    assert!(said.contains("0 to 255"), "{said}");
}
