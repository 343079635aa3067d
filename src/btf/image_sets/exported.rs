//! What an export reports.

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exported {
    /// Images.
    pub images: usize,
    /// Numbers above 1 that the images could not hold and are 1 now.
    pub clipped: u64,
}
