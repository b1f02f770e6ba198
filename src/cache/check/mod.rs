//! The check: is this file intact, well formed, and the tree of that model?
//!
//! It collects instead of stopping at the first finding, and never trusts what it has not checked yet: a broken container keeps the
//! deeper levels away from the sections that it makes unreadable, and [`Report::not_checked`] says so. Nothing here panics,
//! recurses over file content, or allocates by a number that the file's length does not bear out.
//!
//! | level | asks | cost |
//! |---|---|---|
//! | [`Level::Quick`] | header, section table, tiling, ids | the table's length |
//! | [`Level::Hash`] | every hash, every compressed section | one read of the file |
//! | [`Level::Tree`] | every record | a few passes over the records |
//! | [`Level::Source`] | agreement with the source model | a look-up for each triangle |

mod boxes;
mod content;
mod counts;
mod cover;
mod identity;
mod instances;
mod report;
mod topology;

pub use content::{check_image, check_records};
pub use report::{Finding, Place, Report};

/// How deep to look. Each level includes those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    Quick,
    Hash,
    Tree,
    Source,
}

/// What a check may spend.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Findings that are kept for each rule; the others are only counted.
    pub max_issues: usize,
    /// Bytes that compressed sections may decode to, all together.
    pub max_memory: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { max_issues: 20, max_memory: 8 << 30 }
    }
}
