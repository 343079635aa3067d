//! How pictures look: framing, fill light, the ground, tone.

use super::*;

/// A ball of a Lambertian material.
fn white_ball() -> Bench {
    let spec = SampleSpec {
        size: [2, 2],
        views: fibonacci(9),
        lights: bonn81(),
        dtype: DType::F2,
    };
    Bench::new(
        |path| spec.write(path, lambertian),
        |id| ball(16, [2, 2], id),
    )
}

fn frame(bench: &Bench, output: &str, words: &[&str]) -> Picture {
    let size = ["--size", "80x60"];
    let folder = bench.render(output, &[words, &size].concat());
    read_frame(&folder.join("frame.0001.exr"))
}

#[test]
fn a_ball_fills_the_height_of_its_frames() {
    let bench = white_ball();
    for words in [&[][..], &["--sweep", "view-orbit", "--frames", "1-1"]] {
        let picture = frame(&bench, "filled", words);
        let rows = (0..60).filter(|row| {
            let row = &picture.channels["A"][row * 80..][..80];
            row.iter().any(|&a| a > 0.5)
        });
        assert!((56..=58).contains(&rows.count()), "{words:?}");
    }
    let half = frame(&bench, "half", &["--zoom", "0.5"]);
    let covered: f64 = half.channels["A"].iter().sum();
    let all: f64 = frame(&bench, "whole", &[]).channels["A"].iter().sum();
    assert!((covered / all - 0.25).abs() < 0.01, "{covered} {all}");
}

#[test]
fn the_front_is_said_and_can_be_chosen() {
    let bench = white_ball();
    let said = |words: &[&str]| {
        let run = bench.run("fronts", &[words, &["--size", "16x16"]].concat());
        String::from_utf8_lossy(&run.stdout).into_owned()
    };
    assert!(said(&[]).contains("front: z (the usual side"));
    assert!(said(&["--front", "-x"]).contains("front: -x\n"));
    assert!(bench.refuse(&["--front", "y"], 2).contains("x, z, -x, -z"));
    // A stated position leaves it nothing to decide, unless the camera looks straight down.
    let beside = ["--camera-position", "0,1,5"];
    assert!(!said(&beside).contains("front:"));
    let refused = bench.refuse(&[&beside[..], &["--front", "x"]].concat(), 2);
    assert!(
        refused.contains("--front: given with --camera-position"),
        "{refused}"
    );
    let above = ["--camera-position", "0,5,0", "--camera-target", "0,0,0"];
    let told = said(&[&above[..], &["--front", "x"]].concat());
    assert!(told.contains("front: x\n"), "{told}");
    let header = |words: &[&str]| {
        bench.render("fronts", &[words, &["--size", "16x16"]].concat());
        let path = bench.path("fronts/frame.0001.exr");
        let meta = exr::meta::MetaData::read_from_file(path, true).unwrap();
        meta.headers[0].own_attributes.world_to_camera.unwrap()
    };
    // From −x, the camera's right is +z.
    let level = ["--front", "-x", "--camera-elevation", "0"];
    let matrix = header(&level);
    assert!((matrix[8] - 1.0).abs() < 1e-6, "{matrix:?}");
}

/// A latitude-longitude image of X (1 + ¾ sin e) as Radiance HDR.
fn write_sky(path: &Path, radiance: f64) {
    let (width, height) = (64usize, 32usize);
    let rows = (0..height).flat_map(|row| {
        let elevation = PI * (0.5 - (row as f64 + 0.5) / height as f64);
        let value = (radiance * (1.0 + 0.75 * elevation.sin())) as f32;
        vec![image::Rgb([value; 3]); width]
    });
    let file = fs::File::create(path).unwrap();
    let pixels: Vec<image::Rgb<f32>> = rows.collect();
    image::codecs::hdr::HdrEncoder::new(file)
        .encode(&pixels, width, height)
        .unwrap();
}

#[test]
fn fill_light_is_an_environment_brighter_from_above() {
    let bench = white_ball();
    let (sky, file) = (bench.path("sky.hdr"), bench.path("colors.ply"));
    write_sky(&sky, 0.4);
    let colors = |words: &[&str]| {
        let common = [
            "--shadows",
            "none",
            "--vertex-colors",
            text(&file),
            "--linear-colors",
            "--size",
            "16x16",
        ];
        bench.render("filled", &[words, &common].concat());
        vertex_colors(&file)
    };
    let filled = colors(&["--fill", "0.4", "--irradiance", "0"]);
    let lit = colors(&["--environment", text(&sky), "--environment-lights", "1024"]);
    let map = SurfaceTextonMap::read(&bench.map).unwrap();
    for (vertex, (filled, lit)) in filled.iter().zip(&lit).enumerate() {
        let up = f64::from(map.normals[vertex].y);
        for (channel, albedo) in [0.8, 0.5, 0.2].into_iter().enumerate() {
            let wanted = 0.4 * albedo * (1.0 + 0.5 * up);
            let close = |found: f64| (found - wanted).abs() < 0.03 * wanted;
            assert!(close(filled[channel]), "{up}: {filled:?} {wanted}");
            assert!(close(lit[channel]), "{up}: {lit:?} {wanted}");
        }
    }
    // Beside a light both add up, by vertex and by pixel, and however shadows are found.
    let sum = |words: &[&str]| -> f64 {
        let picture = frame(&bench, "sums", words);
        ["R", "G", "B"]
            .iter()
            .flat_map(|name| &picture.channels[*name])
            .sum()
    };
    for manner in [
        &["--shading", "vertex", "--shadows", "vertex"][..],
        &["--shading", "vertex", "--shadows", "pixel"],
        &["--shading", "pixel", "--shadows", "vertex"],
        &["--shading", "pixel", "--shadows", "none"],
    ] {
        let with = |more: &[&str]| sum(&[manner, more].concat());
        let (both, light) = (with(&["--fill", "0.4"]), with(&[]));
        let fill = with(&["--fill", "0.4", "--irradiance", "0"]);
        assert!(fill > 0.05 * light, "{manner:?}: {fill} {light}");
        assert!((both - light - fill).abs() < 0.01 * both, "{manner:?}");
    }
}

#[test]
fn texture_maps_have_fill_light_too() {
    let bench = white_ball();
    let output = bench.path("baked");
    let inputs = [
        "bake-maps",
        text(&bench.sample),
        text(&bench.map),
        "-o",
        text(&output),
    ];
    let dark = "--unwrap --resolution 64 --irradiance 0 --shadows none --fill 0.4";
    let words: Vec<&str> = inputs.into_iter().chain(dark.split(' ')).collect();
    let run = mesotex(&words);
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let radiance = read_frame(&output.join("radiance.exr")).channels["R"].clone();
    let lit: Vec<f64> = radiance.into_iter().filter(|&r| r > 0.0).collect();
    // 0.4 · 0.8 · (1 ± ½) from below to above.
    let (least, most) = lit
        .iter()
        .fold((1.0, 0.0), |(a, b): (f64, f64), &r| (a.min(r), b.max(r)));
    assert!(
        (0.14..0.18).contains(&least) && (0.45..0.5).contains(&most),
        "{least} {most}"
    );
}

#[test]
fn the_ground_catches_a_shadow_and_leaves_the_surface_alone() {
    let bench = white_ball();
    let words = [
        "--light",
        "sun:90,45",
        "--camera-elevation",
        "30",
        "--zoom",
        "0.4",
    ];
    let plain = frame(&bench, "plain", &words);
    let ground = frame(&bench, "ground", &[&words[..], &["--ground"]].concat());
    let at = |picture: &Picture, name: &str, pixel: usize| picture.channels[name][pixel];
    let mut places = Vec::new();
    for pixel in 0..80 * 60 {
        let (before, after) = (at(&plain, "A", pixel), at(&ground, "A", pixel));
        assert!(after >= before && after <= 1.0);
        for name in ["R", "G", "B"] {
            assert_eq!(at(&plain, name, pixel), at(&ground, name, pixel));
        }
        if before == 0.0 && after > 0.0 {
            assert_eq!(at(&ground, "N.Y", pixel), 1.0);
            assert_eq!(at(&ground, "texton.I", pixel), 65535.0);
            assert!(at(&ground, "Z", pixel).is_finite());
            places.push(pixel % 80);
        }
        if after == 0.0 {
            assert_eq!(at(&ground, "Z", pixel), f64::INFINITY);
        }
    }
    // The light comes from the right, so the shadow lies on the left.
    let left = places.iter().filter(|&&column| column < 40).count();
    assert!(
        places.len() > 60 && left > places.len() * 3 / 4,
        "{left} {}",
        places.len()
    );
    // Fill light brightens the shadow, but not below the ball.
    let filled = frame(
        &bench,
        "filled",
        &[&words[..], &["--ground", "--fill", "0.5"]].concat(),
    );
    let darkest = |picture: &Picture| {
        let bare = (0..80 * 60).filter(|&pixel| at(&plain, "A", pixel) == 0.0);
        bare.map(|pixel| at(picture, "A", pixel))
            .fold(0.0, f64::max)
    };
    assert!(darkest(&ground) > 0.99 && (0.4..0.95).contains(&darkest(&filled)));
    // From below there is no ground; without shadows nothing would be seen of it.
    let below = ["--ground", "--camera-elevation", "-30"];
    let bare = frame(&bench, "below", &below[1..]);
    assert_eq!(frame(&bench, "below", &below).channels, bare.channels);
    let error = bench.refuse(&["--ground", "--shadows", "none"], 2);
    assert!(error.contains("--ground"), "{error}");
}

#[test]
fn tone_and_background_are_the_previews_alone() {
    let bench = white_ball();
    let light = ["--light", "sun:0,20,9"];
    let made = |name: &str, words: &[&str]| {
        let picture = frame(&bench, name, &[&light[..], words].concat());
        let preview = image::open(bench.path(name).join("frame.0001.png")).unwrap();
        (picture.channels, preview.into_rgb8())
    };
    let (soft, shown_soft) = made("soft", &[]);
    let (clip, shown_clip) = made("clip", &["--tone", "clip", "--background", "#ff8000"]);
    assert_eq!(soft, clip);
    let middle = [40, 30];
    let red = |picture: &image::RgbImage| picture.get_pixel(middle[0], middle[1])[0];
    assert!(soft["R"][30 * 80 + 40] > 1.5);
    assert_eq!(red(&shown_clip), 255);
    assert!(
        (240..255).contains(&red(&shown_soft)),
        "{}",
        red(&shown_soft)
    );
    assert_eq!(shown_clip.get_pixel(0, 0).0, [255, 128, 0]);
    let error = bench.refuse(&["--background", "white"], 2);
    assert!(error.contains("a grey from 0 to 1"), "{error}");
}
