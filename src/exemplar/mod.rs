//! The exemplar: the sample as synthesis sees it — features of every texel, and the nearest
//! neighbours of every texel's neighbourhood.

pub mod aligned_numbers;
pub mod greedy_choice;
pub mod knn_options;
pub mod level_distances;
pub mod neighbor_table;
pub mod plain_images;
pub mod space;
pub mod square_window;
pub mod table_rows;
pub mod texel_block;
pub mod turned_sums;
pub mod two_level;
pub mod window_distance;

pub use knn_options::KnnOptions;
