//! What a user can ask for: the options and presets, the names of their values, and the registry of methods, which feeds `--help`, META and
//! the build key.

pub(super) mod names;
pub(super) mod options;
pub(super) mod registry;
