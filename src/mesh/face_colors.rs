//! Triangles in two colours, no two alike across an edge; and base meshes that have such colours.
//!
//! In: a manifold mesh. Out: a colour per triangle, or the triangle where two colours do not suffice. Castellanos
//! and Williams §3.9 say that even valences of all inner vertices suffice. That holds on spheres and disks only: on
//! a torus an odd cycle of triangles round a handle can remain. So the dual graph itself is coloured.

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use glam::Vec3;

use crate::error::{Error, Result};
use crate::mesh::retile::{retile, retile_evenly};
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::topology::{NONE, Topology, ends};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// Triangles that barycentric subdivision makes of one.
pub const BARYCENTRIC_PARTS: usize = 6;
/// The fewest and the most triangles a base mesh is asked for.
const FACES: RangeInclusive<usize> = 8..=1 << 24;

/// Whether each triangle is white; the smallest triangle of every component is.
///
/// `Err` holds a triangle on an odd cycle of the dual graph: the mesh has no two colours.
pub fn two_coloring(topology: &Topology) -> std::result::Result<Vec<bool>, u32> {
    let faces = topology.opposite.len() / 3;
    let mut white: Vec<Option<bool>> = vec![None; faces];
    let mut queue = VecDeque::new();
    for seed in 0..faces {
        if white[seed].is_some() {
            continue;
        }
        white[seed] = Some(true);
        queue.push_back((seed as u32, true));
        while let Some((face, own)) = queue.pop_front() {
            for neighbor in across_edges(topology, face) {
                match white[neighbor as usize] {
                    Some(other) if other == own => return Err(neighbor),
                    Some(_) => {}
                    None => {
                        white[neighbor as usize] = Some(!own);
                        queue.push_back((neighbor, !own));
                    }
                }
            }
        }
    }
    Ok(white.into_iter().map(|color| color == Some(true)).collect())
}

/// The triangles across the edges of one, in the order of its edges.
pub fn across_edges(topology: &Topology, face: u32) -> impl Iterator<Item = u32> + '_ {
    let twins = &topology.opposite[3 * face as usize..][..3];
    let inner = twins.iter().filter(|&&twin| twin != NONE);
    inner.map(|twin| twin / 3)
}

/// How a base mesh came to have two colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coloring {
    /// The mesh that was given has them, and about as many triangles as asked.
    Given,
    /// The retiled mesh has them, since edges were split to make all valences even.
    Retiled,
    /// A coarser retiled mesh was subdivided barycentrically, because the retiled mesh has none.
    Barycentric,
}

/// A mesh whose triangles have two colours.
#[derive(Clone, Debug, PartialEq)]
pub struct ColoredMesh {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// Whether each triangle is white.
    pub white: Vec<bool>,
    /// How it came to have two colours.
    pub coloring: Coloring,
}

impl ColoredMesh {
    /// A mesh with its two colours, if it has them.
    fn of(mesh: TriangleMesh, coloring: Coloring) -> Option<Self> {
        let white = two_coloring(&Topology::new(&mesh.triangles)).ok()?;
        Some(Self {
            mesh,
            white,
            coloring,
        })
    }
}

/// A two-coloured mesh of about `faces` triangles on the surface of a manifold mesh; `crease` in radians.
///
/// The mesh itself is taken if it has two colours and the count is off by a tenth at most. Otherwise it is retiled to
/// about that many triangles with even valences and even walks round handles. If two colours do not suffice for the
/// result, where creases or very many handles stand in the way, it is retiled to a sixth of them, and every triangle is
/// cut at its barycentre and the middles of its edges. That has two colours on every orientable surface: triangles of
/// one colour keep the order corner, middle, barycentre. Fewer triangles than the shape needs are not reached.
///
/// Errors: `base-faces` below 8 or above 2²⁴; a mesh that is not manifold or has no triangle.
pub fn colored_base(
    mesh: &TriangleMesh,
    faces: usize,
    crease: f64,
    progress: Progress<'_>,
) -> Result<ColoredMesh> {
    check_base(mesh, faces)?;
    if mesh.triangles.len().abs_diff(faces) <= faces / 10
        && let Some(given) = ColoredMesh::of(mesh.clone(), Coloring::Given)
    {
        return Ok(given);
    }
    let even = retile_evenly(mesh, vertices_of(mesh, faces), crease, progress)?;
    if let Some(retiled) = ColoredMesh::of(even, Coloring::Retiled) {
        return Ok(retiled);
    }
    let sixth = vertices_of(mesh, faces.div_ceil(BARYCENTRIC_PARTS));
    let coarse = retile(mesh, sixth, crease, progress)?;
    let mut cut = barycentric(&coarse);
    let surface = SurfaceBvh::new(mesh);
    for position in &mut cut.mesh.positions[coarse.positions.len()..] {
        if let Some(nearest) = surface.nearest(*position) {
            *position = nearest.position;
        }
    }
    Ok(cut)
}

fn check_base(mesh: &TriangleMesh, faces: usize) -> Result<()> {
    if !FACES.contains(&faces) {
        let expected = format!("{} to {}", FACES.start(), FACES.end());
        return Err(Error::option("base-faces", faces.to_string(), expected));
    }
    if mesh.triangles.is_empty() {
        return Err(Error::data("mesh", "no triangles").expected("at least one"));
    }
    match Topology::new(&mesh.triangles).non_manifold.first() {
        None => Ok(()),
        Some([a, b]) => Err(Error::data(
            format!("edge {a}–{b}"),
            "more than two triangles, or two that run along it in the same direction",
        )
        .expected("a manifold mesh")
        .advice("run `mesotex mesh` on it, which splits such edges")),
    }
}

/// The vertices of a mesh of the same shape with this many triangles: V = (F + 2χ + b) / 2 with b boundary edges,
/// whose number grows as the square root of the triangles'.
fn vertices_of(mesh: &TriangleMesh, faces: usize) -> usize {
    let topology = Topology::new(&mesh.triangles);
    let shape = topology.shape(mesh);
    let boundary: f64 = topology
        .boundary_half_edges()
        .map(|half_edge| {
            let [a, b] = ends(&mesh.triangles, half_edge);
            f64::from(mesh.positions[a as usize].distance(mesh.positions[b as usize]))
        })
        .sum();
    let area = mesh.area() / faces as f64;
    let edge = (area * 4.0 / 3f64.sqrt()).sqrt();
    let boundary_edges = if edge > 0.0 { boundary / edge } else { 0.0 };
    let vertices = (faces as f64 + boundary_edges) / 2.0 + shape.euler_characteristic as f64;
    vertices.round().max(4.0) as usize
}

/// Every triangle cut in six at its barycentre and the middles of its edges, with the two colours that this gives.
///
/// Vertices of the mesh come first and keep their numbers, then the middles of edges, then the barycentres.
/// Triangles 6·t … 6·t + 5 lie in triangle t, round its barycentre.
pub fn barycentric(mesh: &TriangleMesh) -> ColoredMesh {
    let topology = Topology::new(&mesh.triangles);
    let mut positions = mesh.positions.clone();
    let middles = edge_vertices(&topology, positions.len() as u32);
    for (half_edge, &twin) in topology.opposite.iter().enumerate() {
        if twin == NONE || half_edge < twin as usize {
            let [a, b] = ends(&mesh.triangles, half_edge as u32);
            positions.push(positions[a as usize].midpoint(positions[b as usize]));
        }
    }
    let mut triangles = Vec::with_capacity(mesh.triangles.len() * BARYCENTRIC_PARTS);
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let center = positions.len() as u32;
        positions.push(mesh.corners(triangle).into_iter().sum::<Vec3>() / 3.0);
        for corner in 0..3 {
            let middle = middles[3 * triangle + corner];
            triangles.push([corners[corner], middle, center]);
            triangles.push([middle, corners[(corner + 1) % 3], center]);
        }
    }
    ColoredMesh {
        white: (0..triangles.len()).map(|part| part % 2 == 0).collect(),
        mesh: TriangleMesh {
            positions,
            triangles,
        },
        coloring: Coloring::Barycentric,
    }
}

/// The number of a new vertex on every edge, per half-edge, counted from `first` in the order of the edges' smaller
/// half-edges.
pub(crate) fn edge_vertices(topology: &Topology, first: u32) -> Vec<u32> {
    let mut next = first;
    let mut numbers = vec![NONE; topology.opposite.len()];
    for half_edge in 0..topology.opposite.len() {
        let twin = topology.opposite[half_edge] as usize;
        if twin < half_edge {
            numbers[half_edge] = numbers[twin];
        } else {
            numbers[half_edge] = next;
            next += 1;
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn colors(mesh: &TriangleMesh) -> Option<Vec<bool>> {
        two_coloring(&Topology::new(&mesh.triangles)).ok()
    }

    fn assert_proper(mesh: &TriangleMesh, white: &[bool]) {
        let topology = Topology::new(&mesh.triangles);
        for (half_edge, &twin) in topology.opposite.iter().enumerate() {
            let own = white[half_edge / 3];
            assert!(twin == NONE || white[twin as usize / 3] != own);
        }
    }

    /// Four rings of 4, 5, 4 and 5 vertices, joined by strips of nine triangles. The strips on both sides of a ring
    /// are mirror images, so every vertex has as many edges to one side as to the other.
    fn all_even_torus() -> TriangleMesh {
        let rings: [(u32, u32); 4] = [(0, 4), (4, 5), (9, 4), (13, 5)];
        let mut triangles = Vec::new();
        for ring in 0..4 {
            let (low, high) = (rings[ring], rings[(ring + 1) % 4]);
            let ((four, five), is_mirrored) = match low.1 {
                4 => ((low, high), false),
                _ => ((high, low), true),
            };
            let at = |(first, count): (u32, u32), index: u32| first + index % count;
            let (mut i, mut j) = (0, 0);
            for along_four in [true, false, true, false, true, false, true, false, false] {
                let (a, b) = (at(four, i), at(five, j));
                let [p, q, r] = match along_four {
                    true => [a, at(four, i + 1), b],
                    false => [a, at(five, j + 1), b],
                };
                triangles.push(if is_mirrored { [p, r, q] } else { [p, q, r] });
                (i, j) = (i + u32::from(along_four), j + u32::from(!along_four));
            }
        }
        TriangleMesh {
            positions: (0..18).map(|v| Vec3::splat(v as f32)).collect(),
            triangles,
        }
    }

    /// Two tori side by side, joined by a tube of six triangles between a triangle of each.
    fn double_torus() -> TriangleMesh {
        let mut mesh = shapes::torus(12, 8, 1.0, 0.4);
        let second = mesh.positions.len() as u32;
        let turned = |p: &Vec3| Vec3::new(3.4 - p.x, -p.y, p.z);
        let moved: Vec<Vec3> = mesh.positions.iter().map(turned).collect();
        let others: Vec<[u32; 3]> = mesh
            .triangles
            .iter()
            .map(|t| t.map(|v| v + second))
            .collect();
        mesh.positions.extend(moved);
        let [a, b, c] = mesh.triangles.remove(0);
        let [p, q, r] = others[0];
        mesh.triangles.extend(&others[1..]);
        for [a, b, p, q] in [[a, b, p, q], [b, c, r, p], [c, a, q, r]] {
            mesh.triangles.extend([[a, b, p], [a, p, q]]);
        }
        mesh
    }

    #[test]
    fn lattices_have_two_colors() {
        for mesh in [
            shapes::grid(4, 3, 1.0),
            shapes::torus(12, 8, 1.0, 0.4),
            shapes::cylinder(8, 3, 1.0, 0.5),
        ] {
            assert_proper(&mesh, &colors(&mesh).unwrap());
        }
        assert_eq!(colors(&shapes::icosphere(0)), None);
    }

    #[test]
    fn even_valences_do_not_suffice_on_a_torus() {
        let mesh = all_even_torus();
        let topology = Topology::new(&mesh.triangles);
        assert!(topology.non_manifold.is_empty());
        let shape = topology.shape(&mesh);
        assert_eq!((shape.boundaries, shape.euler_characteristic), (0, 0));
        let mut valences = [0; 18];
        for &vertex in mesh.triangles.iter().flatten() {
            valences[vertex as usize] += 1;
        }
        assert!(valences.iter().all(|valence| valence % 2 == 0));
        assert_eq!(colors(&mesh), None);
        let cut = barycentric(&mesh);
        assert_proper(&cut.mesh, &cut.white);
    }

    #[test]
    fn barycentric_subdivision_has_two_colors_and_keeps_the_shape() {
        let torus = double_torus();
        let topology = Topology::new(&torus.triangles);
        assert_eq!(topology.shape(&torus).euler_characteristic, -2);
        let mut open = shapes::icosphere(1);
        open.triangles.truncate(70);
        for mesh in [torus, open, shapes::grid(3, 2, 1.0)] {
            let cut = barycentric(&mesh);
            assert_eq!(cut.mesh.triangles.len(), 6 * mesh.triangles.len());
            assert_proper(&cut.mesh, &cut.white);
            let topology = Topology::new(&cut.mesh.triangles);
            assert!(topology.non_manifold.is_empty());
            let before = Topology::new(&mesh.triangles).shape(&mesh);
            assert_eq!(topology.shape(&cut.mesh), before);
            assert!((cut.mesh.area() / mesh.area() - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn base_meshes_have_two_colors_and_about_the_faces_asked_for() {
        let mut open = shapes::icosphere(3);
        open.triangles
            .retain(|&[a, ..]| open.positions[a as usize].z < 0.7);
        for mesh in [shapes::torus(30, 16, 1.0, 0.4), double_torus(), open] {
            let base = colored_base(&mesh, 1800, 0.7, Progress::silent()).unwrap();
            assert_eq!(base.coloring, Coloring::Retiled);
            assert_proper(&base.mesh, &base.white);
            let faces = base.mesh.triangles.len();
            assert!((1500..=2100).contains(&faces), "{faces}");
            let shape = |mesh: &TriangleMesh| Topology::new(&mesh.triangles).shape(mesh);
            assert_eq!(
                shape(&base.mesh).euler_characteristic,
                shape(&mesh).euler_characteristic
            );
            assert_eq!(shape(&base.mesh).boundaries, shape(&mesh).boundaries);
        }
    }

    #[test]
    fn a_mesh_with_two_colors_and_the_right_count_is_kept() {
        let torus = shapes::torus(30, 16, 1.0, 0.4);
        let base = |faces| colored_base(&torus, faces, 0.7, Progress::silent()).unwrap();
        assert_eq!(base(1000).coloring, Coloring::Given);
        assert_eq!(base(1000).mesh, torus);
        assert_ne!(base(1500).coloring, Coloring::Given);
    }

    #[test]
    fn meshes_and_counts_that_cannot_be_used_are_refused() {
        let base = |mesh: &TriangleMesh, faces| colored_base(mesh, faces, 0.7, Progress::silent());
        let sphere = shapes::icosphere(1);
        let few = base(&sphere, 7).unwrap_err().to_string();
        assert!(few.contains("--base-faces: 7"), "{few}");
        assert!(base(&sphere, usize::MAX).is_err());
        let mut fan = shapes::grid(1, 1, 1.0);
        fan.triangles = vec![[0, 1, 2], [1, 0, 3], [0, 1, 3]];
        let fan = base(&fan, 100).unwrap_err().to_string();
        assert!(fan.contains("edge 0–1"), "{fan}");
        assert!(base(&TriangleMesh::default(), 100).is_err());
    }
}
