//! A user's mesh from any file we read, cleaned, with what came with it and the way back to the
//! file's own vertices.

use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use crate::error::{Error, Result};
use crate::format::guard::guarded;
pub use crate::format::mesh_formats::parse;
use crate::format::polygon_mesh::{FARTHEST, PolygonMesh};
use crate::format::source;
use crate::mesh::cleaning::{
    RepairReport, Split, retain, split_non_manifold, useful_triangles, weld, without_specks,
};
use crate::mesh::origin::{origin_of, warn_of_precision};
use crate::mesh::topology::NONE;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::mesh::triangulation::triangulate;
use crate::progress::Progress;

/// A mesh as the user gave it, made fit for work.
///
/// Vertices are the file's, in the file's order, with copies made by cleaning at the end; only
/// formats that repeat vertices for every face or material (STL, glTF) are closed up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UserMesh {
    /// The surface: manifold, consistently facing, without empty or repeated triangles.
    pub mesh: TriangleMesh,
    /// For every vertex of the file, the vertex of [`mesh`](Self::mesh) at its place.
    pub from_file: Vec<u32>,
    /// Wanted orientation per vertex (PLY `sx sy sz`); zero where there is none.
    pub orientation: Option<Vec<Vec3>>,
    /// Factor on the texel per vertex, above 0 (PLY `scale`).
    pub scale: Option<Vec<f32>>,
    /// Turn of the texture per vertex, in degrees counter-clockwise (PLY `rotation`).
    pub rotation: Option<Vec<f32>>,
    /// How far a texture has changed at each vertex, 0 to 1 (PLY `transition`).
    pub transition: Option<Vec<f32>>,
    /// A painted mask per vertex, labels 0 to 3 (PLY `mask`).
    pub mask: Option<Vec<f32>>,
    /// The file's normals per vertex; zero where it has none.
    pub normals: Option<Vec<Vec3>>,
    /// Texture coordinates of each triangle's corners; NaN where the file has none.
    pub corner_uvs: Option<Vec<[Vec2; 3]>>,
    /// The face of the file, counted from 0, that each triangle was cut from; empty where every triangle is a
    /// face of its own. Triangles of one face stand together.
    pub face_of: Vec<u32>,
    /// What positions count from; subtracted from the file's coordinates, zero for a mesh near zero.
    pub origin: DVec3,
    /// What cleaning changed.
    pub report: RepairReport,
}

impl UserMesh {
    /// Whether numbers other than normals came with its vertices.
    pub fn has_vertex_numbers(&self) -> bool {
        let scalars = [&self.scale, &self.rotation, &self.transition, &self.mask];
        self.orientation.is_some() || scalars.into_iter().any(Option::is_some)
    }
}

/// A mesh that is fit as it stands: manifold, consistently facing, without empty or repeated triangles.
impl From<TriangleMesh> for UserMesh {
    fn from(mesh: TriangleMesh) -> Self {
        Self {
            from_file: (0..mesh.positions.len() as u32).collect(),
            mesh,
            ..Self::default()
        }
    }
}

/// A scale that is not 1 everywhere.
pub fn varying(scale: Option<&[f32]>) -> Option<&[f32]> {
    scale.filter(|scale| scale.iter().any(|&scale| scale != 1.0))
}

/// How strictly a mesh is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CleaningOptions {
    /// Refuse a mesh that needs repair.
    pub strict: bool,
    /// Drop components whose bounding box is smaller than this fraction of the mesh's, by diagonal.
    pub specks: f64,
}

/// Reads and cleans a mesh, keeping every component.
pub fn read(path: &Path, progress: Progress<'_>) -> Result<UserMesh> {
    read_with(path, &CleaningOptions::default(), progress)
}

/// Reads and cleans a mesh.
pub fn read_with(
    path: &Path,
    options: &CleaningOptions,
    progress: Progress<'_>,
) -> Result<UserMesh> {
    let bytes = source::read(path)?;
    progress.check()?;
    guarded(path, || {
        parse(&bytes, path).and_then(|file| clean(file, options, progress))
    })
}

/// Makes a mesh of what a file holds fit for work.
pub fn clean(
    file: PolygonMesh,
    options: &CleaningOptions,
    progress: Progress<'_>,
) -> Result<UserMesh> {
    // Check the positions, and count them from the origin.
    check_positions(&file)?;
    let mut report = RepairReport {
        notes: file.notes.clone(),
        unused: file.unused.clone(),
        ..RepairReport::default()
    };
    warn_of_precision(&file, progress);
    let origin = origin_of(&file);
    let positions: Vec<Vec3> = file
        .positions
        .iter()
        .map(|&p| (DVec3::from_array(p) - origin).as_vec3())
        .collect();
    // Cut polygons into triangles.
    let (mut mesh, mut cut) = cut_polygons(&file, positions, &mut report, progress)?;
    progress.check()?;
    // Join vertices at the same place, and drop triangles that are of no use.
    let from_file = close_up(&mut mesh, file.splits_vertices, &mut report);
    let keep = useful_triangles(&mesh, &mut report);
    cut.retain(&mut mesh, &keep);
    if options.specks > 0.0 {
        let keep = without_specks(&mesh, options.specks, &mut report);
        cut.retain(&mut mesh, &keep);
    }
    if mesh.triangles.is_empty() {
        return Err(Error::data("faces", "none with an area").expected("a surface"));
    }
    progress.check()?;
    // Split what is not manifold, and turn components outwards.
    let split = split_non_manifold(&mut mesh, &mut report);
    progress.check()?;
    turn_corners(cut.uvs.as_mut(), &split);
    for component in &mut report.turned_components {
        let centre = DVec3::from_array(component.centre) + origin;
        component.centre = centre.to_array();
    }
    report.unused_vertices = mesh.positions.len() - mesh.referenced_count();
    // Refuse what had to be repaired, where that is asked for.
    if options.strict && !report.is_sound() {
        return Err(refusal(&report));
    }
    let mut user = attach(file, mesh, cut, from_file, &split, report)?;
    user.origin = origin;
    Ok(user)
}

fn check_positions(file: &PolygonMesh) -> Result<()> {
    let bad = |p: &[f64; 3]| p.iter().any(|c| !c.is_finite() || c.abs() > FARTHEST);
    match file.positions.iter().position(bad) {
        Some(vertex) => Err(Error::data(
            format!("vertex {vertex}"),
            format!("position {:?}", file.positions[vertex]),
        )
        .expected("finite numbers, none beyond 1e15")),
        None => Ok(()),
    }
}

fn refusal(report: &RepairReport) -> Error {
    let mut found = report.lines().join("; ");
    if let Some(first) = &report.first {
        found.push_str(&format!("; first: {first}"));
    }
    Error::data("mesh", found)
        .expected("a sound mesh, as --strict asks")
        .advice("leave out --strict to have it repaired")
}

/// Polygons cut from one look at whether to stop to the next.
const POLYGONS_BETWEEN_CHECKS: usize = 4096;

/// What belongs to the triangles that polygons were cut into.
struct Cut {
    /// The polygon of each.
    face_of: Vec<u32>,
    /// Texture coordinates of their corners, if the file has any.
    uvs: Option<Vec<[Vec2; 3]>>,
}

impl Cut {
    /// Keeps the triangles of a mesh that say so, and what belongs to them.
    fn retain(&mut self, mesh: &mut TriangleMesh, keep: &[bool]) {
        retain(&mut mesh.triangles, keep);
        retain(&mut self.face_of, keep);
        if let Some(uvs) = &mut self.uvs {
            retain(uvs, keep);
        }
    }
}

fn cut_polygons(
    file: &PolygonMesh,
    positions: Vec<Vec3>,
    report: &mut RepairReport,
    progress: Progress<'_>,
) -> Result<(TriangleMesh, Cut)> {
    let mut triangles = Vec::with_capacity(file.faces.sizes.len());
    let mut face_of = Vec::with_capacity(file.faces.sizes.len());
    let mut uvs = file
        .corner_uvs
        .as_ref()
        .map(|_| Vec::with_capacity(file.faces.sizes.len()));
    let mut begin = 0;
    // Triangulate each polygon, with its texture coordinates.
    for (number, polygon) in file.faces.iter().enumerate() {
        if number.is_multiple_of(POLYGONS_BETWEEN_CHECKS) {
            progress.check()?;
        }
        let corners: Vec<_> = polygon
            .iter()
            .map(|&v| positions[v as usize].as_dvec3())
            .collect();
        report.cut_polygons += usize::from(polygon.len() > 3);
        for triangle in triangulate(&corners, progress)? {
            triangles.push(triangle.map(|corner| polygon[corner]));
            face_of.push(number as u32);
            if let (Some(uvs), Some(all)) = (&mut uvs, &file.corner_uvs) {
                uvs.push(triangle.map(|corner| Vec2::from_array(all[begin + corner])));
            }
        }
        begin += polygon.len();
    }
    let mesh = TriangleMesh {
        positions,
        triangles,
    };
    Ok((mesh, Cut { face_of, uvs }))
}

/// Lets triangles share the vertices at one place; a split format's vertices are also renumbered
/// without gaps. Hands back the vertex of each vertex of the file.
fn close_up(mesh: &mut TriangleMesh, renumber: bool, report: &mut RepairReport) -> Vec<u32> {
    let mut first = weld(&mesh.positions);
    report.welded_vertices = first
        .iter()
        .enumerate()
        .filter(|&(v, &first)| v as u32 != first)
        .count();
    if renumber {
        let mut numbers = vec![NONE; mesh.positions.len()];
        let mut positions = Vec::new();
        for (vertex, &first) in first.iter().enumerate() {
            if first == vertex as u32 {
                numbers[vertex] = positions.len() as u32;
                positions.push(mesh.positions[vertex]);
            }
        }
        first.iter_mut().for_each(|v| *v = numbers[*v as usize]);
        mesh.positions = positions;
    }
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = first[*corner as usize];
    }
    first
}

fn turn_corners(uvs: Option<&mut Vec<[Vec2; 3]>>, split: &Split) {
    let pairs = uvs.into_iter().flatten().zip(&split.turned);
    pairs
        .filter(|(_, turned)| **turned)
        .for_each(|(uvs, _)| uvs.swap(1, 2));
}

/// Hangs the file's per-vertex numbers on the cleaned vertices.
fn attach(
    file: PolygonMesh,
    mesh: TriangleMesh,
    cut: Cut,
    from_file: Vec<u32>,
    split: &Split,
    report: RepairReport,
) -> Result<UserMesh> {
    // Find the vertex of the file that each of ours stands for.
    let count = mesh.positions.len();
    let originals = count - split.copies.len();
    let mut sources = vec![NONE; count];
    for (vertex, &ours) in from_file.iter().enumerate() {
        if sources[ours as usize] == NONE {
            sources[ours as usize] = vertex as u32;
        }
    }
    if !file.splits_vertices {
        sources[..originals]
            .iter_mut()
            .enumerate()
            .for_each(|(v, source)| *source = v as u32);
    }
    for (copy, &original) in split.copies.iter().enumerate() {
        sources[originals + copy] = sources[original as usize];
    }
    // Carry the numbers over.
    let scalar = |name: &str| {
        let column = file.column(name)?;
        Some(
            sources
                .iter()
                .map(|&v| column[v as usize] as f32)
                .collect::<Vec<f32>>(),
        )
    };
    let vector = |names: [&str; 3]| {
        let [x, y, z] = names.map(scalar);
        let (x, y, z) = (x?, y?, z?);
        Some(
            (0..count)
                .map(|v| Vec3::new(x[v], y[v], z[v]))
                .collect::<Vec<Vec3>>(),
        )
    };
    let file_normal = |normals: &Vec<[f32; 3]>| {
        sources
            .iter()
            .map(|&v| Vec3::from_array(normals[v as usize]))
            .collect()
    };
    let user = UserMesh {
        orientation: vector(["sx", "sy", "sz"]),
        scale: scalar("scale"),
        rotation: scalar("rotation"),
        transition: scalar("transition"),
        mask: scalar("mask"),
        normals: file.normals.as_ref().map(file_normal),
        mesh,
        from_file,
        corner_uvs: cut.uvs,
        face_of: cut.face_of,
        origin: DVec3::ZERO,
        report,
    };
    check_properties(&user)?;
    Ok(user)
}

fn check_properties(user: &UserMesh) -> Result<()> {
    let fault = |vertex: usize, found: String, expected: &str| {
        Err(Error::data(format!("vertex {vertex}"), found).expected(expected))
    };
    // Check each property where it is given.
    let scales = user.scale.iter().flatten().enumerate();
    for (vertex, scale) in scales {
        if !(scale.is_finite() && *scale > 0.0) {
            return fault(vertex, format!("scale {scale}"), "a number above 0");
        }
    }
    for (vertex, rotation) in user.rotation.iter().flatten().enumerate() {
        if !rotation.is_finite() {
            return fault(vertex, format!("rotation {rotation}"), "degrees");
        }
    }
    for (vertex, transition) in user.transition.iter().flatten().enumerate() {
        if !(0.0..=1.0).contains(transition) {
            return fault(vertex, format!("transition {transition}"), "0 to 1");
        }
    }
    for (vertex, label) in user.mask.iter().flatten().enumerate() {
        if ![0.0, 1.0, 2.0, 3.0].contains(label) {
            return fault(vertex, format!("mask {label}"), "a label, 0 to 3");
        }
    }
    for (vertex, s) in user.orientation.iter().flatten().enumerate() {
        if !s.is_finite() {
            return fault(vertex, format!("orientation {s}"), "a direction");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn user(text: &str, name: &str) -> Result<UserMesh> {
        clean(
            parse(text.as_bytes(), Path::new(name))?,
            &CleaningOptions::default(),
            Progress::silent(),
        )
    }

    #[test]
    fn the_files_order_is_kept() {
        let text = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 1 0\nf 2 3 4 5\nf 2 6 3\n";
        let user = user(text, "a.obj").unwrap();
        assert_eq!(user.mesh.positions.len(), 6);
        assert_eq!(user.mesh.positions[0], Vec3::splat(9.0));
        assert_eq!(user.report.welded_vertices, 1);
        assert_eq!(user.report.cut_polygons, 1);
        assert_eq!(user.from_file[5], 3);
        assert_eq!(user.report.unused_vertices, 2);
    }

    #[test]
    fn split_formats_are_closed_up_with_a_way_back() {
        let corner = |x: i32, y: i32| format!("vertex {x} {y} 0\n");
        let facet = |a: String, b: String, c: String| {
            format!("facet normal 0 0 1\nouter loop\n{a}{b}{c}endloop\nendfacet\n")
        };
        let text = format!(
            "solid x\n{}{}endsolid x\n",
            facet(corner(0, 0), corner(1, 0), corner(1, 1)),
            facet(corner(0, 0), corner(1, 1), corner(0, 1))
        );
        let user = user(&text, "a.stl").unwrap();
        assert_eq!(user.mesh.positions.len(), 4);
        assert_eq!(user.from_file, [0, 1, 2, 0, 2, 3]);
        assert_eq!(user.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn bad_input_is_refused_with_its_place() {
        let refused = |text: &str, name: &str| user(text, name).unwrap_err().to_string();
        assert!(refused("v nan 0 0\n", "a.obj").contains("vertex 0"));
        assert!(refused("v 0 0 0\n", "a.obj").contains("faces"));
        assert!(refused("", "a.xyz").contains(".obj"));
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
            property float z\nproperty float scale\nelement face 1\n\
            property list uchar int vertex_indices\nend_header\n0 0 0 1\n1 0 0 -1\n0 1 0 1\n3 0 1 2\n";
        assert!(refused(ply, "a.ply").contains("vertex 1: scale -1"));
    }

    #[test]
    fn strictness_says_what_it_refuses() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\n";
        let file = parse(text.as_bytes(), Path::new("a.obj")).unwrap();
        let strict = CleaningOptions {
            strict: true,
            ..CleaningOptions::default()
        };
        let error = clean(file, &strict, Progress::silent())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("1 repeated triangles dropped") && error.contains("first"),
            "{error}"
        );
    }
}
