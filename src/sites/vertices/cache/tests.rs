//! Cached surfaces altered in every list and field: told, made again, never used.

use std::sync::Mutex;

use ndarray::Array1;
use rand::Rng;
use serde_json::{Map, Value, json};
use tempfile::TempDir;

use super::*;
use crate::format::npz;
use crate::mesh::field::guides::FieldEnergy;
use crate::mesh::shapes;
use crate::progress::{Event, Progress};
use crate::random;
use crate::sites::vertices::surface::prepare;

/// A member of the archive: its name and its numbers as bytes.
type NamedBytes = (String, Vec<u8>);

/// A cached surface of two levels.
struct Cached {
    folder: TempDir,
    user: UserMesh,
    options: SurfaceOptions,
    surface: PreparedSurface,
}

impl Cached {
    fn new() -> Self {
        let mesh = shapes::torus(16, 10, 1.0, 0.4);
        let user = UserMesh::from(mesh);
        let options = SurfaceOptions {
            levels: 2,
            neighborhood: 3,
            ..SurfaceOptions::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let surface = prepare(&user, &options, Some(folder.path()), Progress::silent()).unwrap();
        Self {
            folder,
            user,
            options,
            surface,
        }
    }

    fn wanted(&self) -> Wanted<'_> {
        Wanted::new(&self.user, &self.options).unwrap()
    }

    fn file(&self) -> PathBuf {
        self.wanted().file(self.folder.path())
    }

    /// Prepares the surface again; what is told meanwhile.
    fn notes(&self) -> Vec<String> {
        let told = Mutex::new(Vec::new());
        let listener = |event| {
            if let Event::Warn(text) = event {
                told.lock().unwrap().push(text);
            }
        };
        let progress = Progress::new(&listener, None);
        let again = prepare(
            &self.user,
            &self.options,
            Some(self.folder.path()),
            progress,
        );
        assert!(again.unwrap() == self.surface, "another surface");
        told.into_inner().unwrap()
    }

    /// Asserts that the file is told not to hold, made again, and then taken.
    fn assert_made_again(&self, what: &str) {
        let name = self
            .file()
            .file_name()
            .unwrap()
            .to_string_lossy()
            .into_owned();
        let notes = self.notes();
        let says = |words: &str| notes.len() == 1 && notes[0].contains(words);
        assert!(says(&name) && says("made again"), "{what}: {notes:?}");
        assert!(self.notes().is_empty(), "{what}: not made again");
    }

    fn parts(&self) -> (Map<String, Value>, Vec<NamedBytes>) {
        let mut reader = npz::Reader::open(&self.file()).unwrap();
        let mut meta: Map<String, Value> = reader.meta().unwrap();
        meta.remove("id");
        let names = LISTS
            .iter()
            .flat_map(|name| [member(0, name), member(1, name)]);
        let lists = names.map(|name| {
            let list: Array1<u8> = reader.array(&name).unwrap();
            (name, list.to_vec())
        });
        let lists = lists.collect();
        (meta, lists)
    }

    fn write(&self, meta: &Map<String, Value>, lists: &[(String, Vec<u8>)]) {
        let lists: Vec<(String, &[u8])> = lists
            .iter()
            .map(|(name, bytes)| (name.clone(), bytes.as_slice()))
            .collect();
        lists::write(&self.file(), meta, &lists).unwrap();
    }
}

/// All lists of a level.
const LISTS: [&str; 10] = [
    "triangles",
    "positions",
    "normals",
    "orientations",
    "samples",
    "coarse_samples",
    "neighbor_starts",
    "neighbors",
    "parents",
    "areas",
];

#[test]
fn a_list_with_any_bit_altered_is_told_and_the_surface_is_the_same() {
    let cached = Cached::new();
    let (meta, lists) = cached.parts();
    let mut stream = random::stream(5, "altered", 0, 0);
    for (at, (name, bytes)) in lists.iter().enumerate() {
        let mut altered = lists.clone();
        match bytes.len() {
            0 => altered[at].1.extend([0; 8]),
            length => altered[at].1[stream.gen_range(0..length)] ^= 1 << stream.gen_range(0..8),
        }
        cached.write(&meta, &altered);
        cached.assert_made_again(name);
        let mut shorter = lists.clone();
        shorter[at].1.truncate(bytes.len().saturating_sub(12));
        if shorter != lists {
            cached.write(&meta, &shorter);
            cached.assert_made_again(&format!("{name}, shorter"));
        }
        let mut without = lists.clone();
        without.remove(at);
        cached.write(&meta, &without);
        cached.assert_made_again(&format!("no {name}"));
    }
}

#[test]
fn a_field_that_is_altered_is_told_and_the_surface_is_the_same() {
    let cached = Cached::new();
    let (meta, lists) = cached.parts();
    let texel = meta["texel"].as_f64().unwrap();
    let level = |field: &str, value: Value| {
        let mut levels = meta["levels"].clone();
        levels[0][field] = value;
        ("levels", levels)
    };
    let fewer = json!([meta["levels"][0]]);
    for (field, value) in [
        ("format", json!("mesotex-checkpoint")),
        ("version", json!(VERSION - 1)),
        ("engine", json!("0.0.9")),
        ("seal", json!(ContentId::of_bytes(b"other").to_string())),
        ("texel", json!(texel.next_up())),
        ("texel", json!(-texel)),
        ("texel", json!("large")),
        ("levels", fewer),
        ("levels", json!([])),
        level("samples_per_site", json!(25)),
        level("samples_per_site", json!(u64::MAX)),
        level("coarse_samples_per_site", json!(null)),
        level("counts", json!([1, 2, 3])),
    ] {
        let mut altered = meta.clone();
        altered.insert(field.into(), value.clone());
        cached.write(&altered, &lists);
        cached.assert_made_again(&format!("{field} {value}"));
        let mut without = meta.clone();
        without.remove(field);
        cached.write(&without, &lists);
        cached.assert_made_again(&format!("no {field}"));
    }
}

/// Changes that a seal made again would cover, and the list each must be told for.
#[test]
fn sealed_lists_that_no_surface_has_are_told_by_name() {
    let cached = Cached::new();
    type Change = (&'static str, fn(&mut [SurfaceLevel]));
    let changes: [Change; 20] = [
        ("L0:", |l| l[0].mesh.positions[3].x += 1.0),
        ("L1/triangles", |l| l[1].mesh.triangles[0][1] = 9999),
        ("L1/positions", |l| l[1].mesh.positions[2].y = f32::NAN),
        ("L1/areas", |l| l[1].sites.areas[0] = -1.0),
        ("L0/areas", |l| l[0].sites.areas[0] = f32::INFINITY),
        ("L0/areas", |l| l[0].sites.areas.truncate(9)),
        ("L0/normals", |l| l[0].frames[1].n *= 2.0),
        ("L0/normals", |l| l[0].frames[1].n.x = f32::NAN),
        ("L0/orientations", |l| l[0].frames[4].s = l[0].frames[4].n),
        ("L0/samples", |l| l[0].sites.fine.samples[7].cell = 1 << 30),
        ("L0/samples", |l| {
            l[0].sites.fine.samples[4].weights = [40_000; 2];
        }),
        ("L0/samples", |l| l[0].sites.fine.samples.truncate(9)),
        ("L0/counts", |l| l[0].samples.valued = u64::MAX),
        ("L0/neighbor_starts", |l| {
            l[0].sites.neighbors.starts[1] = 9999;
        }),
        ("L0/neighbor_starts", |l| {
            l[0].sites.neighbors.starts.clear()
        }),
        ("L0/neighbors", |l| {
            l[0].sites.neighbors.entries[0].site = 9999
        }),
        ("L0/neighbors", |l| {
            l[0].sites.neighbors.entries[0].x = f32::NAN;
        }),
        ("L0/parents", |l| l[0].sites.parents[2].site = 9999),
        ("L0/parents", |l| l[0].sites.parents[2].x = f32::NAN),
        ("L1/parents", |l| {
            l[1].sites.parents = l[0].sites.parents.clone()
        }),
    ];
    for (list, change) in changes {
        let mut surface = cached.surface.clone();
        change(&mut surface.levels);
        let wanted = cached.wanted();
        assert!(write(&cached.file(), &wanted, &surface).is_err(), "{list}");
        write_unchecked(&cached.file(), &wanted, &surface).unwrap();
        let error = read(&cached.file(), &wanted).unwrap_err().to_string();
        assert!(error.contains(list), "{list}: {error}");
        cached.assert_made_again(list);
    }
}

#[test]
fn a_surface_of_another_mesh_is_not_taken_under_this_ones_name() {
    let (one, mut other) = (Cached::new(), Cached::new());
    other.user.mesh.positions[0].x += 0.01;
    std::fs::copy(one.file(), other.file()).unwrap();
    let error = read(&other.file(), &other.wanted())
        .unwrap_err()
        .to_string();
    assert!(error.contains("texel") || error.contains("seal"), "{error}");
}

#[test]
fn another_field_energy_makes_another_surface() {
    let (one, mut other) = (Cached::new(), Cached::new());
    other.options.field_energy = FieldEnergy::Cosine;
    assert_ne!(one.wanted().key, other.wanted().key);
    let told = serde_json::to_string(&one.options).unwrap();
    assert!(!told.contains("field-energy"), "{told}");
}

#[test]
fn a_cache_that_cannot_be_written_is_a_note() {
    let cached = Cached::new();
    let file = cached.file();
    std::fs::remove_file(&file).unwrap();
    std::fs::create_dir(&file).unwrap();
    std::fs::write(file.join("x"), "x").unwrap();
    let notes = cached.notes();
    assert!(
        notes.len() == 2 && notes[1].contains("not cached"),
        "{notes:?}"
    );
    let nowhere = cached.folder.path().join("plain");
    std::fs::write(&nowhere, "no folder").unwrap();
    let below = nowhere.join("below");
    let surface = prepare(
        &cached.user,
        &cached.options,
        Some(&below),
        Progress::silent(),
    );
    assert!(surface.unwrap() == cached.surface);
}
