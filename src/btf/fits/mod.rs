//! Fits of reflectance-transformation imaging: per texel a short sum of functions of the light's direction, seen from
//! directly above (Malzbender 2001: polynomial texture maps; Gautron 2004: hemispherical harmonics).
//!
//! | file | what it does |
//! | --- | --- |
//! | [`basis`] | the functions of the light's direction |
//! | [`fit`] | a fit in memory: one byte per coefficient, evaluated at a light |
//! | [`ptm`], [`hsh`] | the file formats, read and written |
//! | [`header`] | their headers in text |
//! | [`evaluation`] | a fit evaluated at chosen lights becomes a sample |
//! | [`fitting`] | a sample of one view becomes a fit, by least squares |
//! | [`normal_equations`], [`quantization`] | the algebra of that, and its rounding to bytes |

pub(crate) mod basis;
pub(crate) mod evaluation;
pub(crate) mod fit;
pub(crate) mod fitting;
mod header;
pub mod hsh;
mod normal_equations;
pub mod ptm;
mod quantization;

pub use basis::Basis;
pub use evaluation::evaluate;
pub use fit::{Colors, Fit};
pub use fitting::{Fitted, fit_sample};
