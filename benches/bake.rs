//! Baking at the size of the project's aims, and its parts: view rays, shadow rays.

use divan::{Bencher, counter::ItemsCount};
use glam::{DVec2, DVec3};
use mesotex::btf::bake::{BakeOptions, Preset, Samples, bake};
use mesotex::progress::Progress;

fn main() {
    divan::main();
}

/// 128 × 128 texels, 60 views × 60 lights, hard shadows, some samples per texel.
#[divan::bench(
    args = [(Preset::Weave, 1), (Preset::Bark, 1), (Preset::Bark, 4)],
    sample_count = 3,
    sample_size = 1
)]
fn whole_bake(bencher: Bencher, (preset, samples): (Preset, u32)) {
    let Ok(material) = preset.material(128, 1, &Progress::silent()) else {
        return;
    };
    let Ok(folder) = tempfile::tempdir() else {
        return;
    };
    let target = folder.path().join("x.sample");
    let options = BakeOptions {
        samples: Samples::Fixed(samples),
        ..BakeOptions::default()
    };
    bencher
        .counter(ItemsCount::new(128_usize * 128 * 3600 * samples as usize))
        .bench_local(|| bake(&material, &options, &target, Progress::silent()).is_ok());
}

/// Rays from the viewer, one a texel of 128 × 128.
#[divan::bench(args = [15, 45, 75])]
fn view_rays(bencher: Bencher, theta_deg: i32) {
    let Ok(material) = Preset::Bark.material(128, 1, &Progress::silent()) else {
        return;
    };
    let surface = material.surface();
    let towards = tilted(theta_deg);
    bencher
        .counter(ItemsCount::new(128_usize * 128))
        .bench_local(|| {
            (0..128 * 128)
                .filter_map(|i| {
                    surface.seen_through(DVec2::new((i % 128) as f64, (i / 128) as f64), towards)
                })
                .count()
        });
}

/// Rays from those points to a light.
#[divan::bench(args = [15, 45, 75])]
fn shadow_rays(bencher: Bencher, theta_deg: i32) {
    let Ok(material) = Preset::Bark.material(128, 1, &Progress::silent()) else {
        return;
    };
    let surface = material.surface();
    let points: Vec<_> = (0..128 * 128)
        .filter_map(|i| {
            let place = DVec2::new(f64::from(i % 128) + 0.3, f64::from(i / 128) + 0.4);
            surface.seen_through(place, tilted(20))
        })
        .collect();
    let light = tilted(theta_deg);
    bencher
        .counter(ItemsCount::new(points.len()))
        .bench_local(|| {
            points
                .iter()
                .filter(|&&point| surface.occluded(point, light))
                .count()
        });
}

fn tilted(theta_deg: i32) -> DVec3 {
    let (sin, cos) = f64::from(theta_deg).to_radians().sin_cos();
    DVec3::new(0.8 * sin, 0.6 * sin, cos)
}
