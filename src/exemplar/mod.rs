//! The exemplar: the sample as synthesis sees it — features of every texel, and the nearest
//! neighbours of every texel's neighbourhood.

mod aligned_numbers;
pub mod channels;
pub mod controls;
pub(crate) mod dense_windows;
pub(crate) mod embedding;
mod greedy_choice;
pub mod knn_options;
pub(crate) mod level;
mod level_distances;
pub mod neighbor_table;
pub mod plain_images;
mod requirements;
pub mod space;
mod space_level;
pub(crate) mod square_window;
mod table_rows;
mod texel_block;
mod turned_sums;
mod two_level;
mod value_range;
mod window_distance;
pub mod windows;

pub use channels::ChannelKind;
pub use controls::Controls;
pub use knn_options::KnnOptions;
pub use neighbor_table::NeighborTable;
pub use plain_images::{ChannelImage, space_of_images};
pub use space::Space;
