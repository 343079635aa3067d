//! The `.btf` files of the University of Bonn (UBO2014 and others): read into samples, and written.
//!
//! There are four formats behind one container. Their facts are those of two public readers, btflib and btf.hh.
//!
//! | file | what it does |
//! | --- | --- |
//! | [`signature`], [`header`], [`sampling`] | what all files begin with |
//! | [`dfmf`], [`fmf`], [`pvf`], [`bdi`] | one format each: body read, body written |
//! | [`factors`], [`matrix`], [`singular_values`], [`scalar`] | matrices and their number types |
//! | [`color`], [`lab`] | colour models |
//! | [`file`](mod@file), [`fields`] | an open file |
//! | [`import`](mod@import), [`to_factored`], [`expand`], [`images`], [`body`], [`crop`], [`local_frames`] | a sample of it |
//! | [`export`](mod@export), [`sample_factors`], [`one_pair`], [`view_components`], [`encode`], [`output`] | a file of a sample |
//!
//! **Row order.** Row 0 of a file is the top row of its images. btflib shows row 0 at the top. btf.hh reverses the rows
//! when it loads a file, and its program then writes them into a TGA file whose first row is the bottom one: so there
//! too row 0 of the file is seen at the top.

mod bdi;
mod body;
pub(crate) mod color;
mod crop;
mod dfmf;
pub(crate) mod encode;
mod expand;
pub(crate) mod export;
pub(crate) mod factors;
mod fields;
mod file;
mod fmf;
pub(crate) mod header;
mod images;
pub(crate) mod import;
mod lab;
mod local_frames;
pub(crate) mod matrix;
mod one_pair;
mod output;
mod pvf;
mod sample_factors;
pub(crate) mod sampling;
pub(crate) mod scalar;
pub(crate) mod signature;
mod singular_values;
mod to_factored;
mod view_components;

pub use bdi::{BdiContent, Compression};
pub use color::{Color, ColorModel};
pub use dfmf::DfmfContent;
pub use encode::{Written, encode};
pub use export::{BonnExportOptions, Exported, export};
pub use factors::Channel;
pub use file::BonnFile;
pub use fmf::{ExtraHeader, FmfContent};
pub use header::{Header, Meta};
pub use import::{BonnImport, BonnOptions, Told};
pub use matrix::MatrixRows;
pub use pvf::{PvfContent, View};
pub use sampling::Sampling;
pub use scalar::Scalar;
pub use signature::{Format, SIGNATURES, Signature};
