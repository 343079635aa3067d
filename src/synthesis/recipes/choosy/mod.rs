//! Castellanos and Williams, *Automatic Synthesis of Isotropic Textures on Surfaces from Sample Images*: faces are
//! pixels, and no orientation is needed.
//!
//! The sample lies on two triangular grids at 90° to each other, and has a Gaussian and a Laplacian pyramid on each. A
//! surface has the same pyramids on its subdivided faces. Level after level, from the coarsest on, every face takes the
//! values of the sample's face whose neighbourhood is most alike, at the best of three rotations. The more often a face
//! is used, the worse it scores. A face takes the Laplacian values of that face's children too, from which the next level starts.
//!
//! Deviations: the weights of a neighbourhood are those of the regular lattice, also where the surface is not regular.
//! At the same score the face that is used less often is taken, then the one of the smaller number; the paper leaves this open.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`face_values`] | numbers on faces |
//! | [`kernel`] | Gaussian convolution on faces: reduce and project |
//! | [`value_pyramid`] | Gaussian and Laplacian pyramids |
//! | [`sample`] | the pyramids of the sample on its two grids |
//! | [`principal_components`] | vectors on their leading directions |
//! | [`counted_tree`] | the nearest vector, weighted by how often it was used |
//! | [`source_faces`] | the neighbourhoods of the sample's faces, weighted and projected |
//! | [`sampling`] | choosy sampling of one level |
//! | [`options`], [`recipe`] | the whole method |

pub mod counted_tree;
pub mod face_values;
pub mod kernel;
pub mod options;
pub mod principal_components;
pub mod recipe;
pub mod sample;
mod sampling;
pub mod source_faces;
pub mod value_pyramid;

pub use face_values::FaceValues;
pub use options::ChoosyOptions;
pub use recipe::{ChoosyResult, synthesize_faces};
pub use sample::{AnalysisSample, SquareImage};
pub use source_faces::Source;

#[cfg(test)]
mod tests;
