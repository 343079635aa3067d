//! How much memory meshes take while they are retiled and prepared, before any work is done.
//!
//! Figures are of the lists that dominate, measured on meshes of 30,000 to 250,000 vertices: at most 1.5
//! times the peak of the process, and not below it.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use crate::mesh::reading::UserMesh;
use crate::neighborhood::Template;
use crate::sites::vertices::circles::RoundOptions;
use crate::sites::vertices::circles::marching::MOST_NEIGHBORS;
use crate::sites::vertices::surface_options::SurfaceOptions;

/// Bytes a retiled vertex needs at the most, all working lists counted.
const RETILED_VERTEX: u64 = 2500;
/// Bytes per vertex that a prepared level needs beside samples and neighbours: mesh, frames, parents.
const PREPARED_VERTEX: u64 = 220;
/// Bytes per vertex that the finest level needs while its rings, field and hierarchy are made.
const WORKED_VERTEX: u64 = 700;
/// Bytes of a packed sample, of a neighbour, and of an arc of a circle or a vertex near one.
const SAMPLE: u64 = 8;
const NEIGHBOR: u64 = 12;
const ARC: u64 = 8;
/// Arcs of a circle: at least this many, and so many more for each time its radius holds the mean distance of
/// vertices (2π times the crossings per length of a line over a triangle mesh, 2.2).
const FEWEST_ARCS: f64 = 24.0;
const ARCS_PER_RADIUS: f64 = 14.0;
/// The program, and working memory of its threads.
const PROGRAM: u64 = 16 << 20;

/// Bytes that retiling to this many vertices takes.
pub fn bytes_to_retile(vertices: usize) -> u64 {
    RETILED_VERTEX.saturating_mul(vertices as u64)
}

/// How many vertices fit so many bytes while they are retiled.
pub fn vertices_retiled_in(bytes: u64) -> u64 {
    bytes / RETILED_VERTEX
}

/// Bytes that preparing a surface takes: per level the samples of both windows and the neighbours, which
/// are held twice at the finest level while they are joined. `texel` is the finest level's.
pub fn bytes_to_prepare(user: &UserMesh, options: &SurfaceOptions, texel: f64) -> u64 {
    let vertices = user.mesh.positions.len() as u64;
    let samples = |width: u32| u64::from(width) * u64::from(width);
    let (fine, coarse) = (
        samples(options.neighborhood),
        samples(options.coarse_neighborhood),
    );
    let near = vertices_near(user, f64::from(options.neighborhood) * texel);
    let window = (SAMPLE * fine) as f64 + NEIGHBOR as f64 * near;
    let kept = window + (SAMPLE * coarse + PREPARED_VERTEX) as f64;
    // Each coarser level has a quarter of the vertices.
    let levels: f64 = (0..options.levels)
        .map(|level| 0.25_f64.powi(level as i32))
        .sum();
    let a_vertex = kept * levels + window + WORKED_VERTEX as f64;
    (a_vertex * vertices as f64) as u64 + PROGRAM
}

/// Bytes that preparing round sites takes: per level the samples and neighbours, and the circles of the
/// coarsest level, which are held twice while they are joined. `texel` is the finest level's.
pub fn bytes_to_march(user: &UserMesh, options: &RoundOptions, texel: f64) -> u64 {
    let vertices = user.mesh.positions.len() as f64;
    let spacing = (user.mesh.area() / vertices.max(1.0)).sqrt();
    let scale = largest_scale(user);
    let radius = texel * f64::from(scale) * f64::from(1_u32 << (options.levels - 1)) / spacing;
    let arcs: f64 = (1..=options.rings)
        .map(|ring| FEWEST_ARCS + ARCS_PER_RADIUS * f64::from(ring) * radius)
        .sum();
    let circles = 2.0 * (ARC as f64) * (arcs + MOST_NEIGHBORS as f64);
    let samples = Template::round(options.rings).positions.len() as u64;
    let of_level = SAMPLE * samples + NEIGHBOR * MOST_NEIGHBORS as u64;
    let kept = f64::from(options.levels) * of_level as f64;
    ((circles + kept + WORKED_VERTEX as f64) * vertices) as u64 + PROGRAM
}

/// The largest scale of a vertex, 1 without.
fn largest_scale(user: &UserMesh) -> f32 {
    user.scale
        .as_ref()
        .map_or(1.0, |scale| scale.iter().copied().fold(1.0, f32::max))
}

/// How many vertices lie in the window round a vertex, on average: as many as share a cube of the window's width with
/// it.
fn vertices_near(user: &UserMesh, width: f64) -> f64 {
    let mesh = &user.mesh;
    let width = (width as f32 * largest_scale(user)).max(f32::MIN_POSITIVE);
    let (low, high) = mesh.bounds();
    if width >= (high - low).max_element() {
        return mesh.positions.len() as f64;
    }
    let cell = |position: &Vec3| -> IVec3 { ((position - low) / width).floor().as_ivec3() };
    let mut cells: HashMap<IVec3, u64> = HashMap::new();
    for position in &mesh.positions {
        *cells.entry(cell(position)).or_default() += 1;
    }
    let pairs: f64 = cells.values().map(|&count| (count * count) as f64).sum();
    pairs / (mesh.positions.len() as f64).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::rings::Rings;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;
    use crate::progress::Progress;
    use crate::sites::vertices::circles::Manifold;
    use crate::sites::vertices::circles::marching::march;
    use crate::sites::vertices::surface::prepare;

    #[test]
    fn the_vertices_of_a_window_are_about_those_found() {
        for (side, texel) in [(40, 0.5), (40, 1.0), (30, 4.0)] {
            let user = UserMesh {
                mesh: shapes::grid(side, side, 0.5),
                ..UserMesh::default()
            };
            let options = SurfaceOptions {
                levels: 1,
                texel: Some(texel),
                ..SurfaceOptions::default()
            };
            let surface = prepare(&user, &options, None, Progress::silent()).unwrap();
            let sites = &surface.levels[0].sites;
            let found: usize = (0..sites.areas.len())
                .map(|site| sites.neighbors.row(site).len())
                .sum();
            let mean = found as f64 / sites.areas.len() as f64;
            let told = vertices_near(&user, 7.0 * texel);
            assert!(
                (0.6..2.0).contains(&(told / mean)),
                "{texel}: {told} of {mean}"
            );
        }
    }

    #[test]
    fn the_arcs_of_a_circle_are_about_those_marched() {
        let mesh = shapes::torus(90, 40, 1.0, 0.4);
        let topology = Topology::new(&mesh.triangles);
        let rings = Rings::new(&mesh, &topology);
        let surface = Manifold {
            mesh: &mesh,
            topology: &topology,
            rings: &rings,
        };
        let spacing = (mesh.area() / mesh.positions.len() as f64).sqrt();
        let radii = vec![spacing as f32; mesh.positions.len()];
        let circles = march(surface, &radii, 4, Progress::silent()).unwrap();
        let told = 4.0 * FEWEST_ARCS + 10.0 * ARCS_PER_RADIUS;
        let found = circles.arcs.entries.len() as f64 / radii.len() as f64;
        assert!((0.6..1.0).contains(&(found / told)), "{found} of {told}");
    }

    #[test]
    fn a_texel_that_covers_the_mesh_takes_memory_for_all_pairs() {
        let mesh = shapes::grid(100, 100, 1.0);
        let pairs = (mesh.positions.len() * mesh.positions.len()) as u64;
        let user = UserMesh {
            mesh,
            ..UserMesh::default()
        };
        let bytes = bytes_to_prepare(&user, &SurfaceOptions::default(), 100.0);
        assert!(bytes > 12 * pairs);
    }
}
