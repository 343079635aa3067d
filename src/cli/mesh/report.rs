//! What is reported of a mesh, for a person and as JSON.

use std::path::Path;

use serde_json::{Value, json};

use crate::cli::outcome::Outcome;
use crate::cli::session::Session;
use crate::mesh::origin::origin_text;
use crate::mesh::quality::evenness;
use crate::mesh::reading::UserMesh;
use crate::mesh::retile::carrying::Carried;
use crate::mesh::topology::{Shape, Topology};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::sites::vertices::prepared_surface::{PreparedSurface, SurfaceLevel};

/// What was read, what had to be repaired, and what of it is not used.
pub fn read_outcome(input: &Path, user: &UserMesh) -> Outcome {
    let mut outcome = Outcome::default().line(format!(
        "read {}: {} vertices, {} triangles{}",
        input.display(),
        user.from_file.len(),
        user.mesh.triangles.len(),
        properties_text(user)
    ));
    for line in user.report.lines() {
        outcome = outcome.line(format!("repair: {line}"));
    }
    for line in &user.report.unused {
        outcome = outcome.line(format!("note: {line}"));
    }
    if let Some(origin) = origin_text(user.origin) {
        outcome = outcome.line(format!(
            "origin {origin}: positions are relative to it; written files have the coordinates that were read"
        ));
    }
    outcome
        .figure("repairs", json!(user.report))
        .figure("file_vertices", user.from_file.len())
        .figure("properties", properties(user))
        .figure("origin", json!(user.origin.to_array()))
}

/// What comes with a mesh besides its surface.
fn properties(user: &UserMesh) -> Vec<&'static str> {
    let all = [
        ("normals", user.normals.is_some()),
        ("texture coordinates", user.corner_uvs.is_some()),
        ("orientation", user.orientation.is_some()),
        ("scale", user.scale.is_some()),
        ("transition", user.transition.is_some()),
        ("mask", user.mask.is_some()),
        ("rotation", user.rotation.is_some()),
    ];
    all.into_iter()
        .filter_map(|(name, there)| there.then_some(name))
        .collect()
}

fn properties_text(user: &UserMesh) -> String {
    match properties(user)[..] {
        [] => String::new(),
        ref names => format!(", with {}", names.join(", ")),
    }
}

/// Says whether texture coordinates came through retiling.
pub(super) fn carried_outcome(session: &Session, outcome: Outcome, carried: Carried) -> Outcome {
    match carried {
        Carried::Nothing => outcome,
        Carried::Charts(charts) => outcome
            .line(format!(
                "texture coordinates of {charts} charts transferred, seams kept"
            ))
            .figure("texture_charts", charts),
        Carried::Lost { charts, vertices } => {
            session.progress().warn(format!(
                "texture coordinates are lost: the seams of their {charts} charts need about {vertices} vertices; \
                 use more --vertices to keep them"
            ));
            outcome.figure("texture_charts", 0)
        }
    }
}

/// Components this many times smaller than the largest are far apart in scale.
const SCALE_RATIO: f32 = 1000.0;

/// Says so when components differ so much in size that one texel cannot suit all.
pub(super) fn warn_of_scales(session: &Session, mesh: &TriangleMesh) {
    let sizes = crate::mesh::topology::component_diagonals(mesh);
    let largest = sizes.iter().copied().fold(0.0, f32::max);
    let small = sizes
        .iter()
        .filter(|&&size| size * SCALE_RATIO < largest)
        .count();
    if small > 0 {
        session.progress().warn(format!(
            "{small} components are more than {SCALE_RATIO} times smaller than the largest, too small for its texel; \
             drop them with --specks {}",
            1.0 / SCALE_RATIO
        ));
    }
}

pub(super) fn warn_of_count(session: &Session, found: usize, wanted: usize) {
    if found.abs_diff(wanted) * 50 > wanted {
        session.progress().warn(format!(
            "{found} vertices instead of {wanted}: boundaries, creases or many small parts leave no fewer"
        ));
    }
}

fn coordinates([x, y, z]: [f64; 3]) -> String {
    format!("({x:.6}, {y:.6}, {z:.6})")
}

fn shape_of(mesh: &TriangleMesh) -> Shape {
    Topology::new(&mesh.triangles).shape(mesh)
}

/// Adds the counts, shape and size of a mesh.
pub fn with_shape(outcome: Outcome, user: &UserMesh) -> Outcome {
    let mesh = &user.mesh;
    let shape = shape_of(mesh);
    let even = evenness(mesh);
    let texel = (mesh.area() / mesh.referenced_count() as f64).sqrt();
    let (low, high) = mesh.bounds();
    let [low, high] = [low, high].map(|corner| (corner.as_dvec3() + user.origin).to_array());
    // A surface with a boundary encloses nothing.
    let volume = (shape.boundaries == 0).then(|| mesh.volume());
    outcome
        .line(format!(
            "vertices {}, triangles {}, components {}, boundaries {}, Euler characteristic {}",
            mesh.positions.len(),
            mesh.triangles.len(),
            shape.components,
            shape.boundaries,
            shape.euler_characteristic
        ))
        .line(format!(
            "bounds {} to {}{}",
            coordinates(low),
            coordinates(high),
            volume.map_or(String::new(), |volume| format!(", volume {volume:.6}"))
        ))
        .line(format!(
            "area {:.6}, default texel {texel:.6}; edge lengths vary by {:.3}, 99 % of the triangles have no \
             angle below {:.1}°",
            mesh.area(),
            even.edge_variation,
            even.smallest_angle_of_99_percent
        ))
        .figure("vertices", mesh.positions.len())
        .figure("triangles", mesh.triangles.len())
        .figure("components", shape.components)
        .figure("boundaries", shape.boundaries)
        .figure("euler_characteristic", shape.euler_characteristic)
        .figure("bounds", json!([low, high]))
        .figure("area", mesh.area())
        .figure("volume", json!(volume))
        .figure("texel", texel)
        .figure("evenness", json!(even))
}

pub(super) fn describe_levels(outcome: Outcome, surface: &PreparedSurface) -> Outcome {
    let levels = || surface.levels.iter();
    let figures: Vec<Value> = levels()
        .map(|SurfaceLevel { mesh, samples, .. }| {
            let shape = shape_of(mesh);
            json!({
                "vertices": mesh.positions.len(),
                "boundaries": shape.boundaries,
                "euler_characteristic": shape.euler_characteristic,
                "evenness": evenness(mesh),
                "samples_with_value": samples.valued,
                "samples_outside": samples.outside,
                "samples_folded": samples.folded,
            })
        })
        .collect();
    let counts: Vec<String> = levels()
        .map(|level| level.mesh.positions.len().to_string())
        .collect();
    let folded: u64 = levels().map(|level| level.samples.folded).sum();
    outcome
        .line(format!(
            "levels of {} vertices; {folded} samples have no value because the chart folds there",
            counts.join(", ")
        ))
        .figure("levels", figures)
}
