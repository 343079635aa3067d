//! Mesh preparation at its users' sizes: `cargo bench --bench mesh`.

use divan::Bencher;
use mesotex::mesh::builtin::kettlebell;
use mesotex::mesh::field::{FieldConstraints, orientation_field};
use mesotex::mesh::reading::UserMesh;
use mesotex::mesh::{Connection, Rings, Topology, TriangleMesh, frames_of, retile};
use mesotex::neighborhood::Template;
use mesotex::progress::Progress;
use mesotex::sites::SurfaceOptions;
use mesotex::sites::vertices::circles::{Manifold, marching, sampling};
use mesotex::sites::vertices::patches::Patches;
use mesotex::sites::vertices::surface::prepare;

const VERTICES: usize = 250_000;
const CREASE: f64 = 0.7;

fn main() {
    divan::main();
}

fn even(vertices: usize) -> TriangleMesh {
    retile(&kettlebell(40_000), vertices, CREASE, Progress::silent()).unwrap_or_default()
}

fn user(mesh: TriangleMesh) -> UserMesh {
    UserMesh::from(mesh)
}

/// 40,000 vertices to 250,000.
#[divan::bench(sample_count = 3)]
fn retile_to_250k(bencher: Bencher) {
    let mesh = kettlebell(40_000);
    bencher.bench_local(|| retile(&mesh, VERTICES, CREASE, Progress::silent()));
}

/// Pyramid of 4 levels, field, parents, two-level stencils.
#[divan::bench(sample_count = 3)]
fn prepare_250k(bencher: Bencher) {
    let user = user(even(VERTICES));
    let options = SurfaceOptions::default();
    bencher.bench_local(|| prepare(&user, &options, None, Progress::silent()));
}

/// The field alone: the smallest eigenvector of the connection Laplacian.
#[divan::bench(sample_count = 3)]
fn field_250k(bencher: Bencher) {
    let mesh = even(VERTICES);
    let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
    bencher.bench_local(|| {
        orientation_field(
            &mesh,
            &rings,
            &FieldConstraints::default(),
            0,
            Progress::silent(),
        )
    });
}

/// 7×7 stencils and neighbours of every vertex.
#[divan::bench(sample_count = 3)]
fn stencils_250k(bencher: Bencher) {
    let mesh = even(VERTICES);
    let rings = Rings::new(&mesh, &Topology::new(&mesh.triangles));
    let connection = Connection::new(&rings, &vec![0.0; mesh.positions.len()]);
    let texel = (mesh.area() / VERTICES as f64).sqrt() as f32;
    let texels = vec![texel; mesh.positions.len()];
    let patches = Patches {
        mesh: &mesh,
        connection: &connection,
        texels: &texels,
    };
    bencher.bench_local(|| patches.round_vertices(&Template::square(7), 3.5, Progress::silent()));
}

/// Circles of every vertex: 4 rings a texel apart.
#[divan::bench(sample_count = 5, args = [34_834, 48_485])]
fn circles(bencher: Bencher, vertices: usize) {
    let mesh = even(vertices);
    let topology = Topology::new(&mesh.triangles);
    let rings = Rings::new(&mesh, &topology);
    let surface = Manifold {
        mesh: &mesh,
        topology: &topology,
        rings: &rings,
    };
    let texels = vec![(mesh.area() / vertices as f64).sqrt() as f32; mesh.positions.len()];
    bencher.bench_local(|| marching::march(surface, &texels, 4, Progress::silent()));
}

/// Samples and neighbours of circles that are there, for one field.
#[divan::bench(sample_count = 5)]
fn samples_on_circles_35k(bencher: Bencher) {
    let mesh = even(34_834);
    let topology = Topology::new(&mesh.triangles);
    let rings = Rings::new(&mesh, &topology);
    let surface = Manifold {
        mesh: &mesh,
        topology: &topology,
        rings: &rings,
    };
    let texels = vec![(mesh.area() / 34_834.0).sqrt() as f32; mesh.positions.len()];
    let Ok(circles) = marching::march(surface, &texels, 4, Progress::silent()) else {
        return;
    };
    let frames = frames_of(&rings, &vec![0.0; texels.len()]);
    let template = Template::round(4);
    bencher.bench_local(|| {
        let stencils = sampling::stencils(&circles, surface, &frames, &template);
        (stencils, sampling::neighbors(&circles, surface, &frames))
    });
}
