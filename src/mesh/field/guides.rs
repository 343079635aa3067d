//! What the user wants of the field, turned into constraints: directions at vertices and points, a
//! constant direction, texture coordinates, curvature.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use glam::{DVec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::format::json;
use crate::mesh::field::cosine;
use crate::mesh::field::curvature::principal_directions;
use crate::mesh::field::{Constraint, Field, FieldConstraints, orientation_field};
use crate::mesh::keys::KeyFile;
use crate::mesh::reading::UserMesh;
use crate::mesh::rings::Rings;
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::user_vertex::UserVertices;
use crate::progress::Progress;

/// What the field follows where no direction is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Alignment {
    /// Nothing: the field is as smooth as possible.
    #[default]
    Smooth,
    /// The direction of greatest curvature.
    Curvature,
    /// The direction in which the mesh's texture coordinate u grows.
    Uv,
}

/// The energy that the orientation field minimises or maximises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum FieldEnergy {
    /// The least squared change from vertex to vertex; its one optimum is found exactly (Knöppel 2013).
    #[default]
    Dirichlet,
    /// The greatest sum of cosines of the angles along edges; a local optimum is found from the other field (Ying
    /// 2001, footnote 2).
    Cosine,
}

impl FieldEnergy {
    /// Whether it is what counts where nothing is said.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Where the orientation field comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GuideOptions {
    /// A guide file: directions the field must take.
    pub guide: Option<PathBuf>,
    /// A file of keys: directions the field must take as well.
    pub keys: Option<PathBuf>,
    /// What the field follows where no direction is given.
    pub align: Alignment,
    /// A direction in space that s follows wherever it lies along the surface.
    pub direction: Option<Vec<f64>>,
    /// What makes one field better than another.
    pub energy: FieldEnergy,
}

/// The largest angle, in degrees, between a wanted direction and the normal at which it counts as
/// standing on the surface, and no direction of it.
const UPRIGHT_DEGREES: f64 = 3.0;
/// A constant direction rules where at least this much of it lies in the tangent plane; elsewhere
/// the field is free.
const TANGENT_SHARE: f32 = 0.4;
/// How firmly curvature draws the field, over the smoothness energy, at a vertex as sure of its
/// direction as the mean: one over (this many texels)².
const CURVATURE_RADIUS: f64 = 8.0;

impl GuideOptions {
    /// Checks every field.
    pub fn validate(&self) -> Result<()> {
        if let Some(direction) = &self.direction {
            let length = direction.iter().map(|c| c * c).sum::<f64>();
            if direction.len() != 3 || !(length.is_finite() && length > 0.0) {
                return Err(Error::option(
                    "direction",
                    format!("{direction:?}"),
                    "three numbers, not all zero",
                ));
            }
            if self.align != Alignment::Smooth {
                return Err(Error::option(
                    "direction",
                    "together with --align".to_string(),
                    "one of the two",
                ));
            }
        }
        Ok(())
    }
}

/// A guide file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuideFile {
    /// Wanted directions.
    pub guides: Vec<Guide>,
}

/// A wanted direction at a vertex, or at the vertex nearest to a point of the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Guide {
    /// The vertex, by its place in the mesh file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertex: Option<u64>,
    /// A point on or near the surface, in mesh units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// The direction, in mesh space; projected on the tangent plane.
    pub direction: [f32; 3],
}

/// The user's surface while its field is being made.
#[derive(Clone, Copy)]
pub struct GuidedSurface<'a> {
    /// The mesh and what came with it.
    pub user: &'a UserMesh,
    /// Its rings.
    pub rings: &'a Rings,
    /// Its triangles, for points.
    pub tree: &'a SurfaceBvh,
    /// Mesh units a texel covers.
    pub texel: f64,
}

/// The field of a user's mesh under all that guides it.
pub fn guided_field(
    surface: GuidedSurface<'_>,
    options: &GuideOptions,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Field> {
    options.validate()?;
    // Gather the constraints. For each vertex, the first constraint given counts.
    let mut constraints = FieldConstraints::default();
    let count = surface.user.mesh.positions.len();
    let mut said = vec![false; count];
    surface.add_property(&mut constraints, &mut said)?;
    if let Some(path) = &options.guide {
        surface.add_file(path, &mut constraints, &mut said)?;
    }
    if let Some(path) = &options.keys {
        surface.add_keys(path, &mut constraints, &mut said)?;
    }
    if let Some(direction) = &options.direction {
        surface.add_direction(direction, &mut constraints, &mut said);
    }
    if options.align == Alignment::Uv {
        surface.add_uvs(&mut constraints, &mut said)?;
    }
    // Solve for the field.
    let mut field = orientation_field(
        &surface.user.mesh,
        surface.rings,
        &constraints,
        seed,
        progress,
    )?;
    if options.align == Alignment::Curvature {
        field = surface.lean_on_curvature(field, &mut constraints, seed, progress)?;
    }
    match options.energy {
        FieldEnergy::Dirichlet => Ok(field),
        FieldEnergy::Cosine => surface.improve_cosines(&field, &constraints, progress),
    }
}

impl GuidedSurface<'_> {
    fn constrain(
        &self,
        vertex: usize,
        direction: Vec3,
        place: &str,
        constraints: &mut FieldConstraints,
        said: &mut [bool],
    ) -> Result<()> {
        // Refuse a direction that stands on the surface.
        let upright = direction
            .normalize_or_zero()
            .cross(self.rings.normals[vertex])
            .length();
        let angle = self.rings.angle_of(vertex, direction);
        let (Some(angle), true) = (
            angle,
            f64::from(upright) > UPRIGHT_DEGREES.to_radians().sin(),
        ) else {
            return Err(Error::data(
                place,
                format!("direction {direction} is perpendicular to the surface at vertex {vertex}"),
            )
            .expected("a direction along the surface"));
        };
        // Constrain the vertex unless an earlier guide did.
        if !std::mem::replace(&mut said[vertex], true) {
            constraints.hard.push(Constraint {
                vertex: vertex as u32,
                angle,
            });
        }
        Ok(())
    }

    fn is_used(&self, vertex: usize) -> bool {
        !self.rings.edges.row(vertex).is_empty()
    }

    fn add_property(&self, constraints: &mut FieldConstraints, said: &mut [bool]) -> Result<()> {
        for (vertex, &direction) in self.user.orientation.iter().flatten().enumerate() {
            if direction != Vec3::ZERO && self.is_used(vertex) {
                self.constrain(vertex, direction, "sx sy sz", constraints, said)?;
            }
        }
        Ok(())
    }

    fn add_file(
        &self,
        path: &Path,
        constraints: &mut FieldConstraints,
        said: &mut [bool],
    ) -> Result<()> {
        let file: GuideFile = json::read(path)?;
        for (number, guide) in file.guides.iter().enumerate() {
            let place = format!("guide {number}");
            self.add_guide(guide, &place, constraints, said)
                .map_err(|error| error.in_file(path))?;
        }
        Ok(())
    }

    /// Adds the directions of a file of keys.
    fn add_keys(
        &self,
        path: &Path,
        constraints: &mut FieldConstraints,
        said: &mut [bool],
    ) -> Result<()> {
        for (number, key) in KeyFile::read(path)?.keys.iter().enumerate() {
            let Some(direction) = key.direction else {
                continue;
            };
            let guide = Guide {
                vertex: key.vertex,
                point: key.point,
                direction,
            };
            self.add_guide(&guide, &format!("key {number}"), constraints, said)
                .map_err(|error| error.in_file(path))?;
        }
        Ok(())
    }

    fn add_guide(
        &self,
        guide: &Guide,
        place: &str,
        constraints: &mut FieldConstraints,
        said: &mut [bool],
    ) -> Result<()> {
        let vertices = UserVertices {
            user: self.user,
            rings: self.rings,
            tree: self.tree,
        };
        let vertex = vertices.at(guide.vertex, guide.point, place)?;
        let direction = Vec3::from_array(guide.direction);
        self.constrain(vertex, direction, place, constraints, said)
    }

    fn add_direction(
        &self,
        direction: &[f64],
        constraints: &mut FieldConstraints,
        said: &mut [bool],
    ) {
        let wanted = Vec3::new(
            direction[0] as f32,
            direction[1] as f32,
            direction[2] as f32,
        )
        .normalize_or_zero();
        for (vertex, said) in said.iter_mut().enumerate() {
            let lies = wanted.cross(self.rings.normals[vertex]).length() >= TANGENT_SHARE;
            if *said || !lies || !self.is_used(vertex) {
                continue;
            }
            if let Some(angle) = self.rings.angle_of(vertex, wanted) {
                *said = true;
                constraints.hard.push(Constraint {
                    vertex: vertex as u32,
                    angle,
                });
            }
        }
    }

    fn add_uvs(&self, constraints: &mut FieldConstraints, said: &mut [bool]) -> Result<()> {
        let Some(uvs) = &self.user.corner_uvs else {
            return Err(Error::option(
                "align",
                "uv".to_string(),
                "a mesh with texture coordinates",
            ));
        };
        // Sum the directions in which u grows, weighted by area.
        let mesh = &self.user.mesh;
        let mut sums = vec![Vec3::ZERO; said.len()];
        for (triangle, [a, b, c]) in uvs.iter().enumerate() {
            let [p, q, r] = mesh.corners(triangle);
            let ((du, dv), (e, f)) = ((*b - *a, *c - *a), (q - p, r - p));
            let along = (e * dv.y - f * du.y) * (du.perp_dot(dv)).signum();
            if let Some(along) = along.try_normalize().filter(|along| along.is_finite()) {
                let weight = mesh.area_normal(triangle).length();
                mesh.triangles[triangle]
                    .iter()
                    .for_each(|&v| sums[v as usize] += weight * along);
            }
        }
        // Constrain the vertices that no earlier guide did.
        for (vertex, &sum) in sums.iter().enumerate() {
            if let (false, Some(angle)) = (said[vertex], self.rings.angle_of(vertex, sum)) {
                said[vertex] = true;
                constraints.hard.push(Constraint {
                    vertex: vertex as u32,
                    angle,
                });
            }
        }
        Ok(())
    }

    /// Draws the smooth field to the principal directions, each taken with the sign that is nearer;
    /// the signs settle in a few rounds. The constraints are left as they were in the last one.
    fn lean_on_curvature(
        &self,
        smooth: Field,
        constraints: &mut FieldConstraints,
        seed: u64,
        progress: Progress<'_>,
    ) -> Result<Field> {
        let principal = principal_directions(&self.user.mesh, self.rings);
        let mean = principal.iter().map(|p| p.certainty).sum::<f64>() / principal.len() as f64;
        let firmness = (CURVATURE_RADIUS * self.texel).powi(-2);
        let mut field = smooth;
        for _ in 0..3 {
            let lean = |(p, u): (&crate::mesh::field::curvature::Principal, &DVec2)| {
                let sure = (p.certainty / mean.max(f64::MIN_POSITIVE)).min(3.0);
                p.direction * (firmness * sure * p.direction.dot(*u).signum())
            };
            constraints.soft = principal.iter().zip(&field.vectors).map(lean).collect();
            field = orientation_field(&self.user.mesh, self.rings, constraints, seed, progress)?;
        }
        Ok(field)
    }

    /// The field under the same constraints that the cosine energy leads to.
    fn improve_cosines(
        &self,
        field: &Field,
        constraints: &FieldConstraints,
        progress: Progress<'_>,
    ) -> Result<Field> {
        let (mesh, rings) = (&self.user.mesh, self.rings);
        let heeded = (constraints, &mesh.vertex_areas()[..]);
        let vectors = cosine::improved(rings, &field.vectors, heeded, progress)?;
        Ok(Field::of_vectors(mesh, rings, vectors))
    }
}
