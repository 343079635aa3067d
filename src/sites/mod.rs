//! Where synthesis writes: sites in levels, and which sites of which level every sample of a
//! neighbourhood blends. Nothing here knows of exemplars.
//!
//! | target | samples blend | file |
//! | --- | --- | --- |
//! | vertices of a mesh and of its retiled pyramid | 3 vertices | [`vertices`] |
//! | a flat grid | 1 site | [`grid`] |
//! | the texels of a texture atlas | 4 texels | [`atlas`] |
//! | the faces of a subdivided mesh | none: a face is a pixel | [`faces`] |
//!
//! [`level`] has what a target must tell; [`order`], [`scan_order`] and [`coloring`] say in which order its
//! sites are visited; [`controls`] what a texture that changes follows. A [`Target`] is any of them.

pub mod atlas;
pub(crate) mod coloring;
pub(crate) mod controls;
pub mod faces;
pub mod grid;
pub(crate) mod level;
mod mesh_controls;
pub(crate) mod order;
pub(crate) mod scan_order;
pub(crate) mod target;
pub mod vertices;

pub use atlas::options::{AtlasOptions, ChartSource, Sampling};
pub use atlas::preparation::AtlasSurface;
pub use controls::SiteControls;
pub use grid::window::SiteGrid;
pub use level::{Neighbor, Parent, SampleLocation, SiteEdge, SiteHierarchy, Sites};
pub use order::Order;
pub use target::{Target, TargetSites, TargetSurface, WithSites};
pub use vertices::circles::{CircleSource, RoundOptions};
pub use vertices::surface_options::SurfaceOptions;
