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
mod compact;
mod content;
mod counts;
pub(super) mod cover;
mod hashes;
mod identity;
mod instances;
#[cfg(feature = "zstd")]
mod moved;
mod provenance;
mod sequence;
mod sides;
mod topology;
mod turns;
mod vertices;

use bytemuck::Pod;

use super::aligned::AlignedBytes;
use super::container::Container;
use super::decode::Decoded;
use super::meta::Meta;
use crate::exec::Executor;
use crate::layout::{Names, SectionEntry, SectionKind, View, tree_flags};

pub use super::container::hex;
pub use super::report::{Finding, Place, Report};
pub use compact::{CompactRecords, check as check_compact};
pub use content::{RecordsOf, check_records};
pub use counts::check_parts;
pub(super) use counts::check_rows;
pub(super) use hashes::check_packed;
pub use identity::Bits;
pub use sides::check as check_sides;
pub use turns::{TurnRecords, check as check_turns};
pub use vertices::check as check_vertices;

/// How deep to look. Each level includes those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Level {
    /// Header, section table, tiling and both ids, and the counts that header and table both state: rules `E01xx`, E0203 and E0204, and E0302,
    /// E0304, E0305 and E0308.
    Quick,
    /// And the hashes of all sections, compressed ones before and after decoding: E0201, E0202 and E0205. Where something is compressed also
    /// E0310, E0311 and E0410, since rows of `BLAS` that contradict the table are refused before anything is decoded.
    Hash,
    /// And every record, name and provenance: the rest of `E02xx`, `E03xx` to `E05xx`, and `E07xx`.
    Tree,
    /// And whether the triangles are those of a model: rules `E06xx`.
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

/// Everything that a file says of its model.
#[derive(Clone, Copy, Debug)]
pub struct Content<'a> {
    /// The records, each section as a slice.
    pub view: View<'a>,
    /// Provenance, where the file has it and it could be decoded.
    pub meta: Option<&'a Meta>,
    /// `None` where there is no `VERT`.
    pub vertices: Option<&'a [[u32; 3]]>,
    /// Empty where there is no `SIDE`, `None` where it is not sound.
    pub sides: Option<&'a [u32]>,
    /// Empty where there is no `MATS`, `None` where it is not sound.
    pub materials: Option<Names<'a>>,
}

/// Compares the content of a file with the model that it was built from, and adds what it finds to the report.
pub type AgainstSource<'a> = &'a dyn Fn(&Content<'_>, &mut Report);

/// Check a file's bytes as deeply as `level` says; [`Level::Source`] needs `source` and is [`Level::Tree`] without.
pub fn check_bytes(
    bytes: &[u8],
    level: Level,
    source: Option<AgainstSource<'_>>,
    limits: &Limits,
    exec: &Executor,
) -> Report {
    let mut out = Report::new(limits.max_issues);
    let Some(container) = Container::collect(bytes, &mut out) else { return out };
    let sound = out.is_valid();
    _ = container.check_content_id(&mut out);
    let before = out.errors();
    _ = container.check_counts(&mut out);
    let agree = out.errors() == before;
    if level >= Level::Hash {
        let mut sections = hashes::check(&container, bytes, agree, limits, &mut out, exec);
        if level >= Level::Tree {
            align(&mut sections.decoded, limits, &mut out);
            let mut source = source.filter(|_| level >= Level::Source);
            if source.is_some() && !sound {
                // Header and table say what the sections are: where they are wrong, differences from the model mean nothing.
                out.skip("The source: header and section table break rules, so what the sections hold is not certain.");
                source = None;
            }
            let find = |i: usize| sections.decoded.get(i)?.as_ref().map(Decoded::as_slice);
            if !check_content(&container, &find, source, limits, &mut out, exec) {
                out.append(sections.rows);
            }
        } else {
            out.append(sections.rows);
        }
    }
    locate(&mut out, &container);
    out.tell_skipped();
    out
}

/// Copy sections that do not lie on a boundary of their records: the given bytes may start anywhere.
fn align(decoded: &mut [Option<Decoded<'_>>], limits: &Limits, out: &mut Report) {
    let mut left = limits.max_memory;
    for section in decoded.iter_mut() {
        let Some(Decoded::InFile(bytes)) = section else { continue };
        if bytes.as_ptr().align_offset(8) == 0 {
            continue;
        }
        let len = bytes.len() as u64;
        if len > left {
            let needed = u128::from(limits.max_memory - left) + u128::from(len);
            out.exceed(needed, limits.max_memory, |needed| format!("to align the sections takes {needed}"));
            *section = None;
            continue;
        }
        left -= len;
        *section = AlignedBytes::zeroed(bytes.len()).ok().map(|mut copy| {
            copy.as_mut_slice().copy_from_slice(bytes);
            Decoded::Owned(copy)
        });
        if section.is_none() {
            out.starve(Place::file(), "Sections that are not aligned");
        }
    }
}

/// Check everything behind the container and the hashes. `bytes` has the decoded bytes of each section of the table that can be read.
///
/// Whether the records were there to be looked at.
pub(super) fn check_content<'a>(
    container: &Container,
    bytes: &dyn Fn(usize) -> Option<&'a [u8]>,
    source: Option<AgainstSource<'_>>,
    limits: &Limits,
    out: &mut Report,
    exec: &Executor,
) -> bool {
    // Read what stands by itself first.
    let find = |kind| container.find(kind, 0).and_then(|i| Some((bytes(i)?, &container.entries[i])));
    let meta = find(SectionKind::META).and_then(|(bytes, _)| provenance::check_meta(bytes, &container.header, out));

    if container.header.has(tree_flags::SEQUENCE) {
        if source.is_some() {
            out.skip("The source: a sequence is not compared with its models; a frame of it can be, as a still file.");
        }
        return sequence::check(container, bytes, limits, out, exec);
    }

    // Records can only be judged together.
    let two_level = container.header.has(tree_flags::TWO_LEVEL);
    let mut missing = Vec::new();
    let mut bytes = |kind: SectionKind, wanted: bool| match find(kind) {
        Some((bytes, _)) if wanted => bytes,
        None if wanted => {
            missing.push(kind.to_string());
            &[]
        }
        _ => &[],
    };
    let view = View {
        nodes: records(bytes(SectionKind::NODE, true)),
        triangles: records(bytes(SectionKind::TRIS, true)),
        geoms: records(bytes(SectionKind::GEOM, true)),
        blases: records(bytes(SectionKind::BLAS, true)),
        tlas_nodes: records(bytes(SectionKind::TNOD, two_level)),
        instances: records(bytes(SectionKind::INST, two_level)),
    };
    if !missing.is_empty() {
        out.skip(format!("All records: {} cannot be read.", missing.join(", ")));
        return false;
    }
    let before = out.errors();
    out.append(check_records(&view, container.header.tree_flags, RecordsOf::File(&container.header), limits, exec));
    let sound = out.errors() == before;
    provenance::check_names_of(container, find(SectionKind::NAMS), view.geoms, out);
    let compact = CompactRecords {
        rows: find(SectionKind::CROW).map(|(bytes, _)| records(bytes)),
        nodes: find(SectionKind::CNOD).map(|(bytes, _)| records(bytes)),
        order: find(SectionKind::CREF).map(|(bytes, _)| records(bytes)),
    };
    let of_compact = [SectionKind::CROW, SectionKind::CNOD, SectionKind::CREF];
    // One that cannot be decoded has been told of, or is left out.
    let is_unread = |kind| container.find(kind, 0).is_some() && find(kind).is_none();
    if !of_compact.into_iter().any(is_unread) {
        if sound {
            out.append(check_compact(&view, &compact, limits, exec));
        } else if compact.rows.is_some() {
            out.skip("Compact trees: those that they are made of break rules.");
        }
    }
    let turns = TurnRecords {
        rows: find(SectionKind::OROW).map(|(bytes, _)| records(bytes)),
        nodes: find(SectionKind::ONOD).map(|(bytes, _)| records(bytes)),
    };
    if ![SectionKind::OROW, SectionKind::ONOD].into_iter().any(is_unread) {
        if sound {
            out.append(check_turns(&view, &turns, limits, exec));
        } else if turns.rows.is_some() {
            out.skip("Turned subtrees: the tree that they are of breaks rules.");
        }
    }
    let vertices = find(SectionKind::VERT).map(|(bytes, _)| records(bytes));
    let sides = find(SectionKind::SIDE).map(|(bytes, _)| records(bytes));
    let materials = find(SectionKind::MATS);
    if let Some(vertices) = vertices {
        out.append(check_vertices(&view, vertices, limits, exec));
    }
    // What is there and is not sound is said once: it is compared with nothing.
    let before = out.errors();
    let sides = sides.filter(|sides| {
        check_sides(view.geoms, sides, out);
        out.errors() == before
    });
    let before = out.errors();
    let materials = materials.filter(|(bytes, entry)| {
        provenance::check_materials(bytes, entry.elem_count, view.geoms.len(), out);
        out.errors() == before
    });
    if let Some(source) = source {
        let is_absent = |kind| container.find(kind, 0).is_none();
        let materials = materials.map(|(bytes, _)| bytes).or_else(|| is_absent(SectionKind::MATS).then_some(&[][..]));
        let sides = sides.or_else(|| is_absent(SectionKind::SIDE).then_some(&[][..]));
        let materials = materials.map(Names::new);
        source(&Content { view, meta: meta.as_ref(), vertices, sides, materials }, out);
    }
    true
}

/// The container's rules made the length a multiple of the record's, and the bytes are aligned.
fn records<T: Pod>(bytes: &[u8]) -> &[T] {
    bytemuck::try_cast_slice(bytes).unwrap_or_default()
}

/// Say for each record where in the file it stands, unless its section is compressed.
pub(super) fn locate(out: &mut Report, container: &Container) {
    for finding in &mut out.findings {
        let place = &mut finding.place;
        let is_it = |e: &&SectionEntry| (Some(e.kind), e.ordinal) == (place.section, place.ordinal.into());
        let entry = container.entries.iter().find(is_it).filter(|e| !e.is_packed());
        if let (None, Some(entry), Some(index)) = (place.offset, entry, place.index) {
            place.offset = index.checked_mul(entry.elem_size.into()).and_then(|o| o.checked_add(entry.offset));
        }
    }
}
