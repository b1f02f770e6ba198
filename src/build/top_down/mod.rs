//! Top-down construction: the *driver* owns the recursion, node emission, the depth guarantee and leaf creation; a *strategy* answers
//! one question, where to split this range. A *range* is a node's references in the form that the builder keeps them in.

pub mod driver;
pub(super) mod output;
pub(super) mod partition;
pub(super) mod range;
pub(super) mod strategy;
