//! Highlights: what half precision cannot hold, and the angular filter.

use super::*;

/// A mirror with bumps of a random height, from none to visible ones.
fn bumpy_mirror(seed: u64, roughness: f32) -> Material {
    let mut random = mesotex::random::stream(seed, "mirror", 0, 0);
    let highest = 10.0_f32.powf(random.gen_range(-4.5..-1.5));
    let bumps = (0..144).map(|_| random.gen_range(0.0..highest)).collect();
    let mut material = white(12, bumps);
    material.roughness = Some(vec![roughness; 144]);
    material.metallic = Some(vec![1.0; 144]);
    material
}

/// The oracle is the bake in single precision: what it holds beyond half precision is found before a bake in half
/// precision, and nothing else is.
#[test]
fn what_half_precision_cannot_hold_is_found_before_the_bake() {
    let folder = tempfile::tempdir().unwrap();
    let mut outcomes = [0, 0];
    for seed in 0..60 {
        let roughness = [0.01, 0.02, 0.03, 0.04, 0.06, 0.2][seed as usize % 6];
        let material = bumpy_mirror(seed, roughness);
        let single = BakeOptions {
            samples: Samples::Fixed(1 + seed as u32 % 2),
            angular_filter: AngularFilter::Off,
            ..options("rings:0:1", "rings:0:1,20:6,50:9")
        };
        let (_folder, sample) = baked(&material, &single);
        let brightest = (0..16)
            .flat_map(|light| {
                let image = sample.image(light).unwrap();
                (0..image.len()).map(move |i| image.get(i))
            })
            .fold(0.0, f32::max);
        let half = BakeOptions {
            dtype: DType::F2,
            ..single
        };
        let target = folder.path().join(format!("{seed}.sample"));
        let result = bake(&material, &half, &target, Progress::silent());
        assert_eq!(
            result.is_err(),
            brightest > 65_504.0,
            "{seed}: {brightest} {result:?}"
        );
        outcomes[usize::from(result.is_err())] += 1;
        if let Err(error) = result {
            assert!(error.to_string().contains("the highlight at"), "{error}");
            assert!(!target.exists());
            let clamping = BakeOptions {
                clamp: true,
                ..half
            };
            let report = bake(&material, &clamping, &target, Progress::silent()).unwrap();
            assert!(report.clamped > 0);
        }
    }
    assert!(outcomes.iter().all(|&count| count > 5), "{outcomes:?}");
}

/// Of a lobe as wide as the spacing of the lights, the lights' images hold the energy. A narrower one falls between them,
/// or is counted for the whole cell of a light.
#[test]
fn filtered_highlights_keep_their_energy_between_the_lights() {
    let mut mirror = white(16, vec![0.0; 256]);
    mirror.roughness = Some(vec![0.1; 256]);
    mirror.metallic = Some(vec![1.0; 256]);
    let energies = |angular_filter| -> Vec<f64> {
        let filtered = BakeOptions {
            angular_filter,
            ..options("rings:5:3,20:8,40:12", "fibonacci:200")
        };
        let (_folder, sample, report) = reported(&mirror, &filtered);
        assert_eq!(
            report.widened_to.is_some(),
            angular_filter != AngularFilter::Off
        );
        let of_view = |view| {
            (0..200)
                .map(|light| mean(&sample, view, light))
                .sum::<f64>()
        };
        (0..23)
            .map(|view| 2.0 * PI / 200.0 * of_view(view))
            .collect()
    };
    let off_by = |energies: &[f64]| {
        let off: f64 = energies.iter().map(|energy| (energy - 1.0).abs()).sum();
        off / energies.len() as f64
    };
    let (exact, filtered) = (
        off_by(&energies(AngularFilter::Off)),
        off_by(&energies(AngularFilter::Auto)),
    );
    assert!(exact > 0.5 && filtered < 0.1, "{exact} {filtered}");
    assert_eq!(energies(AngularFilter::On), energies(AngularFilter::Auto));
}
