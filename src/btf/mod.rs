//! The BTF sample: directions, storage, and how samples come to be (measured or baked).

pub mod bake;
pub mod direction;
pub mod direction_set;
pub mod import;
pub mod sample;
mod table;
pub mod writer;
