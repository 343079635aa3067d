//! Coverage against rays: no cracks, no sample twice, exact points.

use glam::{DVec3, Vec3};
use rand::Rng;

use super::*;
use crate::random;
use crate::render::camera::{Camera, Projection};

fn view(projection: Projection, size: [u32; 2]) -> View {
    let camera = Camera {
        position: DVec3::new(0.3, -0.2, 4.0),
        target: DVec3::new(0.0, 0.1, 0.0),
        up: DVec3::Y,
        projection,
    };
    View::new(camera, size).unwrap()
}

const PERSPECTIVE: Projection = Projection::Perspective { vertical_fov: 0.6 };
const ORTHOGRAPHIC: Projection = Projection::Orthographic { height: 3.0 };

/// A grid over a square of half side 2.5 in z = 0, its inner vertices jittered: covers the image.
fn wall(cells: usize, seed: u64) -> TriangleMesh {
    let mut stream = random::stream(seed, "wall", 0, 0);
    let mut mesh = TriangleMesh::default();
    for j in 0..=cells {
        for i in 0..=cells {
            let mut at = |k: usize| {
                let inner = k != 0 && k != cells;
                let jitter = if inner {
                    stream.gen_range(-0.4..0.4)
                } else {
                    0.0
                };
                5.0 * ((k as f32 + jitter) / cells as f32 - 0.5)
            };
            mesh.positions.push(Vec3::new(at(i), at(j), 0.0));
        }
    }
    for j in 0..cells as u32 {
        for i in 0..cells as u32 {
            let a = j * (cells as u32 + 1) + i;
            let (b, c, d) = (a + 1, a + cells as u32 + 2, a + cells as u32 + 1);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[test]
fn a_wall_has_no_cracks_at_any_triangle_size() {
    for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
        for cells in [2, 17, 150] {
            let view = view(projection, [97, 70]);
            let mesh = wall(cells, 3);
            let buffer =
                SurfaceBuffer::draw(&view, &mesh, Samples::Sixteen, 1e-3, Progress::silent());
            for row in 0..70 {
                for column in 0..97 {
                    let hits = buffer.pixel(column, row);
                    assert_eq!(hits.len(), 17);
                    assert!(hits.iter().all(Hit::is_surface), "{cells}: {column} {row}");
                }
            }
        }
    }
}

#[test]
fn shared_edges_belong_to_one_triangle() {
    // Drawn alone, the triangles of a wall cover every sample of the image exactly once.
    let view = view(ORTHOGRAPHIC, [40, 30]);
    let mesh = wall(9, 5);
    let mut covered = vec![0; 40 * 30 * 5];
    for triangle in &mesh.triangles {
        let alone = TriangleMesh {
            positions: mesh.positions.clone(),
            triangles: vec![*triangle],
        };
        let buffer = SurfaceBuffer::draw(&view, &alone, Samples::Four, 1e-3, Progress::silent());
        for pixel in 0..1200u32 {
            for (sample, hit) in buffer.pixel(pixel % 40, pixel / 40).iter().enumerate() {
                covered[pixel as usize * 5 + sample] += u32::from(hit.is_surface());
            }
        }
    }
    assert!(covered.iter().all(|&count| count == 1));
}

/// Where the ray through a point of the image meets a triangle: weights and depth.
fn cast(view: &View, pixel: (f64, f64), corners: [Vec3; 3]) -> Option<([f64; 3], f64)> {
    let [a, b, c] = corners.map(|p| view.camera_from_world(p.as_dvec3()));
    let scale = view.pixels_per_unit_at(1.0);
    let x = (pixel.0 - 0.5 * f64::from(view.size[0])) / scale;
    let y = (0.5 * f64::from(view.size[1]) - pixel.1) / scale;
    let (origin, direction) = if view.is_perspective() {
        (DVec3::ZERO, DVec3::new(x, y, 1.0))
    } else {
        (DVec3::new(x, y, 0.0), DVec3::Z)
    };
    let normal = (b - a).cross(c - a);
    let depth = normal.dot(a - origin) / normal.dot(direction);
    let p = origin + direction * depth;
    let part = |q: DVec3, r: DVec3| normal.dot((q - p).cross(r - p)) / normal.length_squared();
    let weights = [part(b, c), part(c, a), part(a, b)];
    (weights.iter().all(|&w| w >= 0.0) && depth > 0.0).then_some((weights, depth))
}

#[test]
fn the_nearest_triangle_is_seen_at_the_point_a_ray_meets() {
    let mut stream = random::stream(1, "triangles", 0, 0);
    let mut mesh = TriangleMesh::default();
    for t in 0..60u32 {
        let centre = Vec3::from_array([0; 3].map(|_| stream.gen_range(-0.8..0.8)));
        for _ in 0..3 {
            let offset = Vec3::from_array([0; 3].map(|_| stream.gen_range(-0.5..0.5)));
            mesh.positions.push(centre + offset);
        }
        mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
    }
    for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
        let view = view(projection, [64, 64]);
        let buffer = SurfaceBuffer::draw(&view, &mesh, Samples::One, 1e-3, Progress::silent());
        let mut agree = 0;
        let mut seen = 0;
        for pixel in 0..64 * 64u32 {
            let (column, row) = (pixel % 64, pixel / 64);
            let at = (f64::from(column) + 0.5, f64::from(row) + 0.5);
            let nearest = (0..60u32)
                .filter_map(|t| cast(&view, at, mesh.corners(t as usize)).map(|hit| (t, hit)))
                .min_by(|a, b| a.1.1.total_cmp(&b.1.1));
            let hit = buffer
                .pixel(column, row)
                .first()
                .copied()
                .unwrap_or(Hit::MISS);
            seen += u32::from(hit.is_surface());
            let Some((triangle, (weights, _))) = nearest else {
                agree += u32::from(!hit.is_surface());
                continue;
            };
            if hit.triangle == triangle {
                agree += 1;
                for (found, wanted) in hit.barycentric().iter().zip(weights) {
                    assert!(
                        (f64::from(*found) - wanted).abs() < 0.03,
                        "{hit:?} {weights:?}"
                    );
                }
            }
        }
        assert!(seen > 1000, "{seen}");
        // Snapping to 1/256 pixel may move a silhouette across a few pixel centres.
        assert!(agree >= 64 * 64 - 12, "{agree}");
    }
}

#[test]
fn triangles_behind_the_camera_are_cut() {
    // A floor from far ahead to far behind the camera fills the image's lower half.
    let mesh = TriangleMesh {
        positions: vec![
            Vec3::new(-1e5, -1.0, 1e5),
            Vec3::new(1e5, -1.0, 1e5),
            Vec3::new(0.0, -1.0, -1e6),
        ],
        triangles: vec![[0, 1, 2]],
    };
    let camera = Camera {
        position: DVec3::ZERO,
        target: -DVec3::Z,
        up: DVec3::Y,
        projection: Projection::Perspective { vertical_fov: 1.0 },
    };
    let view = View::new(camera, [32, 32]).unwrap();
    let buffer = SurfaceBuffer::draw(&view, &mesh, Samples::Four, 1e-2, Progress::silent());
    for row in 0..32 {
        for column in 0..32 {
            let hit = buffer.layer_hit(buffer.pixel(column, row));
            assert_eq!(hit.is_surface(), row >= 16, "{column} {row}");
            if hit.is_surface() {
                let [a, b, c] = hit.barycentric().map(f64::from);
                let z = 1e5 * a + 1e5 * b - 1e6 * c;
                let depth = 1.0 / ((f64::from(row) + 0.5 - 16.0) / view.pixels_per_unit_at(1.0));
                assert!((-z - depth).abs() < 0.15 * depth + 1.0, "{z} {depth}");
            }
        }
    }
}

#[test]
fn other_layers_come_from_the_centre_or_the_nearest_covered_sample() {
    // A triangle that covers the right part of one pixel, its edge right of the centre.
    let mesh = TriangleMesh {
        positions: vec![
            Vec3::new(0.1, -9.0, 0.0),
            Vec3::new(9.0, 0.0, 0.0),
            Vec3::new(0.1, 9.0, 0.0),
        ],
        triangles: vec![[0, 1, 2]],
    };
    let camera = Camera {
        position: DVec3::new(0.0, 0.0, 4.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 1.0 },
    };
    let view = View::new(camera, [1, 1]).unwrap();
    let buffer = SurfaceBuffer::draw(&view, &mesh, Samples::Four, 1e-3, Progress::silent());
    let covered: Vec<bool> = buffer
        .color_hits(buffer.pixel(0, 0))
        .iter()
        .map(Hit::is_surface)
        .collect();
    assert_eq!(covered, [false, true, false, true]);
    let hits = buffer.pixel(0, 0);
    assert!(!hits[4].is_surface());
    assert_eq!(buffer.layer_hit(buffer.pixel(0, 0)), hits[1]);
}
