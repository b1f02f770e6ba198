//! `--nodes`: in which forms a file has its trees.

use crate::cache::{SectionEntry, SectionKind};
use clap::ValueEnum;

/// A form of the trees over triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NodeForm {
    /// Two children a node, which every file has
    Binary,
    /// Eight children a node in 80 bytes
    Compact8,
}

impl NodeForm {
    /// Whether compact trees are among these.
    pub fn any_compact(forms: &[NodeForm]) -> bool {
        forms.contains(&NodeForm::Compact8)
    }
}

/// Do the forms in a file differ from those that were asked for?
pub fn nodes_change(sections: &[SectionEntry], asked: &[NodeForm]) -> Option<&'static str> {
    let has = |kind| sections.iter().any(|s| s.kind == kind);
    let parts = [SectionKind::CROW, SectionKind::CNOD, SectionKind::CREF].map(has);
    match NodeForm::any_compact(asked) {
        true if parts != [true; 3] => Some("nodes binary → compact8"),
        false if parts != [false; 3] => Some("nodes compact8 → binary"),
        _ => None,
    }
}
