//! The surface texton map (Tong 2002 §5): per vertex a texton label and a texture coordinate, on
//! the mesh it was made for. What `synthesis` hands on and `render` reads.

use glam::Vec3;

use crate::format::id::ContentId;
use crate::grid::{TexCoord, TexelGrid};
use crate::index::TextonLabel;
use crate::mesh::frame::Frame;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A decorated mesh; all per-vertex lists are in the mesh's vertex order.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTextonMap {
    /// The surface.
    pub mesh: TriangleMesh,
    /// Unit normals; (0, 0, 1) for a vertex in no face.
    pub normals: Vec<Vec3>,
    /// The orientation field: unit tangents s; (1, 0, 0) for a vertex in no face.
    pub orientations: Vec<Vec3>,
    /// Texture coordinates, in texels of the sample; (½, ½) for a vertex in no face.
    pub coords: Vec<TexCoord>,
    /// Texton labels; [`TextonLabel::NONE`] for a vertex in no face, and for plain images.
    pub textons: Vec<TextonLabel>,
    /// Columns and rows of the sample.
    pub exemplar: [u32; 2],
    /// Mesh units a texel of the finest level covers.
    pub texel: f64,
    /// The seed it was synthesized with.
    pub seed: u64,
    /// The id of the sample.
    pub sample: ContentId,
    /// The id of the space it was synthesized from.
    pub space: ContentId,
}

impl SurfaceTextonMap {
    /// The texture frame of a vertex.
    pub fn frame(&self, vertex: usize) -> Frame {
        let (n, s) = (self.normals[vertex], self.orientations[vertex]);
        Frame {
            s,
            t: n.cross(s),
            n,
        }
    }

    /// The sample's grid at level 0.
    pub fn grid(&self, tileable: bool) -> TexelGrid {
        TexelGrid {
            width: self.exemplar[0],
            height: self.exemplar[1],
            tileable,
        }
    }
}
