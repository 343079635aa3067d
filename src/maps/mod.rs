//! What synthesis hands on.

pub mod vertex_map;
