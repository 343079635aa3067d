//! Texton analysis (Tong 2002 §4): filter bank, representative images, vocabulary, pyramid.

pub mod analysis;
pub mod basis;
pub mod centroids;
pub mod dot_products;
pub mod filter_bank;
pub mod gram_kmeans;
pub mod image_stack;
pub mod matrix;
pub mod options;
pub mod outer_products;
pub mod picture;
pub mod plan;
pub mod report;
pub mod representatives;
pub mod sketch;
pub mod texel_gram;
pub mod vector_kmeans;
pub mod vocabulary;

#[cfg(test)]
mod oracle;

pub use analysis::{Analysis, analyze};
pub use options::TextonOptions;
pub use vocabulary::{Vocabulary, VocabularyLevel};
