//! The test vectors of the format: small valid files, and one invalid file for each rule of the catalogue.
//!
//! They are made here, from hand-made trees, so that no change of a builder changes them. `cargo run --example vectors` writes them to
//! `format-spec/vectors`; `tests/mutation.rs` holds what is committed there against what is made here.
#![allow(dead_code)]

pub mod bytes;
pub mod invalid;
pub mod scenes;
pub mod valid;
