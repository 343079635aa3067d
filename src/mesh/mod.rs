//! The surface: an indexed triangle mesh and what synthesis needs of it — frames, patches,
//! stencils, a pyramid. Nothing here knows of textures.

pub mod builtin;
pub mod chart;
pub mod connection;
pub mod frame;
pub mod hierarchy;
pub mod retile;
pub mod rings;
pub mod rows;
pub mod sampling;
pub mod shapes;
pub mod stencil;
pub mod surface_tree;
pub mod topology;
pub mod triangle_mesh;
