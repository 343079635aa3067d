//! The map in memory.

use glam::{Vec2, Vec3};

use crate::grid::{TexCoord, TexelGrid};
use crate::index::TextonLabel;
use crate::maps::header::MapHeader;
use crate::mesh::atlas::Atlas;
use crate::mesh::triangle_mesh::TriangleMesh;

/// A surface whose texture atlas is decorated. All lists per texel have height · width entries, row by row
/// from the top, where v is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct AtlasMap {
    /// The surface.
    pub mesh: TriangleMesh,
    /// Unit normals per vertex; (0, 0, 1) for a vertex in no face.
    pub vertex_normals: Vec<Vec3>,
    /// Texture coordinates of each triangle's corners, in [0, 1], v upwards.
    pub corner_uvs: Vec<[Vec2; 3]>,
    /// The chart of each triangle.
    pub chart_of: Vec<u32>,
    /// Columns of the atlas.
    pub width: u32,
    /// Rows of the atlas.
    pub height: u32,
    /// The chart of each texel; −1 outside all.
    pub chart: Vec<i32>,
    /// Where each texel's centre lies on the surface, in mesh units; zero outside charts.
    pub position: Vec<Vec3>,
    /// Unit normals; zero outside charts.
    pub normal: Vec<Vec3>,
    /// The orientation field: unit tangents s; zero outside charts.
    pub orientation: Vec<Vec3>,
    /// Factor on the sample's texel at each texel, above 0; `None` for 1 everywhere. 1 outside charts.
    pub scale: Option<Vec<f32>>,
    /// Texture coordinates, in texels of the sample; `None` outside charts.
    pub coords: Vec<Option<TexCoord>>,
    /// Texton labels; [`TextonLabel::NONE`] outside charts, and for plain images.
    pub textons: Vec<TextonLabel>,
    /// Whether opposite borders of the sample continue each other.
    pub tileable: bool,
    /// What it was made from, and how.
    pub header: MapHeader,
}

impl AtlasMap {
    /// Texels in all, those outside charts included.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether there is no texel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Mesh units that a texel of the sample covers at a texel, its scale included.
    #[inline]
    pub fn texel_at(&self, texel: usize) -> f64 {
        match &self.scale {
            Some(scale) => self.header.texel * f64::from(scale[texel]),
            None => self.header.texel,
        }
    }

    /// The charts of the mesh.
    pub fn atlas(&self) -> Atlas {
        Atlas {
            corner_uvs: self.corner_uvs.clone(),
            charts: self
                .chart_of
                .iter()
                .max()
                .map_or(0, |last| *last as usize + 1),
            chart_of: self.chart_of.clone(),
        }
    }

    /// The sample's grid at level 0.
    pub fn grid(&self) -> TexelGrid {
        TexelGrid {
            width: self.header.exemplar[0],
            height: self.header.exemplar[1],
            tileable: self.tileable,
        }
    }
}
