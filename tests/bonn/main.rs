//! `.btf` files of the University of Bonn: every kind is read to the numbers that were written, broken ones are
//! refused with words, and samples go out and come back.

#[path = "../program/mod.rs"]
mod program;

mod export;
mod files;
mod refused;
mod variants;
