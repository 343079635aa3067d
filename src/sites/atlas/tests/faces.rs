//! A chart per face of a control mesh, sampled in the stars of its vertices.

use std::collections::BTreeMap;

use super::*;
use crate::neighborhood::Template;
use crate::sites::atlas::options::ChartSource;
use crate::sites::level::Sites;

/// A mesh whose triangles are the halves of quadrilaterals, two by two.
fn of_quads(mesh: TriangleMesh) -> UserMesh {
    UserMesh {
        face_of: (0..mesh.triangles.len() as u32).map(|t| t / 2).collect(),
        ..UserMesh::from(mesh)
    }
}

fn with_faces(resolution: u32, sampling: Sampling) -> AtlasOptions {
    AtlasOptions {
        levels: 1,
        resolution,
        charts: ChartSource::Faces,
        sampling,
        ..AtlasOptions::default()
    }
}

/// A unit sphere of 6 · n² quadrilaterals: 8 vertices of valence 3, the rest of 4.
fn quad_sphere(n: i32) -> UserMesh {
    let (mut numbers, mut mesh) = (BTreeMap::new(), TriangleMesh::default());
    for axis in 0..3 {
        for side in [-n, n] {
            let mut vertex = |a: i32, b: i32| {
                // Seen from outside, a runs to the right and b upwards.
                let a = if side > 0 { a } else { -a };
                let mut at = [0; 3];
                (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side, a, b);
                *numbers.entry(at).or_insert_with(|| {
                    let place = at.map(|c| (c as f32 / n as f32 * TAU / 8.0).tan());
                    mesh.positions.push(Vec3::from_array(place).normalize());
                    mesh.positions.len() as u32 - 1
                })
            };
            let mut quads = Vec::new();
            for (a, b) in (0..n).flat_map(|a| (0..n).map(move |b| (2 * a - n, 2 * b - n))) {
                let [p, q] = [vertex(a, b), vertex(a + 2, b)];
                quads.push([p, q, vertex(a + 2, b + 2), vertex(a, b + 2)]);
            }
            for [a, b, c, d] in quads {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    of_quads(mesh)
}

#[test]
fn on_flat_faces_samples_lie_where_they_should() {
    let mut user = of_quads(shapes::grid(4, 4, 0.25));
    user.orientation = Some(vec![Vec3::new(0.8, 0.6, 0.0); user.mesh.positions.len()]);
    let template = Template::square(7);
    let options = with_faces(4 * 18, Sampling::Charts);
    let (surface, sites) = prepared(&user, &options);
    assert_eq!((surface.atlas.charts, surface.texels.len()), (16, 16 * 256));
    assert_eq!(surface.subdivisions, Some(2));
    let (texel, mut across) = (surface.texel as f32, 0);
    let (s, t) = (Vec2::new(0.8, 0.6), Vec2::new(-0.6, 0.8));
    for site in 0..sites.levels[0].count() {
        let from = surface.positions[site].truncate();
        for (offset, sample) in template.positions.iter().zip(sites.levels[0].samples(site)) {
            let wanted = from + (s * offset.x + t * offset.y) * texel;
            if wanted.min(1.0 - wanted).min_element() < texel {
                continue;
            }
            let found = place(&surface, sample).unwrap().truncate();
            assert!(found.distance(wanted) < 0.01 * texel, "{site}: {offset}");
            let face = |at: Vec2| (at * 4.0).floor();
            across += usize::from(face(wanted) != face(from));
        }
    }
    assert!(across > 10_000);
    // Near the outer border there is nothing to blend beyond the outermost texels' centres.
    let stretch = surface.stretch(&sites.levels[0]);
    for (stretch, at) in stretch.iter().zip(&surface.positions) {
        let at = at.truncate();
        let is_inside = at.min(1.0 - at).min_element() > 6.0 * texel;
        assert!(!is_inside || *stretch < 0.01, "{at}: {stretch}");
    }
}

/// How far samples lie from the ends of great circles, in texels: within a face, and across faces.
fn errors_on_sphere(surface: &AtlasSurface, sites: &SiteHierarchy<AtlasSites>) -> [Vec<f32>; 2] {
    let template = Template::square(7);
    let mut errors = [Vec::new(), Vec::new()];
    for site in 0..sites.levels[0].count() {
        let position = surface.positions[site];
        let (n, radius) = (position.normalize(), position.length());
        let s = surface.orientations[site];
        let s = (s - n * n.dot(s)).normalize();
        let t = n.cross(s);
        let texel = surface.texel as f32 / radius;
        for (offset, sample) in template.positions.iter().zip(sites.levels[0].samples(site)) {
            let found = place(surface, sample).unwrap();
            let way = (s * offset.x + t * offset.y).normalize_or_zero();
            let angle = offset.length() * texel;
            let wanted = n * angle.cos() + way * angle.sin();
            let same = match sample {
                SampleLocation::Between(of, _) => {
                    let chart = |site: u32| surface.charts[site as usize];
                    of.iter().all(|&of| chart(of) == surface.charts[site])
                }
                _ => true,
            };
            errors[usize::from(!same)].push(found.normalize().distance(wanted) / texel);
        }
    }
    errors
}

#[test]
fn on_a_sphere_of_faces_samples_lie_on_great_circles() {
    let mean = |errors: &[f32]| errors.iter().sum::<f32>() / errors.len() as f32;
    let most = |errors: &[f32]| errors.iter().copied().fold(0.0, f32::max);
    for sampling in BOTH {
        let options = with_faces(10 * 16, sampling);
        let (surface, sites) = prepared(&quad_sphere(4), &options);
        assert_eq!(surface.atlas.charts, 96);
        let counts = surface.counts[0];
        assert_eq!(counts.outside, 0);
        assert!(counts.marched * 100 < counts.valued, "{counts:?}");
        let [inside, across] = errors_on_sphere(&surface, &sites);
        assert!(across.len() > 1000);
        // A star's map is taken to be linear over the window, which it is least round the cube's corners.
        assert!(mean(&inside) < 0.06, "{sampling:?} {}", mean(&inside));
        assert!(mean(&across) < 0.08, "{sampling:?} {}", mean(&across));
        assert!(most(&across) < 1.0, "{sampling:?} {}", most(&across));
    }
}

#[test]
fn a_torus_of_faces_is_the_same_at_any_number_of_threads() {
    let user = of_quads(shapes::torus(8, 5, 1.0, 0.4));
    for sampling in BOTH {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let options = AtlasOptions {
                levels: 3,
                ..with_faces(70, sampling)
            };
            pool.unwrap().install(|| prepared(&user, &options))
        };
        let (surface, sites) = on(1);
        assert!((surface.clone(), sites.clone()) == on(2));
        assert_eq!(surface.mesh.triangles.len(), 40 * 2 * 16);
        let level = &sites.levels[0];
        let stretch = surface.stretch(level);
        let mean = stretch.iter().sum::<f32>() / stretch.len() as f32;
        assert!(mean < 0.15, "{sampling:?} {mean}");
        // Texels side by side lie as far apart across faces as inside.
        for edge in &surface.edges {
            let length = Vec2::from_array(edge.offset).length();
            assert!((0.2..3.0).contains(&length), "{edge:?}");
        }
        let neighbors = (0..level.count()).map(|site| level.neighbors(site).count());
        assert!(neighbors.sum::<usize>() > 30 * level.count());
    }
}

#[test]
fn numbers_of_control_vertices_come_along() {
    let mut user = of_quads(shapes::grid(4, 4, 0.25));
    let count = user.mesh.positions.len();
    user.orientation = Some(vec![Vec3::Y; count]);
    user.scale = Some(
        (0..count)
            .map(|v| if v == 12 { 2.0 } else { 1.0 })
            .collect(),
    );
    user.rotation = Some(vec![90.0; count]);
    let (surface, _) = prepared(&user, &with_faces(64, Sampling::Charts));
    let scale = surface.scale.unwrap();
    // The middle vertex is drawn to its neighbours: 2 to the power of 4/9 on the smooth surface.
    let most = scale.iter().copied().fold(0.0, f32::max);
    let limit = 2_f32.powf(4.0 / 9.0);
    assert!((limit - 0.1..=limit).contains(&most), "{most}");
    for s in surface.orientations {
        assert!((s + Vec3::X).length() < 1e-3, "{s}");
    }
}

#[test]
fn what_is_no_control_mesh_is_refused() {
    let refused = |user: &UserMesh, options: AtlasOptions| {
        let error = prepare(user, &options, Progress::silent());
        error.unwrap_err().to_string()
    };
    let triangles = UserMesh::from(shapes::icosphere(1));
    let text = refused(&triangles, with_faces(64, Sampling::Charts));
    assert!(text.contains("face 0: 3 corners"), "{text}");
    let grid = of_quads(shapes::grid(4, 4, 1.0));
    let text = refused(&grid, with_faces(12, Sampling::Charts));
    assert!(
        text.contains("--resolution") && text.contains("at least 16"),
        "{text}"
    );
    let unwrap = AtlasOptions {
        unwrap: true,
        ..with_faces(64, Sampling::Charts)
    };
    let text = refused(&grid, unwrap);
    assert!(
        text.contains("--charts") && text.contains("--unwrap"),
        "{text}"
    );
}
