//! The exemplar: the sample as synthesis sees it — features of every texel, and the nearest
//! neighbours of every texel's neighbourhood.

pub mod aligned_numbers;
pub mod channels;
pub mod controls;
pub mod dense_windows;
pub mod embedding;
pub mod greedy_choice;
pub mod knn_options;
pub mod level;
pub mod level_distances;
pub mod neighbor_table;
pub mod plain_images;
pub mod requirements;
pub mod space;
pub mod space_level;
pub mod square_window;
pub mod table_rows;
pub mod texel_block;
pub mod turned_sums;
pub mod two_level;
mod value_range;
pub mod window_distance;
pub mod windows;

pub use channels::ChannelKind;
pub use controls::Controls;
pub use knn_options::KnnOptions;
pub use neighbor_table::NeighborTable;
pub use plain_images::{ChannelImage, space_of_images};
pub use space::Space;
