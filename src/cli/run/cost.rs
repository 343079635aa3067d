//! What a stage takes: seconds of one thread, and bytes at the peak.
//!
//! A model fitted to runs of the release program with `--threads 1` on a machine of 2 cores with AVX-512, from 32 to
//! 256 texels per side, 15,000 to 240,000 vertices and 640 × 480 to 1280 × 960 pixels. `tools/compare_plan.py` holds
//! a scene's plan against what its stages took.

use crate::synthesis::{SynthesisOptions, Workload};

/// What the program itself takes.
const PROGRAM: f64 = 16e6;
/// The share of every further thread that stages turn into speed; assumed, as all was measured with one.
const PARALLEL: f64 = 0.8;

/// What a stage takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Seconds of one thread.
    pub seconds: f64,
    /// Bytes at the peak.
    pub bytes: f64,
}

impl Cost {
    fn new(seconds: f64, bytes: f64) -> Self {
        Self {
            seconds,
            bytes: PROGRAM + bytes,
        }
    }

    /// Seconds on this many threads.
    pub fn seconds_on(self, threads: usize) -> f64 {
        self.seconds / (1.0 + PARALLEL * (threads.max(1) - 1) as f64)
    }
}

/// The sample as far as costs depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SampleSize {
    /// Texels.
    pub(super) texels: f64,
    /// Images: pairs of a view and a light.
    pub(super) images: f64,
    /// Lights.
    pub(super) lights: f64,
}

/// The mean of 1/cos θ over 60 directions, `12x5`.
const USUAL_SLANT: f64 = 1.9;

/// A bake of this many rays per texel and image, reflected so often; `slant` is the mean of 1/cos θ over the lights,
/// as flat rays cross more of the relief.
pub(super) fn bake(sample: SampleSize, samples: f64, bounces: f64, slant: f64) -> Cost {
    let rays = sample.texels * sample.images * samples;
    let per_ray = 6e-8 * (slant / USUAL_SLANT).sqrt() * (1.0 + 0.3 * bounces);
    Cost::new(
        0.05 + 5e-6 * sample.texels + per_ray * rays,
        sample.texels * (100.0 + 18.0 * sample.lights),
    )
}

/// A bake in so many shards: what each takes, and to join their parts.
pub(super) fn bake_in_shards(whole: Cost, sample: SampleSize, shards: f64) -> [Cost; 2] {
    let setup = bake(
        SampleSize {
            images: 0.0,
            ..sample
        },
        0.0,
        0.0,
        USUAL_SLANT,
    )
    .seconds;
    let shard = Cost {
        seconds: setup + (whole.seconds - setup) / shards,
        ..whole
    };
    [shard, joining(sample)]
}

/// Parts joined to a sample: bytes are copied and hashed.
fn joining(sample: SampleSize) -> Cost {
    let copied = 6.0 * sample.texels * sample.images;
    Cost::new(0.03 + 2.7e-9 * copied, 10e6)
}

/// The most bytes of images that are decoded at once.
const MOST_DECODED: f64 = 134e6;

/// Measured images, imported: files of this many pixels each.
pub(super) fn import(sample: SampleSize, pixels: f64) -> Cost {
    let decoded = (384.0 * sample.texels).min(MOST_DECODED);
    Cost::new(
        0.03 + sample.images * (1.5e-4 + 5.5e-8 * pixels),
        decoded + 24.0 * pixels,
    )
}

/// An import in so many shards: what each takes, and to join their parts.
pub(super) fn import_in_shards(whole: Cost, sample: SampleSize, shards: f64) -> [Cost; 2] {
    let shard = Cost {
        seconds: 0.03 + whole.seconds / shards,
        ..whole
    };
    [shard, joining(sample)]
}

/// The most texels of which all products are kept; more are projected first.
const MOST_DENSE_TEXELS: f64 = 16_384.0;

/// Texton analysis with this many representative images of this many textons; `grid` is the side of the sub-grid on
/// which images are compared, and `channels` those that are filtered.
pub(super) fn textons(
    sample: SampleSize,
    chosen: f64,
    textons: f64,
    grid: f64,
    channels: f64,
) -> Cost {
    let dense = sample.texels.min(MOST_DENSE_TEXELS);
    let products = dense * dense * (5e-11 * channels * chosen + 7e-8) * sample.texels / dense;
    let (choice, compared) = match chosen < sample.images {
        true => (
            4.1e-9 * (sample.images * grid).powi(2),
            60e6 + 8.5 * sample.images.powi(2),
        ),
        false => (0.0, 0.0),
    };
    let centroids = 256.0 * textons * chosen * channels;
    let values = 4.0 * sample.texels * channels * chosen;
    Cost::new(
        0.1 + products + choice,
        centroids + values + compared.max(8.0 * dense * dense),
    )
}

/// A texton analysis in so many shards: what each takes, and to join their parts; `whole` is one run.
pub(super) fn textons_in_shards(
    whole: Cost,
    sample: SampleSize,
    [chosen, grid, channels]: [f64; 3],
    shards: f64,
) -> [Cost; 2] {
    let dense = sample.texels.min(MOST_DENSE_TEXELS);
    // Runs share the images' appearance vectors, of which some are chosen, or the products of all.
    let (shared, bytes) = match chosen < sample.images {
        true => (2.1e-9 * (sample.images * grid).powi(2), 33e6),
        false => (
            1.7e-11 * channels * chosen * dense * sample.texels,
            6.0 * dense * dense,
        ),
    };
    let reduction = Cost {
        seconds: whole.seconds - shared,
        ..whole
    };
    [Cost::new(0.02 + shared / shards, bytes), reduction]
}

/// The dot products of a vocabulary.
pub(super) fn gram() -> Cost {
    Cost::new(0.1, 6e6)
}

/// The neighbour table of textons.
pub(super) fn knn(texels: f64) -> Cost {
    let seconds = match texels <= MOST_DENSE_TEXELS {
        true => 2.5e-9 * texels * texels,
        false => 1e-4 * texels,
    };
    Cost::new(0.02 + seconds, 500.0 * texels)
}

/// An exemplar of plain images: their neighbour table.
pub(super) fn exemplar(texels: f64) -> Cost {
    let seconds = match texels <= MOST_DENSE_TEXELS {
        true => 1.8e-9 * texels * texels,
        false => 1.3e-4 * texels,
    };
    Cost::new(0.03 + seconds, 500.0 * texels)
}

/// A mesh read, retiled to `vertices` where they are asked for, and measured or given a field.
pub(super) fn mesh(own: f64, vertices: Option<f64>, has_field: bool) -> Cost {
    let (seconds, bytes) = match vertices {
        Some(vertices) => (
            1.5e-5 * own + 2.6e-5 * vertices,
            400.0 * own + 500.0 * vertices,
        ),
        None => (2.6e-6 * own, 400.0 * own),
    };
    let field = match has_field {
        true => 4e-5 * vertices.unwrap_or(own),
        false => 0.0,
    };
    Cost::new(0.1 + seconds + field, 14e6 + bytes)
}

/// Synthesis on this many sites, the surface's preparation included.
pub(super) fn synth(options: &SynthesisOptions, work: Workload, sites: f64) -> Cost {
    let per_site = (options.method.description().microseconds)(work, options);
    Cost::new(0.1 + 1e-6 * per_site * sites, 2_700.0 * sites)
}

/// A sequence of frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sequence {
    /// Frames.
    pub(super) frames: f64,
    /// Pixels of a frame.
    pub(super) pixels: f64,
    /// Lights of a frame.
    pub(super) lights: f64,
    /// Whether colour is computed in every pixel.
    pub(super) by_pixel: bool,
    /// Whether shadows are.
    pub(super) shadows_by_pixel: bool,
    /// Whether an even sky fills the shade.
    pub(super) has_fill: bool,
    /// Whether a ground catches the shadow.
    pub(super) has_ground: bool,
    /// How much more is read than by the default weights.
    pub(super) reads: f64,
    /// The most bytes of the sample that are kept in memory.
    pub(super) table: f64,
}

/// Frames of a surface of this many vertices.
pub(super) fn render(sample: SampleSize, vertices: f64, sequence: Sequence) -> Cost {
    let table = sample.texels * sample.images;
    let (sky, sky_in_vertex, sky_in_pixel) = match sequence.has_fill {
        true => (2e-5 * vertices, 3.3e-7, 4e-7),
        false => (0.0, 0.0, 0.0),
    };
    let setup = 0.1 + 1.3e-8 * table + 3e-6 * vertices + sky;
    let in_vertex = (6e-7 + 1.3e-7 * sequence.lights) * sequence.reads + sky_in_vertex;
    let shaded = match sequence.by_pixel {
        true => 5e-7 * sequence.lights.sqrt() * sequence.reads + sky_in_pixel,
        false => 0.0,
    };
    let shadowed = match sequence.shadows_by_pixel {
        true => 1e-7 * sequence.lights,
        false => 0.0,
    };
    let grounded = match sequence.has_ground {
        true => 2.2e-7 * sequence.lights,
        false => 0.0,
    };
    let of_vertices = vertices * in_vertex;
    let of_pixels = sequence.pixels * (1.6e-7 + shaded + shadowed + grounded);
    let kept = match sequence.by_pixel {
        true => 320.0 * sequence.pixels.min(1e6),
        false => 0.0,
    };
    Cost::new(
        setup + sequence.frames * (of_vertices + of_pixels),
        14e6 + (6.0 * table).min(sequence.table)
            + 500.0 * vertices
            + 130.0 * sequence.pixels
            + kept,
    )
}

/// The pages of a scene: the sample is factored for one, the map measured for the other.
pub(super) fn pages(sample: SampleSize, vertices: f64) -> Cost {
    let table = sample.texels * sample.images;
    Cost::new(
        1.5 + 1e-7 * table + 8e-5 * vertices,
        65e6 + 6.0 * table + 600.0 * vertices,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::Effort;

    /// A sample of 60 views by 60 lights.
    fn sample(side: f64) -> SampleSize {
        SampleSize {
            texels: side * side,
            images: 3600.0,
            lights: 60.0,
        }
    }

    fn sequence(frames: f64, pixels: f64) -> Sequence {
        Sequence {
            frames,
            pixels,
            lights: 1.0,
            by_pixel: false,
            shadows_by_pixel: false,
            has_fill: false,
            has_ground: false,
            reads: 1.0,
            table: 4e9,
        }
    }

    /// The runs that the model was fitted to: seconds of one thread, and bytes at the peak.
    #[test]
    fn the_model_is_within_a_factor_of_two_of_what_was_measured() {
        let scattered = SampleSize {
            texels: 65_536.0,
            images: 256.0,
            lights: 16.0,
        };
        let k_coherence = |side: f64, sites| {
            let mut options = SynthesisOptions::default();
            options.k_coherence.polish = Effort::Rounds(0);
            let work = Workload {
                texels: side * side,
                onto_atlas: false,
            };
            synth(&options, work, sites)
        };
        let small = 640.0 * 480.0;
        let many = textons(sample(64.0), 100.0, 200.0, 8.0, 3.0);
        let all = textons(sample(64.0), 3600.0, 200.0, 8.0, 3.0);
        let images = |side: f64, images| {
            let sample = SampleSize {
                texels: side * side,
                images,
                lights: 10.0,
            };
            import(sample, side * side)
        };
        let measured = [
            ("import 64", images(64.0, 256.0), 0.14, 15e6),
            ("import 256, EXR", images(256.0, 100.0), 0.5, 42e6),
            ("import 1024, PNG", images(1024.0, 30.0), 1.4, 158e6),
            ("bake 64", bake(sample(64.0), 1.0, 0.0, 1.9), 0.91, 22e6),
            ("bake 128", bake(sample(128.0), 1.0, 0.0, 1.9), 3.22, 41e6),
            (
                "bake 64, 4 rays",
                bake(sample(64.0), 4.0, 0.0, 1.9),
                2.84,
                22e6,
            ),
            (
                "bake 64, a bounce",
                bake(sample(64.0), 1.0, 1.0, 1.9),
                1.13,
                23e6,
            ),
            (
                "bake 256, 16 × 16",
                bake(scattered, 1.0, 0.0, 4.7),
                2.27,
                44e6,
            ),
            (
                "textons 32",
                textons(sample(32.0), 200.0, 200.0, 8.0, 3.0),
                3.99,
                208e6,
            ),
            (
                "textons 64",
                textons(sample(64.0), 200.0, 200.0, 8.0, 3.0),
                5.11,
                221e6,
            ),
            (
                "textons 128",
                textons(sample(128.0), 200.0, 200.0, 8.0, 3.0),
                30.75,
                2.29e9,
            ),
            (
                "textons 128, 400",
                textons(sample(128.0), 400.0, 400.0, 8.0, 3.0),
                41.65,
                2.30e9,
            ),
            (
                "textons 64, all",
                textons(sample(64.0), 3600.0, 400.0, 8.0, 3.0),
                10.07,
                1.38e9,
            ),
            (
                "textons 256",
                textons(scattered, 200.0, 200.0, 8.0, 3.0),
                87.88,
                2.57e9,
            ),
            (
                "textons 64, a half",
                textons_in_shards(many, sample(64.0), [100.0, 8.0, 3.0], 2.0)[0],
                1.01,
                49e6,
            ),
            (
                "textons 64, halves joined",
                textons_in_shards(many, sample(64.0), [100.0, 8.0, 3.0], 2.0)[1],
                3.53,
                221e6,
            ),
            (
                "textons 64, all, an eighth",
                textons_in_shards(all, sample(64.0), [3600.0, 8.0, 3.0], 8.0)[0],
                0.45,
                117e6,
            ),
            ("knn 128", knn(16_384.0), 0.66, 27e6),
            ("knn 256", knn(65_536.0), 6.55, 42e6),
            ("exemplar 128", exemplar(16_384.0), 0.46, 26e6),
            ("exemplar 256", exemplar(65_536.0), 8.38, 47e6),
            (
                "mesh 15000",
                mesh(60_000.0, Some(15_000.0), false),
                1.29,
                62e6,
            ),
            (
                "mesh 60000",
                mesh(60_000.0, Some(60_000.0), false),
                2.36,
                81e6,
            ),
            (
                "mesh 240000",
                mesh(60_000.0, Some(240_000.0), false),
                7.26,
                177e6,
            ),
            ("synth 15000", k_coherence(64.0, 15_000.0), 1.67, 56e6),
            ("synth 60000", k_coherence(64.0, 60_000.0), 5.67, 198e6),
            ("synth 240000", k_coherence(64.0, 240_000.0), 23.38, 662e6),
            (
                "synth 60000, 128",
                k_coherence(128.0, 60_000.0),
                7.07,
                199e6,
            ),
            (
                "render 60000",
                render(sample(64.0), 60_000.0, sequence(1.0, small)),
                0.57,
                161e6,
            ),
            (
                "render, 24",
                render(sample(64.0), 60_000.0, sequence(24.0, small)),
                2.64,
                170e6,
            ),
            (
                "render 240000",
                render(sample(64.0), 240_000.0, sequence(24.0, small)),
                5.87,
                253e6,
            ),
            (
                "render, large",
                render(sample(64.0), 60_000.0, sequence(24.0, 4.0 * small)),
                5.56,
                284e6,
            ),
            (
                "render, all in pixels",
                render(
                    sample(64.0),
                    60_000.0,
                    Sequence {
                        by_pixel: true,
                        shadows_by_pixel: true,
                        has_fill: true,
                        has_ground: true,
                        ..sequence(13.0, small)
                    },
                ),
                8.19,
                250e6,
            ),
            ("pages 60000", pages(sample(64.0), 60_000.0), 7.04, 200e6),
        ];
        for (name, cost, seconds, bytes) in measured {
            let [time, space] = [cost.seconds / seconds, cost.bytes / bytes];
            assert!((0.5..2.0).contains(&time), "{name}: {} s", cost.seconds);
            assert!((0.5..2.0).contains(&space), "{name}: {} bytes", cost.bytes);
        }
    }

    #[test]
    fn threads_share_the_work() {
        let cost = bake(sample(64.0), 4.0, 0.0, 1.9);
        assert_eq!(cost.seconds_on(1), cost.seconds);
        assert!((cost.seconds_on(2) * 1.8 - cost.seconds).abs() < 1e-9);
    }
}
