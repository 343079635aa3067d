//! The exemplar: the sample as synthesis sees it — features of every texel, and the nearest
//! neighbours of every texel's neighbourhood.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`space`], [`space_level`] | the features of all texels, level by level, and their file |
//! | [`plain_images`] | a space from aligned images |
//! | [`channels`], [`value_range`] | what the numbers of a feature vector are |
//! | [`controls`] | masks, transitions and orientations beside the features |
//! | [`requirements`] | what a method asks of a space |
//! | [`neighbor_table`], [`knn_options`] | the nearest texels of every texel, their file and options |
//! | [`margin`] | which texels may be listed as neighbours and picked by synthesis |
//! | [`level_distances`], [`window_distance`], [`diagonal_sums`], [`texel_block`] | the distances of all neighbourhoods, exactly |
//! | [`two_level`] | the search through the parent level |
//! | [`separated_neighbors`], [`neighbor_list`] | which neighbours are listed, row by row |
//! | [`level`], [`windows`], [`dense_windows`], [`square_window`] | a level as synthesis reads it: its texels and their windows |
//! | [`embedding`], [`aligned_buffer`] | features as short vectors of the same distances |

mod aligned_buffer;
pub(crate) mod channels;
pub(crate) mod controls;
pub(crate) mod dense_windows;
mod diagonal_sums;
pub(crate) mod embedding;
pub(crate) mod feature_size;
pub(crate) mod knn_options;
pub(crate) mod level;
mod level_distances;
pub(crate) mod margin;
mod neighbor_list;
pub mod neighbor_table;
pub(crate) mod plain_images;
mod requirements;
mod separated_neighbors;
pub(crate) mod space;
mod space_level;
pub(crate) mod square_window;
mod texel_block;
mod two_level;
mod value_range;
mod window_distance;
pub(crate) mod windows;

pub use channels::{Channel, ChannelKind, Channels};
pub use controls::{ControlKind, Controls};
pub use knn_options::{KnnOptions, NeighborSearch};
pub use margin::Margin;
pub use neighbor_table::{NeighborTable, TableLevel};
pub use plain_images::{ChannelImage, space_of_images};
pub use space::{Features, Space, SpaceKind, SpaceLevel, space_of_vocabulary};
pub use windows::Windows;
