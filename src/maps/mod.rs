//! What synthesis hands on.

pub mod vertex_map;

pub use vertex_map::SurfaceTextonMap;
