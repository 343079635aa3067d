//! A line of a list of images.

use crate::btf::direction::Direction;

/// An image as a list names it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Listed {
    /// The line of the list, counted from 1.
    pub(super) line: u64,
    /// The file, as the list names it; empty where it does not.
    pub(super) file: String,
    pub(super) view: Direction,
    pub(super) light: Direction,
}
