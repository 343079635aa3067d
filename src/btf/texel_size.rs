//! The side of a texel in millimetres, as archives state it.

use crate::error::Result;
use crate::format::npz;

/// Refuses a side in the `meta.json` of an archive that no texel has.
pub(crate) fn check_texel_mm(file: &npz::Reader, side: Option<f64>) -> Result<()> {
    match side.filter(|side| !(*side > 0.0 && side.is_finite())) {
        Some(side) => Err(file
            .fault("meta.json: texel_mm", side.to_string())
            .expected("a length above 0")),
        None => Ok(()),
    }
}
