//! Limits of what a glTF file may describe.

use crate::error::{Error, Result};

/// Vertices, and corners of triangles, that any file may describe.
const MOST_ITEMS: usize = 1 << 20;
/// Vertices, and corners of triangles, for each byte of the file and its buffers, beside [`MOST_ITEMS`].
const ITEMS_PER_BYTE: usize = 4;

/// What a file may still describe.
pub(super) struct Room {
    /// Vertices, or corners, in all.
    pub most: usize,
    vertices: usize,
    corners: usize,
}

impl Room {
    pub fn new(bytes: usize) -> Self {
        let most = bytes
            .saturating_mul(ITEMS_PER_BYTE)
            .saturating_add(MOST_ITEMS)
            .min(u32::MAX as usize / 2);
        Self {
            most,
            vertices: most,
            corners: most,
        }
    }

    /// Takes the vertices and corners of a primitive, before they are allocated.
    pub fn take(&mut self, vertices: usize, corners: usize) -> Result<()> {
        let (vertices, corners) = (
            self.vertices.checked_sub(vertices),
            self.corners.checked_sub(corners),
        );
        let (Some(vertices), Some(corners)) = (vertices, corners) else {
            return Err(Error::data("size", "more than its bytes can hold")
                .expected(format!(
                    "at most {} vertices and as many corners in all nodes",
                    self.most
                ))
                .advice("export each instance as a mesh of its own, or fewer instances"));
        };
        (self.vertices, self.corners) = (vertices, corners);
        Ok(())
    }
}
