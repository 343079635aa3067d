//! Scattered samples, pairs of view and light that are no product, through the whole renderer.

use mesotex::btf::Layout;

use super::*;

/// Every pair has a view and a light of its own.
fn write_scattered(path: &Path, pairs: usize) -> ContentId {
    let description = Description {
        dtype: DType::F2,
        layout: Layout::Pairs,
        pairs: Some(
            (0..pairs as u32)
                .map(|k| [k, k * 7 % pairs as u32])
                .collect(),
        ),
        ..Description::product("scattered", [5, 4], fibonacci(pairs), fibonacci(pairs))
    };
    let directions = fibonacci(pairs);
    let mut writer = SampleWriter::create(path, description).unwrap();
    for k in 0..pairs {
        let (view, light) = (&directions[k], &directions[k * 7 % pairs]);
        let texels = (0..4).flat_map(|row| (0..5).map(move |col| (row, col)));
        let image: Vec<f32> = texels
            .flat_map(|(row, col)| hashed(view, light, row, col).map(|v| v as f32))
            .collect();
        writer.push(&image).unwrap();
    }
    writer.finish().unwrap().id
}

#[test]
fn scattered_pairs_are_weighted_by_both_angles() {
    let bench = Bench::new(|path| write_scattered(path, 60), |id| ball(12, [5, 4], id));
    let (sample, map) = (
        Sample::open(&bench.sample).unwrap(),
        SurfaceTextonMap::read(&bench.map).unwrap(),
    );
    let directions = fibonacci(60);
    let lowest = directions.iter().map(|d| d.0.z).fold(1.0, f64::min);
    let (view, light) = (DVec3::Z, DVec3::new(0.0, 0.5, 3f64.sqrt() / 2.0));
    for weights in ["continuous", "inverse-angle"] {
        let file = bench.path("colors.ply");
        let words = [
            "--irradiance",
            "1",
            "--projection",
            "orthographic",
            "--camera-elevation",
            "0",
            "--light",
            "sun:0,30",
            "--shadows",
            "none",
            "--size",
            "8x8",
            "--weights",
            weights,
            "--linear-colors",
            "--vertex-colors",
            text(&file),
        ];
        bench.render("frames", &words);
        let mut lit = 0;
        for (vertex, found) in vertex_colors(&file).into_iter().enumerate() {
            let (n, s) = (
                map.normals[vertex].as_dvec3(),
                map.orientations[vertex].as_dvec3(),
            );
            let local = |v: DVec3| DVec3::new(v.dot(s), v.dot(n.cross(s)), v.dot(n)).normalize();
            let (view, light) = (local(view), local(light));
            if view.z < 0.01 || light.z < 0.01 {
                continue;
            }
            let light_of = |k: usize| directions[k * 7 % 60].0;
            let near = |k: usize| {
                let d = angle(directions[k].0, view).hypot(angle(light_of(k), light));
                let (a, b) = (log_map(directions[k].0, view), log_map(light_of(k), light));
                (d, k, [a, b].concat())
            };
            let all: Vec<Near> = (0..60).map(near).collect();
            let weighted = match weights {
                "continuous" => fit(&all, 17, false, 0.0),
                _ => nearest(all.into_iter().map(|(d, k, _)| (d, k)).collect(), 16),
            };
            let texel = sample
                .grid()
                .texel_holding(map.coords[vertex])
                .unwrap()
                .index();
            let mut wanted = [0.0; 3];
            for (k, weight) in weighted {
                let scale = match weights {
                    "continuous" => (light.z / light_of(k).z).min(2.0),
                    _ => (light.z / lowest).min(1.0),
                };
                for (channel, wanted) in wanted.iter_mut().enumerate() {
                    *wanted += weight
                        * scale
                        * f64::from(sample.image(k).unwrap().get(texel * 3 + channel));
                }
            }
            for (found, wanted) in found.into_iter().zip(wanted) {
                let close = (found - wanted).abs() <= 1e-3 * wanted;
                assert!(close, "{weights}, vertex {vertex}: {found} {wanted}");
            }
            lit += 1;
        }
        assert!(lit > 60, "{lit}");
    }
}

#[test]
fn quadratic_weights_are_refused_for_scattered_pairs() {
    let bench = Bench::new(|path| write_scattered(path, 60), |id| ball(12, [5, 4], id));
    let error = bench.refuse(&["--size", "8x8", "--weights", "quadratic"], 2);
    assert!(
        error.contains("scattered pairs") && error.contains("`continuous`"),
        "{error}"
    );
}

#[test]
fn scattered_pairs_have_no_fill_light() {
    let bench = Bench::new(|path| write_scattered(path, 12), |id| ball(6, [5, 4], id));
    let error = bench.refuse(&["--fill", "0.1"], 2);
    assert!(
        error.contains("--fill") && error.contains("scattered pairs"),
        "{error}"
    );
}
