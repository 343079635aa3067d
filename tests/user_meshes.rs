//! Meshes as users have them, through the program: far coordinates, texture coordinates, idle options.

mod program;

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec2};
use mesotex::format::ply;
use mesotex::mesh::reading::{UserMesh, read};
use mesotex::mesh::{TriangleMesh, shapes, write_user};
use mesotex::progress::Progress;
use program::{refuse, succeed};
use serde_json::Value;

fn report(folder: &Path, words: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, &[words, &["--json"]].concat())).unwrap()
}

/// An OBJ with as many digits as doubles have.
fn obj_at(mesh: &TriangleMesh, place: DVec3) -> String {
    let vertices = mesh.positions.iter().map(|p| {
        let DVec3 { x, y, z } = p.as_dvec3() + place;
        format!("v {x} {y} {z}\n")
    });
    let faces = mesh
        .triangles
        .iter()
        .map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect()
}

#[test]
fn far_meshes_come_back_where_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = shapes::torus(24, 12, 0.1, 0.04);
    for place in [
        DVec3::new(500_000.25, 5_000_000.5, 320.0),
        DVec3::new(4_485_513.7, 651_341.2, 4_471_887.9),
    ] {
        fs::write(folder.path().join("far.obj"), obj_at(&mesh, place)).unwrap();
        for output in ["back.ply", "back.obj", "back.glb"] {
            let told = report(folder.path(), &["mesh", "far.obj", "-o", output]);
            assert_eq!(told["volume"].as_f64().map(|v| v > 0.0), Some(true));
            let user = read(&folder.path().join(output), Progress::silent()).unwrap();
            let pairs = mesh.positions.iter().zip(&user.mesh.positions);
            for (before, after) in pairs {
                let moved = after.as_dvec3() + user.origin - place;
                let distance = (moved - before.as_dvec3()).length();
                assert!(distance < 1e-6 * 0.28, "{output}: {distance}");
            }
            fs::remove_file(folder.path().join(output)).unwrap();
        }
        let text = succeed(folder.path(), &["info", "far.obj"]);
        assert!(text.contains("origin "), "{text}");
    }
}

#[test]
fn a_far_retiling_keeps_its_area() {
    let folder = tempfile::tempdir().unwrap();
    let place = DVec3::new(4_485_513.7, 651_341.2, 4_471_887.9);
    let mesh = shapes::torus(40, 20, 1.0, 0.4);
    fs::write(folder.path().join("far.obj"), obj_at(&mesh, place)).unwrap();
    let words = [
        "mesh",
        "far.obj",
        "-o",
        "even.ply",
        "--vertices",
        "2000",
        "--orient",
        "--direction",
        "0,0,1",
    ];
    let told = report(folder.path(), &words);
    assert!((told["area"].as_f64().unwrap() / mesh.area() - 1.0).abs() < 0.01);
    let file = ply::read(&folder.path().join("even.ply")).unwrap();
    let far = file.column("x").unwrap();
    assert!(far.iter().all(|x| (x - place.x).abs() < 1.5), "{}", far[0]);
}

/// A square of 16 × 16 quads whose texture is one chart, or one per triangle.
fn textured(chart_per_triangle: bool) -> UserMesh {
    let mesh = shapes::grid(16, 16, 0.125);
    let uvs = (0..mesh.triangles.len()).map(|triangle| {
        let shift = match chart_per_triangle {
            true => 5.0 * triangle as f32,
            false => 0.0,
        };
        mesh.corners(triangle)
            .map(|p| p.truncate() / 2.0 + Vec2::X * shift)
    });
    UserMesh {
        corner_uvs: Some(uvs.collect()),
        mesh,
        ..UserMesh::default()
    }
}

#[test]
fn texture_coordinates_come_through_retiling_or_are_said_to_be_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_user(&path("whole.obj"), &textured(false)).unwrap();
    write_user(&path("parts.obj"), &textured(true)).unwrap();
    for output in ["even.obj", "even.glb", "even.ply"] {
        let words = ["mesh", "whole.obj", "-o", output, "--vertices", "500"];
        let text = succeed(folder.path(), &words);
        assert!(text.contains("texture coordinates of 1 charts"), "{text}");
        let user = read(&path(output), Progress::silent()).unwrap();
        for (triangle, uvs) in user.corner_uvs.iter().flatten().enumerate() {
            for (uv, p) in uvs.iter().zip(user.mesh.corners(triangle)) {
                assert!(
                    (*uv - p.truncate() / 2.0).length() < 1e-4,
                    "{output}: {uv} at {p}"
                );
            }
        }
        assert!(user.corner_uvs.is_some(), "{output}");
    }
    let words = ["mesh", "parts.obj", "-o", "lost.obj", "--vertices", "200"];
    let output = program::mesotex(folder.path(), &words);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("texture coordinates are lost"), "{said}");
    let lost = read(&path("lost.obj"), Progress::silent()).unwrap();
    assert_eq!(lost.corner_uvs, None);
}

#[test]
fn options_of_mesh_take_effect_or_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = shapes::torus(24, 12, 1.0, 0.4);
    fs::write(folder.path().join("a.obj"), obj_at(&mesh, DVec3::ZERO)).unwrap();
    fs::write(folder.path().join("g.json"), r#"{"guides": []}"#).unwrap();
    let plain = ["mesh", "a.obj", "-o", "b.ply"];
    for (option, value) in [
        ("--direction", "0,1,0"),
        ("--align", "curvature"),
        ("--field-energy", "cosine"),
        ("--guide", "g.json"),
        ("--texel", "0.1"),
        ("--levels", "3"),
        ("--crease", "30"),
    ] {
        let idle = [&plain[..], &[option, value]].concat();
        let said = refuse(folder.path(), &idle, 2);
        assert!(said.contains(option) && said.contains("--report"), "{said}");
        assert!(!folder.path().join("b.ply").exists());
        succeed(
            folder.path(),
            &[&idle[..], &["--report", "r.json"]].concat(),
        );
        fs::remove_file(folder.path().join("b.ply")).unwrap();
    }
}

#[test]
fn a_turned_component_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = shapes::torus(12, 8, 1.0, 0.4);
    let turned = mesh.triangles.len() / 3;
    mesh.triangles[..turned]
        .iter_mut()
        .for_each(|t| t.swap(1, 2));
    fs::write(folder.path().join("a.obj"), obj_at(&mesh, DVec3::ZERO)).unwrap();
    let text = succeed(folder.path(), &["info", "a.obj"]);
    assert!(text.contains("triangles flipped to face"), "{text}");
}
