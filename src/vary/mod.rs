//! Progressively-variant textures in the plane (Zhang 2003 §4): an exemplar whose pattern changes steadily,
//! made of homogeneous ones.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`color_mask`], [`morphology`] | a texton mask from picked colours, refined |
//! | [`label_set`], [`nearest_pixel`], [`contours`] | parts of a mask: labels, nearest pixels, features with contours |

pub mod color_mask;
pub mod contours;
pub mod label_set;
pub mod morphology;
pub mod nearest_pixel;
