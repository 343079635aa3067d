//! Texton analysis (Tong 2002 §4): filter bank, representative images, vocabulary, pyramid.

pub mod analysis;
pub mod basis;
pub mod border;
pub mod dot_products;
pub mod filter_bank;
pub mod gram_kmeans;
pub mod image_stack;
pub mod level;
pub mod level_textons;
pub mod matrix;
pub mod mixed_responses;
pub mod options;
pub mod outer_products;
pub mod panels;
pub mod picture;
pub mod plan;
pub mod plane_filters;
pub mod report;
pub mod representatives;
pub mod row_blocks;
pub mod sketch;
pub mod sub_grid;
pub mod texel_gram;
pub mod texel_mixtures;
pub mod turning;
pub mod vector_kmeans;
pub mod vocabulary;

#[cfg(test)]
mod oracle;

pub use analysis::{Analysis, analyze};
pub use options::TextonOptions;
pub use vocabulary::{Vocabulary, VocabularyLevel};
