//! Vertices at the same position, merged.

use std::collections::HashMap;

use glam::Vec3;

/// For every position, the first vertex at the same place (−0 and 0 are one).
pub fn weld(positions: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    positions
        .iter()
        .enumerate()
        .map(|(vertex, position)| {
            let key = position.to_array().map(|c| (c + 0.0).to_bits());
            *first.entry(key).or_insert(vertex as u32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_vertex_at_a_place_stands_for_all() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::new(-0.0, 0.0, 0.0), Vec3::X];
        assert_eq!(weld(&points), [0, 1, 0, 1]);
    }
}
