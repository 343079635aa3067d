//! Rendering: a surface texton map and a BTF sample under any view and light, to frames.
//!
//! The way of a frame: [`options`] and files ([`path_file`], [`environment`]) are worked out to
//! cameras and lights ([`plan`]); [`raster`] finds what each sample of the image sees; colour is
//! shaded at vertices ([`vertex_shading`]) or in pixels ([`pixel_shading`]), from the sample laid
//! out texel by texel ([`texel_table`]), weighted by nearness of directions ([`nearest`],
//! [`radiance`]) and dimmed where shadow rays say so ([`occlusion`]); the [`renderer`] resolves it
//! to a [`frame`], and [`sequence`] writes a sweep of them.

pub mod bounds;
pub mod camera;
pub mod compass;
pub mod environment;
pub mod fragment;
pub mod frame;
pub mod frame_range;
pub mod known_weights;
pub mod light;
pub mod memory;
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
pub mod seen_points;
pub mod sequence;
pub mod surroundings;
pub mod texel_table;
pub mod tone;
pub mod values;
pub mod vertex_lights;
pub mod vertex_shading;
pub mod vertex_shadows;
