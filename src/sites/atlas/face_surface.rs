//! The surface of a control mesh: its Catmull-Clark surface, a square of the atlas for each control face, and
//! the stars round control vertices (Ying 2001 §4.2).
//!
//! What came with the vertices of the control mesh comes along. Factors on the texel and turns are subdivided as
//! positions are. Wanted directions stay with the control vertices, which keep their numbers; the field finds
//! those between.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3, Vec3};

use crate::error::Result;
use crate::mesh::atlas::{Atlas, FaceSquares};
use crate::mesh::reading::UserMesh;
use crate::mesh::subdivision::quad_faces::control_mesh;
use crate::mesh::subdivision::{Fans, Refinement, Star};
use crate::mesh::triangle_mesh::TriangleMesh;
use crate::progress::Progress;

/// A subdivided control mesh and its charts.
pub struct FaceSurface {
    /// The surface: cell q of the finest mesh is cut into triangles 2·q and 2·q + 1, from its first corner to
    /// its third. Its vertices lie on the smooth surface.
    pub user: UserMesh,
    /// A chart per control face.
    pub atlas: Atlas,
    /// The control mesh and its refinements.
    pub refinement: Refinement,
    /// The control faces round every control vertex.
    pub fans: Fans,
    /// How often the control mesh is subdivided.
    pub steps: u32,
    /// Stars by their number of faces, and whether these go all the way round.
    stars: BTreeMap<(usize, bool), Star>,
}

impl FaceSurface {
    /// Subdivides a mesh as finely as an image of `resolution` texels per side asks for. Refuses a face that is
    /// no quadrilateral, and more faces than have room.
    pub fn new(user: &UserMesh, resolution: u32, progress: Progress<'_>) -> Result<Self> {
        let control = control_mesh(user)?;
        let squares = FaceSquares::new(control.quads.len(), resolution)?;
        let (fans, steps) = (control.fans(), squares.steps());
        progress.begin("subdivision", 1);
        let mut stars = BTreeMap::new();
        for vertex in 0..control.vertices {
            let kind = (fans.corners.row(vertex).len(), fans.is_closed[vertex]);
            if !stars.contains_key(&kind)
                && let Some(star) = Star::new(kind.0, kind.1, steps)
            {
                progress.check()?;
                stars.insert(kind, star);
            }
        }
        let refinement = Refinement::new(control, steps);
        let surface = Self {
            atlas: squares.atlas(&refinement),
            user: subdivided(user, &refinement),
            refinement,
            fans,
            steps,
            stars,
        };
        progress.advance(1)?;
        progress.end();
        Ok(surface)
    }

    /// The star of a control vertex; `None` where its faces make none.
    pub fn star(&self, vertex: u32) -> Option<&Star> {
        let vertex = vertex as usize;
        let kind = (
            self.fans.corners.row(vertex).len(),
            self.fans.is_closed[vertex],
        );
        self.stars.get(&kind)
    }
}

/// A control mesh with everything that it has, on its smooth surface.
fn subdivided(user: &UserMesh, refinement: &Refinement) -> UserMesh {
    // Subdivide the positions.
    let control: Vec<DVec3> = user.mesh.positions.iter().map(|p| p.as_dvec3()).collect();
    let positions = refinement.limit_values(&control);
    let count = positions.len();
    // Halve the quads.
    let halves = |&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]];
    let quads = &refinement.finest().quads;
    // Blend scales by their logarithms, rotations as unit vectors.
    let scale = |list: &Vec<f32>| {
        let logarithms: Vec<f64> = list.iter().map(|&of| f64::from(of).ln()).collect();
        let fine = refinement.limit_values(&logarithms);
        fine.into_iter().map(|of| of.exp() as f32).collect()
    };
    let rotation = |list: &Vec<f32>| {
        let turns = list.iter().map(|&of| f64::from(of).to_radians());
        let turns: Vec<DVec2> = turns.map(DVec2::from_angle).collect();
        let fine = refinement.limit_values(&turns);
        fine.into_iter()
            .map(|turn| turn.to_angle().to_degrees() as f32)
            .collect()
    };
    // Keep orientations at the control vertices; the field spreads them.
    let orientation = |list: &Vec<Vec3>| {
        let mut all = list.clone();
        all.resize(count, Vec3::ZERO);
        all
    };
    UserMesh {
        mesh: TriangleMesh {
            positions: positions.iter().map(|p| p.as_vec3()).collect(),
            triangles: quads.iter().flat_map(halves).collect(),
        },
        from_file: user.from_file.clone(),
        orientation: user.orientation.as_ref().map(orientation),
        scale: user.scale.as_ref().map(scale),
        rotation: user.rotation.as_ref().map(rotation),
        origin: user.origin,
        report: user.report.clone(),
        ..UserMesh::default()
    }
}
