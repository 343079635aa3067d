//! What pixels show between vertices: edges of shadows, and the sample between its texels.

use super::*;

/// Straight down on the square of side 1 round the origin.
const FROM_ABOVE: &str = "--irradiance 1 --projection orthographic --up z --camera-position 0,0,5 --camera-target 0,0,0 \
                          --view-height 1 --light sun:20,45 --shadows pixel --layers rgba --float";
/// Half the side of a square above it, how it is turned, and its height.
const HALF_SIDE: f32 = 0.12;
const TURN: f32 = 0.3;
const HEIGHT: f32 = 0.25;

/// A square that throws a shadow on a larger one; both have one colour.
fn two_squares() -> Bench {
    let spec = SampleSpec {
        size: [1, 1],
        views: bonn81(),
        lights: bonn81(),
        dtype: DType::F4,
    };
    let map = |id: ContentId| {
        let mut mesh = square(4, [1, 1], 1.0, id.clone()).mesh;
        let first = mesh.positions.len() as u32;
        for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            let (sin, cos) = f32::sin_cos(TURN);
            let corner = HALF_SIDE * Vec3::new(x * cos - y * sin, x * sin + y * cos, 0.0);
            mesh.positions.push(corner + HEIGHT * Vec3::Z);
        }
        mesh.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|corner| first + corner)));
        let normals = vec![Vec3::Z; mesh.positions.len()];
        map_over(mesh, normals, [1, 1], 1.0, id, |_| TexCoord {
            s: 0.5,
            t: 0.5,
        })
    };
    Bench::new(|path| spec.write(path, lambertian), map)
}

/// Per pixel the share of the light that is missing.
fn shade(bench: &Bench, size: usize, more: &str) -> Vec<f64> {
    let size = format!("{size}x{size}");
    let words: Vec<&str> = FROM_ABOVE
        .split_whitespace()
        .chain(["--size", &size])
        .collect();
    let words = [words, more.split_whitespace().collect()].concat();
    let frame = read_frame(&bench.render("frames", &words).join("frame.0001.exr"));
    let lit = 0.8 * 0.5f64.sqrt() / PI;
    let missing = |value: &f64| 1.0 - value / lit;
    frame.channels["R"].iter().map(missing).collect()
}

/// The largest and the mean difference.
fn differences(a: &[f64], b: &[f64]) -> [f64; 2] {
    let all: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect();
    [
        all.iter().copied().fold(0.0, f64::max),
        all.iter().sum::<f64>() / all.len() as f64,
    ]
}

#[test]
fn edges_of_shadows_are_as_smooth_as_outlines() {
    let (bench, size, finer) = (two_squares(), 24, 8);
    for shading in ["vertex", "pixel"] {
        let fine = shade(
            &bench,
            size * finer,
            &format!("--shading {shading} --samples 1"),
        );
        let area = fine.iter().sum::<f64>() / fine.len() as f64;
        let wanted = f64::from(4.0 * HALF_SIDE * HALF_SIDE);
        assert!((area - wanted).abs() < 0.002, "{area} {wanted}");
        let mean = |pixel: usize| {
            let (row, column) = (pixel / size * finer, pixel % size * finer);
            let inside = (0..finer * finer)
                .map(|k| fine[(row + k / finer) * size * finer + column + k % finer]);
            inside.sum::<f64>() / (finer * finer) as f64
        };
        let wanted: Vec<f64> = (0..size * size).map(mean).collect();
        let edge = wanted
            .iter()
            .filter(|&&share| share > 0.1 && share < 0.9)
            .count();
        assert!(edge > 10, "{edge}");
        for (samples, most) in [(4, 0.3), (16, 0.15)] {
            let words = format!("--shading {shading} --samples {samples}");
            let [largest, _] = differences(&shade(&bench, size, &words), &wanted);
            assert!(largest < most, "{shading}, {samples} samples: {largest}");
        }
    }
}

#[test]
fn samples_of_a_pixel_share_the_rays_to_a_light_that_has_a_size() {
    let bench = two_squares();
    for shading in ["vertex", "pixel"] {
        let soft = |rays: u32| {
            let words = format!("--shading {shading} --light-radius 8 --shadow-rays {rays}");
            shade(&bench, 24, &words)
        };
        let wanted = soft(1024);
        let [largest, mean] = differences(&soft(16), &wanted);
        assert!(largest < 0.25 && mean < 0.01, "{shading}: {largest} {mean}");
        // Fewer rays than samples: each sample casts one.
        let [largest, mean] = differences(&soft(2), &wanted);
        assert!(largest < 0.6 && mean < 0.02, "{shading}: {largest} {mean}");
    }
}

#[test]
fn pixels_blend_texels_unless_they_are_told_not_to() {
    let bench = small_ball(DType::F2);
    let made = |words: &[&str]| {
        let size = ["--size", "40x30", "--layers", "rgba"];
        fs::read(
            bench
                .render("frames", &[&size, words].concat())
                .join("frame.0001.exr"),
        )
        .unwrap()
    };
    let [pixel, vertex] = ["pixel", "vertex"].map(|shading| {
        let of = |more: &[&str]| made(&[&["--shading", shading], more].concat());
        (
            of(&[]),
            of(&["--texels", "bilinear"]),
            of(&["--texels", "nearest"]),
        )
    });
    // The header says what was decided.
    assert!(pixel.0 == pixel.1 && pixel.0 != pixel.2);
    assert!(vertex.0 == vertex.2 && vertex.0 != vertex.1);
}

#[test]
fn triangles_of_a_coarse_ball_cast_no_shadows_on_each_other() {
    let spec = SampleSpec {
        size: [1, 1],
        views: bonn81(),
        lights: bonn81(),
        dtype: DType::F4,
    };
    let bench = Bench::new(
        |path| spec.write(path, lambertian),
        |id| ball(9, [1, 1], id),
    );
    for shading in ["vertex", "pixel"] {
        let shown = |shadows: &str| {
            let words = "--size 64x48 --camera-elevation 0 --light sun:70,20 --layers rgba --float";
            let words = format!("{words} --shading {shading} --shadows {shadows}");
            let words: Vec<&str> = words.split_whitespace().collect();
            let frame = read_frame(&bench.render(shadows, &words).join("frame.0001.exr"));
            frame.channels["R"].clone()
        };
        let [largest, mean] = differences(&shown("pixel"), &shown("none"));
        assert!(largest < 0.02 && mean < 1e-4, "{shading}: {largest} {mean}");
    }
}

#[test]
fn pixel_shading_shows_the_sample_between_vertices() {
    // Edges of 4 texels and exact coordinates, seen from straight above at 4 pixels a texel.
    let spec = SampleSpec {
        size: [32, 32],
        views: vec![Direction::from_angles(0.0, 0.0)],
        lights: vec![Direction::from_angles(0.0, 0.0)],
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, hashed),
        |id| square(8, [32, 32], 1.0 / 32.0, id),
    );
    let sample = Sample::open(&bench.sample).unwrap();
    let psnr = |shading: &str| {
        let words = [
            "--irradiance",
            "1",
            "--size",
            "128x128",
            "--projection",
            "orthographic",
            "--up",
            "z",
            "--camera-position",
            "0,0,5",
            "--camera-target",
            "0,0,0",
            "--view-height",
            "1",
            "--light",
            "sun:0,90",
            "--shading",
            shading,
            "--texels",
            "nearest",
            "--samples",
            "1",
        ];
        let frame = read_frame(&bench.render("frames", &words).join("frame.0001.exr"));
        let mut squares = 0.0;
        for pixel in 0..128 * 128 {
            let texel = (pixel / 128 / 4) * 32 + pixel % 128 / 4;
            for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
                let wanted = f64::from(sample.image(0).unwrap().get(texel * 3 + channel));
                squares += (frame.channels[name][pixel] - wanted).powi(2);
            }
        }
        -10.0 * (squares / (3.0 * 128.0 * 128.0)).log10()
    };
    let (pixel, vertex) = (psnr("pixel"), psnr("vertex"));
    assert!(pixel >= 40.0, "{pixel}");
    assert!(vertex <= pixel - 10.0, "{vertex} {pixel}");
}

#[test]
fn pixel_shading_of_a_scaled_plane_is_that_of_a_larger_texel() {
    let spec = SampleSpec {
        size: [32, 32],
        views: vec![Direction::from_angles(0.0, 0.0)],
        lights: vec![Direction::from_angles(0.0, 0.0)],
        dtype: DType::F2,
    };
    let words = "--size 16x16 --projection orthographic --up z --camera-position 0,0,5 \
                 --camera-target 0,0,0 --view-height 1 --light sun:0,90 --mip on";
    let frame = |texel: f64, scale: Option<f32>, shading: &str| {
        let map = |id| {
            let mut map = square(4, [32, 32], 1.0 / 32.0, id);
            map.scale = scale.map(|scale| vec![scale; map.mesh.positions.len()]);
            map.header.texel = texel;
            map
        };
        let bench = Bench::new(|path| spec.write(path, hashed), map);
        let mut words: Vec<&str> = words.split_whitespace().collect();
        words.extend(["--shading", shading]);
        let frame = read_frame(&bench.render("frames", &words).join("frame.0001.exr"));
        ["R", "G", "B"].map(|name| frame.channels[name].clone())
    };
    for shading in ["pixel", "vertex"] {
        let scaled = frame(1.0 / 32.0, Some(2.0), shading);
        assert_eq!(scaled, frame(1.0 / 16.0, None, shading));
        assert_ne!(scaled, frame(1.0 / 32.0, None, shading));
    }
}
