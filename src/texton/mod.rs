//! Texton analysis (Tong 2002 §4): filter bank, representative images, vocabulary, pyramid.

pub(crate) mod analysis;
pub mod basis;
mod border;
pub mod dot_products;
pub mod filter_bank;
pub mod gram_kmeans;
mod image_stack;
mod level;
mod level_textons;
pub mod matrix;
pub mod mixed_responses;
pub mod options;
pub mod outer_products;
mod panels;
pub(crate) mod picture;
mod plan;
pub mod plane_filters;
pub(crate) mod report;
mod representatives;
mod row_blocks;
mod sketch;
pub mod sub_grid;
pub mod texel_gram;
pub mod texel_mixtures;
mod turning;
mod vector_kmeans;
pub mod vocabulary;

#[cfg(test)]
mod oracle;

pub use analysis::{Analysis, analyze};
pub use options::TextonOptions;
pub use vocabulary::{StoredVocabulary, Vocabulary, VocabularyLevel};
