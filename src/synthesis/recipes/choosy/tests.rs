//! Tests of the method as a whole.

use rand::Rng;
use rand::seq::SliceRandom;

use super::*;
use crate::mesh::TriangleMesh;
use crate::mesh::face_colors::{ColoredMesh, Coloring, colored_base, two_coloring};
use crate::mesh::shapes;
use crate::mesh::subdivision::butterfly::inherited_colors;
use crate::mesh::topology::Topology;
use crate::progress::{Event, Progress};
use crate::random;
use crate::sites::faces::{FaceLevel, FacePyramid, FaceTemplate, neighborhood::NEIGHBORS};
use crate::synthesis::drive::{one_by_one, run_by_run};
use crate::synthesis::recipes::choosy::counted_tree::Choice;
use crate::synthesis::recipes::choosy::sampling::{ChoosyRule, LevelState, RunChanges};
use crate::synthesis::recipes::choosy::source_faces::SourceFaces;
use crate::synthesis::rule::{Foreseen, Rule};

fn noise(side: u32, channels: usize) -> Vec<f32> {
    let mut stream = random::stream(9, "sample", 0, 0);
    let count = (side * side) as usize * channels;
    (0..count).map(|_| stream.gen_range(0.0..1.0)).collect()
}

fn analysed(side: u32, channels: usize, ratios: &[f64]) -> AnalysisSample {
    let numbers = noise(side, channels);
    let image = SquareImage {
        side,
        channels,
        numbers: &numbers,
    };
    AnalysisSample::new(image, ratios, Progress::silent()).unwrap()
}

fn torus(faces: usize, subdivisions: u32) -> FacePyramid {
    let quiet = Progress::silent();
    let torus = shapes::torus(16, 8, 1.0, 0.4);
    let base = colored_base(&torus, faces, 0.7, quiet).unwrap();
    FacePyramid::subdivided(&base, subdivisions, quiet).unwrap()
}

/// The sample's own grid, with the corners of face f rotated by f % 3 places.
fn turned_grid(sample: &AnalysisSample) -> FacePyramid {
    let coarse = &sample.grid.pyramid.levels[0];
    let turned = |(face, corners): (usize, &[u32; 3])| {
        let mut corners = *corners;
        corners.rotate_left(face % 3);
        corners
    };
    let mesh = TriangleMesh {
        positions: coarse.mesh.positions.clone(),
        triangles: coarse
            .mesh
            .triangles
            .iter()
            .enumerate()
            .map(turned)
            .collect(),
    };
    let fine = FaceLevel::new(shapes::midpoints(&mesh), inherited_colors(&coarse.white));
    let levels = vec![FaceLevel::new(mesh, coarse.white.clone()), fine];
    FacePyramid { levels }
}

#[test]
fn children_turn_with_the_source() {
    let sample = analysed(24, 2, &[1.2, 1.2]);
    let surface = turned_grid(&sample);
    let template = FaceTemplate::new();
    let faces = SourceFaces::new((&sample, 0), &template, 1.2, 20).unwrap();
    let neighborhoods = template.around_all(&surface.levels[0].topology);
    let rule = ChoosyRule {
        level: &surface.levels[0],
        neighborhoods: &neighborhoods,
        sample: (&sample, 0),
        faces: &faces,
    };
    let values = &sample.pyramids[1].gaussian[0];
    let mut state = LevelState {
        values: values.clone(),
        children: FaceValues::zeros(4 * values.count(), 2),
        sources: vec![Source::default(); values.count()],
        uses: faces.tree(),
        changes: RunChanges::new(values.count(), faces.count()),
    };
    let (mut inside, mut scratch) = (0, Default::default());
    for site in 0..values.count() {
        let around = template.around(&surface.levels[0].topology, site as u32);
        if around.contains(&crate::mesh::topology::NONE) {
            continue;
        }
        inside += 1;
        let source = rule.choose(&state, site, &mut scratch);
        let wanted = Source {
            face: site as u32,
            turn: 1,
            phase: (site % 3) as u8,
        };
        assert_eq!(source, wanted);
        rule.set(&mut state, site, source);
        // The same places on the next level hold the same values, whatever their numbers.
        let laplacian = &sample.pyramids[1].laplacian[1];
        for child in 4 * site..4 * site + 4 {
            let place = surface.levels[1].centers[child];
            let centers = &sample.grid.pyramid.levels[1].centers;
            let same = (4 * site..4 * site + 4).find(|&c| centers[c].distance(place) < 1e-3);
            assert_eq!(state.children.row(child), laplacian.row(same.unwrap()));
            let source = source.child((child % 4) as u32);
            assert_eq!(source.face as usize, same.unwrap());
        }
    }
    assert!(inside > 50, "{inside}");
}

#[test]
fn faces_far_apart_are_textured_with_a_warning() {
    let mut torus = shapes::torus(24, 12, 1.0, 0.4);
    torus.positions[0] *= 30.0;
    let white = two_coloring(&Topology::new(&torus.triangles)).unwrap();
    let base = ColoredMesh {
        mesh: torus,
        white,
        coloring: Coloring::Given,
    };
    let surface = FacePyramid::subdivided(&base, 0, Progress::silent()).unwrap();
    let numbers = noise(16, 3);
    let image = SquareImage {
        side: 16,
        channels: 3,
        numbers: &numbers,
    };
    let warnings = std::sync::Mutex::new(Vec::new());
    let listener = |event: Event| {
        if let Event::Warn(text) = event {
            warnings.lock().unwrap().push(text);
        }
    };
    let progress = Progress::new(&listener, None);
    synthesize_faces(image, &surface, &ChoosyOptions::default(), progress).unwrap();
    let warnings = warnings.into_inner().unwrap();
    assert!(
        warnings.len() == 1 && warnings[0].contains("--base-faces"),
        "{warnings:?}"
    );
}

#[test]
fn search_with_gaps_and_without_find_the_same_where_nothing_is_missing() {
    let sample = analysed(16, 1, &[1.2]);
    let template = FaceTemplate::new();
    let faces = SourceFaces::new((&sample, 0), &template, 1.2, NEIGHBORS).unwrap();
    let mut tree = faces.tree();
    let surface = torus(256, 0);
    let level = &surface.levels[0];
    let mut stream = random::stream(10, "surface", 0, 0);
    let values = FaceValues {
        channels: 1,
        numbers: (0..level.count())
            .map(|_| stream.gen_range(0.0..1.0))
            .collect(),
    };
    let mut pattern = vec![0.0; faces.length()];
    let mut projected = vec![0.0; NEIGHBORS];
    for site in 0..level.count() as u32 {
        let around = template.around(&level.topology, site);
        faces.pattern(&values, &around, &mut pattern);
        let slow = faces.search_with_gaps(&pattern, &around, &tree, Choice::NONE);
        let mut found = Choice::NONE;
        for phase in 0..3 {
            faces.components().project(&pattern, &mut projected);
            tree.search(&projected, phase, &mut found);
            pattern.rotate_right(NEIGHBORS / 3);
        }
        assert!((found.score / slow.score - 1.0).abs() < 1e-3);
        assert_eq!((found.item, found.phase), (slow.item, slow.phase));
        tree.count_use(found.item);
    }
}

#[test]
fn runs_of_visits_are_visits_one_by_one() {
    let sample = analysed(16, 2, &[1.2; 2]);
    let template = FaceTemplate::new();
    let faces = SourceFaces::new((&sample, 1), &template, 1.2, 20).unwrap();
    let closed = torus(256, 2);
    let mesh = shapes::grid(40, 40, 1.0);
    let white = two_coloring(&Topology::new(&mesh.triangles)).unwrap();
    let open = FacePyramid {
        levels: vec![FaceLevel::new(mesh, white)],
    };
    for level in [&closed.levels[2], &open.levels[0]] {
        let neighborhoods = template.around_all(&level.topology);
        let rule = ChoosyRule {
            level,
            neighborhoods: &neighborhoods,
            sample: (&sample, 1),
            faces: &faces,
        };
        let mut order: Vec<u32> = (0..level.count() as u32).collect();
        let mut stream = random::stream(11, "visits", 0, 0);
        order.shuffle(&mut stream);
        let mut start = LevelState {
            values: FaceValues::zeros(level.count(), 2),
            children: FaceValues::default(),
            sources: vec![Source::default(); level.count()],
            uses: faces.tree(),
            changes: RunChanges::new(level.count(), faces.count()),
        };
        for number in &mut start.values.numbers {
            *number = stream.gen_range(0.0..1.0);
        }
        assert!(rule.run() > 8);
        let (mut one, mut other) = (start.clone(), start);
        for _ in 0..2 {
            one_by_one(&rule, &mut one, &order, Progress::silent()).unwrap();
            run_by_run(&rule, &mut other, &order, Progress::silent()).unwrap();
            assert_eq!(one.sources, other.sources);
            assert_eq!(one.values, other.values);
        }
        let uses = |state: &LevelState| {
            (0..faces.count() as u32)
                .map(|item| state.uses.uses(item))
                .max()
        };
        assert_eq!(uses(&one), uses(&other));
    }
}

#[test]
fn faces_hold_their_sources_and_all_sources_are_used_alike() {
    let numbers = noise(16, 1);
    let image = SquareImage {
        side: 16,
        channels: 1,
        numbers: &numbers,
    };
    let surface = torus(256, 1);
    let options = ChoosyOptions {
        iterations: vec![2, 1],
        ..ChoosyOptions::default()
    };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| synthesize_faces(image, &surface, &options, Progress::silent()).unwrap())
    };
    let result = run(1);
    assert_eq!(result, run(3));
    let finest = &result.pyramid.gaussian[1];
    assert_eq!((finest.count(), result.sources.len()), (1024, 1024));
    let mut uses = std::collections::BTreeMap::new();
    for (face, source) in result.sources.iter().enumerate() {
        let pyramid = &result.sample.pyramids[usize::from(source.turn)];
        let row = pyramid.gaussian[1].row(source.face as usize);
        assert_eq!(finest.row(face), row);
        let texels = &result.sample.texels[usize::from(source.turn)];
        assert_eq!(result.colors.row(face), texels.row(source.face as usize));
        *uses.entry((source.turn, source.face)).or_insert(0) += 1;
    }
    // There are 416 faces on each grid: sampling without replacement would use each once or twice.
    let most = uses.values().max().unwrap();
    assert!((2..=4).contains(most), "{most}");
    assert!(uses.len() > 750, "{}", uses.len());
    let mut kinds = [0; 3];
    result
        .sources
        .iter()
        .for_each(|source| kinds[usize::from(source.phase)] += 1);
    assert!(kinds.iter().all(|&count| count > 200), "{kinds:?}");
    assert_eq!(result.eigenvalues.len(), 2);
    assert_eq!(result.pyramid.laplacian[1].count(), 1024);
}

#[test]
fn open_surfaces_and_constant_samples_are_textured() {
    let numbers = [0.25; 16 * 16];
    let image = SquareImage {
        side: 16,
        channels: 1,
        numbers: &numbers,
    };
    let mesh = shapes::grid(10, 8, 1.0);
    let base = ColoredMesh {
        white: two_coloring(&Topology::new(&mesh.triangles)).unwrap(),
        mesh,
        coloring: Coloring::Given,
    };
    let surface = FacePyramid::subdivided(&base, 1, Progress::silent()).unwrap();
    let options = ChoosyOptions::default();
    let result = synthesize_faces(image, &surface, &options, Progress::silent()).unwrap();
    let finest = &result.pyramid.gaussian[1];
    assert_eq!(finest.count(), 640);
    assert!(
        finest
            .numbers
            .iter()
            .all(|number| (number - 0.25).abs() < 1e-6)
    );
}

#[test]
fn what_does_not_fit_is_refused() {
    let refused = |side: u32, faces, subdivisions, options: &ChoosyOptions| {
        let numbers = noise(side, 1);
        let image = SquareImage {
            side,
            channels: 1,
            numbers: &numbers,
        };
        let surface = torus(faces, subdivisions);
        let result = synthesize_faces(image, &surface, options, Progress::silent());
        result.unwrap_err().to_string()
    };
    let fine = ChoosyOptions::default();
    let larger = refused(64, 256, 1, &fine);
    assert!(
        larger.contains("256 faces at the coarsest level"),
        "{larger}"
    );
    let odd = refused(17, 256, 1, &fine);
    assert!(odd.contains("17 pixels per side"), "{odd}");
    let small = refused(8, 256, 1, &fine);
    assert!(small.contains("no whole neighbourhood"), "{small}");
    let none = ChoosyOptions {
        dimensions: 0,
        ..fine.clone()
    };
    assert!(refused(16, 256, 0, &none).contains("--dimensions"));
    for iterations in [vec![], vec![0], vec![1, 1001]] {
        let options = ChoosyOptions {
            iterations,
            ..fine.clone()
        };
        assert!(refused(16, 256, 0, &options).contains("--iterations"));
    }
}
