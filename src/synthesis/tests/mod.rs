//! Tests of the engine as a whole, and small inputs for tests.

pub mod fixtures;
pub mod oracles;
mod runs;
