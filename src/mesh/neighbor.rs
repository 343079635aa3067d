//! A neighbour of a site.

/// A site near another, and where it lies in that one's (s, t) plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Neighbor {
    /// The neighbouring site.
    pub site: u32,
    /// Offset along s, in texels of the level.
    pub x: f32,
    /// Offset along t, in texels of the level.
    pub y: f32,
}
