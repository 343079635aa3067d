//! What filters see beyond the border of a texel grid.
//!
//! In: a position of one axis, on the grid or off it. Out: the row or column whose texel stands
//! there: wrapped where the sample is tileable, else reflected with the edge repeated, as often as
//! needed.

use std::ops::Range;

/// The rows (or columns) of a side that stand at `positions`.
pub fn sources(positions: Range<i64>, side: usize, wraps: bool) -> Vec<usize> {
    positions.map(|at| source(at, side as i64, wraps)).collect()
}

fn source(at: i64, side: i64, wraps: bool) -> usize {
    if wraps {
        return at.rem_euclid(side) as usize;
    }
    let folded = at.rem_euclid(2 * side);
    folded.min(2 * side - 1 - folded) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_wrap_or_reflect_with_their_edge_repeated() {
        assert_eq!(sources(-4..7, 3, true), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(sources(-4..7, 3, false), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
        assert_eq!(sources(-2..3, 1, false), [0; 5]);
    }
}
