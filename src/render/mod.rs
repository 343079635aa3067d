//! Rendering: a surface texton map and a BTF sample under any view and light, to frames.
//!
//! The way of a frame: [`options`] and files ([`path_file`], [`environment`]) become cameras and lights ([`plan`]);
//! [`raster`] finds what each sample of the image sees; colour is shaded at vertices ([`vertex_shading`]) or in pixels
//! ([`pixel_shading`]), from the sample laid out texel by texel ([`texel_table`]), weighted by nearness of directions
//! ([`nearest`], [`btf_lookup`]), with their [`parallax`] where the sample has heights, and dimmed where shadow rays
//! are blocked ([`occlusion`], [`pixel_shadows`]); the [`renderer`] resolves it to a [`frame`], and [`sweep`] writes a
//! sweep of them. `texel_baking` shades the texels of a texture map instead of pixels; [`held_out`] measures how well a
//! sample's directions predict each other.

mod azimuth;
pub(crate) mod blended_image;
pub(crate) mod bounds;
pub(crate) mod btf_lookup;
mod camera;
mod camera_plan;
pub(crate) mod cover;
mod environment;
pub(crate) mod even_light;
pub(crate) mod fill;
mod fragment;
pub(crate) mod frame;
pub(crate) mod frame_range;
mod framing;
pub(crate) mod front;
mod ground;
pub mod held_out;
mod known_weights;
mod light;
pub(crate) mod memory;
pub mod nearest;
mod occlusion;
pub(crate) mod option_values;
pub(crate) mod options;
pub mod parallax;
pub mod path_file;
mod pixel_shading;
mod pixel_shadows;
mod placement;
pub(crate) mod plan;
pub(crate) mod preview;
pub(crate) mod raster;
pub(crate) mod renderer;
mod seen_points;
pub(crate) mod sides;
pub(crate) mod subject;
pub mod sweep;
pub(crate) mod table_levels;
pub(crate) mod texel_baking;
pub(crate) mod texel_table;
mod tone;
mod vertex_frame;
mod vertex_lights;
mod vertex_shading;
mod vertex_shadows;
mod vertices;

pub use azimuth::Axis;
pub use blended_image::blended_image;
pub use bounds::Bounds;
pub use btf_lookup::{BtfLookup, Texels};
pub use camera::{Camera, Projection, View};
pub use cover::Cover;
pub use fill::Fill;
pub use frame::{Frame, GeometryLayers, LayerGroup};
pub use frame_range::{FramePattern, FrameRange};
pub use front::Front;
pub use light::{Light, Origin};
pub use option_values::{
    Animation, ImageSize, Layer, LightSpec, Mip, Point, ProjectionKind, Sweep,
};
pub use options::{
    CameraOptions, FileOptions, ImageOptions, LightOptions, RenderOptions, SweepOptions,
};
pub use plan::{PlannedFrame, plan};
pub use raster::{Hit, Samples};
pub use renderer::{RenderSettings, Renderer, Shading, Shadows};
pub use subject::Subject;
pub use texel_table::MemoryBudget;
pub use tone::{Background, ToneCurve};
