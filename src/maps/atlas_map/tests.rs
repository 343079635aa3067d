//! Round trips and refusals of the folder.

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::{AtlasMap, ChannelFile};
use crate::error::Result;
use crate::format::id::ContentId;
use crate::grid::TexCoord;
use crate::index::TextonLabel;
use crate::maps::header::MapHeader;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A square of two triangles on the lower left three quarters of a 4 × 4 atlas; the sample is 8 × 4 texels.
pub(crate) fn square() -> AtlasMap {
    let id = ContentId::of_bytes(b"x");
    let uv = |u: f32, v: f32| Vec2::new(0.75 * u, 0.75 * v);
    let corners = [Vec3::ZERO, Vec3::X, Vec3::ONE - Vec3::Z, Vec3::Y];
    let is_inside = |texel: usize| texel / 4 > 0 && texel % 4 < 3;
    let per_texel = |inside: Vec3| -> Vec<Vec3> {
        let vector = |texel| if is_inside(texel) { inside } else { Vec3::ZERO };
        (0..16).map(vector).collect()
    };
    let position = |texel: usize| {
        let (row, col) = ((texel / 4) as f32, (texel % 4) as f32);
        Vec3::new((col + 0.5) / 3.0, (3.5 - row) / 3.0, 0.0)
    };
    AtlasMap {
        mesh: TriangleMesh {
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        },
        vertex_normals: vec![Vec3::Z; 4],
        corner_uvs: vec![
            [uv(0.0, 0.0), uv(1.0, 0.0), uv(1.0, 1.0)],
            [uv(0.0, 0.0), uv(1.0, 1.0), uv(0.0, 1.0)],
        ],
        chart_of: vec![0, 0],
        width: 4,
        height: 4,
        chart: (0..16)
            .map(|texel| i32::from(is_inside(texel)) - 1)
            .collect(),
        position: (0..16)
            .map(|texel| {
                if is_inside(texel) {
                    position(texel)
                } else {
                    Vec3::ZERO
                }
            })
            .collect(),
        normal: per_texel(Vec3::Z),
        orientation: per_texel(Vec3::X),
        scale: None,
        coords: (0..16)
            .map(|texel| {
                let (s, t) = ((texel % 4) as f32 + 0.5, (4 - texel / 4) as f32 - 0.5);
                is_inside(texel).then_some(TexCoord { s, t })
            })
            .collect(),
        textons: (0..16)
            .map(|texel| match is_inside(texel) {
                true => TextonLabel(texel as u16),
                false => TextonLabel::NONE,
            })
            .collect(),
        tileable: true,
        header: MapHeader {
            origin: DVec3::new(4_485_513.7, -0.1, 0.0),
            exemplar: [8, 4],
            texel: 1.0 / 3.0,
            seed: 7,
            method: "coherent".into(),
            polish: 1,
            sample: id.clone(),
            space: id,
        },
    }
}

fn written(map: &AtlasMap, folder: &Path) -> Result<AtlasMap> {
    let color = ChannelFile {
        name: "color".into(),
        kind: "color".into(),
        file: "color.png".into(),
        low: 0.0,
        high: 1.0,
    };
    map.write_into(folder, vec![color])?;
    AtlasMap::read(folder)
}

#[test]
fn maps_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let map = square();
    assert_eq!(written(&map, folder.path()).unwrap(), map);
    let text = fs::read_to_string(folder.path().join("atlas.json")).unwrap();
    let told: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&told["width"], &told["seed"]), (&4.into(), &7.into()));
    assert_eq!(told["channels"][0]["file"], "color.png");
    let plain = AtlasMap {
        textons: vec![TextonLabel::NONE; 16],
        scale: Some((1..17).map(|at| at as f32).collect()),
        ..map
    };
    assert_eq!(plain.texel_at(2), 1.0);
    let other = tempfile::tempdir().unwrap();
    assert_eq!(written(&plain, other.path()).unwrap(), plain);
    assert!(!other.path().join("texton.npy").exists());
}

#[test]
fn impossible_maps_are_refused_by_place() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |change: &dyn Fn(&mut AtlasMap)| {
        let mut map = square();
        change(&mut map);
        written(&map, folder.path()).unwrap_err().to_string()
    };
    type Change<'a> = &'a dyn Fn(&mut AtlasMap);
    let cases: [(Change<'_>, &str); 15] = [
        (&|m| m.coords[4] = None, "row 1, column 0"),
        (&|m| m.coords[0] = m.coords[4], "row 0, column 0"),
        (
            &|m| m.coords[5] = Some(TexCoord { s: 8.0, t: 1.0 }),
            "(8, 1)",
        ),
        (
            &|m| {
                m.coords[5] = Some(TexCoord {
                    s: f32::NAN,
                    t: 1.0,
                })
            },
            "coords.npy, row 1",
        ),
        (&|m| m.normal[6] = Vec3::ZERO, "normal, row 1, column 2"),
        (
            &|m| m.position[6].x = f32::INFINITY,
            "position, row 1, column 2",
        ),
        (&|m| m.chart[6] = 1, "chart, row 1, column 2: 1"),
        (&|m| m.mesh.triangles[1][2] = 4, "triangles, row 1"),
        (&|m| m.corner_uvs[1][0].x = 1.5, "corner_uvs, row 1"),
        (&|m| m.chart_of[1] = 2, "triangle_chart, row 1"),
        (&|m| m.textons[0] = TextonLabel(1), "texton.npy, row 0"),
        (
            &|m| m.scale = Some(vec![-1.0; 16]),
            "scale, row 1, column 0: -1",
        ),
        (&|m| m.header.texel = 0.0, "scale"),
        (&|m| m.header.method = "A b".into(), "method"),
        (&|m| m.width = 5, "chart: 16 entries; expected 20"),
    ];
    for (change, says) in cases {
        let text = refused(change);
        assert!(text.contains(says), "{says}: {text}");
    }
}

#[test]
fn files_of_another_run_are_refused() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    written(&square(), a.path()).unwrap();
    let mut other = square();
    other.coords.swap(4, 5);
    other.position[4].z = 1.0;
    other.textons.swap(4, 5);
    written(&other, b.path()).unwrap();
    for name in ["coords.npy", "texton.npy", "surface.npz"] {
        let kept = fs::read(a.path().join(name)).unwrap();
        fs::copy(b.path().join(name), a.path().join(name)).unwrap();
        let text = AtlasMap::read(a.path()).unwrap_err().to_string();
        assert!(
            text.contains(name) && text.contains("different runs"),
            "{text}"
        );
        fs::write(a.path().join(name), kept).unwrap();
    }
    AtlasMap::read(a.path()).unwrap();
}

#[test]
fn a_description_leads_to_no_files_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    written(&square(), folder.path()).unwrap();
    let path = folder.path().join("atlas.json");
    let text = fs::read_to_string(&path).unwrap();
    for (from, to, says) in [
        ("\"color.png\"", "\"../color.png\"", "channels[0]: file"),
        ("\"mesotex-atlas\"", "\"x\"", "format"),
        ("\"width\": 4", "\"width\": 0", "width, height"),
        ("\"width\": 4", "\"width\": 5", "expected [4, 5, 2]"),
        (
            "\"width\": 4,\n  \"height\": 4",
            "\"width\": 16384,\n  \"height\": 8192",
            "at most 67108864 texels",
        ),
        ("\"version\": 1", "\"version\": 2", "version"),
    ] {
        assert!(text.contains(from), "{from}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let told = AtlasMap::read(folder.path()).unwrap_err().to_string();
        assert!(told.contains(says), "{told}");
    }
}
