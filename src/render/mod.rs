//! Rendering: a surface texton map and a BTF sample under any view and light, to frames.
//!
//! The way of a frame: [`options`] and files ([`path_file`], [`environment`]) are worked out to
//! cameras and lights ([`plan`]); [`raster`] finds what each sample of the image sees; colour is
//! shaded at vertices ([`vertex_shading`]) or in pixels ([`pixel_shading`]), from the sample laid
//! out texel by texel ([`texel_table`]), weighted by nearness of directions ([`nearest`],
//! [`radiance`]), with their [`parallax`] where the sample has heights, and dimmed where shadow rays say so ([`occlusion`], [`pixel_shadows`]); the [`renderer`] resolves it
//! to a [`frame`], and [`sequence`] writes a sweep of them. `texel_baking` shades the texels of a texture map
//! instead of pixels; [`held_out`] measures how well a sample's directions predict each other.

pub mod blended_image;
pub mod bounds;
mod camera;
mod camera_plan;
mod compass;
pub mod cover;
mod environment;
pub(crate) mod even_light;
pub mod fill;
mod fragment;
pub mod frame;
pub mod frame_range;
mod framing;
pub mod front;
mod ground;
pub mod held_out;
mod known_weights;
mod light;
pub(crate) mod memory;
pub mod nearest;
mod occlusion;
pub mod options;
pub mod parallax;
pub mod path_file;
mod pixel_shading;
mod pixel_shadows;
pub mod plan;
pub(crate) mod preview;
pub mod radiance;
pub mod raster;
pub mod renderer;
mod seen_points;
pub mod sequence;
pub(crate) mod sides;
pub mod subject;
mod surroundings;
pub mod texel_baking;
pub mod texel_table;
mod tone;
pub mod values;
mod vertex_frame;
mod vertex_lights;
mod vertex_shading;
mod vertex_shadows;
mod vertices;

pub use camera::{Camera, Projection, View};
pub use compass::Axis;
pub use light::{Light, Origin};
pub use options::RenderOptions;
pub use values::{ImageSize, Sweep};
