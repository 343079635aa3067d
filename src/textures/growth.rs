//! Texels beyond the border of a chart, each with the nearest texel inside, ring by ring in the image.

use crate::mesh::topology::NONE;

/// For every texel outside that a walk of at most `reach` steps to any of eight neighbours leads to from
/// inside: the texel inside that it is reached from. In the order of the rings.
pub(super) fn grown(
    [width, height]: [u32; 2],
    is_inside: impl Fn(usize) -> bool,
    reach: u32,
) -> Vec<(u32, u32)> {
    // Begin with the texels inside.
    let texels = width * height;
    let mut source: Vec<u32> = (0..texels)
        .map(|texel| {
            if is_inside(texel as usize) {
                texel
            } else {
                NONE
            }
        })
        .collect();
    let mut ring: Vec<u32> = (0..texels)
        .filter(|&t| source[t as usize] != NONE)
        .collect();
    let mut pairs = Vec::new();
    // Grow ring after ring.
    for _ in 0..reach {
        let mut next = Vec::new();
        for &texel in &ring {
            for neighbor in neighbors(texel, width, height) {
                if source[neighbor as usize] == NONE {
                    source[neighbor as usize] = source[texel as usize];
                    pairs.push((neighbor, source[texel as usize]));
                    next.push(neighbor);
                }
            }
        }
        if next.is_empty() {
            break;
        }
        ring = next;
    }
    pairs
}

/// The neighbours in the image, those that share a side first.
fn neighbors(texel: u32, width: u32, height: u32) -> impl Iterator<Item = u32> {
    const STEPS: [(i64, i64); 8] = [
        (0, -1),
        (0, 1),
        (-1, 0),
        (1, 0),
        (-1, -1),
        (-1, 1),
        (1, -1),
        (1, 1),
    ];
    let (row, col) = (i64::from(texel / width), i64::from(texel % width));
    let inside = move |(down, right): (i64, i64)| {
        let (row, col) = (row + down, col + right);
        let is_there =
            (0..i64::from(height)).contains(&row) && (0..i64::from(width)).contains(&col);
        is_there.then(|| (row * i64::from(width) + col) as u32)
    };
    STEPS.into_iter().filter_map(inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_grow_round_the_inside() {
        let pairs = grown([5, 5], |texel| texel == 12, 1);
        assert_eq!(pairs.len(), 8);
        assert!(pairs.iter().all(|&(_, inside)| inside == 12));
        assert_eq!(grown([5, 5], |texel| texel == 12, 9).len(), 24);
        assert_eq!(grown([5, 5], |_| false, 9), []);
        // Each side of a gap belongs to its own side.
        let pairs = grown([4, 1], |texel| texel == 0 || texel == 3, 2);
        assert_eq!(pairs, [(1, 0), (2, 3)]);
    }
}
