//! Tests of the engine as a whole, and small inputs for tests.

pub(crate) mod fixtures;
pub(crate) mod oracles;
mod runs;
