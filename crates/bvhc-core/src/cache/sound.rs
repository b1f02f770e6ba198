//! Whether everything that an open file says obeys the rules: also what no ray needs, and opening therefore passes over.

use super::check::{self, Limits};
use super::reader::Opened;
use super::report::Report;
use crate::exec::Executor;
use crate::layout::{SectionEntry, SectionKind};

impl Opened<'_> {
    /// Hold every section against the rules, as [`check_bytes`](check::check_bytes) does at [`Level::Tree`](check::Level::Tree): records,
    /// vertices, names, materials and provenance. What opening has proved, the container and at [`Validation::Hash`](super::Validation::Hash)
    /// the hashes, is not asked again.
    ///
    /// For tools that pass a file on or vouch for it. To trace rays, [`Validation::Tree`](super::Validation::Tree) is enough.
    pub fn check(&self, limits: &Limits, exec: &Executor) -> Report {
        self.check_without(&[], limits, exec)
    }

    /// [`Opened::check`] as if there were no sections of these kinds: for a tool that leaves them out.
    pub fn check_without(&self, left_out: &[SectionKind], limits: &Limits, exec: &Executor) -> Report {
        let mut out = Report::new(limits.max_issues);
        let is_asked = |entry: &SectionEntry| !left_out.contains(&entry.kind);
        for (i, entry) in self.sections().iter().enumerate().filter(|(_, entry)| is_asked(entry)) {
            if entry.codec == SectionEntry::ZSTD && self.section_bytes(i).is_none() {
                check::check_packed(entry, self.stored_bytes(i), &mut out, exec);
            }
        }
        let bytes = |i: usize| self.section_bytes(i).filter(|_| self.sections().get(i).is_some_and(is_asked));
        check::check_content(&self.container, &bytes, None, limits, &mut out, exec);
        check::locate(&mut out, &self.container);
        out.tell_skipped();
        out
    }
}
