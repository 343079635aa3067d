//! Levels, cache and refusals.

use std::path::Path;
use std::sync::Mutex;

use glam::{Vec2, Vec3};

use super::*;
use crate::mesh::reading::UserMesh;
use crate::progress::Event;

fn user(mesh: TriangleMesh) -> UserMesh {
    UserMesh::from(mesh)
}

fn small_options() -> RoundOptions {
    RoundOptions {
        rings: 2,
        levels: 2,
        ..RoundOptions::default()
    }
}

#[test]
fn levels_have_the_same_vertices_and_double_circles() {
    let mut user = user(shapes::grid(20, 20, 0.5));
    user.orientation = Some(vec![Vec3::X; user.mesh.positions.len()]);
    user.mesh.positions.push(Vec3::splat(9.0));
    user.orientation.as_mut().unwrap().push(Vec3::ZERO);
    user.from_file.push(441);
    let options = RoundOptions {
        texel: Some(0.5),
        ..small_options()
    };
    let sites = prepare(&user, &options, None, Progress::silent()).unwrap();
    let ready = Ready::new(user.mesh);
    let centre = 10 * 21 + 10;
    for (number, level) in sites.hierarchy.levels.iter().enumerate() {
        assert_eq!(level.areas.len(), 442);
        assert!(level.coarse.is_none());
        let last = number + 1 == sites.hierarchy.levels.len();
        assert_eq!(level.parents.len(), if last { 0 } else { 442 });
        assert!(
            level
                .parents
                .iter()
                .enumerate()
                .all(|(v, p)| p.site as usize == v && p.x == 0.0)
        );
        let step = 0.5 * (1 << number) as f32;
        for (sample, offset) in level.fine.of_site(centre).zip(&sites.template.positions) {
            let at = ready.position(sample).unwrap() - ready.mesh.positions[centre];
            assert!((at.truncate() - *offset * step).length() < 2e-3 * step);
        }
        for near in level.neighbors.row(centre).iter().copied() {
            let real =
                (ready.mesh.positions[near.site as usize] - ready.mesh.positions[centre]) / step;
            assert!((real.truncate() - Vec2::new(near.x, near.y)).length() < 2e-3);
        }
        assert!(
            level
                .fine
                .of_site(441)
                .all(|s| s == SampleLocation::Outside)
        );
        assert_eq!(level.neighbors.row(441).iter().copied().count(), 0);
    }
}

/// What a run over a cache folder said, and whether every level was read.
fn run(user: &UserMesh, options: &RoundOptions, folder: &Path) -> (RoundSites, Vec<String>) {
    let told = Mutex::new(Vec::new());
    let listener = |event| {
        if let Event::Warn(text) = event {
            told.lock().unwrap().push(text);
        }
    };
    let sites = prepare(user, options, Some(folder), Progress::new(&listener, None)).unwrap();
    (sites, told.into_inner().unwrap())
}

fn all_from(sites: &RoundSites, source: CircleSource) -> bool {
    sites.levels.iter().all(|level| level.source == source)
}

#[test]
fn cached_circles_are_read_under_any_field_and_damaged_ones_marched_again() {
    let mut user = user(shapes::torus(30, 16, 1.0, 0.4));
    let folder = tempfile::tempdir().unwrap();
    let options = small_options();
    let (first, _) = run(&user, &options, folder.path());
    assert!(all_from(&first, CircleSource::Marched));
    let (second, told) = run(&user, &options, folder.path());
    assert!(all_from(&second, CircleSource::Read) && told.is_empty());
    assert!(second.hierarchy == first.hierarchy);
    user.rotation = Some(vec![30.0; user.mesh.positions.len()]);
    let (turned, _) = run(&user, &options, folder.path());
    assert!(all_from(&turned, CircleSource::Read) && turned.hierarchy != first.hierarchy);
    user.scale = Some(vec![1.5; user.mesh.positions.len()]);
    let (scaled, _) = run(&user, &options, folder.path());
    assert!(all_from(&scaled, CircleSource::Marched));
    (user.rotation, user.scale) = (None, None);
    for entry in std::fs::read_dir(folder.path()).unwrap().flatten() {
        let bytes = std::fs::read(entry.path()).unwrap();
        std::fs::write(entry.path(), &bytes[..bytes.len() / 2]).unwrap();
    }
    let (again, told) = run(&user, &options, folder.path());
    assert!(all_from(&again, CircleSource::Marched) && again.hierarchy == first.hierarchy);
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(
        told.iter()
            .all(|text| text.contains("circles.npz") && text.contains("marched again"))
    );
    assert!(all_from(
        &run(&user, &options, folder.path()).0,
        CircleSource::Read
    ));
}

#[test]
fn circles_with_a_sound_seal_and_wrong_numbers_are_refused() {
    let ready = flat(6);
    let circles = ready.march(0.5, 2);
    let wanted = cache::Wanted::new(&ready.mesh, &circles.radii, 2);
    let folder = tempfile::tempdir().unwrap();
    let file = wanted.file(folder.path());
    let refused = |change: &dyn Fn(&mut Circles)| {
        let mut changed = circles.clone();
        change(&mut changed);
        cache::write(&file, &wanted, &changed).unwrap();
        cache::read(&file, &wanted)
            .err()
            .map(|error| error.to_string())
    };
    assert_eq!(refused(&|_| {}), None);
    type Change<'a> = (&'a str, &'a dyn Fn(&mut Circles));
    let changes: [Change<'_>; 9] = [
        ("arcs", &|c| c.arcs.entries[3].triangle = 72),
        ("arcs", &|c| c.arcs.entries[0].turn = 1),
        ("arcs", &|c| c.arcs.entries[1].turn = 0),
        ("arc_starts", &|c| c.arcs.starts[1] = u32::MAX),
        ("arc_starts", &|c| c.arcs.starts.truncate(9)),
        ("perimeters", &|c| c.perimeters[5] = f32::NAN),
        ("near", &|c| c.near.entries[0].vertex = 49),
        ("near", &|c| c.near.entries[0].radius = u16::MAX),
        ("near_starts", &|c| c.near.starts[2] = 0),
    ];
    for (place, change) in changes {
        let error = refused(change).unwrap();
        assert!(
            error.contains(place) && error.contains("circles.npz"),
            "{place}: {error}"
        );
    }
    // A file of other radii under this name is recognised by its seal.
    let other = ready.march(0.4, 2);
    let foreign = cache::Wanted::new(&ready.mesh, &other.radii, 2);
    cache::write(&file, &foreign, &other).unwrap();
    let error = cache::read(&file, &wanted).unwrap_err().to_string();
    assert!(error.contains("seal"), "{error}");
}

#[test]
fn bad_options_and_radii_are_refused_by_name() {
    let user = user(shapes::grid(3, 3, 1.0));
    let refused = |options: RoundOptions| {
        let error = prepare(&user, &options, None, Progress::silent());
        error.unwrap_err().to_string()
    };
    let base = RoundOptions::default;
    assert!(refused(RoundOptions { rings: 0, ..base() }).contains("--rings"));
    assert!(
        refused(RoundOptions {
            rings: 32,
            ..base()
        })
        .contains("--rings")
    );
    assert!(
        refused(RoundOptions {
            levels: 0,
            ..base()
        })
        .contains("--levels")
    );
    let texel = Some(-1.0);
    assert!(refused(RoundOptions { texel, ..base() }).contains("--texel"));
    let ready = flat(3);
    for radius in [0.0, f32::NAN, f32::INFINITY] {
        let radii = vec![radius; 16];
        let error = marching::march(ready.surface(), &radii, 2, Progress::silent());
        assert!(
            error
                .unwrap_err()
                .to_string()
                .contains("radius of vertex 0")
        );
    }
    assert!(marching::march(ready.surface(), &[1.0], 2, Progress::silent()).is_err());
    let circles = ready.march(0.5, 2);
    let frames = ready.frames(Vec3::X, 0.0);
    let square = Template::square(5);
    assert!(sampling::stencils(&circles, ready.surface(), &frames, &square).is_err());
}

#[test]
fn levels_marched_together_are_those_marched_apart() {
    let ready = Ready::new(shapes::torus(60, 36, 1.0, 0.4));
    let radii = vec![0.05; ready.mesh.positions.len()];
    let march = |levels: &[u32]| {
        marching::march_levels(ready.surface(), &radii, 3, levels, Progress::silent()).unwrap()
    };
    let together = march(&[0, 1, 3]);
    let apart: Vec<Circles> = [0, 1, 3].map(|level| march(&[level]).remove(0)).into();
    assert_eq!(together[0], ready.march(0.05, 3));
    for (together, apart) in together.iter().zip(&apart) {
        assert_eq!(together.radii, apart.radii);
        assert_eq!(together.perimeters.len(), apart.perimeters.len());
        let lengths = together.perimeters.iter().zip(&apart.perimeters);
        assert!(lengths.clone().all(|(a, b)| (a - b).abs() <= 1e-5 * b));
        assert_eq!(together.near, apart.near);
    }
}
