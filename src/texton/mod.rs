//! Texton analysis (Tong 2002 §4): filter bank, representative images, vocabulary, pyramid.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`analysis`], [`options`], [`report`] | the whole way from a sample to its vocabulary |
//! | [`study`], [`plan`] | the sample as it is analysed; which route every level takes, by its memory |
//! | [`parts`], [`image_blocks`] | an analysis shared by several runs |
//! | [`representatives`], [`image_stack`], [`image_batches`] | the images that stand for all, and how they are read |
//! | [`eigenplanes`] | the few planes that stand for the images of a factored sample |
//! | [`filter_bank`], [`border`], [`filtered_level`] | the 48 filters, and the grid they see |
//! | [`fft_filters`], [`point_filters`], [`filter_eigenbasis`] | filter responses: of whole planes, at few points, as factors of waves |
//! | [`image_products`], [`scatter_matrix`], [`texel_gram`], [`gram_kmeans`] | textons from the dot products of all texels |
//! | [`sketch`], [`vector_kmeans`] | textons from short vectors |
//! | [`texel_sums`], [`response_sums`] | centres, and the sums that a sketch begins with |
//! | [`clustering`] | the textons of every level, by either route |
//! | [`vocabulary`], [`gram`] | what is found, its file, and its Gram matrix |
//! | [`montage`] | pictures of a vocabulary |
//! | [`row_blocks`], [`transpose`] | rows too many for one piece of memory; rows into columns |

pub(crate) mod analysis;
mod border;
mod clustering;
mod eigenplanes;
pub(crate) mod fft_filters;
pub(crate) mod filter_bank;
pub(crate) mod filter_eigenbasis;
mod filtered_level;
pub(crate) mod gram;
pub(crate) mod gram_kmeans;
mod image_batches;
pub(crate) mod image_blocks;
mod image_products;
mod image_stack;
pub(crate) mod montage;
pub(crate) mod options;
pub(crate) mod parts;
mod plan;
pub(crate) mod point_filters;
pub(crate) mod report;
mod representatives;
pub(crate) mod response_sums;
mod row_blocks;
pub(crate) mod scatter_matrix;
mod sketch;
pub(crate) mod study;
pub(crate) mod texel_gram;
pub(crate) mod texel_sums;
mod transpose;
mod vector_kmeans;
pub(crate) mod vocabulary;

#[cfg(test)]
mod oracle;

pub use analysis::{Analysis, analyze, find};
pub use fft_filters::FftFilters;
pub use filter_bank::leung_malik;
pub use filter_eigenbasis::FilterEigenbasis;
pub use gram::gram_matrix;
pub use gram_kmeans::cluster;
pub use options::TextonOptions;
pub use parts::{PartFile, PartReport, Parts, write_part};
pub use point_filters::PointFilters;
pub use report::{AnalysisReport, LevelReport};
pub use response_sums::sum_responses;
pub use scatter_matrix::ScatterMatrix;
pub use study::Study;
pub use texel_gram::texel_gram;
pub use texel_sums::TexelSums;
pub use vocabulary::{FoundVocabulary, StoredVocabulary, Vocabulary, VocabularyLevel};
