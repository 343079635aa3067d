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

pub mod canvas;
pub mod color_mask;
pub mod contours;
pub mod distortion;
pub mod filtering;
pub mod key_values;
pub mod label_set;
pub mod mask_blending;
pub mod material;
pub mod morphology;
pub mod nearest_pixel;
pub mod planar_basis;
pub mod warp;
