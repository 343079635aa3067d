//! How much the chart round each vertex bends lengths.

use rayon::prelude::*;

use crate::mesh::chart::ChartGrower;
use crate::sites::vertices::patches::Patches;

/// Vertices a block: one grower serves them.
const BLOCK: usize = 4096;

/// Per vertex the mean of |drawn / real − 1| over the edges of its chart, to a radius in texels; 0
/// for a vertex in no triangle.
pub fn distortion(patches: Patches<'_>, radius: f32) -> Vec<f32> {
    let count = patches.mesh.positions.len();
    let blocks: Vec<Vec<f32>> = (0..count.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut grower = ChartGrower::new(count);
            let vertices = block * BLOCK..((block + 1) * BLOCK).min(count);
            vertices
                .map(|vertex| of_vertex(patches, &mut grower, vertex, radius))
                .collect()
        })
        .collect();
    blocks.concat()
}

fn of_vertex(patches: Patches<'_>, grower: &mut ChartGrower, vertex: usize, radius: f32) -> f32 {
    let reach = radius * patches.texels[vertex];
    let placed = grower
        .round_vertex(patches.connection, vertex as u32, reach)
        .to_vec();
    let (mut sum, mut edges) = (0.0, 0);
    for from in placed.iter().filter(|from| from.position.length() <= reach) {
        for spoke in patches.connection.spokes.row(from.vertex as usize) {
            if let Some(to) = grower.position_of(spoke.target)
                && to.length() <= reach
            {
                sum += (to.distance(from.position) / spoke.edge.length() - 1.0).abs();
                edges += 1;
            }
        }
    }
    if edges == 0 { 0.0 } else { sum / edges as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::connection::Connection;
    use crate::mesh::rings::Rings;
    use crate::mesh::shapes;
    use crate::mesh::topology::Topology;
    use crate::mesh::triangle_mesh::TriangleMesh;

    fn most(mesh: &TriangleMesh, texel: f32) -> f32 {
        let rings = Rings::new(mesh, &Topology::new(&mesh.triangles));
        let connection = Connection::new(&rings, &vec![0.0; mesh.positions.len()]);
        let texels = vec![texel; mesh.positions.len()];
        let patches = Patches {
            mesh,
            connection: &connection,
            texels: &texels,
        };
        distortion(patches, 3.0).into_iter().fold(0.0, f32::max)
    }

    #[test]
    fn what_unrolls_is_not_bent() {
        assert!(most(&shapes::grid(12, 12, 1.0), 1.0) < 1e-4);
        assert!(most(&shapes::cylinder(40, 12, 1.0, 0.15), 0.15) < 1e-4);
        let sphere = most(&shapes::icosphere(3), 0.12);
        assert!((1e-4..0.1).contains(&sphere), "{sphere}");
    }
}
