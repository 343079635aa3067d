//! Tests of the engine as a whole, and small inputs for tests.

pub mod fixtures;
mod oracles;
mod runs;
