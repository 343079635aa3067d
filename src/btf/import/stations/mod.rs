//! Cameras and lamps near the patch: their directions differ from texel to texel, and a lamp is brighter where it is
//! nearer.
//!
//! A sample has one view and light per image, those at the patch's centre. [`station`] says where camera and lamp
//! stood and how far directions spread over the patch. Where that is too far, images are resampled: at each texel
//! the value for the directions of the centre is found from the images whose directions at that texel are near
//! ([`weights`]), each brought to the lamp's distance from the centre ([`resampling`]).

mod resampling;
mod station;
mod weights;

pub use crate::btf::import::stations::resampling::{NearField, Resampler};
pub use crate::btf::import::stations::station::{Patch, Station};

#[cfg(test)]
mod tests;
