//! A sweep does not pop: twice the frames, half the change from one to the next.

use mesotex::progress::Progress;
use mesotex::render::nearest::Weighting;
use mesotex::render::options::RenderOptions;
use mesotex::render::renderer::Shadows;
use mesotex::render::sequence::{Inputs, with_renderer};
use mesotex::render::values::{ImageSize, Sweep};

use super::*;

/// The largest change of any vertex between neighbouring frames of a quarter turn of the light.
fn largest_change(bench: &Bench, weights: Weighting, frames_a_turn: u32) -> f32 {
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
        sweep: Sweep::LightAzimuth,
        sweep_length: Some(frames_a_turn),
        frames: Some(format!("1-{}", frames_a_turn / 4 + 1).parse().unwrap()),
        size: ImageSize([8, 8]),
        light_elevation: 35.0,
        weights,
        shadows: Shadows::None,
        ..RenderOptions::default()
    };
    with_renderer(
        &inputs,
        &options,
        &Progress::silent(),
        |renderer, frames| {
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
        },
    )
    .unwrap()
    .0
}

/// How much smaller changes are with 720 frames a turn than with 360.
fn ratio(lights: &str, weights: Weighting) -> f32 {
    let bake = |path: &Path| {
        let words = [
            "bake",
            "--preset",
            "weave",
            "--size",
            "16",
            "--views",
            "fibonacci:10",
            "--lights",
            lights,
            "-o",
            text(path),
        ];
        assert!(mesotex(&words).status.success());
        Sample::open(path).unwrap().id().clone()
    };
    let bench = Bench::new(bake, |id| ball(14, [16, 16], id));
    largest_change(&bench, weights, 720) / largest_change(&bench, weights, 360)
}

#[test]
fn continuous_weights_halve_the_change_with_twice_the_frames() {
    for lights in ["bonn81", "fibonacci:200"] {
        let ratio = ratio(lights, Weighting::Continuous);
        assert!(ratio <= 0.6, "{lights}: {ratio}");
    }
}

#[test]
fn inverse_angle_weights_jump_however_many_frames() {
    let ratio = ratio("bonn81", Weighting::InverseAngle);
    assert!(ratio >= 0.85, "{ratio}");
}
