//! Texton analysis (Tong 2002 §4): filter bank, representative images, vocabulary, pyramid.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`analysis`], [`options`], [`report`] | the whole way from a sample to its vocabulary |
//! | [`study`], [`plan`] | the sample as it is analysed; which route every level takes, by its memory |
//! | [`parts`], [`image_blocks`] | an analysis shared by several runs |
//! | [`representatives`], [`image_stack`], [`panels`] | the images that stand for all, and how they are read |
//! | [`eigenplanes`] | the few planes that stand for the images of a factored sample |
//! | [`filter_bank`], [`border`], [`level`] | the 48 filters, and the grid they see |
//! | [`plane_filters`], [`sub_grid`], [`basis`], [`turning`] | filter responses: on planes, at few points, as diagonals |
//! | [`image_products`], [`outer_products`], [`texel_gram`], [`gram_kmeans`] | textons from the dot products of all texels |
//! | [`sketch`], [`texel_mixtures`], [`mixed_responses`], [`vector_kmeans`] | textons from short vectors, and centres from mixtures |
//! | [`level_textons`] | the textons of every level, by either route |
//! | [`vocabulary`], [`dot_products`] | what is found, its file, and its Gram matrix |
//! | [`picture`] | pictures of a vocabulary |
//! | [`row_blocks`] | rows too many for one piece of memory |

pub(crate) mod analysis;
pub mod basis;
mod border;
pub mod dot_products;
mod eigenplanes;
pub mod filter_bank;
pub mod gram_kmeans;
pub mod image_blocks;
mod image_products;
mod image_stack;
mod level;
mod level_textons;
pub mod mixed_responses;
pub mod options;
pub mod outer_products;
mod panels;
pub(crate) mod parts;
pub(crate) mod picture;
mod plan;
pub mod plane_filters;
pub(crate) mod report;
mod representatives;
mod row_blocks;
mod sketch;
pub(crate) mod study;
pub mod sub_grid;
pub mod texel_gram;
pub mod texel_mixtures;
mod turning;
mod vector_kmeans;
pub mod vocabulary;

#[cfg(test)]
mod oracle;

pub use analysis::{Analysis, analyze, find};
pub use options::TextonOptions;
pub use parts::{PartFile, PartReport, Parts, write_part};
pub use report::{AnalysisReport, LevelReport};
pub use study::Study;
pub use vocabulary::{FoundVocabulary, StoredVocabulary, Vocabulary, VocabularyLevel};
