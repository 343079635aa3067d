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
pub(crate) mod basis;
mod border;
pub(crate) mod dot_products;
mod eigenplanes;
pub(crate) mod filter_bank;
pub(crate) mod gram_kmeans;
pub(crate) mod image_blocks;
mod image_products;
mod image_stack;
mod level;
mod level_textons;
pub(crate) mod mixed_responses;
pub(crate) mod options;
pub(crate) mod outer_products;
mod panels;
pub(crate) mod parts;
pub(crate) mod picture;
mod plan;
pub(crate) mod plane_filters;
pub(crate) mod report;
mod representatives;
mod row_blocks;
mod sketch;
pub(crate) mod study;
pub(crate) mod sub_grid;
pub(crate) mod texel_gram;
pub(crate) mod texel_mixtures;
mod turning;
mod vector_kmeans;
pub(crate) mod vocabulary;

#[cfg(test)]
mod oracle;

pub use analysis::{Analysis, analyze, find};
pub use basis::PlaneBasis;
pub use dot_products::dot_products;
pub use filter_bank::leung_malik;
pub use gram_kmeans::cluster;
pub use mixed_responses::mix_into;
pub use options::{ByteSize, TextonOptions};
pub use outer_products::OuterProducts;
pub use parts::{PartFile, PartReport, Parts, write_part};
pub use plane_filters::PlaneFilters;
pub use report::{AnalysisReport, LevelReport};
pub use study::Study;
pub use sub_grid::SubGrid;
pub use texel_gram::texel_gram;
pub use texel_mixtures::TexelMixtures;
pub use vocabulary::{FoundVocabulary, StoredVocabulary, Vocabulary, VocabularyLevel};
