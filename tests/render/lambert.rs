//! What comes back through the whole renderer: Lambert's law, the values of sampled directions, and which side of a
//! relief is lit.

use super::*;

#[test]
fn a_lambertian_ball_is_lambertian() {
    let spec = SampleSpec {
        size: [1, 1],
        views: bonn81(),
        lights: bonn81(),
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, lambertian),
        |id| ball(40, [1, 1], id),
    );
    let map = SurfaceTextonMap::read(&bench.map).unwrap();
    for (azimuth, elevation) in [(0.0f64, 5.0f64), (60.0, 30.0), (200.0, 62.0)] {
        let file = bench.path("colors.ply");
        let sun = format!("sun:{azimuth},{elevation}");
        let words = [
            "--irradiance",
            "1",
            "--size",
            "16x16",
            "--camera-elevation",
            "0",
            "--light",
            &sun,
            "--shadows",
            "none",
            "--linear-colors",
            "--vertex-colors",
            text(&file),
        ];
        bench.render("frames", &words);
        let (a, e) = (azimuth.to_radians(), elevation.to_radians());
        let light = DVec3::new(a.sin() * e.cos(), e.sin(), a.cos() * e.cos());
        for (vertex, found) in vertex_colors(&file).into_iter().enumerate() {
            let cos = map.normals[vertex].as_dvec3().dot(light).max(0.0);
            for (found, albedo) in found.into_iter().zip([0.8, 0.5, 0.2]) {
                let wanted = albedo * cos / PI;
                assert!(
                    (found - wanted).abs() < 0.01 * albedo / PI,
                    "{sun}, vertex {vertex}: {found} {wanted}"
                );
            }
        }
    }
}

#[test]
fn a_flat_square_shows_each_measured_light() {
    // A single texel seen from straight above, under every light of a measurement in turn.
    let mut directions = vec![Direction::from_angles(0.0, 0.0)];
    directions.extend(fibonacci(40));
    let spec = SampleSpec {
        size: [1, 1],
        views: directions.clone(),
        lights: directions.clone(),
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, hashed),
        |id| square(1, [1, 1], 1.0, id),
    );
    let mut table = "light_azimuth,light_elevation\n".to_string();
    for light in &directions {
        // Azimuth 0 is where the first camera stands: in front of it, at −y, when it looks down.
        let azimuth = light.0.y.atan2(light.0.x).to_degrees() + 90.0;
        table += &format!("{azimuth},{}\n", light.0.z.asin().to_degrees());
    }
    let path = bench.path("lights.csv");
    fs::write(&path, table).unwrap();
    let words = [
        "--irradiance",
        "1",
        "--up",
        "z",
        "--projection",
        "orthographic",
        "--camera-elevation",
        "90",
        "--size",
        "8x8",
        "--sweep",
        text(&path),
        "--float",
    ];
    let folder = bench.render("frames", &words);
    let sample = Sample::open(&bench.sample).unwrap();
    for light in 0..directions.len() {
        let frame = read_frame(&folder.join(format!("frame.{:04}.exr", light + 1)));
        for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
            let stored = f64::from(sample.image(light).unwrap().get(channel));
            let found = frame.channels[name][4 * 8 + 4];
            assert!(
                (found - stored).abs() < 1e-3 * stored,
                "light {light}: {found} {stored}"
            );
        }
    }
}

#[test]
fn the_inside_of_an_open_surface_has_the_light_of_its_own_side() {
    let spec = SampleSpec {
        size: [1, 1],
        views: bonn81(),
        lights: bonn81(),
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, lambertian),
        |id| square(3, [1, 1], 1.0, id),
    );
    for (shading, shadows) in ["vertex", "pixel"]
        .into_iter()
        .flat_map(|shading| ["none", "vertex", "pixel"].map(|shadows| (shading, shadows)))
    {
        // The square lies in the plane of x and y and is seen from below.
        let center = |light: f64| {
            let sun = format!("sun:0,{light}");
            let words = [
                "--irradiance",
                "1",
                "--up",
                "z",
                "--projection",
                "orthographic",
                "--camera-elevation",
                "-90",
                "--size",
                "8x8",
                "--light",
                &sun,
                "--shading",
                shading,
                "--shadows",
                shadows,
                "--float",
            ];
            let folder = bench.render(&format!("{shading}-{shadows}{light}"), &words);
            let frame = read_frame(&folder.join("frame.0001.exr"));
            frame.channels["R"][4 * 8 + 4]
        };
        let cosine = 60.0f64.to_radians().sin();
        let (below, above) = (center(-60.0), center(60.0));
        assert!(
            (below - 0.8 * cosine / PI).abs() < 0.005,
            "{shading}, {shadows}: {below}"
        );
        assert!(above.abs() < 1e-6, "{shading}, {shadows}: {above}");
    }
}

#[test]
fn relief_is_lit_from_the_lights_side() {
    // A facing slope to the sample's right is bright when the light comes from the right.
    let spec = SampleSpec {
        size: [16, 16],
        views: fibonacci(6),
        lights: fibonacci(40),
        dtype: DType::F2,
    };
    let tilted = |_: &Direction, light: &Direction, _: u32, col: u32| {
        let slope = if col < 8 { -0.6f64 } else { 0.6 };
        let normal = DVec3::new(slope, 0.0, 1.0).normalize();
        [normal.dot(light.0).max(0.0) / PI; 3]
    };
    let bench = Bench::new(
        |path| spec.write(path, tilted),
        |id| square(16, [16, 16], 1.0 / 16.0, id),
    );
    for (azimuth, right_is_brighter) in [("50", true), ("-50", false)] {
        // The camera looks from +z with y up: azimuth 50, counter-clockwise from above, is on the right.
        let light = format!("sun:{azimuth},40");
        let words = [
            "--size",
            "64x64",
            "--camera-elevation",
            "0",
            "--light",
            &light,
        ];
        let frame = read_frame(&bench.render("frames", &words).join("frame.0001.exr"));
        let (mut left, mut right) = (0.0, 0.0);
        for pixel in (0..64 * 64).filter(|&pixel| frame.channels["A"][pixel] == 1.0) {
            let side = if frame.channels["uv.U"][pixel] < 0.5 {
                &mut left
            } else {
                &mut right
            };
            *side += frame.channels["G"][pixel];
        }
        assert_eq!(
            right > 1.3 * left,
            right_is_brighter,
            "{azimuth}: {left} {right}"
        );
        assert_eq!(left > 1.3 * right, !right_is_brighter);
    }
}
