//! `mesotex render` as a user runs it: frames against the contract and against the formulas, read
//! back; the same bytes whatever the threads, interruptions and shards; bad input.

mod animations;
mod interruptions;
mod keeping;
mod lambert;
mod looks;
mod pairs;
mod pixels;
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

// ---- the contract, literally, in double precision ----

fn oracle_color(
    sample: &Sample,
    map: &SurfaceTextonMap,
    vertex: usize,
    camera: DVec3,
    light: DVec3,
    weighting: &str,
) -> [f64; 3] {
    let n = map.normals[vertex].as_dvec3();
    let s = map.orientations[vertex].as_dvec3();
    let t = n.cross(s);
    let local = |v: DVec3| DVec3::new(v.dot(s), v.dot(t), v.dot(n)).normalize();
    let light = local(light);
    let mut view = local(camera - map.mesh.positions[vertex].as_dvec3());
    if light.z <= 0.0 {
        return [0.0; 3];
    }
    if view.z < 0.0 {
        let phi = view.y.atan2(view.x);
        view = Direction::from_angles(PI / 2.0 - 1e-3, phi).0;
    }
    let description = sample.description();
    let texel = sample
        .grid()
        .texel_holding(map.coords[vertex])
        .unwrap()
        .index();
    let mut color = [0.0; 3];
    for (v, view_weight) in view_weights(&description.views, view, weighting) {
        for (l, light_weight) in light_weights(&description.lights, light, weighting) {
            let image = sample.image(v * description.lights.len() + l).unwrap();
            for (channel, sum) in color.iter_mut().enumerate() {
                let value = f64::from(image.get(texel * 3 + channel));
                *sum += view_weight * light_weight * value;
            }
        }
    }
    color.map(|value| value.max(0.0))
}

#[test]
fn vertex_colors_equal_the_formula_in_all_weightings() {
    for dtype in [DType::F2, DType::F4] {
        let bench = small_ball(dtype);
        let (sample, map) = (
            Sample::open(&bench.sample).unwrap(),
            SurfaceTextonMap::read(&bench.map).unwrap(),
        );
        for weights in ["continuous", "quadratic", "inverse-angle"] {
            let file = bench.path("colors.ply");
            let words = [
                "--irradiance",
                "1",
                "--shadows",
                "none",
                "--weights",
                weights,
                "--size",
                "16x16",
                "--linear-colors",
                "--vertex-colors",
                text(&file),
                "--camera-position",
                "1,2,3",
                "--light",
                "sun:40,35",
                "--camera-target",
                "0,0,0",
            ];
            bench.render("frames", &words);
            let camera = DVec3::new(1.0, 2.0, 3.0);
            // Azimuth 0 points at the camera, counter-clockwise seen from above (+y).
            let zero = DVec3::new(1.0, 0.0, 3.0).normalize();
            let left = DVec3::Y.cross(zero);
            let (a, e) = (40f64.to_radians(), 35f64.to_radians());
            let light = (zero * a.cos() + left * a.sin()) * e.cos() + DVec3::Y * e.sin();
            let mut lit = 0;
            for (vertex, found) in vertex_colors(&file).into_iter().enumerate() {
                let wanted = oracle_color(&sample, &map, vertex, camera, light, weights);
                for (found, wanted) in found.into_iter().zip(wanted) {
                    // Halfs have 11 bits; a quadratic fit also takes differences of values.
                    let close = (found - wanted).abs() <= 1e-3 * wanted.max(0.01);
                    assert!(close, "{weights}, vertex {vertex}: {found} {wanted}");
                    lit += u32::from(wanted > 0.0);
                }
            }
            assert!(lit > 300, "{lit}");
        }
    }
}

#[test]
fn stored_values_come_back_at_sampled_directions() {
    let spec = SampleSpec {
        size: [6, 6],
        views: fibonacci(9),
        lights: fibonacci(12),
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, hashed),
        |id| square(6, [6, 6], 1.0 / 6.0, id),
    );
    let sample = Sample::open(&bench.sample).unwrap();
    let map = SurfaceTextonMap::read(&bench.map).unwrap();
    for (v, l) in [(0, 0), (3, 7), (8, 11)] {
        let (view, light) = (spec.views[v].0, spec.lights[l].0);
        // Orthographic, so that every vertex is seen along one direction. Up is z, so azimuths are
        // the sample's own, less that of the camera.
        let camera = view * 10.0;
        let degrees = |d: DVec3| (d.y.atan2(d.x).to_degrees(), d.z.asin().to_degrees());
        let (light_angles, view_angles) = (degrees(light), degrees(view));
        let sun = format!("sun:{},{}", light_angles.0 - view_angles.0, light_angles.1);
        let position = format!("{},{},{}", camera.x, camera.y, camera.z);
        let file = bench.path("colors.ply");
        bench.render(
            "frames",
            &[
                "--irradiance",
                "1",
                "--up",
                "z",
                "--projection",
                "orthographic",
                "--size",
                "40x40",
                "--camera-position",
                &position,
                "--camera-target",
                "0,0,0",
                "--light",
                &sun,
                "--linear-colors",
                "--vertex-colors",
                text(&file),
            ],
        );
        let image = sample.image(v * 12 + l).unwrap();
        for (vertex, found) in vertex_colors(&file).into_iter().enumerate() {
            let texel = sample
                .grid()
                .texel_holding(map.coords[vertex])
                .unwrap()
                .index();
            for (channel, found) in found.into_iter().enumerate() {
                let stored = f64::from(image.get(texel * 3 + channel));
                assert!(
                    (found - stored).abs() < 1e-6,
                    "{v} {l} {vertex}: {found} {stored}"
                );
            }
        }
    }
}

#[test]
fn frames_hold_what_the_contract_says() {
    let bench = small_ball(DType::F2);
    let words = [
        "--size",
        "48x36",
        "--sweep",
        "light-azimuth",
        "--frames",
        "2",
    ];
    let folder = bench.render("frames", &words);
    for name in [
        "frame.0001.exr",
        "frame.0001.png",
        "frame.0002.exr",
        "frame.0002.png",
        "contact.png",
    ] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    let path = folder.join("frame.0002.exr");
    let frame = read_frame(&path);
    assert_eq!(frame.size, [48, 36]);
    let kinds: Vec<(&str, &str)> = frame.kinds.iter().map(|(n, k)| (n.as_str(), *k)).collect();
    assert_eq!(
        kinds,
        [
            ("A", "half"),
            ("B", "half"),
            ("G", "half"),
            ("N.X", "float"),
            ("N.Y", "float"),
            ("N.Z", "float"),
            ("R", "half"),
            ("Z", "float"),
            ("texton.I", "uint"),
            ("uv.U", "float"),
            ("uv.V", "float"),
        ]
    );
    let map = SurfaceTextonMap::read(&bench.map).unwrap();
    let at = |name: &str, pixel: usize| frame.channels[name][pixel];
    for pixel in 0..48 * 36 {
        let coverage = at("A", pixel);
        assert!((coverage * 4.0).fract() == 0.0 && coverage <= 1.0);
        if coverage == 0.0 {
            assert_eq!(at("Z", pixel), f64::INFINITY);
            assert_eq!(at("texton.I", pixel), 65535.0);
            for name in ["R", "G", "B", "N.X", "N.Y", "N.Z", "uv.U", "uv.V"] {
                assert_eq!(at(name, pixel), 0.0);
            }
        } else {
            let normal = DVec3::new(at("N.X", pixel), at("N.Y", pixel), at("N.Z", pixel));
            assert!((normal.length() - 1.0).abs() < 1e-5);
            // The label and the coordinate are one vertex's own.
            let (s, t) = (at("uv.U", pixel) * 8.0, at("uv.V", pixel) * 6.0);
            let same = |v: &usize| {
                (f64::from(map.coords[*v].s) - s).abs() < 1e-4
                    && (f64::from(map.coords[*v].t) - t).abs() < 1e-4
                    && f64::from(map.textons[*v].0) == at("texton.I", pixel)
            };
            assert!((0..map.coords.len()).find(same).is_some());
        }
    }
    check_header(&bench, &path, &frame);
}

fn check_header(bench: &Bench, path: &Path, frame: &Picture) {
    use exr::meta::attribute::AttributeValue as Value;
    let meta = exr::meta::MetaData::read_from_file(path, true).unwrap();
    let header = &meta.headers[0];
    let own = &header.own_attributes;
    let other = |name: &str| {
        own.other
            .get(&exr::meta::attribute::Text::from(name))
            .unwrap()
            .clone()
    };
    let to_text = |name: &str| match other(name) {
        Value::Text(value) => value.to_string(),
        value => panic!("{name}: {value:?}"),
    };
    assert_eq!(to_text("colorInteropID"), "lin_rec709_scene");
    assert_eq!(to_text("mesotex:seed"), "5");
    assert_eq!(
        to_text("mesotex:sample"),
        Sample::open(&bench.sample).unwrap().id().to_string()
    );
    assert_eq!(
        to_text("mesotex:map"),
        ContentId::of_file(&bench.map).unwrap().to_string()
    );
    let options: serde_json::Value = serde_json::from_str(&to_text("mesotex:options")).unwrap();
    assert_eq!(options["weights"], "continuous");
    assert!(!to_text("mesotex:options").contains(text(bench.folder.path())));
    assert_eq!(other("frame"), Value::I32(2));
    let Value::F32(irradiance) = other("lightIrradiance") else {
        panic!()
    };
    assert!((irradiance - std::f32::consts::PI).abs() < 1e-6);
    let Value::FloatVec3((x, y, z)) = other("lightDirection") else {
        panic!()
    };
    assert!((x * x + y * y + z * z - 1.0).abs() < 1e-5);
    assert!(header.shared_attributes.chromaticities.is_some());

    // Points of the surface, by Z and the matrices, lie on the unit ball.
    let to_camera = own.world_to_camera.unwrap().map(f64::from);
    let to_ndc = own.world_to_normalized_device.unwrap().map(f64::from);
    let times = |p: DVec3, m: &[f64; 16]| {
        let row = [p.x, p.y, p.z, 1.0];
        [0, 1, 2, 3].map(|column: usize| (0..4).map(|k| row[k] * m[k * 4 + column]).sum::<f64>())
    };
    // The matrix is a rotation and a shift with a mirrored axis: invert it by its transpose.
    let axis = |column: usize| {
        DVec3::new(
            to_camera[column],
            to_camera[4 + column],
            to_camera[8 + column],
        )
    };
    let (right, up, ahead) = (axis(0), axis(1), axis(2));
    assert!((right.cross(up) + ahead).length() < 1e-5, "left-handed");
    let origin = -(right * to_camera[12] + up * to_camera[13] + ahead * to_camera[14]);
    let mut seen = 0;
    for pixel in 0..48 * 36 {
        if frame.channels["A"][pixel] < 1.0 {
            continue;
        }
        let ndc = [
            ((pixel % 48) as f64 + 0.5) / 48.0,
            ((pixel / 48) as f64 + 0.5) / 36.0,
        ];
        // Solve for the camera ray through the pixel by two probes of the linear map.
        let depth = frame.channels["Z"][pixel];
        let probe = |x: f64, y: f64| {
            let p = origin + right * x + up * y + ahead * depth;
            let [u, v, _, w] = times(p, &to_ndc);
            [u / w, v / w]
        };
        let ([u0, v0], [u1, _], [_, v1]) = (probe(0.0, 0.0), probe(1.0, 0.0), probe(0.0, 1.0));
        let (x, y) = ((ndc[0] - u0) / (u1 - u0), (ndc[1] - v0) / (v1 - v0));
        let p = origin + right * x + up * y + ahead * depth;
        assert!((p.length() - 1.0).abs() < 0.02, "{p}");
        seen += 1;
    }
    assert!(seen > 200);
}

#[test]
fn bytes_do_not_depend_on_threads_interruptions_or_shards() {
    let bench = small_ball(DType::F2);
    let sweep = [
        "--size",
        "40x30",
        "--sweep",
        "view-orbit",
        "--frames",
        "7",
        "--layers",
        "rgba,depth,shadow,weight",
    ];
    let with = |more: &[&'static str]| [&sweep[..], more].concat();
    let whole = files(&bench.render("one", &with(&["--threads", "1"])));
    assert_eq!(whole.len(), 15);
    assert_eq!(
        whole,
        files(&bench.render("eight", &with(&["--threads", "8"])))
    );

    for shard in ["2/3", "0/3", "1/3"] {
        bench.render("shards", &with(&["--shard", shard]));
    }
    assert_eq!(whole, files(&bench.path("shards")));

    // What a killed run leaves: some frames whole, one preview without its frame, a temporary file.
    let resumed = bench.render("resumed", &with(&[]));
    let kept = fs::metadata(resumed.join("frame.0002.exr"))
        .unwrap()
        .modified()
        .unwrap();
    for gone in [
        "frame.0003.exr",
        "frame.0005.exr",
        "frame.0005.png",
        "contact.png",
    ] {
        fs::remove_file(resumed.join(gone)).unwrap();
    }
    bench.render("resumed", &with(&["--skip-existing"]));
    assert_eq!(whole, files(&resumed));
    let now = fs::metadata(resumed.join("frame.0002.exr"))
        .unwrap()
        .modified()
        .unwrap();
    assert_eq!(kept, now, "kept frames are not touched");

    // Frames of other options are made anew.
    let other = bench.run("resumed", &with(&["--skip-existing", "--irradiance", "2"]));
    assert!(String::from_utf8_lossy(&other.stdout).contains("7 frames of other options"));
}

#[test]
fn pixel_shading_shows_the_sample_between_vertices() {
    // Edges of 4 texels and exact coordinates, seen from straight above at 4 pixels a texel.
    let spec = SampleSpec {
        size: [32, 32],
        views: vec![Direction::from_angles(0.0, 0.0)],
        lights: vec![Direction::from_angles(0.0, 0.0)],
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, hashed),
        |id| square(8, [32, 32], 1.0 / 32.0, id),
    );
    let sample = Sample::open(&bench.sample).unwrap();
    let psnr = |shading: &str| {
        let words = [
            "--irradiance",
            "1",
            "--size",
            "128x128",
            "--projection",
            "orthographic",
            "--up",
            "z",
            "--camera-position",
            "0,0,5",
            "--camera-target",
            "0,0,0",
            "--view-height",
            "1",
            "--light",
            "sun:0,90",
            "--shading",
            shading,
            "--texels",
            "nearest",
            "--samples",
            "1",
        ];
        let frame = read_frame(&bench.render("frames", &words).join("frame.0001.exr"));
        let mut squares = 0.0;
        for pixel in 0..128 * 128 {
            let texel = (pixel / 128 / 4) * 32 + pixel % 128 / 4;
            for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
                let wanted = f64::from(sample.image(0).unwrap().get(texel * 3 + channel));
                squares += (frame.channels[name][pixel] - wanted).powi(2);
            }
        }
        -10.0 * (squares / (3.0 * 128.0 * 128.0)).log10()
    };
    let (pixel, vertex) = (psnr("pixel"), psnr("vertex"));
    assert!(pixel >= 40.0, "{pixel}");
    assert!(vertex <= pixel - 10.0, "{vertex} {pixel}");
}

#[test]
fn pixel_shading_of_a_scaled_plane_is_that_of_a_larger_texel() {
    let spec = SampleSpec {
        size: [32, 32],
        views: vec![Direction::from_angles(0.0, 0.0)],
        lights: vec![Direction::from_angles(0.0, 0.0)],
        dtype: DType::F2,
    };
    let words = "--size 16x16 --projection orthographic --up z --camera-position 0,0,5 \
                 --camera-target 0,0,0 --view-height 1 --light sun:0,90 --mip on";
    let frame = |texel: f64, scale: Option<f32>, shading: &str| {
        let map = |id| {
            let mut map = square(4, [32, 32], 1.0 / 32.0, id);
            map.scale = scale.map(|scale| vec![scale; map.mesh.positions.len()]);
            map.header.texel = texel;
            map
        };
        let bench = Bench::new(|path| spec.write(path, hashed), map);
        let mut words: Vec<&str> = words.split_whitespace().collect();
        words.extend(["--shading", shading]);
        let frame = read_frame(&bench.render("frames", &words).join("frame.0001.exr"));
        ["R", "G", "B"].map(|name| frame.channels[name].clone())
    };
    for shading in ["pixel", "vertex"] {
        let scaled = frame(1.0 / 32.0, Some(2.0), shading);
        assert_eq!(scaled, frame(1.0 / 16.0, None, shading));
        assert_ne!(scaled, frame(1.0 / 32.0, None, shading));
    }
}

#[test]
fn relief_is_lit_from_the_lights_side() {
    // A facing slope to the sample's right is bright when the light comes from the right.
    let spec = SampleSpec {
        size: [16, 16],
        views: fibonacci(6),
        lights: fibonacci(40),
        dtype: DType::F2,
    };
    let tilted = |_: &Direction, light: &Direction, _: u32, col: u32| {
        let slope = if col < 8 { -0.6f64 } else { 0.6 };
        let normal = DVec3::new(slope, 0.0, 1.0).normalize();
        [normal.dot(light.0).max(0.0) / PI; 3]
    };
    let bench = Bench::new(
        |path| spec.write(path, tilted),
        |id| square(16, [16, 16], 1.0 / 16.0, id),
    );
    for (azimuth, right_is_brighter) in [("50", true), ("-50", false)] {
        // The camera looks from +z with y up: azimuth 50, counter-clockwise from above, is on the right.
        let light = format!("sun:{azimuth},40");
        let words = [
            "--size",
            "64x64",
            "--camera-elevation",
            "0",
            "--light",
            &light,
        ];
        let frame = read_frame(&bench.render("frames", &words).join("frame.0001.exr"));
        let (mut left, mut right) = (0.0, 0.0);
        for pixel in (0..64 * 64).filter(|&pixel| frame.channels["A"][pixel] == 1.0) {
            let side = if frame.channels["uv.U"][pixel] < 0.5 {
                &mut left
            } else {
                &mut right
            };
            *side += frame.channels["G"][pixel];
        }
        assert_eq!(
            right > 1.3 * left,
            right_is_brighter,
            "{azimuth}: {left} {right}"
        );
        assert_eq!(left > 1.3 * right, !right_is_brighter);
    }
}

#[test]
fn impossible_requests_are_refused_with_reasons() {
    let bench = small_ball(DType::F2);
    for (words, code, says) in [
        (&["--frames", "0"][..], 2, "no frame"),
        (&["--size", "0x10"], 2, "size"),
        (&["--sweep", "light-azimut"], 2, "light-azimuth"),
        (
            &[
                "--sweep",
                "view-orbit",
                "--frames",
                "2",
                "--pattern",
                "frame",
            ],
            2,
            "--pattern",
        ),
        (
            &["--sweep", "view-orbit", "--frames", "12", "--pattern", "f#"],
            2,
            "at least 2 #",
        ),
        (&["--frames", "2"], 2, "without a sweep"),
        (&["--fov", "0"], 2, "--fov"),
        (&["--light", "lamp:1"], 2, "sun:AZIMUTH"),
        (&["--light", "point:0,1,0"], 2, "on the surface"),
        (
            &["--camera-position", "0,0,0", "--camera-target", "0,0,0"],
            2,
            "camera target",
        ),
        (&["--irradiance=-1"], 2, "--irradiance"),
        (&["--shard", "3/3"], 2, "shard"),
        (&["--threads", "0"], 2, "--threads"),
    ] {
        let error = bench.refuse(words, code);
        assert!(error.contains(says), "{words:?}: {error}");
    }
    let path = bench.path("path.csv");
    fs::write(&path, "camera_x,camera_y,camera_z\n0,1,5\n0,NaN,5\n").unwrap();
    let error = bench.refuse(&["--camera-path", text(&path)], 1);
    assert!(
        error.contains("path.csv") && error.contains("line 3, camera_y"),
        "{error}"
    );
    assert!(!bench.path("refused/frame.0001.exr").exists());
}

#[test]
fn warnings_say_what_will_look_wrong() {
    let bench = small_ball(DType::F2);
    let says = |words: &[&str]| {
        let result = bench.run("warned", &[words, &["--size", "16x16"]].concat());
        assert!(result.status.success());
        String::from_utf8_lossy(&result.stderr).into_owned()
    };
    assert!(says(&["--camera-position", "0,0.1,0"]).contains("inside the mesh"));
    assert!(says(&["--light", "point:0,0.1,0"]).contains("inside the mesh"));
    assert!(says(&["--pattern", "other.####"]).contains("not of this sweep"));
    assert!(
        says(&["--camera-position", "0,9,9", "--camera-target", "0,20,9"])
            .contains("shows nothing")
    );
}

#[test]
fn maps_and_samples_that_do_not_belong_together_are_refused() {
    let (a, b) = (small_ball(DType::F2), small_ball(DType::F4));
    let output = a.path("mixed");
    let words = [
        "render",
        text(&b.sample),
        text(&a.map),
        "-o",
        text(&output),
        "--size",
        "8x8",
    ];
    let refused = mesotex(&words);
    let error = String::from_utf8_lossy(&refused.stderr);
    assert!(
        refused.status.code() == Some(1) && error.contains("sample id"),
        "{error}"
    );
    assert!(
        mesotex(&[&words[..], &["--force"]].concat())
            .status
            .success()
    );

    let spec = SampleSpec {
        size: [5, 5],
        views: fibonacci(5),
        lights: fibonacci(5),
        dtype: DType::F2,
    };
    spec.write(&a.path("other.sample"), hashed);
    let other = a.path("other.sample");
    let words = [
        "render",
        text(&other),
        text(&a.map),
        "-o",
        text(&output),
        "--force",
    ];
    let error = mesotex(&words).stderr;
    assert!(String::from_utf8_lossy(&error).contains("5 × 5"));
}

#[test]
fn samples_with_few_directions_render_with_a_warning() {
    let spec = SampleSpec {
        size: [4, 4],
        views: fibonacci(1),
        lights: fibonacci(3),
        dtype: DType::F2,
    };
    let bench = Bench::new(
        |path| spec.write(path, lambertian),
        |id| ball(8, [4, 4], id),
    );
    for weights in ["continuous", "quadratic", "inverse-angle"] {
        let result = bench.run("few", &["--size", "24x24", "--weights", weights]);
        assert!(result.status.success());
        assert!(String::from_utf8_lossy(&result.stderr).contains("1 distinct views"));
        let frame = read_frame(&bench.path("few/frame.0001.exr"));
        assert!(frame.channels["R"].iter().any(|&v| v > 0.1));
    }
}

#[test]
fn radiance_that_is_none_is_named_by_place() {
    let bench = small_ball(DType::F2);
    let path = bench.sample.join("radiance.npy");
    let mut bytes = fs::read(&path).unwrap();
    // The last number of the last image: half NaN.
    let end = bytes.len();
    bytes[end - 2..].copy_from_slice(&[0x00, 0x7e]);
    fs::write(&path, bytes).unwrap();
    let error = bench.refuse(&["--size", "8x8"], 1);
    assert!(
        error.contains("view 10, light 13, row 5, column 7") && error.contains("NaN"),
        "{error}"
    );
}
