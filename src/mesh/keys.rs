//! Key values on a surface: at a few vertices or points how far a texture has changed, and which way it runs
//! (Zhang 2003 §5). Between them the transition is interpolated by Gaussian radial basis functions over geodesic
//! distance.

use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::format::json;
use crate::mesh::geodesic_distance::GeodesicDistances;
use crate::mesh::reading::UserMesh;
use crate::mesh::rings::Rings;
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::topology::Topology;
use crate::mesh::user_vertex::UserVertices;
use crate::progress::Progress;
use crate::radial_basis::{RadialBasis, usual_radius};

/// A file of key values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyFile {
    /// The keys.
    pub keys: Vec<Key>,
    /// Radius of the basis functions in mesh units; by default the mean way from a key to the nearest other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
}

/// What is wanted at a vertex, or at the vertex nearest to a point of the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// The vertex, by its place in the mesh file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertex: Option<u64>,
    /// A point on or near the surface, in mesh units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// How far the texture has changed there, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transition: Option<f64>,
    /// The direction the texture runs in there, in mesh space; projected on the tangent plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f32; 3]>,
}

impl KeyFile {
    /// Reads a file and checks its numbers.
    pub fn read(path: &Path) -> Result<Self> {
        let file: Self = json::read(path)?;
        file.check().map_err(|error| error.in_file(path))?;
        Ok(file)
    }

    /// Whether any key has a transition.
    pub fn has_transition(&self) -> bool {
        self.keys.iter().any(|key| key.transition.is_some())
    }

    fn check(&self) -> Result<()> {
        for (number, key) in self.keys.iter().enumerate() {
            let place = format!("key {number}");
            match key.transition {
                Some(value) if !(0.0..=1.0).contains(&value) => {
                    let found = format!("transition {value}");
                    return Err(Error::data(place, found).expected("0 to 1"));
                }
                None if key.direction.is_none() => {
                    return Err(Error::data(place, "neither transition nor direction")
                        .expected("one or both"));
                }
                _ => {}
            }
        }
        match self.radius {
            Some(radius) if !(radius > 0.0 && radius.is_finite()) => {
                Err(Error::data("radius", radius.to_string()).expected("above 0"))
            }
            _ => Ok(()),
        }
    }

    /// The transition of every vertex of a mesh, 0 to 1. Errors: fewer than two keys with a transition,
    /// different ones at a vertex, a part of the surface without a key, keys too near each other.
    pub fn transition(&self, user: &UserMesh, progress: Progress<'_>) -> Result<Vec<f32>> {
        let mesh = &user.mesh;
        let (rings, tree) = (
            Rings::new(mesh, &Topology::new(&mesh.triangles)),
            SurfaceBvh::new(mesh),
        );
        let vertices = UserVertices {
            user,
            rings: &rings,
            tree: &tree,
        };
        let keys = self.transition_keys(vertices)?;
        progress.begin("transition", keys.len() as u64);
        let surface = GeodesicDistances {
            mesh,
            rings: &rings,
        };
        let from_key = |&(vertex, _): &(u32, f64)| {
            let distances = surface.from_vertex(vertex);
            progress.advance(1).map(|()| distances)
        };
        let distances: Vec<Vec<f64>> = keys.par_iter().map(from_key).collect::<Result<_>>()?;
        progress.end();
        check_reach(mesh.referenced(), &distances)?;
        // From the other to the one, as a vertex is reached below: a front need not find the same way back.
        let between = |one: usize, other: usize| distances[other][keys[one].0 as usize];
        let values: Vec<[f64; 1]> = keys.iter().map(|&(_, value)| [value]).collect();
        let usual = || usual_radius(keys.len(), between);
        let radius = self
            .radius
            .or_else(usual)
            .unwrap_or(f64::from(mesh.diagonal()));
        let field = RadialBasis::new(&values, between, radius)?;
        let value = |vertex: usize| {
            let [value] = field.at(distances.iter().map(|of_key| of_key[vertex]));
            value.clamp(0.0, 1.0) as f32
        };
        Ok((0..mesh.positions.len())
            .into_par_iter()
            .map(value)
            .collect())
    }

    /// Vertices and values of the keys that have a transition, each vertex once.
    fn transition_keys(&self, vertices: UserVertices<'_>) -> Result<Vec<(u32, f64)>> {
        let mut keys: Vec<(u32, f64)> = Vec::new();
        for (number, key) in self.keys.iter().enumerate() {
            let Some(value) = key.transition else {
                continue;
            };
            let place = format!("key {number}");
            let vertex = vertices.at(key.vertex, key.point, &place)? as u32;
            match keys.iter().find(|(other, _)| *other == vertex) {
                None => keys.push((vertex, value)),
                Some(&(_, other)) if other == value => {}
                Some((_, other)) => {
                    let found = format!("transition {value} at a vertex that has {other} already");
                    return Err(Error::data(place, found).expected("one value per vertex"));
                }
            }
        }
        match keys.len() {
            0 | 1 => Err(
                Error::data("keys", format!("{} vertex with a transition", keys.len()))
                    .expected("two or more: one alone means no change"),
            ),
            _ => Ok(keys),
        }
    }
}

/// Refuses a surface of which a vertex is reached from no key.
fn check_reach(referenced: Vec<bool>, distances: &[Vec<f64>]) -> Result<()> {
    let is_reached = |vertex: usize| distances.iter().any(|of_key| of_key[vertex].is_finite());
    let vertices = referenced.iter().enumerate().filter(|(_, used)| **used);
    let Some((vertex, _)) = vertices
        .into_iter()
        .find(|&(vertex, _)| !is_reached(vertex))
    else {
        return Ok(());
    };
    Err(
        Error::data("keys", format!("none on the component of vertex {vertex}"))
            .expected("a key with a transition on every component")
            .advice("add one there, or leave small components out with --specks"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn at_vertex(vertex: u64, transition: f64) -> Key {
        Key {
            vertex: Some(vertex),
            transition: Some(transition),
            ..Key::default()
        }
    }

    fn file(keys: &[Key]) -> KeyFile {
        KeyFile {
            keys: keys.to_vec(),
            radius: None,
        }
    }

    #[test]
    fn keys_are_met_and_values_between_them_rise() {
        let user = UserMesh::from(shapes::grid(20, 6, 0.5));
        let keys = file(&[
            at_vertex(0, 0.25),
            Key {
                point: Some([10.0, 0.1, 0.3]),
                transition: Some(1.0),
                ..Key::default()
            },
        ]);
        let found = keys.transition(&user, Progress::silent()).unwrap();
        assert!((found[0] - 0.25).abs() < 1e-6 && (found[20] - 1.0).abs() < 1e-6);
        assert!(found[..21].is_sorted());
        assert!((found[10] - 0.625).abs() < 1e-3);
    }

    #[test]
    fn keys_that_say_nothing_or_two_things_are_refused() {
        let user = UserMesh::from(shapes::grid(20, 6, 0.5));
        let refused = |keys: &[Key]| {
            let found = file(keys).transition(&user, Progress::silent());
            found.unwrap_err().to_string()
        };
        assert!(refused(&[at_vertex(3, 0.5)]).contains("1 vertex with a transition"));
        let said = refused(&[at_vertex(3, 0.5), at_vertex(3, 0.6), at_vertex(4, 1.0)]);
        assert!(
            said.contains("key 1: transition 0.6 at a vertex that has 0.5"),
            "{said}"
        );
        assert!(refused(&[at_vertex(3, 0.5), at_vertex(9999, 0.6)]).contains("vertex 9999"));
        let mut two = shapes::grid(4, 4, 1.0);
        let base = two.positions.len() as u32;
        let far = two.positions.iter().map(|p| *p + glam::Vec3::Z * 9.0);
        two.positions.extend(far.collect::<Vec<_>>());
        let more = two.triangles.iter().map(|t| t.map(|v| v + base));
        two.triangles.extend(more.collect::<Vec<_>>());
        let keys = file(&[at_vertex(0, 0.0), at_vertex(7, 1.0)]);
        let said = keys.transition(&UserMesh::from(two), Progress::silent());
        let said = said.unwrap_err().to_string();
        assert!(
            said.contains(&format!("none on the component of vertex {base}")),
            "{said}"
        );
        let wrong = file(&[at_vertex(0, 1.5)]).check().unwrap_err().to_string();
        assert!(
            wrong.contains("key 0: transition 1.5; expected 0 to 1"),
            "{wrong}"
        );
    }
}
