//! The container: header, section table and tiling, which every file passes before anything in it is used.
//!
//! One walk asks the rules `E01xx` in one order. Its [`Sink`] decides what a breach means: the reader stops at the first, the
//! [check](super::check) collects them all. The cost depends on the number of sections, not on the length of the file.
//!
//! | file | asks |
//! |---|---|
//! | `header` | the first 256 bytes |
//! | `table` | where the table lies, how the sections tile the file, which of them there are |
//! | `entry` | what one entry says by itself |
//! | `sink` | what becomes of a breach |

mod entry;
mod header;
mod sink;
mod table;

use std::ops::ControlFlow;

use super::report::{Finding, Place, Report};
use super::{keys, rules};
use crate::layout::{Header, SectionEntry, SectionKind, tree_flags};

#[cfg(not(feature = "zstd"))]
pub use entry::undecodable;
pub use entry::{is_known_codec, is_understood};
pub use header::check_tree_flags;
pub use sink::{First, Sink};

/// A file's header and table.
#[derive(Debug)]
pub struct Container {
    /// The first 256 bytes. Unless the container was [collected](Container::collect), the rules hold that they and the table can answer together
    /// with the file's length; the counts are those that the header states, until [`Container::check_head`] has asked the table.
    pub header: Header,
    /// The section table in file order, unknown kinds included.
    pub entries: Vec<SectionEntry>,
    /// For each entry whether no rule keeps its section from being read.
    readable: Vec<bool>,
}

impl Container {
    /// Read header and table.
    ///
    /// # Errors
    /// The first breach of a rule.
    pub fn parse(file: &[u8]) -> Result<Container, Finding> {
        let mut first = First::default();
        let container = Container::walk(file, &mut first);
        first.result()?;
        // A walk that finds no breach has read everything.
        container.ok_or_else(|| Finding::new(&rules::E0110, Place::file(), "readable".into(), "nowhere".into()))
    }

    /// Read header and table, and collect every breach. `None` where there is nothing that could be read on from.
    pub fn collect(file: &[u8], out: &mut Report) -> Option<Container> {
        Container::walk(file, out)
    }

    fn walk(file: &[u8], out: &mut impl Sink) -> Option<Container> {
        match walk(file, out) {
            ControlFlow::Continue(container) => Some(container),
            ControlFlow::Break(()) => None,
        }
    }

    /// The section of this kind and number, if this version can read it. In a still file every number is 0.
    pub fn find(&self, kind: SectionKind, ordinal: u32) -> Option<usize> {
        self.entries.iter().position(|e| (e.kind, e.ordinal) == (kind, ordinal) && is_understood(e))
    }

    /// The stored bytes of a section; `None` beyond the table, outside the file, and where a rule keeps them from being read.
    pub fn stored<'a>(&self, file: &'a [u8], index: usize) -> Option<&'a [u8]> {
        let entry = self.entries.get(index).filter(|_| self.readable.get(index) == Some(&true))?;
        file.get(usize::try_from(entry.offset).ok()?..usize::try_from(entry.end()?).ok()?)
    }

    /// `content_id` follows from the table.
    pub fn check_content_id(&self, out: &mut impl Sink) -> ControlFlow<()> {
        let found = keys::content_id(&self.entries);
        if found != self.header.content_id {
            return out.breach(&rules::E0204, Place::byte(96), || (hex(&found), hex(&self.header.content_id)));
        }
        ControlFlow::Continue(())
    }

    /// The entries of two kinds that share their numbers: for each number both. Numbers are without holes where the rules hold.
    pub fn pairs(&self, a: SectionKind, b: SectionKind) -> Vec<[usize; 2]> {
        let (a, b) = (self.numbered(a), self.numbered(b));
        a.into_iter().zip(b).map(|(a, b)| [a, b]).collect()
    }

    /// The entries of a kind in the order of their numbers.
    fn numbered(&self, kind: SectionKind) -> Vec<usize> {
        let is_mine = |i: &usize| self.entries[*i].kind == kind && is_understood(&self.entries[*i]);
        let mut all: Vec<usize> = (0..self.entries.len()).filter(is_mine).collect();
        all.sort_by_key(|i| self.entries[*i].ordinal);
        all
    }

    /// For such pairs the records that the table states.
    pub fn lengths(&self, pairs: &[[usize; 2]]) -> Vec<[u64; 2]> {
        pairs.iter().map(|pair| pair.map(|i| self.entries[i].elem_count)).collect()
    }

    /// The counts that the header repeats are those of the table, so that nothing is sized by a number that another contradicts.
    pub fn check_counts(&self, out: &mut impl Sink) -> ControlFlow<()> {
        let header = &self.header;
        let sequence = header.has(tree_flags::SEQUENCE);
        let kinds = match sequence {
            false => [SectionKind::TRIS, SectionKind::BLAS],
            true => [SectionKind::TRIX, SectionKind::TOPO],
        };
        for (rule, offset, kind, stated) in [
            (&rules::E0302, 168, kinds[0], header.ref_count),
            (&rules::E0304, 184, kinds[1], header.blas_count.into()),
            (&rules::E0305, 188, SectionKind::INST, header.instance_count.into()),
            (&rules::E0308, 192, SectionKind::FRAM, header.frame_count.into()),
        ] {
            let mut of_kind =
                self.entries.iter().zip(&self.readable).filter(|(e, _)| e.kind == kind && is_understood(e));
            // How many records it has is not known, or its absence has a rule of its own.
            let optional = matches!(kind, SectionKind::INST | SectionKind::FRAM);
            let is_refused = self.entries.iter().any(|e| e.kind == kind && !is_understood(e));
            if !optional && of_kind.clone().next().is_none()
                || is_refused
                || of_kind.clone().any(|(_, readable)| !readable)
            {
                continue;
            }
            // In a still file sections with other numbers are refused by their own rule.
            let Some(count) = of_kind.try_fold(0u64, |sum, (e, _)| sum.checked_add(e.elem_count)) else { continue };
            if count != stated {
                out.breach(rule, Place::byte(offset), || (count.to_string(), stated.to_string()))?;
            }
        }
        ControlFlow::Continue(())
    }

    /// [`Container::check_counts`] the reader's way: up to the first breach.
    ///
    /// Parsing does not ask this itself, so that a file whose sections are too large is refused for that first.
    pub fn check_head(&self) -> Result<(), Finding> {
        let mut first = First::default();
        _ = self.check_counts(&mut first);
        first.result()
    }
}

fn walk(file: &[u8], out: &mut impl Sink) -> ControlFlow<(), Container> {
    let header = header::read(file, out)?;
    let entries = table::read(file, &header, out)?;
    let mut readable = vec![true; entries.len()]; // as many as there are entries in the file
    table::check_tiling(file, &header, &entries, &mut readable, out)?;
    for (i, entry) in entries.iter().enumerate() {
        readable[i] &= entry::check(entry, place(&header, entry, i), out)?;
        readable[i] &= entry::check_delta(entry, &header, place(&header, entry, i), out)?;
    }
    table::check_unique(&header, &entries, &mut readable, out)?;
    table::check_presence(&header, &entries, out)?;
    ControlFlow::Continue(Container { header, entries, readable })
}

/// Why the META of a file cannot be read by this version, if there is one that cannot.
pub fn later_meta(entries: &[SectionEntry]) -> Option<Finding> {
    let entry = entries.iter().find(|e| e.kind == SectionKind::META && e.ordinal == 0 && !is_understood(e))?;
    let (known, found) = entry::unread(entry);
    Some(Finding::new(&rules::W0101, Place::section(entry.kind), known, found))
}

/// Where entry `i` of the table stands.
fn place(header: &Header, entry: &SectionEntry, i: usize) -> Place {
    let offset = u64::from(header.header_len) + (i * SectionEntry::LEN) as u64;
    Place { offset: Some(offset), ..Place::of(entry) }
}

/// Lower-case hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
