//! Several steps of subdivision, and the cells that a control face becomes.

use super::catmull_clark::{Value, limit_values, refined, refined_values};
use super::quad_mesh::QuadMesh;

/// A control mesh and its refinements.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement {
    /// The control mesh first, the finest mesh last.
    meshes: Vec<QuadMesh>,
}

/// Where the four parts of a quadrilateral lie: columns and rows from its first corner.
const PARTS: [[u32; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];

impl Refinement {
    /// Refines a control mesh a number of times.
    pub fn new(control: QuadMesh, steps: u32) -> Self {
        let mut meshes = vec![control];
        for _ in 0..steps {
            meshes.push(refined(&meshes[meshes.len() - 1]));
        }
        Self { meshes }
    }

    /// The control mesh.
    pub fn control(&self) -> &QuadMesh {
        &self.meshes[0]
    }

    /// The finest mesh. Vertices of the control mesh come first and keep their numbers.
    pub fn finest(&self) -> &QuadMesh {
        &self.meshes[self.meshes.len() - 1]
    }

    /// Cells along each side of a control face.
    pub fn cells_per_side(&self) -> u32 {
        1 << (self.meshes.len() - 1)
    }

    /// The values of the smooth surface at the vertices of the finest mesh, from values at those of the
    /// control mesh.
    pub fn limit_values<T: Value>(&self, control: &[T]) -> Vec<T> {
        let mut values = control.to_vec();
        for mesh in &self.meshes[..self.meshes.len() - 1] {
            values = refined_values(mesh, &values);
        }
        limit_values(self.finest(), &values)
    }

    /// The quadrilateral of the finest mesh that lies in a control face at a column and row, which run from
    /// the face's first corner to its second and to its fourth.
    pub fn cell(&self, face: u32, [column, row]: [u32; 2]) -> u32 {
        let steps = self.meshes.len() as u32 - 1;
        (0..steps).rev().fold(face, |cell, bit| {
            let part = [column >> bit & 1, row >> bit & 1];
            let part = PARTS.iter().position(|&other| other == part);
            4 * cell + part.unwrap_or(0) as u32
        })
    }

    /// The control face of a quadrilateral of the finest mesh, and its column and row there.
    pub fn place_of(&self, cell: u32) -> (u32, [u32; 2]) {
        let steps = self.meshes.len() as u32 - 1;
        let place = (0..steps).fold([0, 0], |[column, row], bit| {
            let [right, up] = PARTS[(cell >> (2 * bit)) as usize % 4];
            [column | right << bit, row | up << bit]
        });
        (cell >> (2 * steps), place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn cells_lie_where_their_column_and_row_say() {
        // A control face far from the borders of a lattice, so that it is carried to itself.
        let at = |x: u32, y: u32| y * 6 + x;
        let quads = (0..5).flat_map(|y| {
            (0..5).map(move |x| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)])
        });
        let control = QuadMesh::new(36, quads.collect());
        let points: Vec<DVec2> = (0..36)
            .map(|v| DVec2::new(f64::from(v % 6), f64::from(v / 6)))
            .collect();
        let refinement = Refinement::new(control, 3);
        let limit = refinement.limit_values(&points);
        let (face, side) = (12, refinement.cells_per_side());
        for row in 0..side {
            for column in 0..side {
                let cell = refinement.cell(face, [column, row]);
                assert_eq!(refinement.place_of(cell), (face, [column, row]));
                let corners = refinement.finest().quads[cell as usize];
                for (corner, [right, up]) in corners.into_iter().zip(PARTS) {
                    let wanted = DVec2::new(f64::from(column + right), f64::from(row + up));
                    let wanted = DVec2::splat(2.0) + wanted / f64::from(side);
                    assert!(limit[corner as usize].distance(wanted) < 1e-12);
                }
            }
        }
    }
}
