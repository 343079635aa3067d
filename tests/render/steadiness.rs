//! A sweep does not pop: twice the frames, half the change from one to the next.

use mesotex::progress::Progress;
use mesotex::render::nearest::Weighting;
use mesotex::render::parallax::Parallax;
use mesotex::render::sweep::{Inputs, with_renderer};
use mesotex::render::{
    CameraOptions, ImageOptions, ImageSize, LightOptions, RenderOptions, Shadows, Sweep,
    SweepOptions,
};

use super::*;

/// The largest change of any vertex between neighbouring frames of a quarter turn of the light.
fn largest_change(bench: &Bench, options: &RenderOptions, frames_a_turn: u32) -> f32 {
    let (sample, map) = (
        Sample::open(&bench.sample).unwrap(),
        SurfaceTextonMap::read(&bench.map).unwrap(),
    );
    let inputs = Inputs {
        sample: &sample,
        map: &map,
        map_id: &ContentId::of_bytes(b"map"),
        cover: None,
        folder: bench.folder.path(),
        force: true,
    };
    let options = RenderOptions {
        sweep: SweepOptions {
            kind: Sweep::LightAzimuth,
            sweep_length: Some(frames_a_turn),
            frames: Some(format!("1-{}", frames_a_turn / 4 + 1).parse().unwrap()),
            ..options.sweep.clone()
        },
        image: ImageOptions {
            size: ImageSize([8, 8]),
            shadows: Shadows::None,
            ..options.image.clone()
        },
        lights: LightOptions {
            light_elevation: 35.0,
            ..options.lights.clone()
        },
        ..options.clone()
    };
    with_renderer(&inputs, &options, Progress::silent(), |renderer, frames| {
        let mut largest = 0f32;
        let mut last: Option<Vec<[f32; 3]>> = None;
        for frame in frames {
            let colors = renderer.vertex_colors(&frame.view, &frame.lights)?;
            let numbers = || colors.as_flattened().iter();
            for (a, b) in numbers().zip(last.iter().flatten().flatten()) {
                largest = largest.max((a - b).abs());
            }
            last = Some(colors);
        }
        Ok(largest)
    })
    .unwrap()
    .0
}

/// How much smaller changes are with 720 frames a turn than with 360.
fn ratio(lights: &str, weights: Weighting) -> f32 {
    let bench = Bench::new(baked("weave", lights), |id| ball(14, [16, 16], id));
    let options = RenderOptions {
        image: ImageOptions {
            weights,
            ..ImageOptions::default()
        },
        ..RenderOptions::default()
    };
    largest_change(&bench, &options, 720) / largest_change(&bench, &options, 360)
}

/// Bakes a preset under some lights.
fn baked(preset: &str, lights: &str) -> impl FnOnce(&Path) -> ContentId {
    move |path| {
        let words = ["bake", "--preset", preset, "--size", "16", "--samples", "1"];
        let directions = ["--views", "fibonacci:10", "--lights", lights];
        let words = [&words[..], &directions[..], &["-o", text(path)]].concat();
        assert!(mesotex(&words).status.success());
        Sample::open(path).unwrap().id().clone()
    }
}

/// A coherent map seen at an angle, so that texels are moved.
#[test]
fn parallax_keeps_sweeps_of_the_light_steady() {
    let bench = Bench::new(baked("cobbles", "bonn81"), |id| {
        square(8, [16, 16], 1.0 / 16.0, id)
    });
    let with = |weights, parallax| RenderOptions {
        image: ImageOptions {
            weights,
            parallax,
            ..ImageOptions::default()
        },
        camera: CameraOptions {
            camera_azimuth: -50.0,
            ..CameraOptions::default()
        },
        ..RenderOptions::default()
    };
    let change =
        |weights, parallax, frames| largest_change(&bench, &with(weights, parallax), frames);
    for weights in [Weighting::Continuous, Weighting::Quadratic] {
        let [fine, coarse] = [720, 360].map(|frames| change(weights, Parallax::On, frames));
        assert!(fine <= 0.6 * coarse, "{weights:?}: {fine}, {coarse}");
        assert_ne!(coarse, change(weights, Parallax::Off, 360));
    }
}

#[test]
fn fitted_weights_halve_the_change_with_twice_the_frames() {
    for lights in ["bonn81", "fibonacci:200"] {
        for weights in [Weighting::Continuous, Weighting::Quadratic] {
            let ratio = ratio(lights, weights);
            assert!(ratio <= 0.6, "{lights}, {weights:?}: {ratio}");
        }
    }
}

#[test]
fn inverse_angle_weights_jump_however_many_frames() {
    let ratio = ratio("bonn81", Weighting::InverseAngle);
    assert!(ratio >= 0.85, "{ratio}");
}
