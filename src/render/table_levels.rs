//! The levels of a sample laid out for shading: their bytes, and which of them stay in memory.
//!
//! The finest levels go to disk until the rest fits the memory that is allowed, all of it together.

use crate::grid::TexelGrid;

/// A table's levels, from the finest on.
#[derive(Clone, Copy, Debug)]
pub struct TableLevels {
    /// The texels of the finest level.
    pub finest: TexelGrid,
    /// Bytes per texel.
    pub stride: u64,
    /// Whether there are coarser levels.
    pub mip: bool,
}

impl TableLevels {
    /// The texel grids, finest first.
    pub fn grids(self) -> impl Iterator<Item = TexelGrid> {
        let coarser = move |grid: &TexelGrid| (self.mip && grid.len() > 1).then(|| grid.coarser());
        std::iter::successors(Some(self.finest), coarser)
    }

    /// Bytes of the levels from this one on.
    fn bytes_from(self, level: usize) -> u64 {
        let grids = self.grids().skip(level);
        grids.map(|grid| grid.len() as u64 * self.stride).sum()
    }

    /// How many of the finest levels go to disk, where so many bytes are allowed.
    pub fn on_disk(self, allowed: u64) -> usize {
        let levels = self.grids().count();
        let fits = |level: &usize| self.bytes_from(*level) <= allowed;
        (0..levels).find(fits).unwrap_or(levels)
    }

    /// Bytes of the levels that stay in memory.
    pub fn bytes_in_memory(self, allowed: u64) -> u64 {
        self.bytes_from(self.on_disk(allowed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_in_memory_fit_it_together() {
        let finest = TexelGrid {
            width: 8,
            height: 8,
            tileable: true,
        };
        let levels = TableLevels {
            finest,
            stride: 10,
            mip: true,
        };
        // 640, 160, 40 and 10 bytes.
        for (allowed, on_disk, held) in [
            (850, 0, 850),
            (849, 1, 210),
            (210, 1, 210),
            (209, 2, 50),
            (10, 3, 10),
            (9, 4, 0),
        ] {
            let found = (levels.on_disk(allowed), levels.bytes_in_memory(allowed));
            assert_eq!(found, (on_disk, held), "{allowed}");
        }
        let plain = TableLevels {
            mip: false,
            ..levels
        };
        assert_eq!([640, 639].map(|bytes| plain.on_disk(bytes)), [0, 1]);
    }
}
