//! Flags that change the output.
//!
//! `tree` has those that choose a recipe, made from the library's tables; `listing` prints the table of options for `-O help`; `reading` has
//! those that choose what of a model is read.

pub mod listing;
mod reading;
mod tree;

pub use reading::{InputFormat, ReadArgs};
pub use tree::{TreeArgs, preset_lines};

use crate::build::Named;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A closed set of the library as values of a flag: its names are the choices.
pub fn choice<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let names = T::names().into_iter().map(|(_, name)| PossibleValue::new(name));
    PossibleValuesParser::new(names).try_map(|text| T::parse(&text))
}
