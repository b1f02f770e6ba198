//! What a user can ask for: presets, methods and options.
//!
//! | file | holds |
//! |---|---|
//! | `options` | the closed sets: methods, presets, ways to clip |
//! | `table` | the options, one row each, and [`BuildOptions`](options::BuildOptions) written out of them |
//! | `row`, `value` | the columns of that table, and the types of its values |
//! | `registry` | the methods and the presets, one row each |
//! | `settings` | options as text, put on top of a preset, and refused where the method does not read them |
//! | `effective` | what of the options decides a build, for META, the build key and the command line |
//! | `names` | names of closed sets' values |

mod effective;
pub(super) mod names;
pub(super) mod options;
pub(super) mod registry;
pub(super) mod row;
pub(super) mod settings;
pub(super) mod table;
#[cfg(test)]
mod tests;
mod value;
