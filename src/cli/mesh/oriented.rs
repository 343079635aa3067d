//! A mesh with its orientation field, and what a report says of it.

use glam::Vec3;
use serde_json::{Value, json};

use crate::cli::outcome::Outcome;
use crate::error::Result;
use crate::mesh::connection::Connection;
use crate::mesh::field::Field;
use crate::mesh::field::cosine::mean_cosine;
use crate::mesh::field::guides::{GuidedSurface, guided_field};
use crate::mesh::field::singularities::{Singularity, singularities};
use crate::mesh::pictures;
use crate::mesh::reading::UserMesh;
use crate::mesh::rings::Rings;
use crate::mesh::surface_bvh::SurfaceBvh;
use crate::mesh::topology::Topology;
use crate::progress::Progress;
use crate::sites::vertices::distortion::distortion;
use crate::sites::vertices::patches::Patches;
use crate::sites::vertices::surface_options::SurfaceOptions;

/// The farthest a chart's samples lie, in texels, when its distortion is drawn.
const DISTORTION_RADIUS: f32 = 5.0;

/// A user's mesh with its field.
pub(super) struct Oriented {
    pub rings: Rings,
    pub field: Field,
    pub singular: Vec<Singularity>,
    texel: f64,
}

impl Oriented {
    pub fn new(user: &UserMesh, options: &SurfaceOptions, progress: Progress<'_>) -> Result<Self> {
        let rings = Rings::new(&user.mesh, &Topology::new(&user.mesh.triangles));
        let texel = options.texel_on(&user.mesh)?;
        let surface = GuidedSurface {
            user,
            rings: &rings,
            tree: &SurfaceBvh::new(&user.mesh),
            texel,
        };
        let field = guided_field(surface, &options.guides(), options.seed, progress)?;
        let singular = singularities(&user.mesh, &rings, &field.vectors);
        Ok(Self {
            rings,
            field,
            singular,
            texel,
        })
    }

    /// A direction per vertex, in space.
    pub fn directions(&self) -> Vec<Vec3> {
        let angles = self.field.angles();
        let direction = |vertex: usize| match self.rings.edges.row(vertex).is_empty() {
            true => Vec3::X,
            false => self.rings.direction(vertex, angles[vertex]),
        };
        (0..angles.len()).map(direction).collect()
    }

    /// What is measured of the field.
    pub fn describe(&self, outcome: Outcome, user: &UserMesh) -> Outcome {
        let sum: i32 = self.singular.iter().map(|s| s.index).sum();
        let list: Vec<Value> = self
            .singular
            .iter()
            .map(|s| {
                let centre = pictures::centroid(&user.mesh, s.triangle as usize);
                json!({ "triangle": s.triangle, "index": s.index, "position": centre.to_array() })
            })
            .collect();
        let energy = self.field.energy;
        let cosine = mean_cosine(&self.rings, &self.field.vectors);
        outcome
            .line(format!(
                "field: {} singular triangles, index sum {sum}, smoothness energy {energy:.6e}, \
                 mean cosine along edges {cosine:.6}",
                list.len()
            ))
            .figure("field_energy", energy)
            .figure("field_cosine", cosine)
            .figure("singularity_index_sum", sum)
            .figure("singularities", list)
    }

    /// Mean distortion of the chart round each vertex.
    pub fn distortion(&self, user: &UserMesh) -> Vec<f32> {
        let connection = Connection::new(&self.rings, &self.field.angles());
        let texels = vec![self.texel as f32; user.mesh.positions.len()];
        let patches = Patches {
            mesh: &user.mesh,
            connection: &connection,
            texels: &texels,
        };
        distortion(patches, DISTORTION_RADIUS)
    }
}
