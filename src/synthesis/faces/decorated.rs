//! A face map as a surface texton map, whose vertices have texture coordinates and frames of their own.
//!
//! The frame of a face is what its source says: with the corners of the face on those of the source, s runs along the
//! sample's s. Every face has corners of its own, as neighbours come from different parts of the sample.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::grid::TexCoord;
use crate::index::TextonLabel;
use crate::maps::face_map::FaceMap;
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::rings::vertex_normals;
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::synthesis::faces::source_places::SourcePlaces;

/// What the corners of a face hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CornerPlaces {
    /// The place of the source's centre: a face has one value.
    Center,
    /// The places of the source's corners: the sample shows inside a face.
    Corners,
}

/// A face on its source.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FaceFrame {
    /// The unit normal.
    normal: Vec3,
    /// The unit tangent that runs along the sample's s.
    s: Vec3,
    /// Mesh units per texel.
    texel: f64,
}

impl FaceFrame {
    /// The frame that brings places on the sample closest to corners in space, by least squares.
    fn new(corners: [Vec3; 3], places: [TexCoord; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let normal = normal.try_normalize().unwrap_or(Vec3::Z);
        let across = (b - a).try_normalize();
        let across = across.unwrap_or_else(|| normal.any_orthonormal_vector());
        let along = normal.cross(across);
        let on_plane = corners.map(|corner| {
            let from_first = corner - a;
            Vec2::new(from_first.dot(across), from_first.dot(along))
        });
        let on_sample = places.map(|place| Vec2::new(place.s, place.t));
        let [own, wanted] = [on_plane, on_sample].map(|points| {
            let mean = points.into_iter().sum::<Vec2>() / 3.0;
            points.map(|point| point - mean)
        });
        let pairs = || own.iter().zip(&wanted);
        let turn = Vec2::new(
            pairs().map(|(own, wanted)| own.dot(*wanted)).sum(),
            pairs().map(|(own, wanted)| wanted.perp_dot(*own)).sum(),
        );
        let squares: f32 = wanted.iter().map(|point| point.length_squared()).sum();
        let direction = turn.try_normalize().unwrap_or(Vec2::X);
        Self {
            normal,
            s: across * direction.x + along * direction.y,
            texel: f64::from(turn.length()) / f64::from(squares).max(f64::MIN_POSITIVE),
        }
    }
}

/// A map whose vertices 3·f … 3·f + 2 are the corners of face f, with the surface's smooth normals. `corners` says what
/// they hold.
///
/// Errors: a map whose sources are not on its sample's grids.
pub fn with_own_corners(map: &FaceMap, corners: CornerPlaces) -> Result<SurfaceTextonMap> {
    // Find the place and the frame of each face.
    let places = SourcePlaces::of(map)?;
    let normals = vertex_normals(&map.mesh);
    let faces = 0..map.mesh.triangles.len();
    let frames: Vec<FaceFrame> = faces
        .clone()
        .into_par_iter()
        .map(|face| frame_of(map, &places, face))
        .collect();
    // Give each corner its coordinate and normal.
    let coords = faces.clone().flat_map(|face| match corners {
        CornerPlaces::Center => [places.center(map.sources[face]); 3],
        CornerPlaces::Corners => places.corners(map.sources[face], map.phases[face]),
    });
    let normals: Vec<Vec3> = map
        .mesh
        .triangles
        .iter()
        .flatten()
        .map(|&vertex| normals[vertex as usize])
        .collect();
    let tangent = |(corner, &normal): (usize, &Vec3)| tangent_of(frames[corner / 3].s, normal);
    let scale = |frame: &FaceFrame| [(frame.texel / map.header.texel) as f32; 3];
    // Cut the faces apart.
    let mesh = TriangleMesh {
        positions: faces
            .clone()
            .flat_map(|face| map.mesh.corners(face))
            .collect(),
        triangles: faces
            .map(|face| [0, 1, 2].map(|corner| 3 * face as u32 + corner))
            .collect(),
    };
    Ok(SurfaceTextonMap {
        orientations: normals.iter().enumerate().map(tangent).collect(),
        normals,
        coords: coords.collect(),
        scale: match corners {
            CornerPlaces::Center => None,
            CornerPlaces::Corners => Some(frames.iter().flat_map(scale).collect()),
        },
        ..of_mesh(map, mesh)
    })
}

/// A map whose vertices are the centres of the faces, and which has no triangles: for what a face alone holds.
///
/// Errors: a map whose sources are not on its sample's grids.
pub fn at_centers(map: &FaceMap) -> Result<SurfaceTextonMap> {
    let places = SourcePlaces::of(map)?;
    let faces = (0..map.mesh.triangles.len()).into_par_iter();
    let frames: Vec<FaceFrame> = faces
        .clone()
        .map(|face| frame_of(map, &places, face))
        .collect();
    let center = |face| map.mesh.corners(face).into_iter().sum::<Vec3>() / 3.0;
    let mesh = TriangleMesh {
        positions: faces.map(center).collect(),
        triangles: Vec::new(),
    };
    let sources = map.sources.iter();
    Ok(SurfaceTextonMap {
        orientations: frames.iter().map(|frame| frame.s).collect(),
        normals: frames.iter().map(|frame| frame.normal).collect(),
        coords: sources.map(|&source| places.center(source)).collect(),
        ..of_mesh(map, mesh)
    })
}

fn frame_of(map: &FaceMap, places: &SourcePlaces, face: usize) -> FaceFrame {
    let on_sample = places.corners(map.sources[face], map.phases[face]);
    FaceFrame::new(map.mesh.corners(face), on_sample)
}

/// A direction in the plane of a normal.
fn tangent_of(direction: Vec3, normal: Vec3) -> Vec3 {
    let flat = direction - normal * direction.dot(normal);
    flat.try_normalize()
        .unwrap_or_else(|| normal.any_orthonormal_vector())
}

/// A map of a mesh whose lists per vertex are still empty but for its textons: none.
fn of_mesh(map: &FaceMap, mesh: TriangleMesh) -> SurfaceTextonMap {
    SurfaceTextonMap {
        textons: vec![TextonLabel::NONE; mesh.positions.len()],
        mesh,
        normals: Vec::new(),
        orientations: Vec::new(),
        scale: None,
        coords: Vec::new(),
        transition: None,
        mask: None,
        header: map.header.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::face_map::tests::pair;

    #[test]
    fn frames_turn_and_scale_with_the_source() {
        let places = [[1.0, 2.0], [2.0, 2.0], [1.5, 3.0]].map(|[s, t]| TexCoord { s, t });
        let turn = 0.7f32;
        // The sample's plane turned about z, three mesh units per texel.
        let (sin, cos) = turn.sin_cos();
        let corner =
            |at: TexCoord| 3.0 * Vec3::new(cos * at.s - sin * at.t, sin * at.s + cos * at.t, 1.0);
        let frame = FaceFrame::new(places.map(corner), places);
        assert!(
            frame.s.distance(Vec3::new(cos, sin, 0.0)) < 1e-5,
            "{frame:?}"
        );
        assert!((frame.texel - 3.0).abs() < 1e-5 && frame.normal.distance(Vec3::Z) < 1e-5);
        // A third of a turn more or less, with another phase.
        let [a, b, c] = places;
        let next = FaceFrame::new(places.map(corner), [b, c, a]);
        assert!(next.s.dot(frame.s) < 0.0);
    }

    #[test]
    fn corners_continue_the_sample_and_centres_hold_one_place() {
        let mut map = pair();
        (map.header.texel, map.sources) = (0.5, vec![3, 700]);
        let whole = with_own_corners(&map, CornerPlaces::Corners).unwrap();
        let flat = with_own_corners(&map, CornerPlaces::Center).unwrap();
        let points = at_centers(&map).unwrap();
        assert_eq!(whole.mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(whole.mesh.positions[4], map.mesh.positions[2]);
        for face in 0..2 {
            let center = points.coords[face];
            assert!((0..3).all(|corner| flat.coords[3 * face + corner] == center));
            let mean = whole.coords[3 * face..][..3]
                .iter()
                .map(|at| at.s)
                .sum::<f32>()
                / 3.0;
            // Centres of texels, which the sources' centres lie in.
            assert!((mean - center.s).abs() < 0.501);
            for corner in 3 * face..3 * face + 3 {
                let s = whole.orientations[corner];
                assert!(
                    s.dot(whole.normals[corner]).abs() < 1e-6 && (s.length() - 1.0).abs() < 1e-6
                );
                assert!(whole.texel_at(corner) > 0.0);
            }
        }
        assert!(points.mesh.triangles.is_empty() && points.textons.len() == 2);
    }
}
