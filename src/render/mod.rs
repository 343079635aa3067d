//! Rendering: a surface texton map and a BTF sample under any view and light, to frames.

pub mod bounds;
pub mod camera;
pub mod compass;
pub mod environment;
pub mod fragment;
pub mod frame;
pub mod frame_range;
pub mod light;
pub mod nearest;
pub mod occlusion;
pub mod options;
pub mod path_file;
pub mod pixel_shading;
pub mod plan;
pub mod preview;
pub mod radiance;
pub mod raster;
pub mod renderer;
pub mod sequence;
pub mod surroundings;
pub mod texel_table;
pub mod tone;
pub mod vertex_shading;
