//! The BTF sample: directions, storage, and how samples come to be (measured or baked).
//!
//! | file | what it does |
//! | --- | --- |
//! | [`sample`], [`writer`] | a sample in its folder, read in parts and written image by image |
//! | [`parts`] | parts of a sample that several runs make, and how they are joined |
//! | [`description`], [`image_source`] | what a sample is of, and images that are read in runs |
//! | [`height_map`] | how high the surface lies at every texel |
//! | [`heights`] | the same, estimated from the images |
//! | [`factored`] | samples whose images are products of factors |
//! | [`direction`], [`direction_set`] | directions, and named sets of them |
//! | [`bake`] | a sample ray-traced from height, colour and roughness |
//! | [`fits`] | polynomial texture maps and hemispherical harmonics of reflectance-transformation imaging |
//! | [`import`], [`table`] | a sample from measured images and their list |
//! | [`image_sets`] | a sample as a set of images that other programs read |
//! | [`bonn`] | `.btf` files of the University of Bonn, read and written |

pub mod bake;
pub mod bonn;
pub(crate) mod description;
pub(crate) mod direction;
pub(crate) mod direction_set;
pub mod factored;
pub mod fits;
pub(crate) mod height_map;
pub mod heights;
pub mod image_sets;
pub(crate) mod image_source;
pub mod import;
pub(crate) mod parts;
pub(crate) mod sample;
mod table;
pub(crate) mod texel_size;
pub(crate) mod writer;

pub use description::{Description, FORMAT, Layout, VERSION};
pub use direction::Direction;
pub use direction_set::{DirectionSet, Ring};
pub use factored::FactoredWriter;
pub use height_map::HeightMap;
pub use image_source::ImageSource;
pub use parts::WrittenSample;
pub use sample::{DType, Pixels, Sample};
pub use writer::SampleWriter;
