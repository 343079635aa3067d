//! Rendering: a surface texton map and a BTF sample under any view and light, to frames.

pub mod bounds;
pub mod camera;
pub mod compass;
pub mod preview;
pub mod raster;
pub mod tone;
