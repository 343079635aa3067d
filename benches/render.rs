//! Frames a second at the size of docs/performance/render.md: 300,000 vertices, 1280 × 960, 4
//! samples a pixel, a 64 × 64 sample of 60 views × 60 lights. Input is generated. One iteration is
//! one frame of a sweep of 96; nothing is written.

use std::path::Path;
use std::sync::OnceLock;

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use glam::Vec3;
use mesotex::btf::{DType, Description, Direction, Sample, SampleWriter};
use mesotex::format::ContentId;
use mesotex::format::exr::{Compression, ExrImage, encode};
use mesotex::grid::TexCoord;
use mesotex::index::TextonLabel;
use mesotex::maps::{MapHeader, SurfaceTextonMap};
use mesotex::mesh::TriangleMesh;
use mesotex::progress::Progress;
use mesotex::render::nearest::Weighting;
use mesotex::render::{
    BtfLookup, CameraOptions, FrameRange, ImageOptions, ImageSize, LayerGroup, MemoryBudget,
    PlannedFrame, RenderOptions, RenderSettings, Renderer, Samples, Shading, Shadows, Subject,
    Sweep, SweepOptions, Texels, plan,
};

fn main() {
    divan::main();
}

/// Sides of the torus' grid: 300,328 vertices.
const GRID: [u32; 2] = [868, 346];

fn directions(count: usize) -> Vec<Direction> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count)
        .map(|i| {
            let cos = 1.0 - (i as f64 + 0.5) / count as f64;
            Direction::from_angles(cos.acos(), i as f64 * golden)
        })
        .collect()
}

/// A sample whose values differ everywhere.
fn sample(folder: &Path) -> Sample {
    let path = folder.join("bench.sample");
    let description = Description {
        dtype: DType::F2,
        tileable: true,
        ..Description::product("bench", [64, 64], directions(60), directions(60))
    };
    let mut writer = SampleWriter::create(&path, description).unwrap();
    for image in 0..3600u32 {
        let value = |k: u32| (k.wrapping_mul(2_654_435_761).wrapping_add(image * 97) >> 16) % 1000;
        let numbers: Vec<f32> = (0..64 * 64 * 3).map(|k| value(k) as f32 * 1e-3).collect();
        writer.push(&numbers).unwrap();
    }
    writer.finish().unwrap();
    Sample::open(&path).unwrap()
}

/// A torus with texture coordinates along its circles, repeated.
fn torus(sample: &Sample) -> SurfaceTextonMap {
    let [around, across] = GRID;
    let turn = |k: u32, n: u32| std::f32::consts::TAU * k as f32 / n as f32;
    let (mut mesh, mut normals) = (TriangleMesh::default(), Vec::new());
    let (mut orientations, mut coords) = (Vec::new(), Vec::new());
    for i in 0..around {
        for j in 0..across {
            let ((su, cu), (sv, cv)) = (turn(i, around).sin_cos(), turn(j, across).sin_cos());
            let ring = 1.0 + 0.4 * cv;
            mesh.positions
                .push(Vec3::new(ring * su, 0.4 * sv, ring * cu));
            normals.push(Vec3::new(cv * su, sv, cv * cu));
            orientations.push(Vec3::new(cu, 0.0, -su));
            coords.push(TexCoord {
                s: (i % 64) as f32 + 0.5,
                t: (j % 64) as f32 + 0.5,
            });
            let at = |i: u32, j: u32| i % around * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    SurfaceTextonMap {
        scale: None,
        textons: vec![TextonLabel(1); mesh.positions.len()],
        transition: None,
        mask: None,
        mesh,
        normals,
        orientations,
        coords,
        header: MapHeader {
            origin: glam::DVec3::ZERO,
            exemplar: [64, 64],
            texel: f64::from(std::f32::consts::TAU) / f64::from(around),
            seed: 0,
            method: "k-coherence".into(),
            polish: 0,
            sample: sample.id().clone(),
            space: ContentId::of_bytes(b""),
        },
    }
}

struct Material {
    _folder: tempfile::TempDir,
    sample: Sample,
    map: SurfaceTextonMap,
}

fn material() -> &'static Material {
    static MATERIAL: OnceLock<Material> = OnceLock::new();
    MATERIAL.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let sample = sample(folder.path());
        let map = torus(&sample);
        Material {
            _folder: folder,
            sample,
            map,
        }
    })
}

/// The sample as a shading reads it by default.
fn lookup(shading: Shading) -> BtfLookup {
    let budget = MemoryBudget {
        bytes: 4 << 30,
        folder: std::env::temp_dir(),
    };
    BtfLookup::new(
        &material().sample,
        Weighting::Continuous,
        match shading {
            Shading::Vertex => Texels::Nearest,
            Shading::Pixel => Texels::Bilinear,
        },
        shading == Shading::Pixel,
        false,
        &budget,
        Progress::silent(),
    )
    .unwrap()
}

fn frames(sweep: Sweep) -> Vec<PlannedFrame> {
    let options = RenderOptions {
        sweep: SweepOptions {
            kind: sweep,
            frames: Some(FrameRange::count(96)),
            ..SweepOptions::default()
        },
        image: ImageOptions {
            size: ImageSize([1280, 960]),
            ..ImageOptions::default()
        },
        camera: CameraOptions {
            camera_elevation: 30.0,
            ..CameraOptions::default()
        },
        ..RenderOptions::default()
    };
    let subject = Subject::new(&material().map.mesh, glam::DVec3::ZERO, &options).unwrap();
    plan(&options, &subject, Progress::silent()).unwrap()
}

/// Colour alone.
fn settings(shading: Shading, shadows: Shadows) -> RenderSettings {
    RenderSettings {
        shading,
        shadows,
        samples: Samples::Four,
        soft_rays: 1,
        fill: None,
        ground: None,
        geometry_layers: false,
        extra_layers: false,
    }
}

fn run(bencher: Bencher, sweep: Sweep, shading: Shading, shadows: Shadows) {
    let lookup = lookup(shading);
    let map = &material().map;
    let mut renderer =
        Renderer::new(map, &lookup, settings(shading, shadows), Progress::silent()).unwrap();
    let frames = frames(sweep);
    // The first frame of a light sweep also finds what is seen; the sweep's rate is without it.
    renderer.frame(&frames[0].view, &frames[0].lights).unwrap();
    let mut next = frames.iter().cycle();
    bencher.counter(ItemsCount::new(1u32)).bench_local(|| {
        next.next()
            .map(|frame| renderer.frame(&frame.view, &frame.lights).unwrap())
    });
}

#[divan::bench(args = [Shadows::None, Shadows::Vertex, Shadows::Pixel])]
fn light_azimuth_vertex_shading(bencher: Bencher, shadows: Shadows) {
    run(bencher, Sweep::LightAzimuth, Shading::Vertex, shadows);
}

#[divan::bench(args = [Shadows::None, Shadows::Vertex])]
fn view_orbit_vertex_shading(bencher: Bencher, shadows: Shadows) {
    run(bencher, Sweep::ViewOrbit, Shading::Vertex, shadows);
}

#[divan::bench(args = [Shadows::None, Shadows::Vertex, Shadows::Pixel], sample_count = 20)]
fn light_azimuth_pixel_shading(bencher: Bencher, shadows: Shadows) {
    run(bencher, Sweep::LightAzimuth, Shading::Pixel, shadows);
}

/// Encoding a frame with all standard layers.
#[divan::bench(
    args = [Compression::Zip, Compression::Zips, Compression::Piz, Compression::None],
    sample_count = 20
)]
fn encode_frame(bencher: Bencher, compression: Compression) {
    let lookup = lookup(Shading::Vertex);
    let settings = RenderSettings {
        geometry_layers: true,
        ..settings(Shading::Vertex, Shadows::None)
    };
    let mut renderer =
        Renderer::new(&material().map, &lookup, settings, Progress::silent()).unwrap();
    let planned = &frames(Sweep::None)[0];
    let frame = renderer.frame(&planned.view, &planned.lights).unwrap();
    let groups = [
        LayerGroup::Rgba,
        LayerGroup::Depth,
        LayerGroup::Normals,
        LayerGroup::Uv,
        LayerGroup::Texton,
    ];
    let picture = ExrImage {
        size: frame.size,
        channels: frame.channels(&groups, false),
        attributes: Default::default(),
    };
    bencher
        .counter(BytesCount::new(1280u32 * 960 * 36))
        .bench(|| encode(&picture, compression).unwrap());
}

/// The machine's own pace: copying as many bytes as the sample laid out for shading has.
#[divan::bench]
fn copy_as_many_bytes(bencher: Bencher) {
    let bytes = vec![1u8; 64 * 64 * 3600 * 6];
    let mut copy = vec![0u8; bytes.len()];
    bencher
        .counter(BytesCount::new(bytes.len()))
        .bench_local(|| copy.copy_from_slice(divan::black_box(&bytes)));
}
