//! Colours of vertices against the contract, literally, in double precision.

use super::*;

fn oracle_color(
    sample: &Sample,
    map: &SurfaceTextonMap,
    vertex: usize,
    camera: DVec3,
    light: DVec3,
    weighting: &str,
) -> [f64; 3] {
    let n = map.normals[vertex].as_dvec3();
    let s = map.orientations[vertex].as_dvec3();
    let t = n.cross(s);
    let local = |v: DVec3| DVec3::new(v.dot(s), v.dot(t), v.dot(n)).normalize();
    let light = local(light);
    let mut view = local(camera - map.mesh.positions[vertex].as_dvec3());
    if light.z <= 0.0 {
        return [0.0; 3];
    }
    if view.z < 0.0 {
        let phi = view.y.atan2(view.x);
        view = Direction::from_angles(PI / 2.0 - 1e-3, phi).0;
    }
    let description = sample.description();
    let texel = sample
        .grid()
        .texel_holding(map.coords[vertex])
        .unwrap()
        .index();
    let mut color = [0.0; 3];
    for (v, view_weight) in view_weights(&description.views, view, weighting) {
        for (l, light_weight) in light_weights(&description.lights, light, weighting) {
            let image = sample.image(v * description.lights.len() + l).unwrap();
            for (channel, sum) in color.iter_mut().enumerate() {
                let value = f64::from(image.get(texel * 3 + channel));
                *sum += view_weight * light_weight * value;
            }
        }
    }
    color.map(|value| value.max(0.0))
}

#[test]
fn vertex_colors_equal_the_formula_in_all_weightings() {
    for dtype in [DType::F2, DType::F4] {
        let bench = small_ball(dtype);
        let (sample, map) = (
            Sample::open(&bench.sample).unwrap(),
            SurfaceTextonMap::read(&bench.map).unwrap(),
        );
        for weights in ["continuous", "quadratic", "inverse-angle"] {
            let file = bench.path("colors.ply");
            let words = [
                "--irradiance",
                "1",
                "--shadows",
                "none",
                "--weights",
                weights,
                "--size",
                "16x16",
                "--linear-colors",
                "--vertex-colors",
                text(&file),
                "--camera-position",
                "1,2,3",
                "--light",
                "sun:40,35",
                "--camera-target",
                "0,0,0",
            ];
            bench.render("frames", &words);
            let camera = DVec3::new(1.0, 2.0, 3.0);
            // Azimuth 0 points at the camera, counter-clockwise seen from above (+y).
            let zero = DVec3::new(1.0, 0.0, 3.0).normalize();
            let left = DVec3::Y.cross(zero);
            let (a, e) = (40f64.to_radians(), 35f64.to_radians());
            let light = (zero * a.cos() + left * a.sin()) * e.cos() + DVec3::Y * e.sin();
            let mut lit = 0;
            for (vertex, found) in vertex_colors(&file).into_iter().enumerate() {
                let wanted = oracle_color(&sample, &map, vertex, camera, light, weights);
                for (found, wanted) in found.into_iter().zip(wanted) {
                    // Halfs have 11 bits; a quadratic fit also takes differences of values.
                    let close = (found - wanted).abs() <= 1e-3 * wanted.max(0.01);
                    assert!(close, "{weights}, vertex {vertex}: {found} {wanted}");
                    lit += u32::from(wanted > 0.0);
                }
            }
            assert!(lit > 300, "{lit}");
        }
    }
}

#[test]
fn stored_values_come_back_at_sampled_directions() {
    let spec = SampleSpec {
        size: [6, 6],
        views: fibonacci(9),
        lights: fibonacci(12),
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, hashed),
        |id| square(6, [6, 6], 1.0 / 6.0, id),
    );
    let sample = Sample::open(&bench.sample).unwrap();
    let map = SurfaceTextonMap::read(&bench.map).unwrap();
    for (v, l) in [(0, 0), (3, 7), (8, 11)] {
        let (view, light) = (spec.views[v].0, spec.lights[l].0);
        // Orthographic, so that every vertex is seen along one direction. Up is z, so azimuths are
        // the sample's own, less that of the camera.
        let camera = view * 10.0;
        let degrees = |d: DVec3| (d.y.atan2(d.x).to_degrees(), d.z.asin().to_degrees());
        let (light_angles, view_angles) = (degrees(light), degrees(view));
        let sun = format!("sun:{},{}", light_angles.0 - view_angles.0, light_angles.1);
        let position = format!("{},{},{}", camera.x, camera.y, camera.z);
        let file = bench.path("colors.ply");
        bench.render(
            "frames",
            &[
                "--irradiance",
                "1",
                "--up",
                "z",
                "--projection",
                "orthographic",
                "--size",
                "40x40",
                "--camera-position",
                &position,
                "--camera-target",
                "0,0,0",
                "--light",
                &sun,
                "--linear-colors",
                "--vertex-colors",
                text(&file),
            ],
        );
        let image = sample.image(v * 12 + l).unwrap();
        for (vertex, found) in vertex_colors(&file).into_iter().enumerate() {
            let texel = sample
                .grid()
                .texel_holding(map.coords[vertex])
                .unwrap()
                .index();
            for (channel, found) in found.into_iter().enumerate() {
                let stored = f64::from(image.get(texel * 3 + channel));
                assert!(
                    (found - stored).abs() < 1e-6,
                    "{v} {l} {vertex}: {found} {stored}"
                );
            }
        }
    }
}
