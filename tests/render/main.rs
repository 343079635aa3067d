//! `mesotex render` as a user runs it: frames against the contract and against the formulas, read
//! back; the same bytes whatever the threads, interruptions and shards; bad input.

mod animations;
mod formula;
mod frames;
mod interruptions;
mod keeping;
mod lambert;
mod looks;
mod pairs;
mod pixels;
mod refused;
mod steadiness;
mod weights;

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use glam::{DVec3, Vec3};
use mesotex::btf::{DType, Description, Direction, Sample, SampleWriter};
use mesotex::format::{ContentId, ply};
use mesotex::grid::TexCoord;
use mesotex::index::TextonLabel;
use mesotex::maps::{MapHeader, SurfaceTextonMap};
use mesotex::mesh::TriangleMesh;

use weights::{Near, angle, fit, light_weights, log_map, nearest, view_weights};

// ---- running ----

fn mesotex(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mesotex"))
        .args(words)
        .output()
        .unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A sample and a map in a folder, rendered again and again.
struct Bench {
    folder: tempfile::TempDir,
    sample: PathBuf,
    map: PathBuf,
}

impl Bench {
    fn new(
        sample: impl FnOnce(&Path) -> ContentId,
        map: impl FnOnce(ContentId) -> SurfaceTextonMap,
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (sample_path, map_path) = (
            folder.path().join("a.sample"),
            folder.path().join("a.map.ply"),
        );
        let id = sample(&sample_path);
        map(id).write(&map_path).unwrap();
        Self {
            folder,
            sample: sample_path,
            map: map_path,
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, output: &str, words: &[&str]) -> Output {
        let output = self.path(output);
        let inputs = [
            "render",
            text(&self.sample),
            text(&self.map),
            "-o",
            text(&output),
        ];
        mesotex(&[&inputs, words].concat())
    }

    fn render(&self, output: &str, words: &[&str]) -> PathBuf {
        let result = self.run(output, words);
        let error = String::from_utf8_lossy(&result.stderr);
        assert!(result.status.success(), "{words:?}: {error}");
        self.path(output)
    }

    fn refuse(&self, words: &[&str], code: i32) -> String {
        let result = self.run("refused", words);
        let error = String::from_utf8_lossy(&result.stderr).into_owned();
        assert_eq!(result.status.code(), Some(code), "{words:?}: {error}");
        assert!(!error.contains("panicked"), "{error}");
        error
    }
}

// ---- samples and maps made by formulas ----

fn fibonacci(count: usize) -> Vec<Direction> {
    (0..count)
        .map(|i| {
            let cos = 1.0 - (i as f64 + 0.5) / count as f64;
            Direction::from_angles(cos.acos(), i as f64 * PI * (3.0 - 5f64.sqrt()))
        })
        .collect()
}

/// The 81 directions of Bonn: rings of 1, 6, 12, 18, 20, 24.
fn bonn81() -> Vec<Direction> {
    [
        (0.0, 1),
        (15.0, 6),
        (30.0, 12),
        (45.0, 18),
        (60.0, 20),
        (75.0, 24),
    ]
    .into_iter()
    .flat_map(|(theta, count): (f64, u32)| {
        (0..count).map(move |k| {
            let phi = 360.0 * f64::from(k) / f64::from(count);
            Direction::from_angles(theta.to_radians(), phi.to_radians())
        })
    })
    .collect()
}

struct SampleSpec {
    size: [u32; 2],
    views: Vec<Direction>,
    lights: Vec<Direction>,
    dtype: DType,
}

impl SampleSpec {
    /// Writes a product sample; `value` is called with view, light, row, column.
    fn write(
        &self,
        path: &Path,
        value: impl Fn(&Direction, &Direction, u32, u32) -> [f64; 3],
    ) -> ContentId {
        let [width, height] = self.size;
        let description = Description {
            dtype: self.dtype,
            tileable: true,
            ..Description::product(
                "made",
                [width, height],
                self.views.clone(),
                self.lights.clone(),
            )
        };
        let mut writer = SampleWriter::create(path, description).unwrap();
        for view in &self.views {
            for light in &self.lights {
                let texels = (0..height).flat_map(|row| (0..width).map(move |col| (row, col)));
                let image: Vec<f32> = texels
                    .flat_map(|(row, col)| value(view, light, row, col).map(|v| v as f32))
                    .collect();
                writer.push(&image).unwrap();
            }
        }
        writer.finish().unwrap().id
    }
}

/// Something that differs in every image and texel, and is never smooth.
fn hashed(view: &Direction, light: &Direction, row: u32, col: u32) -> [f64; 3] {
    let seed = view.0.x * 12.9898 + view.0.y * 78.233 + light.0.x * 37.719 + light.0.y * 4.581;
    [0.0, 1.0, 2.0].map(|channel| {
        let x = (seed + f64::from(row) * 1.37 + f64::from(col) * 5.11 + channel).sin() * 43758.5453;
        0.05 + 0.9 * (x - x.floor())
    })
}

fn lambertian(_: &Direction, light: &Direction, _: u32, _: u32) -> [f64; 3] {
    [0.8, 0.5, 0.2].map(|albedo| albedo * light.0.z.max(0.0) / PI)
}

/// A map over any mesh with given normals; orientations follow the x axis where they can.
fn map_over(
    mesh: TriangleMesh,
    normals: Vec<Vec3>,
    exemplar: [u32; 2],
    texel: f64,
    sample: ContentId,
    coord: impl Fn(usize) -> TexCoord,
) -> SurfaceTextonMap {
    let orientation = |n: &Vec3| {
        let along = if n.x.abs() < 0.9 { Vec3::X } else { Vec3::Y };
        (along - *n * n.dot(along)).normalize()
    };
    let count = normals.len();
    SurfaceTextonMap {
        scale: None,
        orientations: normals.iter().map(orientation).collect(),
        coords: (0..count).map(coord).collect(),
        textons: (0..count).map(|v| TextonLabel((v % 7) as u16)).collect(),
        transition: None,
        mask: None,
        mesh,
        normals,
        header: MapHeader {
            origin: glam::DVec3::ZERO,
            exemplar,
            texel,
            seed: 5,
            method: "k-coherence".into(),
            polish: 0,
            sample,
            space: ContentId::of_bytes(b"space"),
        },
    }
}

/// A ball of radius 1 with outward triangles.
fn ball(rings: u32, exemplar: [u32; 2], sample: ContentId) -> SurfaceTextonMap {
    let mut mesh = TriangleMesh::default();
    mesh.positions.push(Vec3::Y);
    for i in 1..rings {
        for j in 0..2 * rings {
            let theta = std::f32::consts::PI * i as f32 / rings as f32;
            let phi = std::f32::consts::PI * j as f32 / rings as f32;
            let (sin, cos) = theta.sin_cos();
            mesh.positions
                .push(Vec3::new(sin * phi.sin(), cos, sin * phi.cos()));
        }
    }
    mesh.positions.push(-Vec3::Y);
    let around = 2 * rings;
    let last = mesh.positions.len() as u32 - 1;
    let at = |i: u32, j: u32| 1 + (i - 1) * around + j % around;
    for j in 0..around {
        mesh.triangles.push([0, at(1, j), at(1, j + 1)]);
        mesh.triangles
            .push([last, at(rings - 1, j + 1), at(rings - 1, j)]);
        for i in 1..rings - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let normals = mesh.positions.iter().map(|p| p.normalize()).collect();
    let [width, height] = exemplar;
    map_over(mesh, normals, exemplar, 0.05, sample, |v| TexCoord {
        s: (v as u32 * 7 % width) as f32 + 0.5,
        t: (v as u32 * 3 % height) as f32 + 0.5,
    })
}

/// A unit square in z = 0 seen from +z, `cells` × `cells`, one texel of a `cells`-sized sample a cell.
fn square(cells: u32, exemplar: [u32; 2], texel: f64, sample: ContentId) -> SurfaceTextonMap {
    let mut mesh = TriangleMesh::default();
    for j in 0..=cells {
        for i in 0..=cells {
            let at = |k: u32| k as f32 / cells as f32 - 0.5;
            mesh.positions.push(Vec3::new(at(i), at(j), 0.0));
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = j * (cells + 1) + i;
            let [b, c, d] = [a + 1, a + cells + 2, a + cells + 1];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let normals = vec![Vec3::Z; mesh.positions.len()];
    let positions = mesh.positions.clone();
    let [width, height] = exemplar.map(|side| side as f32);
    map_over(mesh, normals, exemplar, texel, sample, move |v| {
        let at = (positions[v] + 0.5) / texel as f32;
        let t = at.y.rem_euclid(height);
        TexCoord {
            s: at.x.rem_euclid(width),
            t: if t > 0.0 { t } else { height },
        }
    })
}

fn small_ball(dtype: DType) -> Bench {
    let spec = SampleSpec {
        size: [8, 6],
        views: fibonacci(11),
        lights: fibonacci(14),
        dtype,
    };
    Bench::new(|path| spec.write(path, hashed), |id| ball(14, [8, 6], id))
}

// ---- reading frames ----

struct Picture {
    size: [usize; 2],
    channels: BTreeMap<String, Vec<f64>>,
    kinds: BTreeMap<String, &'static str>,
}

fn read_frame(path: &Path) -> Picture {
    let image = read_all_flat_layers_from_file(path).unwrap();
    assert_eq!(image.layer_data.len(), 1);
    let layer = &image.layer_data[0];
    let mut picture = Picture {
        size: [layer.size.0, layer.size.1],
        channels: BTreeMap::new(),
        kinds: BTreeMap::new(),
    };
    for channel in &layer.channel_data.list {
        let (kind, numbers): (_, Vec<f64>) = match &channel.sample_data {
            FlatSamples::F16(v) => ("half", v.iter().map(|x| x.to_f64()).collect()),
            FlatSamples::F32(v) => ("float", v.iter().map(|x| f64::from(*x)).collect()),
            FlatSamples::U32(v) => ("uint", v.iter().map(|x| f64::from(*x)).collect()),
        };
        picture.kinds.insert(channel.name.to_string(), kind);
        picture.channels.insert(channel.name.to_string(), numbers);
    }
    picture
}

/// The linear colours that `--linear-colors` writes.
fn vertex_colors(path: &Path) -> Vec<[f64; 3]> {
    let file = ply::read(path).unwrap();
    let channels = ["r", "g", "b"].map(|name| file.require(name).unwrap().to_vec());
    (0..file.vertex_count)
        .map(|v| [0, 1, 2].map(|k: usize| channels[k][v]))
        .collect()
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| {
            let name = entry.file_name().into_string().unwrap();
            (name, fs::read(entry.path()).unwrap())
        })
        .collect()
}
