//! The surface: an indexed triangle mesh and what synthesis needs of it — frames, patches,
//! stencils, a pyramid. Nothing here knows of textures.

pub mod builtin;
pub mod frame;
pub mod hierarchy;
pub mod stencil;
pub mod triangle_mesh;
