//! The surface: an indexed triangle mesh and what synthesis needs of it — frames, patches,
//! stencils, a pyramid. Nothing here knows of textures.

pub mod builtin;
pub mod cache;
pub mod chart;
pub mod cleaning;
pub mod connection;
pub mod distortion;
pub mod field;
pub mod frame;
pub mod grid_window;
pub mod hierarchy;
pub mod memory;
pub mod neighbor;
pub mod origin;
pub mod parents;
pub mod patches;
pub mod pictures;
pub mod point_tree;
pub mod prepared_surface;
pub mod quality;
pub mod reading;
pub mod retile;
pub mod rings;
pub mod rows;
pub mod sample_location;
pub mod sampling;
pub mod shapes;
pub mod stencil;
pub mod surface;
pub mod surface_options;
pub mod surface_tree;
pub mod texture_charts;
pub mod topology;
pub mod triangle_mesh;
pub mod triangulation;
pub mod writing;
