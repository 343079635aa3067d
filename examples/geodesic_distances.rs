//! Geodesic distances from a vertex of a mesh file to all others, for comparison with other programs
//! (`tools/compare_geodesics.py`):
//!
//! ```sh
//! cargo run --release --example geodesic_distances -- bunny.obj 0 distances.npy
//! ```
//!
//! Writes f64 [vertices of the mesh as cleaned], and prints the seconds that the front took.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a program of its own"
)]

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use mesotex::error::{Error, Result};
use mesotex::format::npy;
use mesotex::mesh::{GeodesicDistances, Rings, Topology, reading};
use mesotex::progress::Progress;
use ndarray::ArrayView1;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, vertex, output] = &arguments[..] else {
        eprintln!("geodesic_distances MESH VERTEX DISTANCES.npy");
        return ExitCode::from(2);
    };
    match write(Path::new(mesh), vertex, Path::new(output)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn write(mesh: &Path, vertex: &str, output: &Path) -> Result<()> {
    let mesh = reading::read(mesh, Progress::silent())?.mesh;
    let count = mesh.positions.len();
    let vertex = vertex
        .parse()
        .ok()
        .filter(|&vertex: &u32| (vertex as usize) < count);
    let expected = || format!("below {count}");
    let vertex =
        vertex.ok_or_else(|| Error::option("VERTEX", "another".to_string(), expected()))?;
    let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
    let begin = Instant::now();
    let surface = GeodesicDistances {
        mesh: &mesh,
        rings: &rings,
    };
    let distances = surface.from_vertex(vertex);
    println!("{:.3} s", begin.elapsed().as_secs_f64());
    npy::write(output, ArrayView1::from(&distances).into_dyn())
}
