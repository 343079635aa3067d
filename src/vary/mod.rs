//! Progressively-variant textures in the plane (Zhang 2003 §4): an exemplar whose pattern changes steadily,
//! made of homogeneous ones.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`color_mask`], [`morphology`] | a texton mask from picked colours, refined |
//! | [`label_set`], [`nearest_pixel`], [`contours`] | parts of a mask: labels, nearest pixels, features with contours |
//! | [`key_values`], [`planar_basis`] | transition functions and orientation fields from key values |
//! | [`distortion`] | synthesis with windows scaled and turned at every pixel |
//! | [`warp`] | operations on a mask that the transition drives |
//! | [`mask_blending`] | the mask between two masks |
//! | [`filtering`] | a texture for a mask, as image analogies; mixed textures |
//! | [`canvas`] | how a texture's mask goes on beyond its borders |
//! | [`material`] | images and BTF samples: what is compared of them, and what is made |

pub(crate) mod canvas;
pub(crate) mod color_mask;
pub(crate) mod contours;
pub(crate) mod distortion;
pub mod filtering;
pub(crate) mod key_values;
pub(crate) mod label_set;
pub(crate) mod mask_blending;
pub(crate) mod material;
pub(crate) mod morphology;
pub(crate) mod nearest_pixel;
pub(crate) mod planar_basis;
pub mod warp;

pub use canvas::{Extension, extended};
pub use color_mask::{Pick, PickedColor, mask_of_colors};
pub use contours::{Feature, MaskFeatures};
pub use distortion::{DistortionOptions, distorted};
pub use key_values::{Key, orientation_of_keys, ramp, straight_orientation, transition_of_keys};
pub use label_set::LabelSet;
pub use mask_blending::{BlendOptions, Joining, blended_mask};
pub use material::{Material, Picks};
pub use morphology::{Edit, Operation, morph};
pub use nearest_pixel::Axis;
