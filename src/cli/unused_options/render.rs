//! Frames: sweeps, cameras and lights that exclude each other.

use crate::cli::atlas;
use crate::cli::render::Arguments;
use crate::cli::unused_options::combination::{Combination, found};
use crate::render::option_values::{LightSpec, ProjectionKind, Sweep};
use crate::render::options::RenderOptions;
use crate::render::renderer::Shadows;

/// What only atlases have.
pub(super) const ATLAS: &[Combination<Arguments>] = &[
    Combination {
        options: &["displace"],
        unused: given_for_another_map,
        expected: "an atlas; other maps have no channel of heights",
    },
    Combination {
        options: &["surface-color"],
        unused: given_for_another_map,
        expected: "an atlas; other maps have no channel of alpha",
    },
];

fn given_for_another_map(arguments: &Arguments) -> Option<String> {
    let text = format!("given for {}", arguments.map.display());
    found(!atlas::is_atlas(&arguments.map), text)
}

/// The options of frames.
pub(super) const FRAMES: &[Combination<RenderOptions>] = &[
    Combination {
        options: &["frames"],
        unused: |options| {
            let count = options
                .sweep
                .frames
                .map_or(1, |frames| frames.numbers().count());
            let is_still =
                options.sweep.kind == Sweep::None && options.camera.camera_path.is_none();
            found(
                is_still && count > 1,
                format!("{count} without a sweep, all of them the same"),
            )
        },
        expected: "--sweep or --camera-path as well",
    },
    Combination {
        options: &["sweep-length", "sweep-from", "sweep-to"],
        unused: |options| match &options.sweep.kind {
            Sweep::None => Some("given without a sweep".into()),
            Sweep::File(path) => Some(format!(
                "given with {}, which renders all of its rows",
                path.display()
            )),
            _ => None,
        },
        expected: "--sweep light-azimuth, light-elevation, light-spiral or view-orbit",
    },
    Combination {
        options: &["turns"],
        unused: |options| {
            let text = format!("given with --sweep {}", options.sweep.kind);
            found(options.sweep.kind != Sweep::LightSpiral, text)
        },
        expected: "--sweep light-spiral, which turns while it sinks",
    },
    Combination {
        options: &["sweep"],
        unused: |options| {
            let has_point = matches!(options.lights.light.first(), Some(LightSpec::Point { .. }));
            let text = format!("{} with a point light as the first", options.sweep.kind);
            found(has_point && is_light_sweep(options), text)
        },
        expected: "a sun as the first --light (points are moved by a .csv file)",
    },
    Combination {
        options: &["sweep"],
        unused: |options| {
            let rises = matches!(
                options.sweep.kind,
                Sweep::LightElevation | Sweep::LightSpiral
            );
            let text = format!("{} with an environment alone", options.sweep.kind);
            found(rises && is_environment_alone(options), text)
        },
        expected: "light-azimuth, which turns the environment, or a --light to move",
    },
    Combination {
        options: &["light-azimuth"],
        unused: light_azimuth_is_replaced,
        expected: "one way to set the light's azimuth",
    },
    Combination {
        options: &["light-elevation"],
        unused: |options| match &options.sweep.kind {
            Sweep::LightElevation | Sweep::LightSpiral => {
                Some(format!("given with --sweep {}", options.sweep.kind))
            }
            _ => standing_light_is_replaced(options),
        },
        expected: "one way to set the light's elevation (--sweep-from and --sweep-to of a sweep)",
    },
    Combination {
        options: &["irradiance"],
        unused: |options| {
            let own = |light: &LightSpec| match light {
                LightSpec::Sun { irradiance, .. } | LightSpec::Point { irradiance, .. } => {
                    irradiance.is_some()
                }
            };
            match options.lights.light.as_slice() {
                [] => found(
                    is_environment_alone(options) && !options.has_rows(),
                    "given with an environment alone",
                ),
                lights => found(
                    lights.iter().all(own),
                    "given with lights that state their own",
                ),
            }
        },
        expected: "a light without an irradiance of its own (--environment-scale is the environment's)",
    },
    Combination {
        options: &["light-radius"],
        unused: without_shadows,
        expected: "--shadows vertex or pixel, whose edges it softens",
    },
    Combination {
        options: &["shadow-rays"],
        unused: |options| match options.lights.light_radius == 0.0 {
            true => Some("given without --light-radius".into()),
            false => without_shadows(options),
        },
        expected: "--light-radius and shadows as well: sharp edges take one ray",
    },
    Combination {
        options: &[
            "environment-encoding",
            "environment-layer",
            "environment-lights",
            "environment-scale",
            "environment-azimuth",
        ],
        unused: |options| {
            found(
                options.lights.environment.is_none(),
                "given without an environment",
            )
        },
        expected: "--environment FILE as well",
    },
    Combination {
        options: &["front"],
        unused: |options| {
            let camera = &options.camera;
            let is_vertical = camera
                .camera_target
                .is_some_and(|target| camera.looks_along_up(target.0));
            let is_unused = camera.camera_position.is_some() && !options.has_rows() && !is_vertical;
            found(is_unused, "given with --camera-position")
        },
        expected: "one way to set the camera's position (or a --camera-target straight below or above it)",
    },
    Combination {
        options: &["camera-azimuth"],
        unused: camera_azimuth_is_replaced,
        expected: "one way to set the camera's position",
    },
    Combination {
        options: &["camera-elevation"],
        unused: |options| {
            let is_unused = options.camera.camera_position.is_some() && !options.has_rows();
            found(is_unused, "given with --camera-position")
        },
        expected: "one way to set the camera's position",
    },
    Combination {
        options: &["fov", "focal-length"],
        unused: |options| {
            let is_unused = options.camera.projection == ProjectionKind::Orthographic;
            found(is_unused, "given with --projection orthographic")
        },
        expected: "--view-height, the height of an orthographic picture",
    },
    Combination {
        options: &["view-height"],
        unused: |options| {
            let is_unused = options.camera.projection == ProjectionKind::Perspective;
            found(is_unused, "given with --projection perspective")
        },
        expected: "--projection orthographic beside it, or --fov",
    },
];

fn is_light_sweep(options: &RenderOptions) -> bool {
    matches!(
        options.sweep.kind,
        Sweep::LightAzimuth | Sweep::LightElevation | Sweep::LightSpiral
    )
}

fn is_environment_alone(options: &RenderOptions) -> bool {
    options.lights.environment.is_some() && options.lights.light.is_empty()
}

fn without_shadows(options: &RenderOptions) -> Option<String> {
    found(
        options.image.shadows == Shadows::None,
        "given with --shadows none",
    )
}

/// What stands in for the light of --light-azimuth and --light-elevation.
fn standing_light_is_replaced(options: &RenderOptions) -> Option<String> {
    match (options.lights.light.is_empty(), &options.lights.environment) {
        (false, _) => Some("given with --light".into()),
        (true, Some(_)) => Some("given with --environment".into()),
        (true, None) => None,
    }
}

/// Sweeps of the azimuth begin at it; a spiral turns from it.
fn light_azimuth_is_replaced(options: &RenderOptions) -> Option<String> {
    match options.sweep.kind {
        Sweep::LightSpiral => None,
        Sweep::LightAzimuth => found(
            options.sweep.sweep_from.is_some() && !is_environment_alone(options),
            "given with --sweep-from",
        ),
        _ => standing_light_is_replaced(options),
    }
}

/// An orbit begins at it; a position that is given is rotated by what an orbit adds to it.
fn camera_azimuth_is_replaced(options: &RenderOptions) -> Option<String> {
    let starts_apart = options.sweep.kind == Sweep::ViewOrbit && options.sweep.sweep_from.is_some();
    match options.camera.camera_position.is_some() {
        _ if options.has_rows() => None,
        true => found(!starts_apart, "given with --camera-position"),
        false => found(starts_apart, "given with --sweep-from"),
    }
}
