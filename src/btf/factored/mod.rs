//! Factored samples: every image a sum of a few eigentextures.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`factorization`] | what `btf.json` says of the factors |
//! | [`factors`], [`products`] | the factors in memory, and images multiplied out |
//! | [`writer`], [`content_id`] | a factored sample written row by row, and its id |
//! | [`mod@factorize`] | a factored sample made from any images |
//! | [`image_matrix`], [`randomized_svd`], [`orthonormal`] | the leading eigentextures, by passes over the images |
//! | [`residual`] | the error that factors leave |

pub(crate) mod content_id;
pub(crate) mod factorization;
pub(crate) mod factorize;
pub(crate) mod factors;
mod image_matrix;
pub(crate) mod orthonormal;
pub(crate) mod products;
mod randomized_svd;
pub(crate) mod residual;
pub(crate) mod writer;

#[cfg(test)]
mod factorize_tests;
#[cfg(test)]
mod tests;

pub use factorization::Factorization;
pub use factorize::{Accuracy, FactorOptions, factorize};
pub use factors::Factors;
pub use products::Values;
pub use residual::Residual;
pub use writer::FactoredWriter;
