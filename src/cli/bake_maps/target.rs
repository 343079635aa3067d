//! What a bake writes on: a mesh with texture coordinates, and the point of the map's surface that each texel
//! shows.

use std::path::Path;

use glam::Vec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::maps::vertex_map::SurfaceTextonMap;
use crate::mesh::atlas::{Atlas, TexelPoints};
use crate::mesh::reading::{self, UserMesh};
use crate::mesh::rings::vertex_normals;
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::tessellation::TexturedMesh;
use crate::progress::Progress;
use crate::render::raster::Hit;

/// The farthest that a texel may lie from the map's surface, in diagonals of its box: farther, the mesh is
/// another one.
const FARTHEST: f32 = 0.05;

/// A mesh with an atlas of some size.
pub(super) struct TexturedTarget {
    /// Its positions count from the map's origin.
    pub(super) surface: TexturedMesh,
    pub(super) atlas: Atlas,
    pub(super) points: TexelPoints,
    /// Whether it is the mesh of the map.
    is_same: bool,
}

/// Where texels lie on the map's surface.
pub(super) struct Placed {
    /// Per texel the point, or none.
    pub(super) hits: Vec<Hit>,
    /// The farthest that a texel lies from its point, in mesh units.
    pub(super) farthest: f32,
}

impl TexturedTarget {
    /// The map's own mesh, or another of the same surface, with texture coordinates of its own or new ones.
    pub(super) fn new(
        map: &SurfaceTextonMap,
        mesh: Option<&Path>,
        unwrap: bool,
        resolution: u32,
        progress: Progress<'_>,
    ) -> Result<Self> {
        // Read the mesh that carries the textures.
        let user = match mesh {
            Some(path) => reading::read(path, progress)?,
            None => UserMesh {
                origin: map.header.origin,
                normals: Some(map.normals.clone()),
                ..UserMesh::from(map.mesh.clone())
            },
        };
        let in_file = |error: Error| match mesh {
            Some(path) => error.in_file(path),
            None => error,
        };
        // Take its texture coordinates, or make new ones.
        let surface = placed_beside(map, user);
        let atlas = match (unwrap, &surface.corner_uvs[..]) {
            (true, _) => Atlas::unwrapped(&surface.mesh, resolution, progress)?,
            (false, []) => {
                return Err(in_file(
                    Error::data("texture coordinates", "none")
                        .expected("a mesh with texture coordinates")
                        .advice("--unwrap makes new ones"),
                ));
            }
            (false, uvs) => Atlas::of_uvs(&surface.mesh, uvs).map_err(in_file)?,
        };
        // Lay out the texels.
        progress.check()?;
        let points =
            TexelPoints::new(&surface.mesh, &atlas, resolution, resolution).map_err(in_file)?;
        Ok(Self {
            is_same: surface.mesh == map.mesh,
            surface: TexturedMesh {
                corner_uvs: atlas.corner_uvs.clone(),
                ..surface
            },
            atlas,
            points,
        })
    }

    /// Finds the point of the map's surface that each texel shows: its own on the map's mesh, the nearest that
    /// faces alike on another.
    pub(super) fn placed(&self, map: &SurfaceTextonMap, progress: Progress<'_>) -> Result<Placed> {
        // Keep the texel's own point where the mesh is the map's.
        let texels = (0..self.points.triangle.len()).into_par_iter();
        if self.is_same {
            let hit = |texel: usize| match self.points.is_inside(texel) {
                true => hit(self.points.triangle[texel], self.points.weights[texel]),
                false => Hit::MISS,
            };
            return Ok(Placed {
                hits: texels.map(hit).collect(),
                farthest: 0.0,
            });
        }
        // Find the nearest point elsewhere.
        let tree = SurfaceBvh::new(&map.mesh);
        let found = texels.map(|texel| {
            if progress.is_interrupted() || !self.points.is_inside(texel) {
                return (Hit::MISS, 0.0);
            }
            let corners = self
                .surface
                .mesh
                .corners(self.points.triangle[texel] as usize);
            let shares = corners.iter().zip(self.points.weights[texel]);
            let point: Vec3 = shares.map(|(corner, weight)| *corner * weight).sum();
            match tree.nearest_alike(point, &corners) {
                Some(near) => (
                    hit(near.triangle, near.weights),
                    near.position.distance(point),
                ),
                None => (Hit::MISS, 0.0),
            }
        });
        let (hits, distances): (Vec<Hit>, Vec<f32>) = found.unzip();
        // Refuse a mesh that lies too far away.
        progress.check()?;
        let farthest = distances.into_iter().fold(0.0, f32::max);
        let diagonal = map.mesh.diagonal();
        match farthest <= FARTHEST * diagonal {
            true => Ok(Placed { hits, farthest }),
            false => Err(Error::data(
                "mesh",
                format!("a texel lies {farthest} mesh units from the map's surface"),
            )
            .expected(format!(
                "at most {}, a twentieth of the map's extent",
                FARTHEST * diagonal
            ))
            .advice("give the mesh that the map was made on, or the one it was retiled from")),
        }
    }
}

fn hit(triangle: u32, [a, b, _]: [f32; 3]) -> Hit {
    Hit {
        triangle,
        weights: [a, b],
    }
}

/// A mesh in the map's coordinates; without texture coordinates where any corner has none.
fn placed_beside(map: &SurfaceTextonMap, user: UserMesh) -> TexturedMesh {
    let mut mesh = user.mesh;
    let offset = user.origin - map.header.origin;
    if offset != glam::DVec3::ZERO {
        for position in &mut mesh.positions {
            *position = (position.as_dvec3() + offset).as_vec3();
        }
    }
    let mut normals = vertex_normals(&mesh);
    for (ours, theirs) in normals.iter_mut().zip(user.normals.iter().flatten()) {
        *ours = theirs.try_normalize().unwrap_or(*ours);
    }
    TexturedMesh {
        normals,
        corner_uvs: user.corner_uvs.unwrap_or_default(),
        mesh,
    }
}
