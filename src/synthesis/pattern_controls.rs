//! What an exemplar's controls make of a finished map: its mask, and the frames that a turned pattern has.

use glam::Vec3;
use ndarray::{Array2, Array3};

use crate::exemplar::space::Space;
use crate::grid::{TexCoord, TexelGrid};
use crate::sites::level::SiteEdge;
use crate::synthesis::options::Method;

/// The controls that a method heeds.
pub struct PatternControls<'a> {
    grid: TexelGrid,
    mask: Option<&'a Array2<u8>>,
    orientation: Option<&'a Array3<f32>>,
    /// Whether the pattern changes over the surface.
    pub varies: bool,
}

impl<'a> PatternControls<'a> {
    /// Those of an exemplar, if the method follows them.
    pub fn of(space: &'a Space, method: Method) -> Self {
        let controls = space.controls.first();
        let heeded = controls.filter(|_| method.description().follows_controls);
        Self {
            grid: space.levels[0].grid,
            mask: heeded.and_then(|controls| controls.mask.as_ref()),
            orientation: heeded.and_then(|controls| controls.orientation.as_ref()),
            varies: heeded.is_some_and(|controls| controls.transition.is_some()),
        }
    }

    /// The label of every coordinate, where there is a mask.
    pub fn labels(&self, coords: &[TexCoord]) -> Option<Vec<u8>> {
        let labels = self.mask?.as_slice()?;
        let label = |&at: &TexCoord| labels[self.grid.texel_nearest(at).index()];
        Some(coords.iter().map(label).collect())
    }

    /// The frames in which the exemplar's s and t lie on the surface: the pattern's x axis follows the orientation
    /// field, and the exemplar says where that axis points.
    pub fn turned(&self, fields: &[Vec3], normals: &[Vec3], coords: &[TexCoord]) -> Vec<Vec3> {
        let Some(orientation) = self.orientation else {
            return fields.to_vec();
        };
        let all = fields.iter().zip(normals).zip(coords);
        let turned = |((&s, &n), &at): ((&Vec3, &Vec3), &TexCoord)| {
            let [cos, sin] = self.axis(orientation, at);
            (s * cos - n.cross(s) * sin).normalize_or(s)
        };
        all.map(turned).collect()
    }

    /// Lets the offsets of edges be those in the exemplar's frame at their first site.
    pub fn turn_edges(&self, edges: &mut [SiteEdge], coords: &[TexCoord]) {
        let Some(orientation) = self.orientation else {
            return;
        };
        for edge in edges {
            let [cos, sin] = self.axis(orientation, coords[edge.from as usize]);
            let [x, y] = edge.offset;
            edge.offset = [cos * x - sin * y, sin * x + cos * y];
        }
    }

    fn axis(&self, orientation: &Array3<f32>, at: TexCoord) -> [f32; 2] {
        let (row, col) = self.grid.row_col(self.grid.texel_nearest(at));
        [0, 1].map(|axis| orientation[[row as usize, col as usize, axis]])
    }
}
