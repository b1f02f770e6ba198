//! Top-down construction: the *driver* owns the recursion, node emission, the depth guarantee and leaf creation; a *strategy* answers
//! one question, where to split this range.

pub mod driver;
pub(super) mod output;
pub(super) mod partition;
pub(super) mod strategy;
