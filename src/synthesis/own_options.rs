//! Options that one method has beside those of all.

use crate::error::Result;

/// The options of one method: a part of [`SynthesisOptions`](crate::synthesis::SynthesisOptions) that every other
/// method refuses.
pub trait OwnOptions {
    /// Refuses values outside their ranges.
    fn validate(&self) -> Result<()>;

    /// The name of every option on the command line, and whether its value is not the default.
    fn changed(&self) -> Vec<(&'static str, bool)>;
}
