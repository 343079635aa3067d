//! Numbering for locality: vertices along a space-filling curve, triangles after their vertices.

use glam::Vec3;

use crate::mesh::retile::edge_operations::EditMesh;
use crate::mesh::topology::NONE;

/// The same mesh, compacted, its vertices in Morton order of their positions.
pub fn spatially(edited: &EditMesh) -> EditMesh {
    let mut alive: Vec<(u64, u32)> = keys(edited);
    alive.sort_unstable();
    let mut numbers = vec![NONE; edited.positions.len()];
    for (number, &(_, vertex)) in alive.iter().enumerate() {
        numbers[vertex as usize] = number as u32;
    }
    let mut triangles: Vec<(u32, u32)> = edited
        .triangles
        .iter()
        .enumerate()
        .filter(|(_, triangle)| triangle[0] != NONE)
        .map(|(index, t)| {
            (
                t.map(|v| numbers[v as usize])
                    .into_iter()
                    .fold(NONE, u32::min),
                index as u32,
            )
        })
        .collect();
    triangles.sort_unstable();
    edited.renumbered(&alive, &numbers, &triangles)
}

fn keys(edited: &EditMesh) -> Vec<(u64, u32)> {
    let points = || {
        let alive = edited.leaving.iter().zip(&edited.positions).enumerate();
        alive
            .filter(|(_, (leaving, _))| **leaving != NONE)
            .map(|(vertex, (_, &position))| (vertex as u32, position))
    };
    let first = points().next().map_or(Vec3::ZERO, |(_, p)| p);
    let (low, high) = points().fold((first, first), |(low, high), (_, p)| {
        (low.min(p), high.max(p))
    });
    let scale = 2_097_151.0 / (high - low).max_element().max(f32::MIN_POSITIVE);
    points()
        .map(|(vertex, p)| {
            let [x, y, z] = ((p - low) * scale).to_array().map(|c| spread(c as u64));
            (x | y << 1 | z << 2, vertex)
        })
        .collect()
}

/// Moves the low 21 bits of a number three apart.
fn spread(bits: u64) -> u64 {
    let mut x = bits & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_three_apart() {
        for bit in 0..21 {
            assert_eq!(spread(1 << bit), 1 << (3 * bit));
        }
    }
}
