//! A decorated mesh for other programs: texture coordinates, labels, orientation and colours per vertex.
//!
//! Coordinates are over the sample's size, v upwards. Where neighbouring vertices lie in different repeats of the
//! sample, or in different patches, they jump: they are there to look the sample up at vertices, not between them.

mod glb;
mod obj;
mod ply;
mod usda;

use std::path::Path;

use crate::error::Result;
use crate::maps::vertex_map::SurfaceTextonMap;

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelFormat {
    /// glTF 2.0 in one file: TEXCOORD_0, TANGENT (s and the sign of t), _TEXTON, COLOR_0 (linear).
    Glb,
    /// Wavefront: vt, vn, and colours behind the position (sRGB, 0 to 1).
    Obj,
    /// USD as text: primvars st, texton, orientation, displayColor (linear).
    Usda,
    /// Properties s t (over the sample's size), texton, sx sy sz, and red green blue (sRGB bytes).
    Ply,
}

/// A surface texton map, and the linear colours of its vertices where they are known.
#[derive(Clone, Copy, Debug)]
pub struct VertexModel<'a> {
    /// The map.
    pub map: &'a SurfaceTextonMap,
    /// Linear Rec. 709, white is 1; per vertex.
    pub colors: Option<&'a [[f32; 3]]>,
}

impl VertexModel<'_> {
    /// Writes the model.
    pub fn write(&self, path: &Path, format: ModelFormat) -> Result<()> {
        match format {
            ModelFormat::Glb => glb::write(path, self),
            ModelFormat::Obj => obj::write(path, self),
            ModelFormat::Usda => usda::write(path, self),
            ModelFormat::Ply => ply::write(path, self),
        }
    }

    /// Texture coordinates over the sample's size, v upwards.
    fn uvs(&self) -> Vec<[f32; 2]> {
        let [width, height] = self.map.header.exemplar.map(|side| side as f32);
        let coords = self.map.coords.iter();
        coords.map(|at| [at.s / width, at.t / height]).collect()
    }

    /// Colours between 0 and 1.
    fn clamped_colors(&self) -> Option<Vec<[f32; 3]>> {
        let clamped = |color: &[f32; 3]| color.map(|value| value.clamp(0.0, 1.0));
        Some(self.colors?.iter().map(clamped).collect())
    }
}
