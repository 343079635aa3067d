//! How much round stencils and square patches stretch the texture where a surface bends:
//!
//! ```sh
//! cargo run --release --example stencil_stretch -- bunny.obj horse_quads.obj
//! ```
//!
//! Prints a line per mesh as JSON: the time to march the circles, and over the vertices at which curvature
//! times the radius of the neighbourhood exceeds 0.5 the median stretch (`sites::vertices::stretch`) of both kinds of
//! stencils, and the share of samples that have a place on the surface. The directions are those in which the
//! rings of the vertices begin.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a program of its own"
)]

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use mesotex::error::Result;
use mesotex::mesh::field::curvature::largest_curvatures;
use mesotex::mesh::{Connection, Rings, Topology, reading};
use mesotex::neighborhood::Template;
use mesotex::progress::Progress;
use mesotex::sites::vertices::circles::{Manifold, marching, sampling};
use mesotex::sites::vertices::patches::Patches;
use mesotex::sites::vertices::stencil::{PackedSample, PatchStencils};
use mesotex::sites::vertices::stretch::{adjacent_samples, on_one_ring, stretch};
use mesotex::sites::vertices::surface_options::texel_on;

/// Rings of the round neighbourhood; the square one has as many texels to each side.
const RINGS: u32 = 3;
/// Vertices count where the curvature times the radius exceeds this.
const BENT: f64 = 0.5;

fn main() -> ExitCode {
    for mesh in std::env::args().skip(1) {
        match line_of(Path::new(&mesh)) {
            Ok(line) => println!("{line}"),
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}

fn line_of(path: &Path) -> Result<String> {
    let quiet = Progress::silent();
    let mesh = reading::read(path, quiet)?.mesh;
    let topology = Topology::new(&mesh.triangles);
    let rings = Rings::new(&mesh, &topology);
    let texel = texel_on(&mesh, None)? as f32;
    let texels = vec![texel; mesh.positions.len()];
    let connection = Connection::new(&rings, &vec![0.0; texels.len()]);
    let radius = f64::from(RINGS as f32 * texel);
    let bent: Vec<usize> = largest_curvatures(&mesh, &rings)
        .iter()
        .enumerate()
        .filter(|(_, curvature)| **curvature * radius > BENT)
        .map(|(vertex, _)| vertex)
        .collect();

    let surface = Manifold {
        mesh: &mesh,
        topology: &topology,
        rings: &rings,
    };
    let begin = Instant::now();
    let circles = marching::march(surface, &texels, RINGS, quiet)?;
    let seconds = begin.elapsed().as_secs_f64();
    let round = Template::round(RINGS);
    let (of_circles, _) = sampling::stencils(&circles, surface, &connection.frames, &round)?;

    let square = Template::square(2 * RINGS + 1);
    let patches = Patches {
        mesh: &mesh,
        connection: &connection,
        texels: &texels,
    };
    let half = RINGS as f32 + 0.5;
    let of_patches = patches.round_vertices(&square, half, quiet)?.stencils;
    let median_of = |stencils: &PatchStencils, template: &Template, pairs: &[[usize; 2]]| {
        let all = stretch(&mesh, stencils, template, pairs, &texels);
        median(bent.iter().map(|&vertex| all[vertex]).collect())
    };
    let pairs = adjacent_samples(&round);
    let (on_rings, between): (Vec<_>, Vec<_>) =
        pairs.iter().partition(|&&pair| on_one_ring(&round, pair));
    Ok(format!(
        r#"{{"mesh": {:?}, "vertices": {}, "bent": {}, "seconds_marching": {seconds:.3}, "arcs": {}, "near": {}, "round": {{"stretch": {:.4}, "on_rings": {:.4}, "between_rings": {:.4}, "valued": {:.4}}}, "square": {{"stretch": {:.4}, "valued": {:.4}}}}}"#,
        path.file_name().unwrap_or_default(),
        mesh.referenced_count(),
        bent.len(),
        circles.arcs.entries.len(),
        circles.near.entries.len(),
        median_of(&of_circles, &round, &pairs),
        median_of(&of_circles, &round, &on_rings),
        median_of(&of_circles, &round, &between),
        valued(&of_circles, &bent),
        median_of(&of_patches, &square, &adjacent_samples(&square)),
        valued(&of_patches, &bent),
    ))
}

fn median(mut values: Vec<f32>) -> f32 {
    values.retain(|value| !value.is_nan());
    values.sort_by(f32::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f32::NAN)
}

/// The share of samples round some vertices that have a place on the surface.
fn valued(stencils: &PatchStencils, vertices: &[usize]) -> f64 {
    let per_site = stencils.samples_per_site;
    let samples = |vertex: &usize| &stencils.samples[vertex * per_site..][..per_site];
    let all = vertices.iter().flat_map(samples);
    let with_place = all.filter(|sample| **sample != PackedSample::OUTSIDE);
    with_place.count() as f64 / (vertices.len() * per_site).max(1) as f64
}
